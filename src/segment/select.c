/* SPDX-License-Identifier: Apache-2.0 */
#include <osteon/segment.h>

#include <stdlib.h>

#include "core/integer.h"

/* Returns the index, along one axis, of the voxel that contains a position. Returns -1 outside the grid. */
static int64_t index_of(ost_pm at, ost_pm origin, ost_pm spacing, int32_t n)
{
    const int64_t i = ost_floor_div(2 * (at - origin) + spacing, 2 * spacing);
    return i >= 0 && i < n ? i : -1;
}

int ost_segment_label_at(const ost_volume *labels, ost_pm3 at)
{
    const ost_geometry *g = &labels->geometry;
    if (at.x < -OST_LENGTH_MAX || at.x > OST_LENGTH_MAX || at.y < -OST_LENGTH_MAX || at.y > OST_LENGTH_MAX ||
        at.z < -OST_LENGTH_MAX || at.z > OST_LENGTH_MAX)
        return -1;
    const int64_t x = index_of(at.x, g->origin.x, g->spacing.x, g->dims.x),
                  y = index_of(at.y, g->origin.y, g->spacing.y, g->dims.y),
                  z = index_of(at.z, g->origin.z, g->spacing.z, g->dims.z);
    return x < 0 || y < 0 || z < 0 ? -1 : labels->voxels[x + g->dims.x * (y + g->dims.y * z)];
}

/* On each axis, a distance is below 2^45 pm, so a sum of squares is below 2^92. */
int ost_segment_label_near(const ost_volume *labels, ost_pm3 at, ost_pm3 *found)
{
    const ost_geometry *g = &labels->geometry;
    const int16_t *voxel = labels->voxels;
    ost_i128 least = -1;
    int label = 0;
    for (int32_t z = 0; z < g->dims.z; z++)
        for (int32_t y = 0; y < g->dims.y; y++) {
            const ost_i128 dy = (ost_i128)g->origin.y + (ost_i128)y * g->spacing.y - at.y,
                           dz = (ost_i128)g->origin.z + (ost_i128)z * g->spacing.z - at.z,
                           row = dy * dy + dz * dz;
            for (int32_t x = 0; x < g->dims.x; x++, voxel++) {
                if (!*voxel || (label && row >= least))
                    continue;
                const ost_i128 dx = (ost_i128)g->origin.x + (ost_i128)x * g->spacing.x - at.x, d2 = dx * dx + row;
                if (label && d2 >= least)
                    continue;
                least = d2;
                label = *voxel;
                *found = (ost_pm3){g->origin.x + x * g->spacing.x, g->origin.y + y * g->spacing.y,
                                   g->origin.z + z * g->spacing.z};
            }
        }
    return label;
}

ost_status ost_segments_keep(ost_volume *labels, ost_segment *segments, size_t *count, const bool *keep,
                             ost_error *err)
{
    const int64_t voxels = ost_dims_count(labels->geometry.dims);
    int16_t *renamed = calloc(*count + 1, sizeof *renamed);
    size_t kept = 0;
    if (!renamed)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for %zu labels", *count);
    for (size_t k = 0; k < *count; k++)
        if (keep[k]) {
            segments[kept] = segments[k];
            renamed[k + 1] = (int16_t)++kept;
        }
    for (int64_t i = 0; i < voxels; i++)
        labels->voxels[i] = renamed[labels->voxels[i]];
    free(renamed);
    *count = kept;
    return OST_OK;
}
