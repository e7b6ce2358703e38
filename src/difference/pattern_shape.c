/* SPDX-License-Identifier: Apache-2.0 */
/* Implements the rules of pattern.h for rows, for the surface, and for neighbouring voxels. */
#include <osteon/mesh.h>

#include "difference/pattern_parts.h"

/* Returns the end of the complete run of equal voxels in g that begins at x. Returns x if no run begins there or if
   the run continues beyond `end`. */
static int32_t run_from(const int16_t *g, int32_t n, int32_t x, int32_t end)
{
    int32_t to = x + 1;
    if (x > 0 && g[x - 1] == g[x])
        return x;
    while (to < end && g[to] == g[x])
        to++;
    return to == n || g[to] != g[x] ? to : x;
}

/* Returns the smallest number of complete runs of a or b that exactly cover the voxels x with from <= x < end, or 0 if
   no runs cover them exactly. */
static int32_t runs_between(const int16_t *a, const int16_t *b, int32_t n, int32_t from, int32_t end)
{
    /* least[x] is 1 + the minimum number of runs that exactly cover [from, x), or 0 if no runs cover it */
    int32_t least[OST_TOOL_DIM_MAX + 1] = {0};
    least[from] = 1;
    for (int32_t x = from; x < end; x++) {
        if (!least[x])
            continue;
        for (int g = 0; g < 2; g++) {
            const int32_t to = run_from(g ? b : a, n, x, end);
            if (to > x && (!least[to] || least[to] > least[x] + 1))
                least[to] = least[x] + 1;
        }
    }
    return least[end] ? least[end] - 1 : 0;
}

bool ost_pattern_column_parity(const pattern_scan *s, char *text)
{
    const pattern_view *v = s->v;
    int64_t runs = 0, rows = 0;
    if (!v->tool || v->dims.x > OST_TOOL_DIM_MAX)
        return false;
    for (int32_t z = s->lo[2]; z < s->hi[2]; z++)
        for (int32_t y = s->lo[1]; y < s->hi[1]; y++) {
            const int16_t *a = v->a + pattern_at(v->dims, 0, y, z), *b = v->b + pattern_at(v->dims, 0, y, z);
            const int64_t before = runs;
            for (int32_t x = 0; x < v->dims.x; x++) {
                int32_t end = x;
                while (end < v->dims.x && a[end] != b[end])
                    end++;
                if (end == x)
                    continue;
                const int32_t these = runs_between(a, b, v->dims.x, x, end);
                if (!these)
                    return false;
                runs += these;
                x = end - 1;
            }
            rows += runs > before;
        }
    return s->count >= 2 * runs &&
           ost_pattern_describe(text, "whole runs of voxels along x, between crossings of the surface, in %lld row%s",
                                (long long)rows, rows == 1 ? "" : "s");
}

bool ost_pattern_tool_class(const pattern_scan *s, char *text)
{
    const pattern_view *v = s->v;
    if (!v->tool)
        return false;
    PATTERN_EACH(s, p, i)
        if (v->a[i] < v->solid_a || v->b[i] < v->solid_b)
            return false;
    return ost_pattern_describe(text, "every voxel that differs is solid in both: one has it cutting, the other not");
}

static const int ways[6][3] = {{-1, 0, 0}, {1, 0, 0}, {0, -1, 0}, {0, 1, 0}, {0, 0, -1}, {0, 0, 1}};

/* Returns the side of the surface on which a voxel of A lies: 1 if it is solid, otherwise 0. In a tool, returns the
   class of the voxel instead. If the input is the bone before an event, returns 1 if the event removed the voxel, 0 if
   the voxel remained, and -1 if it was not bone before. */
static int side_of(const pattern_view *v, int64_t i)
{
    if (v->tool)
        return v->a[i];
    if (v->input == PATTERN_BEFORE)
        return v->in[i] == 0 ? -1 : v->a[i] == 0;
    return v->a[i] >= v->solid_a;
}

/* Returns true if one of the 26 neighbours of voxel p is on the other side of the surface. Neighbours outside the
   grid count as empty, or are ignored if the input is the bone before an event. Sets *known to true if at least one
   neighbour can be compared. */
static bool on_surface(const pattern_view *v, const int32_t p[3], int64_t i, bool *known)
{
    const int mine = side_of(v, i);
    bool surface = false;
    *known = false;
    for (int w = 0; w < 27; w++) {
        const int32_t q[3] = {p[0] + w % 3 - 1, p[1] + w / 3 % 3 - 1, p[2] + w / 9 - 1};
        if (w == 13)
            continue;
        const bool in = pattern_inside(v->dims, q[0], q[1], q[2]);
        const int other = in ? side_of(v, pattern_at(v->dims, q[0], q[1], q[2])) : v->input == PATTERN_BEFORE ? -1 : 0;
        *known |= other >= 0;
        surface |= other >= 0 && other != mine;
    }
    return surface;
}

bool ost_pattern_boundary_layer(const pattern_scan *s, char *text)
{
    const pattern_view *v = s->v;
    const bool cut = v->input == PATTERN_BEFORE;
    int64_t known = 0;
    PATTERN_EACH(s, p, i) {
        bool can;
        if (cut ? v->in[i] == 0 || (v->a[i] != 0 && v->b[i] != 0)
                : !v->tool && (v->a[i] >= v->solid_a) == (v->b[i] >= v->solid_b))
            return false;
        const bool on = on_surface(v, p, i, &can);
        if (can && !on)
            return false;
        known += can;
    }
    /* If most solid voxels are on the surface, most differences are on the surface too, so the pattern is not
       significant. */
    int64_t solid = 0, surface = 0;
    int32_t p[3];
    for (p[2] = s->lo[2]; p[2] < s->hi[2]; p[2]++)
        for (p[1] = s->lo[1]; p[1] < s->hi[1]; p[1]++)
            for (p[0] = s->lo[0]; p[0] < s->hi[0]; p[0]++) {
                const int64_t i = pattern_at(v->dims, p[0], p[1], p[2]);
                bool can;
                if (side_of(v, i) <= 0 || v->a[i] != v->b[i])
                    continue;
                solid++;
                surface += on_surface(v, p, i, &can);
            }
    if (2 * known < s->count || (!cut && solid >= PATTERN_TELLING && 4 * surface > 3 * solid))
        return false;
    return ost_pattern_describe(text, cut ? "every difference lies on the border of what is cut, one voxel deep"
                                      : "every difference lies on A's surface, one voxel deep");
}

/*
 * Returns true if the row of B that begins at index `row` can be explained by counts of the previous row that were not
 * cleared. Such a row is solid where at least one of the two rows is solid (winding), or where exactly one of them is
 * solid (parity). Adds to *differing the number of voxels of the row that became solid or empty.
 */
static bool is_carried(const pattern_view *v, int64_t row, int64_t *differing)
{
    bool differs = false, either = true, one = true, known = true;
    for (int64_t i = row; i < row + v->dims.x; i++) {
        const bool a = v->a[i] != 0, b = v->b[i] != 0, before = row > 0 && v->b[i - v->dims.x] != 0;
        differs |= v->a[i] != v->b[i];
        *differing += a != b;
        either &= b == (a || before);
        one &= b == (a != before);
        known &= v->a[i] == v->b[i] || before;
    }
    return !differs || (known && (either || one));
}

bool ost_pattern_carried_rows(const pattern_scan *s, char *text)
{
    const pattern_view *v = s->v;
    int64_t differing = 0;
    if (!v->tool)
        return false;
    for (int32_t z = s->lo[2]; z < s->hi[2]; z++)
        for (int32_t y = s->lo[1]; y < s->hi[1]; y++)
            if (!is_carried(v, pattern_at(v->dims, 0, y, z), &differing))
                return false;
    return differing >= PATTERN_TELLING &&
           ost_pattern_describe(text, "every row that differs is what the row before it and its own make together");
}

bool ost_pattern_speckle(const pattern_scan *s, char *text)
{
    const pattern_view *v = s->v;
    int64_t alone = 0;
    PATTERN_EACH(s, p, i) {
        bool company = false;
        for (int w = 0; w < 6; w++) {
            const int64_t x = p[0] + ways[w][0], y = p[1] + ways[w][1], z = p[2] + ways[w][2];
            company |= pattern_inside(v->dims, x, y, z) &&
                       v->a[pattern_at(v->dims, x, y, z)] != v->b[pattern_at(v->dims, x, y, z)];
        }
        alone += !company;
    }
    return alone * 2 > s->count &&
           ost_pattern_describe(text, "%lld of %lld voxel%s no neighbour that differs", (long long)alone,
                                (long long)s->count, s->count == 1 ? " has" : "s have");
}

