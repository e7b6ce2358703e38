/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Rect grid to cubic (AR-CUB).
 *
 *   nearest, thesis   three lists of indices and no voxel; a grid that is
 *                     itself a selection gives lists of lists
 *   linear            a grid of its own, unless all spacings are equal
 */
#include "core/conditions.h"

#include <stdlib.h>

#include "core/integer.h"
#include "cpu/import/grid.h"
#include "cpu/import/import.h"

enum { WEIGHT_BITS = 15, ONE = 1 << WEIGHT_BITS };

/* (ONE - weight) of voxel index and weight of the next, which is inside the grid if weight > 0. */
typedef struct tap {
    int32_t index, weight;
} tap;

/* (2 i + 1) * spacing < 2^15 * 2^37; 2^15 * rest < 2^15 * 2^38. The floor of thesis is below n, as i < ceil(n rect / cubic). */
static tap tap_at(int64_t i, ost_pm cubic, ost_pm rect, int32_t n, ost_resample rule)
{
    const int64_t last = n - 1;
    if (rule == OST_RESAMPLE_THESIS)
        return (tap){(int32_t)ost_floor_div(i * cubic, rect), 0};
    if (rule == OST_RESAMPLE_NEAREST) {
        const int64_t nearest = ost_floor_div((2 * i + 1) * cubic, 2 * rect);
        return (tap){(int32_t)(nearest < last ? nearest : last), 0};
    }
    const int64_t at = (2 * i + 1) * cubic - rect, index = at < 0 ? 0 : at / (2 * rect);
    if (at <= 0 || index >= last)
        return (tap){(int32_t)(at <= 0 ? 0 : last), 0};
    return (tap){(int32_t)index, (int32_t)ost_rhe_div((at - index * 2 * rect) << WEIGHT_BITS, 2 * rect)};
}

static ost_status select_voxels(const cpu_grid *rect, const ost_geometry *geometry, ost_resample rule, ost_grid **out, ost_error *err)
{
    const ost_geometry *r = &rect->base.geometry;
    const int32_t from[3] = {r->dims.x, r->dims.y, r->dims.z}, to[3] = {geometry->dims.x, geometry->dims.y, geometry->dims.z};
    const ost_pm spacing[3] = {r->spacing.x, r->spacing.y, r->spacing.z};
    int32_t *map[3] = {NULL, NULL, NULL};
    bool same = !rect->map[0];
    for (int a = 0; a < 3; a++) {
        map[a] = malloc((size_t)to[a] * sizeof *map[a]);
        if (!map[a]) {
            free(map[0]);
            free(map[1]);
            return ost_fail(err, OST_ERR_MEMORY, "no memory for %d indices", (int)to[a]);
        }
        same = same && from[a] == to[a];
        for (int32_t i = 0; i < to[a]; i++) {
            int32_t at = tap_at(i, geometry->spacing.x, spacing[a], from[a], rule).index;
            map[a][i] = rect->map[a] ? rect->map[a][at] : at;
            same = same && at == i;
        }
    }
    for (int a = 0; a < 3 && same; a++) {
        free(map[a]);
        map[a] = NULL;
    }
    return ost_cpu_grid_select(rect, geometry, map, out, err);
}

/* What a view's rows are at an index of an axis. */
static size_t source(const cpu_view *view, int a, int32_t i)
{
    return (size_t)(view->map[a] ? view->map[a][i] : i);
}

/* The products of weights sum to 2^45, so |sum| <= 2^60, and the mean lies between the least and the greatest voxel. */
static int16_t weighted(const cpu_view *view, tap x, tap y, tap z)
{
    int64_t sum = 0;
    for (int corner = 0; corner < 8; corner++) {
        const int dx = corner & 1, dy = corner >> 1 & 1, dz = corner >> 2;
        const int64_t weight = (int64_t)(dx ? x.weight : ONE - x.weight) * (dy ? y.weight : ONE - y.weight) * (dz ? z.weight : ONE - z.weight);
        if (weight > 0)
            sum += weight * view->voxels[source(view, 0, x.index + dx) + view->row * source(view, 1, y.index + dy) +
                                         view->slice * source(view, 2, z.index + dz)];
    }
    return (int16_t)ost_rhe_div(sum, INT64_C(1) << 3 * WEIGHT_BITS);
}

static ost_status interpolate(const cpu_grid *rect, const ost_geometry *geometry, ost_grid **out, ost_error *err)
{
    const cpu_backend *backend = (const cpu_backend *)rect->base.backend;
    const ost_geometry *r = &rect->base.geometry;
    const ost_dims d = geometry->dims;
    const cpu_view view = ost_cpu_grid_view(rect);
    const ost_pm c = geometry->spacing.x;
    tap *x = malloc((size_t)d.x * sizeof *x);
    if (!x)
        return ost_fail(err, OST_ERR_MEMORY, "no memory for %d indices", (int)d.x);
    ost_status status = ost_cpu_grid_create(rect->base.backend, geometry, out, err);
    if (status != OST_OK) {
        free(x);
        return status;
    }
    int16_t *voxels = ((cpu_grid *)*out)->store->voxels;
    for (int32_t i = 0; i < d.x; i++)
        x[i] = tap_at(i, c, r->spacing.x, r->dims.x, OST_RESAMPLE_LINEAR);
    const int64_t rows = (int64_t)d.y * d.z;
#pragma omp parallel for schedule(static) num_threads(ost_cpu_threads(backend, rows * d.x))
    for (int64_t row = 0; row < rows; row++) {
        const tap y = tap_at(row % d.y, c, r->spacing.y, r->dims.y, OST_RESAMPLE_LINEAR);
        const tap z = tap_at(row / d.y, c, r->spacing.z, r->dims.z, OST_RESAMPLE_LINEAR);
        for (int32_t i = 0; i < d.x; i++)
            voxels[row * d.x + i] = weighted(&view, x[i], y, z);
    }
    free(x);
    return OST_OK;
}

ost_status ost_cpu_rect_to_cubic(const ost_grid *base, const ost_geometry *geometry, ost_resample rule, ost_grid **out, ost_error *err)
{
    const cpu_grid *rect = (const cpu_grid *)base;
    const ost_pm3 from = base->geometry.spacing, to = geometry->spacing;
    const bool equal = from.x == to.x && from.y == to.y && from.z == to.z;
    return rule == OST_RESAMPLE_LINEAR && !equal ? interpolate(rect, geometry, out, err) : select_voxels(rect, geometry, rule, out, err);
}
