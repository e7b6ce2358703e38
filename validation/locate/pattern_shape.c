/* SPDX-License-Identifier: Apache-2.0 */
/* Rules on rows, on the surface, and on neighbours. */
#include "validation/locate/pattern_parts.h"

/* Voxels x0 <= x < x1 of the row are one run of g. */
static bool whole_run(const int16_t *row, int32_t n, int32_t x0, int32_t x1)
{
    for (int32_t x = x0; x + 1 < x1; x++)
        if (row[x] != row[x + 1])
            return false;
    return (x0 == 0 || row[x0 - 1] != row[x0]) && (x1 == n || row[x1] != row[x1 - 1]);
}

bool pattern_column_parity(const pattern_scan *s, char *text)
{
    const pattern_view *v = s->v;
    int64_t runs = 0, rows = 0;
    if (!v->tool)
        return false;
    for (int32_t z = s->lo[2]; z < s->hi[2]; z++)
        for (int32_t y = s->lo[1]; y < s->hi[1]; y++) {
            const int16_t *a = v->a + pattern_at(v->dims, 0, y, z), *b = v->b + pattern_at(v->dims, 0, y, z);
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
    return s->count >= 2 * runs && pattern_say(text, "whole runs of voxels along x, between crossings of the surface, in %lld row%s", (long long)rows, rows == 1 ? "" : "s");
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
        const bool in = pattern_inside(v->dims, q[0], q[1], q[2]);
        const int other = in ? side_of(v, pattern_at(v->dims, q[0], q[1], q[2])) : v->input == PATTERN_BEFORE ? -1 : 0;
        *known |= other >= 0;
        surface |= other >= 0 && other != mine;
    }
    return surface;
}

bool pattern_boundary_layer(const pattern_scan *s, char *text)
{
    const pattern_view *v = s->v;
    const bool cut = v->input == PATTERN_BEFORE;
    int64_t known = 0;
    PATTERN_EACH(s, p, i) {
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
                const int64_t i = pattern_at(v->dims, p[0], p[1], p[2]);
                bool can;
                if (side_of(v, i) != 1 || v->a[i] != v->b[i])
                    continue;
                solid++;
                surface += on_surface(v, p, i, &can);
            }
    if (2 * known < s->count || (!cut && solid >= PATTERN_TELLING && 4 * surface > 3 * solid))
        return false;
    return pattern_say(text, cut ? "every difference lies on the border of what is cut, one voxel deep" : "every difference lies on A's surface, one voxel deep");
}

bool pattern_carried_rows(const pattern_scan *s, char *text)
{
    const pattern_view *v = s->v;
    if (!v->tool || s->count < PATTERN_TELLING)
        return false;
    PATTERN_EACH(s, p, i)
        if (v->a[i] != 0 || i < v->dims.x || v->b[i - v->dims.x] == 0)
            return false;
    return pattern_say(text, "every voxel that differs is solid, and so is the one in the row before it");
}

bool pattern_speckle(const pattern_scan *s, char *text)
{
    const pattern_view *v = s->v;
    int64_t alone = 0;
    PATTERN_EACH(s, p, i) {
        bool company = false;
        for (int w = 0; w < 6; w++) {
            const int64_t x = p[0] + ways[w][0], y = p[1] + ways[w][1], z = p[2] + ways[w][2];
            company |= pattern_inside(v->dims, x, y, z) && v->a[pattern_at(v->dims, x, y, z)] != v->b[pattern_at(v->dims, x, y, z)];
        }
        alone += !company;
    }
    return alone * 2 > s->count && pattern_say(text, "%lld of %lld voxel%s no neighbour that differs", (long long)alone, (long long)s->count, s->count == 1 ? " has" : "s have");
}

