/* SPDX-License-Identifier: Apache-2.0 */
#include "difference/pattern_parts.h"

#include <stdlib.h>

const char *ost_pattern_name(pattern p)
{
    static const char *const names[PATTERNS] = {"byte-order",   "axis-swap",     "shift",       "row-pitch",
                                                "offset",       "threshold",     "stale-chunk", "lost-tail",
                                                "lost-chunk",   "column-parity", "tool-class",  "boundary-layer",
                                                "carried-rows", "speckle",       "unclassified"};
    return names[p];
}

static void scan_all(const pattern_view *v, pattern_scan *s)
{
    const int32_t n[3] = {v->dims.x, v->dims.y, v->dims.z};
    int16_t one = 0;
    int64_t i = 0;
    int32_t p[3];
    *s = (pattern_scan){.v = v, .lo = {n[0], n[1], n[2]}};
    for (p[2] = 0; p[2] < n[2]; p[2]++)
        for (p[1] = 0; p[1] < n[1]; p[1]++)
            for (p[0] = 0; p[0] < n[0]; p[0]++, i++) {
                if (v->a[i] == v->b[i])
                    continue;
                if (s->count++ == 0)
                    s->first = i;
                for (int axis = 0; axis < 3; axis++) {
                    s->lo[axis] = p[axis] < s->lo[axis] ? p[axis] : s->lo[axis];
                    s->hi[axis] = p[axis] >= s->hi[axis] ? p[axis] + 1 : s->hi[axis];
                }
                if (v->b[i] && one && v->b[i] != one)
                    s->several = true;
                one = v->b[i] ? v->b[i] : one;
            }
}

/* ------------------------------------------------------- rules on values */

static bool byte_order(const pattern_scan *s, char *text)
{
    const pattern_view *v = s->v;
    bool telling = false;
    PATTERN_EACH(s, p, i) {
        const uint16_t right = (uint16_t)(v->input == PATTERN_THRESHOLDED ? v->in[i] : v->a[i]);
        if (v->b[i] != ost_pattern_stored(v, (int16_t)(uint16_t)(right << 8 | right >> 8)))
            return false;
        telling |= v->b[i] != 0;
    }
    return telling &&
           ost_pattern_describe(text, "every voxel that differs is the right one with its two bytes swapped");
}

static bool offset(const pattern_scan *s, char *text)
{
    const pattern_view *v = s->v;
    const int by = v->b[s->first] - v->a[s->first];
    if (v->tool)
        return false;
    PATTERN_EACH(s, p, i)
        if (v->b[i] - v->a[i] != by || v->a[i] < v->solid_a || v->b[i] < v->solid_b)
            return false;
    return s->count >= PATTERN_TELLING &&
           ost_pattern_describe(text, "every voxel that differs is %d %s", abs(by), by > 0 ? "more" : "less");
}

/*
 * Checks the rule `threshold` if `in` is the grid before densities below the threshold were set to 0. The rule holds if
 * B has kept a density below the threshold in every voxel of D. The rule also holds if B seems to have been made with a
 * higher threshold: in every chunk that differs, B lacks exactly the densities up to a certain value.
 */
static bool threshold_of_chunks(const pattern_scan *s, char *text)
{
    const pattern_view *v = s->v;
    const int n = v->chunk;
    bool unchanged = true, gone = true, other = false;
    int16_t most = INT16_MIN;
    PATTERN_EACH(s, p, i) {
        unchanged &= v->a[i] == 0 && v->b[i] == v->in[i];
        gone &= v->b[i] == 0 && v->a[i] == v->in[i];
        most = v->in[i] > most ? v->in[i] : most;
    }
    if (unchanged)
        return ost_pattern_describe(text, "every voxel that differs kept a density below the threshold %d", v->solid_a);
    if (!gone)
        return false;
    for (int32_t z = s->lo[2] / n * n; z < s->hi[2]; z += n)
        for (int32_t y = s->lo[1] / n * n; y < s->hi[1]; y += n)
            for (int32_t x = s->lo[0] / n * n; x < s->hi[0]; x += n) {
                bool differs = false, some = false, some_more = false;
                for (int32_t k = z; k < z + n && k < v->dims.z; k++)
                    for (int32_t j = y; j < y + n && j < v->dims.y; j++)
                        for (int32_t i = x; i < x + n && i < v->dims.x; i++) {
                            const int64_t w = pattern_at(v->dims, i, j, k);
                            differs |= v->a[w] != v->b[w];
                            some |= v->a[w] == v->b[w] && v->a[w] && v->a[w] <= most;
                            some_more |= v->a[w] == v->b[w] && v->a[w] > most;
                        }
                if (differs && some)
                    return false;
                other |= differs && some_more;
            }
    if (other && most == v->solid_a)
        return ost_pattern_describe(text,
                                    "in every chunk that differs, all of density %d, the threshold itself, are missing "
                                    "and nothing denser: > in place of >=",
                                    most);
    return other && ost_pattern_describe(text,
                                         "in every chunk that differs, all of density %d to %d are missing and nothing "
                                         "denser",
                                         v->solid_a, most);
}

static bool threshold(const pattern_scan *s, char *text)
{
    const pattern_view *v = s->v;
    if (v->tool || v->input == PATTERN_BEFORE)
        return false;
    if (v->input == PATTERN_THRESHOLDED)
        return threshold_of_chunks(s, text);
    int32_t gone = INT32_MIN, appeared = INT32_MIN, unchanged = INT32_MAX, old = INT32_MAX;
    bool removed = true, added = true;
    const int64_t n = ost_dims_count(v->dims);
    for (int64_t i = 0; i < n; i++) {
        const bool a = v->a[i] >= v->solid_a, b = v->b[i] >= v->solid_b;
        removed &= v->a[i] == v->b[i] || (a && !b);
        added &= v->a[i] == v->b[i] || (b && !a);
        unchanged = b && v->b[i] < unchanged ? v->b[i] : unchanged;
        old = a && v->a[i] < old ? v->a[i] : old;
        gone = a && !b && v->a[i] > gone ? v->a[i] : gone;
        appeared = b && !a && v->b[i] > appeared ? v->b[i] : appeared;
    }
    if (removed && gone < unchanged && unchanged != INT32_MAX)
        return ost_pattern_describe(text, "B lacks exactly what is less dense than %d", gone + 1);
    return added && appeared < old && old != INT32_MAX &&
           ost_pattern_describe(text, "A lacks exactly what is less dense than %d", appeared + 1);
}

void ost_pattern_find(const pattern_view *view, pattern_list *out)
{
    static pattern_rule *const rules[PATTERN_UNCLASSIFIED] = {
        [PATTERN_BYTE_ORDER] = byte_order,
        [PATTERN_AXIS_SWAP] = ost_pattern_axis_swap,
        [PATTERN_SHIFT] = ost_pattern_shift,
        [PATTERN_ROW_PITCH] = ost_pattern_row_pitch,
        [PATTERN_OFFSET] = offset,
        [PATTERN_THRESHOLD] = threshold,
        [PATTERN_STALE_CHUNK] = ost_pattern_stale_chunk,
        [PATTERN_LOST_TAIL] = ost_pattern_lost_tail,
        [PATTERN_LOST_CHUNK] = ost_pattern_lost_chunk,
        [PATTERN_COLUMN_PARITY] = ost_pattern_column_parity,
        [PATTERN_TOOL_CLASS] = ost_pattern_tool_class,
        [PATTERN_BOUNDARY_LAYER] = ost_pattern_boundary_layer,
        [PATTERN_CARRIED_ROWS] = ost_pattern_carried_rows,
        [PATTERN_SPECKLE] = ost_pattern_speckle,
    };
    pattern_scan s = {.v = view};
    *out = (pattern_list){.of_all = PATTERN_UNCLASSIFIED};
    const bool same = pattern_same_dims(view->dims, view->dims_b);
    if (same)
        scan_all(view, &s);
    if (same && s.count == 0)
        return;
    for (int p = PATTERN_UNCLASSIFIED - 1; p >= 0; p--)
        if ((same || p == PATTERN_AXIS_SWAP) && rules[p](&s, out->text[p])) {
            out->holds[p] = true;
            out->of_all = (pattern)p;
        }
}
