/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Rect grid to cubic (AR-CUB): three lists of indices and no voxel.  A grid
 * that is itself a selection gives lists of lists.
 */
#include "core/conditions.h"

#include <stdlib.h>

#include "core/integer.h"
#include "cpu/import/grid.h"
#include "cpu/import/import.h"

/* i * spacing < 2^14 * 10^11 < 2^51. The floor is below n, as i < ceil(n rect / cubic). */
static int64_t source_index(int64_t i, ost_pm cubic, ost_pm rect, int32_t n, ost_resample rule)
{
    if (rule == OST_RESAMPLE_FLOOR)
        return ost_floor_div(i * cubic, rect);
    int64_t nearest = ost_floor_div((2 * i + 1) * cubic, 2 * rect);
    return nearest < n - 1 ? nearest : n - 1;
}

ost_status ost_cpu_rect_to_cubic(const ost_grid *base, const ost_geometry *geometry, ost_resample rule, ost_grid **out, ost_error *err)
{
    const cpu_grid *rect = (const cpu_grid *)base;
    const ost_geometry *r = &base->geometry;
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
            int32_t at = (int32_t)source_index(i, geometry->spacing.x, spacing[a], from[a], rule);
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
