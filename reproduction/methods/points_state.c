/* SPDX-License-Identifier: Apache-2.0 */
/* The state that yau.c, zheng.c and reza.c share, and the computation of the points' ranges in a box of the bone. */
#include "reproduction/methods/points.h"

#include <stdlib.h>

#include "core/int128.h"

ost_status points_state_open(const methods_scene *scene, const method_setup *setup, int block, points_state **out,
                             ost_error *err)
{
    points_state *s = calloc(1, sizeof *s);
    if (!s)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a method");
    s->threads = setup->threads;
    ost_status status = OST_OK;
    if (ost_dims_count(scene->event.bone.dims) >= UINT32_MAX)
        status = ost_fail(err, OST_ERR_RANGE, "a bone of 2^32 voxels or more; tool points index 32 bits");
    if (status == OST_OK)
        status = matrix_bone_init(&s->bone, scene, err);
    if (status == OST_OK)
        status = method_points_init(&s->points, &scene->event.tool, setup->points, block, err);
    if (status == OST_OK)
        *out = s;
    else
        points_state_close(s);
    return status;
}

void points_state_close(void *state)
{
    points_state *s = state;
    matrix_bone_free(&s->bone);
    method_points_free(&s->points);
    free(s);
}

ost_status points_state_restore(void *state, ost_error *err)
{
    points_state *s = state;
    (void)err;
    matrix_bone_restore(&s->bone);
    for (int a = 0; a < 3; a++)
        matrix_touch(s->points.e[a], (size_t)s->points.count * sizeof *s->points.e[a]);
    return OST_OK;
}

ost_status points_state_result(void *state, method_set *set, ost_error *err)
{
    (void)err;
    matrix_bone_result(&((const points_state *)state)->bone, set);
    return OST_OK;
}

void points_state_work(void *state, method_work *out)
{
    const points_state *s = state;
    *out = (method_work){.visited = s->visited, .bone_bytes = matrix_bone_bytes(&s->bone),
                         .index_bytes = s->points.block_count * (int64_t)sizeof *s->points.blocks,
                         .tool_bytes = s->points.count * (int64_t)(3 * sizeof *s->points.e[0])};
}

void points_remove_range(points_state *s, const ost_voxel_box *box, const points_map *map, int32_t first,
                         int32_t count)
{
    enum { PART = 4096 };
    const int32_t parts = (count + PART - 1) / PART;
#if defined _OPENMP
#pragma omp parallel for schedule(static) num_threads(s->threads) if (s->threads > 1)
#endif
    for (int32_t p = 0; p < parts; p++)
        points_remove(s->bone.voxels, s->bone.scene->event.bone.dims, box, &s->points, map, first + p * PART,
                      count - p * PART < PART ? count - p * PART : PART, false);
    s->visited = count;
}

ost_voxel_box points_whole_bone(ost_dims bone)
{
    return (ost_voxel_box){.hi = {bone.x, bone.y, bone.z}};
}

void points_ranges_of_box(const ost_map *map, const ost_voxel_box *box, ost_dims tool, int32_t lo[3], int32_t hi[3])
{
    const int32_t dims[3] = {tool.x, tool.y, tool.z};
    const double scale = (double)ost_i128_of(map->divisor) * (1 << OST_MAP_FRACTION);
    for (int a = 0; a < 3; a++) {
        /* The corners of the box are half a voxel beyond the centres of its outermost voxels. */
        double least = (double)ost_i128_of(map->origin[a]) / scale, greatest = least;
        for (int b = 0; b < 3; b++) {
            const double step = (double)ost_i128_of(map->column[b][a]) / scale;
            const double from = step * (box->lo[b] - 0.5), to = step * (box->hi[b] - 0.5);
            least += from < to ? from : to;
            greatest += from < to ? to : from;
        }
        /* Tool voxel i has its centre at i + 1/2. Therefore e = 2 (i + 1/2) - dims. */
        const double bound = 4.0 * OST_TOOL_DIM_REMOVE_MAX;
        double first = 2 * least - dims[a] - 2, last = 2 * greatest - dims[a] + 2;
        first = first > bound ? bound : first < -bound ? -bound : first;
        last = last > bound ? bound : last < -bound ? -bound : last;
        lo[a] = (int32_t)first;
        hi[a] = (int32_t)last;
    }
}

int32_t points_first_from(const method_points *points, int32_t z)
{
    int32_t lo = 0, hi = points->count;
    while (lo < hi) {
        const int32_t middle = lo + (hi - lo) / 2;
        if (points->e[2][middle] < z)
            lo = middle + 1;
        else
            hi = middle;
    }
    return lo;
}
