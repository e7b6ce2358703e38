/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Computes the sets that the methods' definitions require, voxel by voxel and point by point, without any shortcut. A
 * method is measured only if it removes exactly the set computed here. tests/reproduction compares these functions with
 * an independent implementation.
 */
#include <math.h>

#include "core/int128.h"
#include "reproduction/methods/points.h"

/* Returns true if the tool voxel at the centre of bone voxel (i, j, k) is cutting (AR-MAP-4, AR-REM-1). `base` is the
   base of the bone voxel's block. */
static bool covered(const bench_scene *event, const int32_t base[3], int32_t i, int32_t j, int32_t k)
{
    const ost_dims d = event->tool.geometry.dims;
    const int32_t in_block[3] = {i % OST_MAP_BLOCK, j % OST_MAP_BLOCK, k % OST_MAP_BLOCK};
    int32_t u[3];
    for (int a = 0; a < 3; a++) {
        u[a] = base[a];
        for (int b = 0; b < 3; b++)
            u[a] += in_block[b] * event->map.step[b][a];
        u[a] >>= OST_MAP_FRACTION;
    }
    if (u[0] < 0 || u[1] < 0 || u[2] < 0 || u[0] >= d.x || u[1] >= d.y || u[2] >= d.z)
        return false;
    return event->tool.voxels[u[0] + d.x * (u[1] + (int64_t)d.y * u[2])] == OST_TOOL_CUTTING;
}

void method_define_bone_to_tool(method_set *set, const bench_scene *event, const int16_t *voxels)
{
    const ost_voxel_box *b = &set->box;
    const ost_dims d = event->bone.dims;
    for (int32_t k = b->lo[2]; k < b->hi[2]; k++)
        for (int32_t j = b->lo[1]; j < b->hi[1]; j++) {
            int32_t base[3], block = -1;
            bool near = false;
            for (int32_t i = b->lo[0]; i < b->hi[0]; i++) {
                if (i / OST_MAP_BLOCK != block) {
                    block = i / OST_MAP_BLOCK;
                    near = ost_map_block_base(
                        &event->map, (ost_dims){block, j / OST_MAP_BLOCK, k / OST_MAP_BLOCK}, base);
                }
                const bool active = !voxels || voxels[i + d.x * (j + (int64_t)d.y * k)] != 0;
                if (active && near && covered(event, base, i, j, k))
                    set->in[method_set_row(set, j, k) + (size_t)(i - b->lo[0])] = 1;
            }
        }
}

void method_define_tool_to_bone(method_set *set, const method_points *points, const points_map *map, ost_dims bone,
                                const int16_t *voxels)
{
    const ost_voxel_box *box = &set->box;
    for (int32_t n = 0; n < points->count; n++) {
        int32_t v[3];
        bool in = true;
        for (int b = 0; b < 3; b++) {
            int64_t u = map->base[b];
            for (int a = 0; a < 3; a++)
                u += (int64_t)points->e[a][n] * map->step[a][b];
            v[b] = map->anchor[b] + (int32_t)(u >> map->fraction);
            in = in && v[b] >= box->lo[b] && v[b] < box->hi[b];
        }
        if (in && (!voxels || voxels[v[0] + bone.x * (v[1] + (int64_t)bone.y * v[2])] != 0))
            set->in[method_set_row(set, v[1], v[2]) + (size_t)(v[0] - box->lo[0])] = 1;
    }
}

/* Returns true if the voxel's position is so close to a border of tool voxels that floats may give a different result.
   A float computation rounds the factors, four products and three sums, so its error is at most 8 * 2^-24 of the sum of
   all magnitudes. The error of the position according to AR-MAP is at most 23 units (AR-MAP-6). */
static bool near_border(const bench_scene *event, const int32_t v[3])
{
    const double scale = (double)ost_i128_of(event->map.divisor) * (1 << OST_MAP_FRACTION);
    for (int a = 0; a < 3; a++) {
        double at = (double)ost_i128_of(event->map.origin[a]) / scale, magnitude = fabs(at);
        for (int b = 0; b < 3; b++) {
            const double term = v[b] * ((double)ost_i128_of(event->map.column[b][a]) / scale);
            at += term;
            magnitude += fabs(term);
        }
        if (fabs(at - nearbyint(at)) <= 8 * magnitude / (1 << 24) + 23.0 / (1 << OST_MAP_FRACTION))
            return true;
    }
    return false;
}

int64_t method_beyond_floats(const method_set *expected, const method_set *set, const bench_scene *event)
{
    const ost_voxel_box *b = &set->box;
    int64_t beyond = 0;
    for (int32_t k = b->lo[2]; k < b->hi[2]; k++)
        for (int32_t j = b->lo[1]; j < b->hi[1]; j++)
            for (int32_t i = b->lo[0]; i < b->hi[0]; i++) {
                const size_t at = method_set_row(set, j, k) + (size_t)(i - b->lo[0]);
                beyond += expected->in[at] != set->in[at] && !near_border(event, (const int32_t[3]){i, j, k});
            }
    return beyond;
}
