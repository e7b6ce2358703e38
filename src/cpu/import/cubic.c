/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Resamples a rect grid to a cubic grid (AR-CUB). The cubic grid contains no voxels of its own: it refers to the
 * voxels of the rect grid by a list for each axis.
 *
 *   nearest, thesis   lists of indices; if the rect grid also has lists, the indices of
 *                     both grids are composed, so that the new lists refer to the store
 *   linear            lists of indices and weights (cpu_view); if the rect grid also
 *                     has lists, its voxels are first copied to a store of its own
 */
#include "core/conditions.h"

#include <stdlib.h>

#include "core/integer.h"
#include "cpu/import/grid.h"
#include "cpu/import/import.h"

/*
 * The source of a cubic voxel on one axis. The rect voxel `index` has the weight 2^15 - weight, and the next rect voxel
 * has the weight `weight`. The grid contains the next rect voxel if `weight` is above 0.
 */
typedef struct source_position {
    int32_t index, weight;
} source_position;

/*
 * Returns the source position of cubic voxel i among n rect voxels of one axis.
 *
 * Ranges. (2 i + 1) * spacing < 2^15 * 2^37; 2^15 * remainder < 2^15 * 2^38. The floor of the
 * `thesis` rule is below n, because i < ceil(n rect / cubic).
 */
static source_position source_position_of(int64_t i, ost_pm cubic, ost_pm rect, int32_t n, ost_resample rule)
{
    const int64_t last = n - 1;
    if (rule == OST_RESAMPLE_THESIS)
        return (source_position){(int32_t)ost_floor_div(i * cubic, rect), 0};
    if (rule == OST_RESAMPLE_NEAREST) {
        const int64_t nearest = ost_floor_div((2 * i + 1) * cubic, 2 * rect);
        return (source_position){(int32_t)(nearest < last ? nearest : last), 0};
    }
    const int64_t at = (2 * i + 1) * cubic - rect, index = at < 0 ? 0 : at / (2 * rect);
    if (at <= 0 || index >= last)
        return (source_position){(int32_t)(at <= 0 ? 0 : last), 0};
    return (source_position){(int32_t)index,
                             (int32_t)ost_rhe_div((at - index * 2 * rect) << OST_WEIGHT_BITS, 2 * rect)};
}

typedef struct lists {
    int32_t *map[3];
    int16_t *minus[3];
    bool same[3]; /* for each axis: true if voxel i of the cubic grid is voxel i of the rect grid for all i */
    bool weighted[3]; /* for each axis: true if at least one voxel has an upper neighbour with a weight above 0 */
} lists;

static void drop_weights(lists *l, int axis)
{
    free(l->minus[axis]);
    l->minus[axis] = NULL;
}

static void free_lists(lists *l)
{
    for (int a = 0; a < 3; a++) {
        free(l->map[a]);
        drop_weights(l, a);
    }
}

/*
 * Computes the index list of axis a and, for the `linear` rule, the weight list. Their capacity is the number of voxels
 * rounded up to a multiple of 16, as kernels.h requires. Returns false if memory is exhausted.
 */
static bool make_axis(lists *l, int a, int32_t from, int32_t to, ost_pm cubic, ost_pm rect, ost_resample rule)
{
    const size_t capacity = ((size_t)to + 15) / 16 * 16;
    l->map[a] = calloc(capacity, sizeof *l->map[a]);
    if (rule == OST_RESAMPLE_LINEAR)
        l->minus[a] = calloc(2 * capacity, sizeof *l->minus[a]);
    if (!l->map[a] || (rule == OST_RESAMPLE_LINEAR && !l->minus[a]))
        return false;
    l->same[a] = from == to;
    for (int32_t i = 0; i < to; i++) {
        const source_position p = source_position_of(i, cubic, rect, from, rule);
        l->map[a][i] = p.index;
        l->same[a] = l->same[a] && p.index == i && p.weight == 0;
        l->weighted[a] = l->weighted[a] || p.weight != 0;
        if (l->minus[a]) {
            l->minus[a][2 * i] = (int16_t)(p.weight - OST_WEIGHT_ONE);
            l->minus[a][2 * i + 1] = (int16_t)-p.weight;
        }
    }
    return true;
}

/*
 * Frees the weight lists that a cpu_view does not need:
 *
 *   no weight is above 0      all lists
 *   only z is resampled       the lists of x and y
 *   otherwise                 a list of y or z whose weights are all 0
 *
 * If the list of x remains, both neighbours of a voxel along x must exist. A voxel whose source is the last rect voxel
 * therefore gets the last two rect voxels as its neighbours, with weight 0 for the lower one.
 */
static void finish_weights(lists *l, int32_t width, int32_t last)
{
    const bool planes = !l->same[0] || !l->same[1], any = l->weighted[0] || l->weighted[1] || l->weighted[2];
    for (int a = 0; a < 3; a++)
        if (!any || (!planes && !l->weighted[a]) || (a > 0 && !l->weighted[a]))
            drop_weights(l, a);
    for (int32_t i = 0; i < width && l->minus[0] && last > 0; i++)
        if (l->map[0][i] == last) {
            l->map[0][i] = last - 1;
            l->minus[0][2 * i] = 0;
            l->minus[0][2 * i + 1] = -OST_WEIGHT_ONE;
        }
}

ost_status ost_cpu_rect_to_cubic(const ost_grid *base, const ost_geometry *geometry, ost_resample rule, ost_grid **out,
                                 ost_error *err)
{
    /* const is cast away, because ost_cpu_grid_own may copy the voxels of the rect grid to a new store. */
    cpu_grid *rect = (cpu_grid *)(uintptr_t)base;
    const ost_geometry *r = &base->geometry;
    const int32_t from[3] = {r->dims.x, r->dims.y, r->dims.z},
                  to[3] = {geometry->dims.x, geometry->dims.y, geometry->dims.z};
    const ost_pm spacing[3] = {r->spacing.x, r->spacing.y, r->spacing.z};
    lists l = {.map = {NULL}};
    for (int a = 0; a < 3; a++)
        if (!make_axis(&l, a, from[a], to[a], geometry->spacing.x, spacing[a], rule)) {
            free_lists(&l);
            return ost_fail(err, OST_ERR_MEMORY, "out of memory for %d indices", (int)to[a]);
        }
    finish_weights(&l, to[0], from[0] - 1);
    const cpu_view view = ost_cpu_grid_view(rect);
    if (view.map[0] && (ost_cpu_view_linear(&view) || l.minus[0] || l.minus[2])) {
        const ost_status status = ost_cpu_grid_own(rect, err);
        if (status != OST_OK) {
            free_lists(&l);
            return status;
        }
    }
    if (rect->map[0]) /* replaces indices of rect voxels with indices of the rect grid's store */
        for (int a = 0; a < 3; a++)
            for (int32_t i = 0; i < to[a]; i++)
                l.map[a][i] = rect->map[a][l.map[a][i]];
    else if (l.same[0] && l.same[1] && l.same[2])
        for (int a = 0; a < 3; a++) {
            free(l.map[a]);
            l.map[a] = NULL;
        }
    return ost_cpu_grid_select(rect, geometry, l.map, l.minus, out, err);
}
