/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What a difference as a whole looks like.  Each pattern is a statement that
 * is checked on every voxel it speaks of, so that it is a fact and not a guess;
 * several may hold at once.
 *
 *   geometry        dims, spacing or origin differ
 *   orientation     B is A with axes permuted or turned round
 *   shift           B is A moved by up to three voxels (where both have voxels)
 *   byte-order      B is A with the bytes of each voxel swapped
 *   offset          all changed densities differ by the same amount
 *   threshold       what is missing is all that was less dense than some value
 *   only-removed    nothing but removal, as by reaming
 *   only-added      nothing but addition
 *   whole-chunks    every chunk that differs is empty on one side
 *   boundary-layer  solid voxels came or went only on A's surface, one layer thick
 *   scattered       most voxels that differ have no neighbour that does
 */
#include "app/diff_compare.h"

#include <limits.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

static void add(diff_result *r, const char *name, const char *format, ...) OST_PRINTF(3, 4);
static void add(diff_result *r, const char *name, const char *format, ...)
{
    if (r->pattern_count == DIFF_PATTERN_MAX)
        return;
    diff_pattern *p = &r->patterns[r->pattern_count++];
    p->name = name;
    va_list args;
    va_start(args, format);
    vsnprintf(p->text, sizeof p->text, format, args);
    va_end(args);
}

static void geometry(const loaded_volume *a, const loaded_volume *b, diff_result *r)
{
    if (r->same_dims && r->same_spacing && r->same_origin)
        return;
    const ost_geometry *ga = &a->volume.geometry, *gb = &b->volume.geometry;
    char text[2][3][OST_PM_TEXT];
    if (!r->same_dims) {
        add(r, "geometry", "dims %d x %d x %d against %d x %d x %d", ga->dims.x, ga->dims.y, ga->dims.z, gb->dims.x, gb->dims.y, gb->dims.z);
        return;
    }
    const ost_pm3 va = r->same_spacing ? ga->origin : ga->spacing, vb = r->same_spacing ? gb->origin : gb->spacing;
    add(r, "geometry", "%s (%s, %s, %s) against (%s, %s, %s) mm", r->same_spacing ? "origin" : "spacing", ost_pm_format(va.x, text[0][0]),
        ost_pm_format(va.y, text[0][1]), ost_pm_format(va.z, text[0][2]), ost_pm_format(vb.x, text[1][0]), ost_pm_format(vb.y, text[1][1]),
        ost_pm_format(vb.z, text[1][2]));
}

/* -------------------------------------------------- B as a rearranged A */

/* Voxel p of B's grid is voxel q of A's: q[from[axis]] = flip ? n - 1 - p[axis] : p[axis], all plus shift. */
typedef struct arrangement {
    int from[3];
    bool flip[3];
    int32_t shift[3];
} arrangement;

static bool arranged_equal(const ost_volume *a, const ost_volume *b, const arrangement *how, int32_t stride)
{
    const int32_t da[3] = {a->geometry.dims.x, a->geometry.dims.y, a->geometry.dims.z};
    const int32_t db[3] = {b->geometry.dims.x, b->geometry.dims.y, b->geometry.dims.z};
    int32_t p[3], q[3];
    bool solid = false;
    for (p[2] = 0; p[2] < db[2]; p[2] += stride)
        for (p[1] = 0; p[1] < db[1]; p[1] += stride)
            for (p[0] = 0; p[0] < db[0]; p[0] += stride) {
                bool inside = true;
                for (int axis = 0; axis < 3; axis++) {
                    int to = how->from[axis];
                    q[to] = (how->flip[axis] ? db[axis] - 1 - p[axis] : p[axis]) + how->shift[to];
                    inside &= q[to] >= 0 && q[to] < da[to];
                }
                if (!inside)
                    continue;
                int16_t vb = b->voxels[p[0] + db[0] * (p[1] + (int64_t)db[1] * p[2])];
                if (a->voxels[q[0] + da[0] * (q[1] + (int64_t)da[1] * q[2])] != vb)
                    return false;
                solid |= vb != 0;
            }
    return solid || stride > 1;
}

/* A coarse look first: most arrangements fail it at once. */
static bool arranged(const ost_volume *a, const ost_volume *b, const arrangement *how)
{
    return arranged_equal(a, b, how, 7) && arranged_equal(a, b, how, 1);
}

static bool orientation(const loaded_volume *a, const loaded_volume *b, diff_result *r)
{
    static const int permutation[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
    const int32_t da[3] = {a->volume.geometry.dims.x, a->volume.geometry.dims.y, a->volume.geometry.dims.z};
    const int32_t db[3] = {b->volume.geometry.dims.x, b->volume.geometry.dims.y, b->volume.geometry.dims.z};
    for (int p = 0; p < 6; p++)
        for (int f = 0; f < 8; f++) {
            arrangement how = {.shift = {0, 0, 0}};
            bool fits = true;
            for (int axis = 0; axis < 3; axis++) {
                how.from[axis] = permutation[p][axis];
                how.flip[axis] = f >> axis & 1;
                fits &= da[how.from[axis]] == db[axis];
            }
            if (!fits || (p == 0 && f == 0) || !arranged(&a->volume, &b->volume, &how))
                continue;
            add(r, "orientation", "B's axes x, y, z are A's %s%c, %s%c, %s%c", how.flip[0] ? "-" : "", "xyz"[how.from[0]],
                how.flip[1] ? "-" : "", "xyz"[how.from[1]], how.flip[2] ? "-" : "", "xyz"[how.from[2]]);
            return true;
        }
    return false;
}

static bool shift(const loaded_volume *a, const loaded_volume *b, diff_result *r)
{
    enum { REACH = 3 };
    for (int z = -REACH; z <= REACH; z++)
        for (int y = -REACH; y <= REACH; y++)
            for (int x = -REACH; x <= REACH; x++) {
                const arrangement how = {.from = {0, 1, 2}, .shift = {-x, -y, -z}};
                if ((!x && !y && !z) || !arranged(&a->volume, &b->volume, &how))
                    continue;
                add(r, "shift", "B is A moved by (%d, %d, %d) voxels", x, y, z);
                return true;
            }
    return false;
}

/* -------------------------------------------------- statements on values */

static void values(const loaded_volume *a, const loaded_volume *b, diff_result *r)
{
    const int64_t n = ost_dims_count(a->volume.geometry.dims);
    const int16_t *pa = a->volume.voxels, *pb = b->volume.voxels;
    bool swapped = true, one_offset = true;
    int offset = 0;
    int32_t densest_gone = INT_MIN, least_kept = INT_MAX, densest_new = INT_MIN, least_old = INT_MAX;
    for (int64_t v = 0; v < n; v++) {
        uint16_t ua = (uint16_t)pa[v];
        swapped &= pb[v] == (int16_t)(uint16_t)(ua << 8 | ua >> 8);
        bool sa = pa[v] >= a->threshold, sb = pb[v] >= b->threshold;
        if (sb && pb[v] < least_kept)
            least_kept = pb[v];
        if (sa && pa[v] < least_old)
            least_old = pa[v];
        if (sa && !sb && pa[v] > densest_gone)
            densest_gone = pa[v];
        if (sb && !sa && pb[v] > densest_new)
            densest_new = pb[v];
        if (pa[v] != pb[v]) {
            int d = pb[v] - pa[v];
            one_offset &= sa && sb && (offset == 0 || d == offset);
            offset = d;
        }
    }
    if (swapped)
        add(r, "byte-order", "every voxel of B is A's with its two bytes swapped");
    if (one_offset && r->count[DIFF_CHANGED] == r->different)
        add(r, "offset", "every voxel that differs is %d %s in B", abs(offset), offset > 0 ? "more" : "less");
    if (r->count[DIFF_REMOVED] && r->count[DIFF_REMOVED] == r->different) {
        if (densest_gone < least_kept && least_kept != INT_MAX)
            add(r, "threshold", "B lacks exactly what is less dense than %d", densest_gone + 1);
        add(r, "only-removed", "B is A with voxels removed, nothing else");
    }
    if (r->count[DIFF_ADDED] && r->count[DIFF_ADDED] == r->different) {
        if (densest_new < least_old && least_old != INT_MAX)
            add(r, "threshold", "A lacks exactly what is less dense than %d", densest_new + 1);
        add(r, "only-added", "B is A with voxels added, nothing else");
    }
}

static void whole_chunks(diff_result *r)
{
    for (size_t c = 0; c < r->chunk_count; c++) {
        const diff_chunk *chunk = &r->chunks[c];
        bool gone = chunk->solid_a && !chunk->solid_b, come = !chunk->solid_a && chunk->solid_b;
        if (!gone && !come)
            return;
    }
    add(r, "whole-chunks", "%zu whole chunk%s, and nothing else", r->chunk_count,
        r->chunk_count == 1 ? " is solid on one side only" : "s are solid on one side only");
}

/* --------------------------------------------- statements on neighbours */

typedef struct neighbourhood {
    const loaded_volume *a, *b;
    int64_t step[3];
    int32_t dims[3];
} neighbourhood;

static bool is_solid(const neighbourhood *h, int64_t v)
{
    return h->a->volume.voxels[v] >= h->a->threshold;
}

static void neighbours(const loaded_volume *a, const loaded_volume *b, diff_result *r)
{
    const ost_dims d = a->volume.geometry.dims;
    const neighbourhood h = {.a = a, .b = b, .step = {1, d.x, (int64_t)d.x * d.y}, .dims = {d.x, d.y, d.z}};
    int64_t alone = 0;
    bool layer = r->count[DIFF_CHANGED] == 0 && r->count[DIFF_BELOW] == 0;
    int32_t p[3];
    for (p[2] = r->box.lo[2]; p[2] < r->box.hi[2]; p[2]++)
        for (p[1] = r->box.lo[1]; p[1] < r->box.hi[1]; p[1]++)
            for (p[0] = r->box.lo[0]; p[0] < r->box.hi[0]; p[0]++) {
                int64_t v = p[0] * h.step[0] + p[1] * h.step[1] + p[2] * h.step[2];
                if (a->volume.voxels[v] == b->volume.voxels[v])
                    continue;
                bool company = false, border = false, solid = is_solid(&h, v);
                for (int axis = 0; axis < 3; axis++)
                    for (int way = -1; way <= 1; way += 2) {
                        if (p[axis] + way < 0 || p[axis] + way >= h.dims[axis]) {
                            border |= solid;
                            continue;
                        }
                        int64_t next = v + way * h.step[axis];
                        company |= a->volume.voxels[next] != b->volume.voxels[next];
                        border |= is_solid(&h, next) != solid;
                    }
                alone += !company;
                layer &= border;
            }
    if (layer)
        add(r, "boundary-layer", "every difference lies on A's surface, one voxel deep");
    if (alone * 2 > r->different)
        add(r, "scattered", "%lld of %lld voxels have no neighbour that differs", (long long)alone, (long long)r->different);
}

void diff_patterns(const loaded_volume *a, const loaded_volume *b, diff_result *r)
{
    geometry(a, b, r);
    if (r->same_dims && !r->different)
        return;
    bool rearranged = orientation(a, b, r);
    if (!r->same_dims)
        return;
    if (!rearranged)
        shift(a, b, r);
    values(a, b, r);
    whole_chunks(r);
    neighbours(a, b, r);
}
