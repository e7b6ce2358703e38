/* SPDX-License-Identifier: Apache-2.0 */
#include "validation/locate/pattern.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

/* Fewer voxels than this say nothing about a shape that they all have. */
enum { TELLING = 8, GROUP = 256 };

/* The view, and what every rule wants to know of D. */
typedef struct scan {
    const pattern_view *v;
    int64_t count;         /* of D */
    int64_t first;         /* the least index in D */
    int32_t lo[3], hi[3];  /* around D, half-open */
    bool several;          /* values of b in D, 0 not counted, are more than one */
} scan;

typedef bool rule(const scan *s, char *text);

const char *pattern_name(pattern p)
{
    static const char *const names[PATTERNS] = {"byte-order", "axis-swap",  "shift",         "offset",         "threshold", "stale-chunk",
                                                "lost-tail",  "lost-chunk", "column-parity", "boundary-layer", "speckle",   "unclassified"};
    return names[p];
}

static bool say(char *text, const char *format, ...) OST_PRINTF(2, 3);
static bool say(char *text, const char *format, ...)
{
    va_list args;
    va_start(args, format);
    vsnprintf(text, PATTERN_TEXT, format, args);
    va_end(args);
    return true;
}

static bool same_dims(ost_dims a, ost_dims b)
{
    return a.x == b.x && a.y == b.y && a.z == b.z;
}

static int64_t at(ost_dims d, int64_t x, int64_t y, int64_t z)
{
    return x + d.x * (y + d.y * z);
}

static bool inside(ost_dims d, int64_t x, int64_t y, int64_t z)
{
    return x >= 0 && y >= 0 && z >= 0 && x < d.x && y < d.y && z < d.z;
}

/* Walks D: p is its voxel, i its index. */
#define EACH_DIFFERENT(s, p, i)                                                                                                   \
    for (int32_t p[3] = {0, 0, (s)->lo[2]}; p[2] < (s)->hi[2]; p[2]++)                                                            \
        for (p[1] = (s)->lo[1]; p[1] < (s)->hi[1]; p[1]++)                                                                        \
            for (int64_t i = at((s)->v->dims, p[0] = (s)->lo[0], p[1], p[2]); p[0] < (s)->hi[0]; p[0]++, i++)                     \
                if ((s)->v->a[i] != (s)->v->b[i])

static void scan_all(const pattern_view *v, scan *s)
{
    const int32_t n[3] = {v->dims.x, v->dims.y, v->dims.z};
    int16_t one = 0;
    int64_t i = 0;
    int32_t p[3];
    *s = (scan){.v = v, .lo = {n[0], n[1], n[2]}};
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

/* As the stage stores it. */
static int16_t stored(const pattern_view *v, int16_t density)
{
    return v->input == PATTERN_THRESHOLDED && density < v->solid_a ? 0 : density;
}

/* What the stage would have made of the voxel beside p's own; false outside. */
static bool beside(const pattern_view *v, const int32_t p[3], int dx, int dy, int dz, int16_t *out)
{
    const bool input = v->input == PATTERN_SOURCE || v->input == PATTERN_THRESHOLDED;
    const ost_dims d = input ? v->in_dims : v->dims;
    int64_t q[3] = {p[0], p[1], p[2]};
    for (int axis = 0; axis < 3 && v->input == PATTERN_SOURCE; axis++)
        q[axis] = v->source[axis][p[axis]];
    q[0] += dx;
    q[1] += dy;
    q[2] += dz;
    if (!inside(d, q[0], q[1], q[2]))
        return false;
    *out = stored(v, (input ? v->in : v->a)[at(d, q[0], q[1], q[2])]);
    return true;
}

/* ------------------------------------------------------- rules on values */

static bool byte_order(const scan *s, char *text)
{
    const pattern_view *v = s->v;
    bool telling = false;
    EACH_DIFFERENT(s, p, i) {
        const uint16_t right = (uint16_t)(v->input == PATTERN_THRESHOLDED ? v->in[i] : v->a[i]);
        if (v->b[i] != stored(v, (int16_t)(uint16_t)(right << 8 | right >> 8)))
            return false;
        telling |= v->b[i] != 0;
    }
    return telling && say(text, "every voxel that differs is the right one with its two bytes swapped");
}

static bool offset(const scan *s, char *text)
{
    const pattern_view *v = s->v;
    const int by = v->b[s->first] - v->a[s->first];
    if (v->tool)
        return false;
    EACH_DIFFERENT(s, p, i)
        if (v->b[i] - v->a[i] != by || v->a[i] < v->solid_a || v->b[i] < v->solid_b)
            return false;
    return s->count >= TELLING && say(text, "every voxel that differs is %d %s", abs(by), by > 0 ? "more" : "less");
}

/* With the grid before the threshold at hand, chunk by chunk. */
static bool threshold_of_chunks(const scan *s, char *text)
{
    const pattern_view *v = s->v;
    const int n = v->chunk;
    bool kept = true, gone = true, rest = false;
    int16_t most = INT16_MIN;
    EACH_DIFFERENT(s, p, i) {
        kept &= v->a[i] == 0 && v->b[i] == v->in[i];
        gone &= v->b[i] == 0 && v->a[i] == v->in[i];
        most = v->in[i] > most ? v->in[i] : most;
    }
    if (kept)
        return say(text, "every voxel that differs kept a density below the threshold %d", v->solid_a);
    if (!gone)
        return false;
    for (int32_t z = s->lo[2] / n * n; z < s->hi[2]; z += n)
        for (int32_t y = s->lo[1] / n * n; y < s->hi[1]; y += n)
            for (int32_t x = s->lo[0] / n * n; x < s->hi[0]; x += n) {
                bool differs = false, some = false, some_more = false;
                for (int32_t k = z; k < z + n && k < v->dims.z; k++)
                    for (int32_t j = y; j < y + n && j < v->dims.y; j++)
                        for (int32_t i = x; i < x + n && i < v->dims.x; i++) {
                            const int64_t w = at(v->dims, i, j, k);
                            differs |= v->a[w] != v->b[w];
                            some |= v->a[w] == v->b[w] && v->a[w] && v->a[w] <= most;
                            some_more |= v->a[w] == v->b[w] && v->a[w] > most;
                        }
                if (differs && some)
                    return false;
                rest |= differs && some_more;
            }
    return rest && say(text, "in every chunk that differs, all of density %d to %d are missing and nothing denser", v->solid_a, most);
}

static bool threshold(const scan *s, char *text)
{
    const pattern_view *v = s->v;
    if (v->tool || v->input == PATTERN_BEFORE)
        return false;
    if (v->input == PATTERN_THRESHOLDED)
        return threshold_of_chunks(s, text);
    int32_t gone = INT32_MIN, come = INT32_MIN, kept = INT32_MAX, old = INT32_MAX;
    bool removed = true, added = true;
    const int64_t n = ost_dims_count(v->dims);
    for (int64_t i = 0; i < n; i++) {
        const bool a = v->a[i] >= v->solid_a, b = v->b[i] >= v->solid_b;
        removed &= v->a[i] == v->b[i] || (a && !b);
        added &= v->a[i] == v->b[i] || (b && !a);
        kept = b && v->b[i] < kept ? v->b[i] : kept;
        old = a && v->a[i] < old ? v->a[i] : old;
        gone = a && !b && v->a[i] > gone ? v->a[i] : gone;
        come = b && !a && v->b[i] > come ? v->b[i] : come;
    }
    if (removed && gone < kept && kept != INT32_MAX)
        return say(text, "B lacks exactly what is less dense than %d", gone + 1);
    return added && come < old && old != INT32_MAX && say(text, "A lacks exactly what is less dense than %d", come + 1);
}

/* ------------------------------------------------------- rules on places */

/* Voxel p of B is voxel q of A: q[from[axis]] = flip ? n - 1 - p[axis] : p[axis], all plus shift. */
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
                const int16_t b = v->b[at(v->dims_b, p[0], p[1], p[2])];
                if (v->a[at(v->dims, q[0], q[1], q[2])] != b)
                    return false;
                solid |= b != 0;
            }
    return solid || stride > 1;
}

/* A coarse look first: most arrangements fail it at once. */
static bool arranged(const pattern_view *v, const arrangement *how)
{
    return arranged_equal(v, how, 7) && arranged_equal(v, how, 1);
}

static const int permutations[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};

/* The input read as if its axes lay in memory in another order. */
static bool misread(const scan *s, const int order[3])
{
    const pattern_view *v = s->v;
    const bool resampled = v->input == PATTERN_SOURCE;
    const ost_dims d = resampled ? v->in_dims : v->dims;
    const int64_t n[3] = {d.x, d.y, d.z}, all = ost_dims_count(d);
    const int16_t *from = resampled ? v->in : v->a;
    EACH_DIFFERENT(s, p, i) {
        int64_t q[3];
        for (int axis = 0; axis < 3; axis++)
            q[axis] = resampled ? v->source[axis][p[axis]] : p[axis];
        const int64_t w = q[order[0]] + n[order[0]] * (q[order[1]] + n[order[1]] * q[order[2]]);
        if (v->b[i] != (w < all ? from[w] : 0))
            return false;
    }
    return true;
}

static bool axis_swap(const scan *s, char *text)
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
                return say(text, "B's axes x, y, z are A's %s%c, %s%c, %s%c", how.flip[0] ? "-" : "", "xyz"[how.from[0]], how.flip[1] ? "-" : "",
                           "xyz"[how.from[1]], how.flip[2] ? "-" : "", "xyz"[how.from[2]]);
        }
    if (!same_dims(v->dims, v->dims_b) || s->count < TELLING || !s->several || v->tool)
        return false;
    for (int p = 1; p < 6; p++)
        if (misread(s, permutations[p]))
            return say(text, "every voxel that differs is what lies there if memory is read with its axes in the order %c, %c, %c", "xyz"[permutations[p][0]],
                       "xyz"[permutations[p][1]], "xyz"[permutations[p][2]]);
    return false;
}

/* All of D have what is one step further. */
static bool stepped(const scan *s, int dx, int dy, int dz)
{
    int64_t met = 0;
    EACH_DIFFERENT(s, p, i) {
        int16_t there;
        if (!beside(s->v, p, dx, dy, dz, &there))
            continue; /* beyond the border anything may stand */
        if (s->v->b[i] != there)
            return false;
        met++;
    }
    return met >= TELLING && 2 * met > s->count;
}

/* Each of D has what some neighbour of its source has, all in one octant. */
static bool resampled(const scan *s, int way)
{
    EACH_DIFFERENT(s, p, i) {
        bool found = false;
        for (int n = 1; n < 8 && !found; n++) {
            int16_t there;
            found = beside(s->v, p, n & 1 ? way : 0, n & 2 ? way : 0, n & 4 ? way : 0, &there) && there == s->v->b[i];
        }
        if (!found)
            return false;
    }
    return true;
}

static bool shift(const scan *s, char *text)
{
    enum { REACH = 3 };
    const pattern_view *v = s->v;
    for (int z = -REACH; z <= REACH; z++)
        for (int y = -REACH; y <= REACH; y++)
            for (int x = -REACH; x <= REACH; x++) {
                const arrangement how = {.from = {0, 1, 2}, .shift = {-x, -y, -z}};
                if ((x || y || z) && arranged(v, &how))
                    return say(text, "B is A moved by (%d, %d, %d) voxels", x, y, z);
            }
    if (s->count < TELLING || !s->several || v->tool)
        return false;
    for (int axis = 0; axis < 3; axis++)
        for (int way = -1; way <= 1; way += 2)
            if (stepped(s, axis == 0 ? way : 0, axis == 1 ? way : 0, axis == 2 ? way : 0))
                return say(text, "every voxel that differs is its %sneighbour's at %s%c", v->input == PATTERN_SOURCE ? "source's " : "", way < 0 ? "-" : "+",
                           "xyz"[axis]);
    for (int way = -1; way <= 1 && v->input == PATTERN_SOURCE; way += 2)
        if (resampled(s, way))
            return say(text, "every voxel that differs was taken from a source voxel one %s on some axis", way < 0 ? "lower" : "higher");
    return false;
}

/* ------------------------------------------------------- rules on chunks */

typedef struct chunk_look {
    bool differs, as_before, hit; /* B is `in` all over; A is not */
    bool solid_a, solid_b;
} chunk_look;

static chunk_look look_at(const pattern_view *v, int32_t x, int32_t y, int32_t z)
{
    chunk_look l = {.as_before = v->input == PATTERN_BEFORE};
    for (int32_t k = z; k < z + v->chunk && k < v->dims.z; k++)
        for (int32_t j = y; j < y + v->chunk && j < v->dims.y; j++)
            for (int32_t i = x; i < x + v->chunk && i < v->dims.x; i++) {
                const int64_t w = at(v->dims, i, j, k);
                l.differs |= v->a[w] != v->b[w];
                l.solid_a |= v->a[w] >= v->solid_a;
                l.solid_b |= v->b[w] >= v->solid_b;
                l.as_before &= v->input == PATTERN_BEFORE && v->b[w] == v->in[w];
                l.hit |= v->input == PATTERN_BEFORE && v->a[w] != v->in[w];
            }
    return l;
}

typedef struct chunk_sums {
    int64_t differ, undone, one_sided; /* one_sided: solid in one grid alone */
    int64_t hit, hit_after; /* hit_after: and right, behind the first that differs */
} chunk_sums;

static chunk_sums sum_chunks(const pattern_view *v)
{
    chunk_sums n = {0};
    for (int32_t z = 0; z < v->dims.z; z += v->chunk)
        for (int32_t y = 0; y < v->dims.y; y += v->chunk)
            for (int32_t x = 0; x < v->dims.x; x += v->chunk) {
                const chunk_look l = look_at(v, x, y, z);
                n.hit += l.hit;
                n.hit_after += n.differ && l.hit && !l.differs;
                n.differ += l.differs;
                n.undone += l.differs && l.as_before;
                n.one_sided += l.differs && l.solid_a != l.solid_b;
            }
    return n;
}

static bool stale_chunk(const scan *s, char *text)
{
    if (s->v->input != PATTERN_BEFORE || s->v->reported_too)
        return false;
    const chunk_sums n = sum_chunks(s->v);
    return n.undone == n.differ &&
           say(text, "%lld chunk%s as before the event, though the report counts what was cut there", (long long)n.differ, n.differ == 1 ? " is" : "s are");
}

static bool lost_chunk(const scan *s, char *text)
{
    if (s->v->tool || s->count < TELLING)
        return false;
    const chunk_sums n = sum_chunks(s->v);
    const char *whole = n.differ == 1 ? " " : "s ";
    if (n.undone == n.differ && s->v->input == PATTERN_BEFORE && s->v->reported_too)
        return say(text, "%lld whole chunk%sleft out: neither cut nor reported", (long long)n.differ, whole);
    return n.one_sided == n.differ && say(text, "%lld whole chunk%ssolid on one side only", (long long)n.differ, n.differ == 1 ? " is " : "s are ");
}

/* The last samples of batches. */
static bool lost_samples(const scan *s, char *text)
{
    int32_t most = 0;
    EACH_DIFFERENT(s, p, i) {
        const int32_t behind = s->v->behind[i];
        if (behind < 0 || behind >= GROUP)
            return false;
        most = behind > most ? behind : most;
    }
    return s->count > 1 && say(text, "every voxel that differs has its last sample among the last %d of a batch", most + 1);
}

static bool lost_tail(const scan *s, char *text)
{
    const pattern_view *v = s->v;
    if (v->tool)
        return false;
    if (v->input == PATTERN_BEFORE) {
        const chunk_sums n = sum_chunks(v);
        return v->reported_too && n.undone == n.differ && n.hit > n.differ && n.hit_after == 0 &&
               say(text, "the last %lld of %lld chunks that are hit: neither cut nor reported", (long long)n.differ, (long long)n.hit);
    }
    if (v->behind && lost_samples(s, text))
        return true;
    const int64_t all = ost_dims_count(v->dims);
    bool head = false, last_layer = s->lo[2] == v->dims.z - 1 && v->dims.z > 1;
    if (s->count < TELLING)
        return false;
    EACH_DIFFERENT(s, p, i)
        last_layer &= v->b[i] == 0;
    if (last_layer)
        return say(text, "all that differs lies in the last layer, z = %d, and is 0", s->lo[2]);
    for (int64_t i = s->first; i < all; i++)
        if (v->a[i] != 0 && v->b[i] != 0)
            return false;
    for (int64_t i = 0; i < s->first && !head; i++)
        head = v->a[i] != 0;
    return head && say(text, "nothing is there from voxel %lld of %lld on, in the order of memory", (long long)s->first, (long long)all);
}

/* --------------------------------------------------- rules on neighbours */

/* Voxels x0 <= x < x1 of the row are one run of g. */
static bool whole_run(const int16_t *row, int32_t n, int32_t x0, int32_t x1)
{
    for (int32_t x = x0; x + 1 < x1; x++)
        if (row[x] != row[x + 1])
            return false;
    return (x0 == 0 || row[x0 - 1] != row[x0]) && (x1 == n || row[x1] != row[x1 - 1]);
}

static bool column_parity(const scan *s, char *text)
{
    const pattern_view *v = s->v;
    int64_t runs = 0, rows = 0;
    if (!v->tool)
        return false;
    for (int32_t z = s->lo[2]; z < s->hi[2]; z++)
        for (int32_t y = s->lo[1]; y < s->hi[1]; y++) {
            const int16_t *a = v->a + at(v->dims, 0, y, z), *b = v->b + at(v->dims, 0, y, z);
            const int64_t before = runs;
            for (int32_t x = 0; x < v->dims.x; x++) {
                int32_t end = x;
                while (end < v->dims.x && a[end] != b[end] && a[end] == a[x] && b[end] == b[x])
                    end++;
                if (end == x)
                    continue;
                if (!whole_run(a, v->dims.x, x, end) && !whole_run(b, v->dims.x, x, end))
                    return false;
                runs++;
                x = end - 1;
            }
            rows += runs > before;
        }
    return s->count >= 2 * runs && say(text, "whole runs of voxels along x, between crossings of the surface, in %lld row%s", (long long)rows, rows == 1 ? "" : "s");
}

static const int ways[6][3] = {{-1, 0, 0}, {1, 0, 0}, {0, -1, 0}, {0, 1, 0}, {0, 0, -1}, {0, 0, 1}};

/* Which side of the surface a voxel of A is on: 1 or 0; -1 where there is no bone to say. */
static int side_of(const pattern_view *v, int64_t i)
{
    if (v->input == PATTERN_BEFORE)
        return v->in[i] == 0 ? -1 : v->a[i] == 0;
    return v->a[i] >= v->solid_a;
}

/* Voxel p has one of 26 neighbours on the other side; where beyond the grid lies the other side, that too. *known: it has one to compare with. */
static bool on_surface(const pattern_view *v, const int32_t p[3], int64_t i, bool *known)
{
    const int mine = side_of(v, i);
    bool surface = false;
    *known = false;
    for (int w = 0; w < 27; w++) {
        const int32_t q[3] = {p[0] + w % 3 - 1, p[1] + w / 3 % 3 - 1, p[2] + w / 9 - 1};
        if (w == 13)
            continue;
        const bool in = inside(v->dims, q[0], q[1], q[2]);
        const int other = in ? side_of(v, at(v->dims, q[0], q[1], q[2])) : v->input == PATTERN_BEFORE ? -1 : 0;
        *known |= other >= 0;
        surface |= other >= 0 && other != mine;
    }
    return surface;
}

static bool boundary_layer(const scan *s, char *text)
{
    const pattern_view *v = s->v;
    const bool cut = v->input == PATTERN_BEFORE;
    int64_t known = 0;
    EACH_DIFFERENT(s, p, i) {
        bool can;
        if (cut ? v->in[i] == 0 || (v->a[i] != 0 && v->b[i] != 0) : (v->a[i] >= v->solid_a) == (v->b[i] >= v->solid_b))
            return false;
        const bool on = on_surface(v, p, i, &can);
        if (can && !on)
            return false;
        known += can;
    }
    /* Where most of the bone is surface, all differences are on it and that tells nothing. */
    int64_t solid = 0, surface = 0;
    int32_t p[3];
    for (p[2] = s->lo[2]; p[2] < s->hi[2]; p[2]++)
        for (p[1] = s->lo[1]; p[1] < s->hi[1]; p[1]++)
            for (p[0] = s->lo[0]; p[0] < s->hi[0]; p[0]++) {
                const int64_t i = at(v->dims, p[0], p[1], p[2]);
                bool can;
                if (side_of(v, i) != 1 || v->a[i] != v->b[i])
                    continue;
                solid++;
                surface += on_surface(v, p, i, &can);
            }
    if (2 * known < s->count || (!cut && solid >= TELLING && 4 * surface > 3 * solid))
        return false;
    return say(text, cut ? "every difference lies on the border of what is cut, one voxel deep" : "every difference lies on A's surface, one voxel deep");
}

static bool speckle(const scan *s, char *text)
{
    const pattern_view *v = s->v;
    int64_t alone = 0;
    EACH_DIFFERENT(s, p, i) {
        bool company = false;
        for (int w = 0; w < 6; w++) {
            const int64_t x = p[0] + ways[w][0], y = p[1] + ways[w][1], z = p[2] + ways[w][2];
            company |= inside(v->dims, x, y, z) && v->a[at(v->dims, x, y, z)] != v->b[at(v->dims, x, y, z)];
        }
        alone += !company;
    }
    return alone * 2 > s->count && say(text, "%lld of %lld voxel%s no neighbour that differs", (long long)alone, (long long)s->count, s->count == 1 ? " has" : "s have");
}

void pattern_find(const pattern_view *view, pattern_list *out)
{
    static rule *const rules[PATTERN_UNCLASSIFIED] = {
        [PATTERN_BYTE_ORDER] = byte_order, [PATTERN_AXIS_SWAP] = axis_swap,           [PATTERN_SHIFT] = shift,
        [PATTERN_OFFSET] = offset,         [PATTERN_THRESHOLD] = threshold,           [PATTERN_STALE_CHUNK] = stale_chunk,
        [PATTERN_LOST_TAIL] = lost_tail,   [PATTERN_LOST_CHUNK] = lost_chunk,         [PATTERN_COLUMN_PARITY] = column_parity,
        [PATTERN_SPECKLE] = speckle,       [PATTERN_BOUNDARY_LAYER] = boundary_layer,
    };
    scan s = {.v = view};
    *out = (pattern_list){.of_all = PATTERN_UNCLASSIFIED};
    const bool same = same_dims(view->dims, view->dims_b);
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
