/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The inner loop of the tool-to-bone methods on the processor. It maps 256 points at a time to indices of the bone's
 * buffer, with vector instructions of the compiler, and then removes the voxels at these indices one by one.
 */
#include "reproduction/methods/points.h"

enum { TILE = 256 };
static const uint32_t OUTSIDE = UINT32_MAX;

/*
 * Removes a voxel. Several threads may remove the same voxel, so the store is atomic. On common processors, an atomic
 * store is as fast as a normal one.
 */
static inline void clear_voxel(int16_t *voxel)
{
    if (__atomic_load_n(voxel, __ATOMIC_RELAXED) != 0)
        __atomic_store_n(voxel, 0, __ATOMIC_RELAXED);
}

static void indices_in_box(uint32_t *restrict out, ost_dims bone, const ost_voxel_box *box,
                           const method_points *points, const points_map *map, int32_t first, int32_t count)
{
    const int16_t *restrict ex = points->e[0] + first, *restrict ey = points->e[1] + first,
                  *restrict ez = points->e[2] + first;
    const points_map m = *map;
    const ost_voxel_box b = *box;
    const uint32_t wx = (uint32_t)(b.hi[0] - b.lo[0]), wy = (uint32_t)(b.hi[1] - b.lo[1]),
                   wz = (uint32_t)(b.hi[2] - b.lo[2]);
    for (int32_t n = 0; n < count; n++) {
        const int32_t e[3] = {ex[n], ey[n], ez[n]};
        const int32_t ux = m.base[0] + e[0] * m.step[0][0] + e[1] * m.step[1][0] + e[2] * m.step[2][0];
        const int32_t uy = m.base[1] + e[0] * m.step[0][1] + e[1] * m.step[1][1] + e[2] * m.step[2][1];
        const int32_t uz = m.base[2] + e[0] * m.step[0][2] + e[1] * m.step[1][2] + e[2] * m.step[2][2];
        const int32_t x = m.anchor[0] + (ux >> m.fraction), y = m.anchor[1] + (uy >> m.fraction),
                      z = m.anchor[2] + (uz >> m.fraction);
        const bool in = ((uint32_t)(x - b.lo[0]) < wx) & ((uint32_t)(y - b.lo[1]) < wy) &
                        ((uint32_t)(z - b.lo[2]) < wz);
        const uint32_t index =
            (uint32_t)x + (uint32_t)bone.x * ((uint32_t)y + (uint32_t)bone.y * (uint32_t)z);
        out[n] = in ? index : OUTSIDE;
    }
}

/* Computes the indices without testing whether the points are in the box. */
static void indices(uint32_t *restrict out, ost_dims bone, const method_points *points, const points_map *map,
                    int32_t first, int32_t count)
{
    const int16_t *restrict ex = points->e[0] + first, *restrict ey = points->e[1] + first,
                  *restrict ez = points->e[2] + first;
    const points_map m = *map;
    for (int32_t n = 0; n < count; n++) {
        const int32_t e[3] = {ex[n], ey[n], ez[n]};
        const int32_t ux = m.base[0] + e[0] * m.step[0][0] + e[1] * m.step[1][0] + e[2] * m.step[2][0];
        const int32_t uy = m.base[1] + e[0] * m.step[0][1] + e[1] * m.step[1][1] + e[2] * m.step[2][1];
        const int32_t uz = m.base[2] + e[0] * m.step[0][2] + e[1] * m.step[1][2] + e[2] * m.step[2][2];
        const int32_t x = m.anchor[0] + (ux >> m.fraction), y = m.anchor[1] + (uy >> m.fraction),
                      z = m.anchor[2] + (uz >> m.fraction);
        out[n] = (uint32_t)x + (uint32_t)bone.x * ((uint32_t)y + (uint32_t)bone.y * (uint32_t)z);
    }
}

void points_remove(int16_t *voxels, ost_dims bone, const ost_voxel_box *box, const method_points *points,
                   const points_map *map, int32_t first, int32_t count, bool inside)
{
    uint32_t index[TILE];
    for (int32_t end = first + count; first < end; first += TILE) {
        const int32_t n = end - first < TILE ? end - first : TILE;
        if (inside) {
            indices(index, bone, points, map, first, n);
            for (int32_t i = 0; i < n; i++)
                clear_voxel(voxels + index[i]);
            continue;
        }
        indices_in_box(index, bone, box, points, map, first, n);
        for (int32_t i = 0; i < n; i++)
            if (index[i] != OUTSIDE)
                clear_voxel(voxels + index[i]);
    }
}
