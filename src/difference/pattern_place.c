/* SPDX-License-Identifier: Apache-2.0 */
/* Implements the rules of pattern.h for values at a wrong position. Each rule searches for the position at which the
   reference has these values. */
#include "difference/pattern_parts.h"

#include "core/integer.h"

static const int permutations[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};

/* A wrong way to read the input: at an offset of `step` voxels, with a different order of the axes in memory, or with
   rows (along x) of a different length. */
typedef struct reading {
    int step[3];
    const int *order;
    int64_t row; /* length of a row in voxels; 0 for the correct length */
} reading;

/* Resamples voxel p from an input that is read as described by *how. Returns false if a source voxel is outside the
   input's dims. With a different order of axes or a different row length, an index may lie beyond the input's memory;
   such a voxel reads as 0. */
static bool resample_as(const pattern_view *v, const int32_t p[3], const reading *how, int16_t *out)
{
    const ost_dims d = v->in_dims;
    const int64_t n[3] = {how->row ? how->row : d.x, d.y, d.z}, all = ost_dims_count(d);
    int64_t sum = 0;
    for (int corner = 0; corner < 8; corner++) {
        int64_t q[3], weight = 1;
        for (int axis = 0; axis < 3; axis++) {
            const int next = corner >> axis & 1, w = v->weight[axis] ? v->weight[axis][p[axis]] : 0;
            q[axis] = v->source[axis][p[axis]] + how->step[axis] + next;
            weight *= next ? w : PATTERN_WEIGHT_ONE - w;
        }
        if (weight == 0)
            continue;
        if (!pattern_inside(d, q[0], q[1], q[2]))
            return false;
        const int *order = how->order;
        const int64_t at = q[order[0]] + n[order[0]] * (q[order[1]] + n[order[1]] * q[order[2]]);
        sum += weight * (at < all ? v->in[at] : 0);
    }
    *out = (int16_t)ost_rhe_div(sum, INT64_C(1) << 45);
    return true;
}

/* Computes the stage's result for the voxel at p + (dx, dy, dz). Returns false if this voxel is outside the grid. */
static bool neighbour(const pattern_view *v, const int32_t p[3], int dx, int dy, int dz, int16_t *out)
{
    if (v->input == PATTERN_SOURCE) {
        const reading how = {.step = {dx, dy, dz}, .order = permutations[0]};
        return resample_as(v, p, &how, out);
    }
    const bool input = v->input == PATTERN_THRESHOLDED;
    const ost_dims d = input ? v->in_dims : v->dims;
    const int64_t q[3] = {p[0] + dx, p[1] + dy, p[2] + dz};
    if (!pattern_inside(d, q[0], q[1], q[2]))
        return false;
    *out = ost_pattern_stored(v, (input ? v->in : v->a)[pattern_at(d, q[0], q[1], q[2])]);
    return true;
}

/* An arrangement of the axes in which voxel p of B is voxel q of A. For an axis of B with n voxels and the axis
   to = from[axis] of A, q[to] is (flip[axis] ? n - 1 - p[axis] : p[axis]) + shift[to]. */
typedef struct arrangement {
    int from[3];
    bool flip[3];
    int32_t shift[3];
} arrangement;

static bool arranged_equal(const pattern_view *v, const arrangement *how, int32_t stride)
{
    const int32_t da[3] = {v->dims.x, v->dims.y, v->dims.z}, db[3] = {v->dims_b.x, v->dims_b.y, v->dims_b.z};
    int32_t p[3], q[3];
    bool solid = false;
    for (p[2] = 0; p[2] < db[2]; p[2] += stride)
        for (p[1] = 0; p[1] < db[1]; p[1] += stride)
            for (p[0] = 0; p[0] < db[0]; p[0] += stride) {
                bool in = true;
                for (int axis = 0; axis < 3; axis++) {
                    const int to = how->from[axis];
                    q[to] = (how->flip[axis] ? db[axis] - 1 - p[axis] : p[axis]) + how->shift[to];
                    in &= q[to] >= 0 && q[to] < da[to];
                }
                if (!in)
                    continue;
                const int16_t b = v->b[pattern_at(v->dims_b, p[0], p[1], p[2])];
                if (v->a[pattern_at(v->dims, q[0], q[1], q[2])] != b)
                    return false;
                solid |= b != 0;
            }
    return solid || stride > 1;
}

/* Returns true if B is A in this arrangement. Checks a few voxels first, because these rule out most arrangements. */
static bool arranged(const pattern_view *v, const arrangement *how)
{
    return arranged_equal(v, how, 7) && arranged_equal(v, how, 1);
}

/* Returns true if all differing voxels have the values that result if the input is read with this order of the axes
   and this row length. */
static bool misread(const pattern_scan *s, const int order[3], int64_t row)
{
    const pattern_view *v = s->v;
    const ost_dims d = v->dims;
    const int64_t n[3] = {row ? row : d.x, d.y, d.z}, all = ost_dims_count(d);
    const reading how = {.order = order, .row = row};
    PATTERN_EACH(s, p, i) {
        int16_t there = 0;
        if (v->input == PATTERN_SOURCE) {
            if (!resample_as(v, p, &how, &there))
                return false;
        } else {
            const int64_t w = p[order[0]] + n[order[0]] * (p[order[1]] + n[order[1]] * p[order[2]]);
            there = w < all ? v->a[w] : 0;
        }
        if (v->b[i] != there)
            return false;
    }
    return true;
}

bool ost_pattern_axis_swap(const pattern_scan *s, char *text)
{
    const pattern_view *v = s->v;
    const int32_t da[3] = {v->dims.x, v->dims.y, v->dims.z}, db[3] = {v->dims_b.x, v->dims_b.y, v->dims_b.z};
    for (int p = 0; p < 6; p++)
        for (int f = 0; f < 8; f++) {
            arrangement how = {.shift = {0, 0, 0}};
            bool fits = true;
            for (int axis = 0; axis < 3; axis++) {
                how.from[axis] = permutations[p][axis];
                how.flip[axis] = f >> axis & 1;
                fits &= da[how.from[axis]] == db[axis];
            }
            if (fits && (p || f) && arranged(v, &how))
                return ost_pattern_describe(text, "B's axes x, y, z are A's %s%c, %s%c, %s%c", how.flip[0] ? "-" : "",
                                            "xyz"[how.from[0]], how.flip[1] ? "-" : "", "xyz"[how.from[1]],
                                            how.flip[2] ? "-" : "", "xyz"[how.from[2]]);
        }
    if (!pattern_same_dims(v->dims, v->dims_b) || s->count < PATTERN_TELLING || !s->several || v->tool)
        return false;
    for (int p = 1; p < 6; p++)
        if (misread(s, permutations[p], 0))
            return ost_pattern_describe(
                text,
                "every voxel that differs is what lies there if memory is read with its axes in the order %c, %c, %c",
                "xyz"[permutations[p][0]], "xyz"[permutations[p][1]], "xyz"[permutations[p][2]]);
    return false;
}

/* Returns true if every differing voxel has the value of its neighbour at this offset. */
static bool stepped(const pattern_scan *s, int dx, int dy, int dz)
{
    int64_t met = 0;
    PATTERN_EACH(s, p, i) {
        int16_t there;
        if (!neighbour(s->v, p, dx, dy, dz, &there))
            continue; /* values read beyond the border are arbitrary */
        if (s->v->b[i] != there)
            return false;
        met++;
    }
    return met >= PATTERN_TELLING && 2 * met > s->count;
}

/* Returns true if every differing voxel has the value of one of its seven neighbours in an octant. `way`, which is -1
   or 1, selects the octant of negative or of positive offsets. */
static bool resampled(const pattern_scan *s, int way)
{
    PATTERN_EACH(s, p, i) {
        bool found = false;
        for (int n = 1; n < 8 && !found; n++) {
            int16_t there;
            found = neighbour(s->v, p, n & 1 ? way : 0, n & 2 ? way : 0, n & 4 ? way : 0, &there) &&
                    there == s->v->b[i];
        }
        if (!found)
            return false;
    }
    return true;
}

bool ost_pattern_shift(const pattern_scan *s, char *text)
{
    enum { REACH = 3 };
    const pattern_view *v = s->v;
    for (int z = -REACH; z <= REACH; z++)
        for (int y = -REACH; y <= REACH; y++)
            for (int x = -REACH; x <= REACH; x++) {
                const arrangement how = {.from = {0, 1, 2}, .shift = {-x, -y, -z}};
                if ((x || y || z) && arranged(v, &how))
                    return ost_pattern_describe(text, "B is A moved by (%d, %d, %d) voxels", x, y, z);
            }
    if (s->count < PATTERN_TELLING || !s->several || v->tool)
        return false;
    for (int axis = 0; axis < 3; axis++)
        for (int way = -1; way <= 1; way += 2)
            if (stepped(s, axis == 0 ? way : 0, axis == 1 ? way : 0, axis == 2 ? way : 0))
                return ost_pattern_describe(text, "every voxel that differs is its %sneighbour's at %s%c",
                                            v->input == PATTERN_SOURCE ? "source's " : "", way < 0 ? "-" : "+",
                                            "xyz"[axis]);
    for (int way = -1; way <= 1 && v->input == PATTERN_SOURCE; way += 2)
        if (resampled(s, way))
            return ost_pattern_describe(text,
                                        "every voxel that differs was taken from a source voxel one %s on some axis",
                                        way < 0 ? "lower" : "higher");
    return false;
}

/* Checks the rule row-pitch. Tests rows that are one voxel shorter, rows that are one voxel longer, and rows that are
   padded by at most PADDING voxels to a multiple of ALIGNED voxels, as rows of images may be. */
bool ost_pattern_row_pitch(const pattern_scan *s, char *text)
{
    enum { ALIGNED = 4, PADDING = 64 };
    const pattern_view *v = s->v;
    const int32_t n = v->input == PATTERN_SOURCE ? v->in_dims.x : v->dims.x;
    if (s->count < PATTERN_TELLING || !s->several || v->tool)
        return false;
    for (int32_t row = n - 1; row <= n + PADDING; row++)
        if (row > 0 && row != n && (row == n - 1 || row == n + 1 || row % ALIGNED == 0) &&
            misread(s, permutations[0], row))
            return ost_pattern_describe(
                text, "every voxel that differs is what lies there if rows in memory have %d voxels; they have %d", row,
                n);
    return false;
}
