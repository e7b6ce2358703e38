/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The method of Faieghi, Tutunea-Fatan and Eagleson ("Parallelized collision detection with applications in virtual
 * bone machining", Comput. Methods Programs Biomed. 188, 2020, 105263; in the thesis: Reza et al., section 3.2.3 and
 * Fig. 3.10) maps a sparse buffer of tool points, and skips blocks of points that are outside the bone:
 *
 *   the points are grouped in blocks of 16^3 tool voxels, with the bounds of the points of each block
 *   for each block: map the bounds; skip the block if it is outside the bone
 *     for each point of the block: map it to a bone voxel, and remove the voxel
 *
 * The publication estimates the possible intersection volume and uses it to cull threads. On the device, a work group
 * processes one block and ends early if the block is skipped. The points of a block that is completely inside the
 * bone's grid are not compared with the grid again. The removed set is the same as in yau.c.
 */
#include "reproduction/methods/points_cl.h"

enum { BLOCK = 16, GROUP = 64 };

/* Computes the lowest and the highest bone voxel that a block of points can reach. Both are exact, because each
   coordinate is a sum of one monotone term per axis. */
static void bounds_of(const points_block *block, const points_map *map, int32_t lo[3], int32_t hi[3])
{
    for (int b = 0; b < 3; b++) {
        int32_t least = map->base[b], greatest = map->base[b];
        for (int a = 0; a < 3; a++) {
            const int32_t from = block->lo[a] * map->step[a][b], to = block->hi[a] * map->step[a][b];
            least += from < to ? from : to;
            greatest += from < to ? to : from;
        }
        lo[b] = map->anchor[b] + (least >> map->fraction);
        hi[b] = map->anchor[b] + (greatest >> map->fraction);
    }
}

static int64_t remove_block(points_state *s, const ost_voxel_box *all, const points_map *map,
                            const points_block *block)
{
    int32_t lo[3], hi[3];
    bool inside = true;
    bounds_of(block, map, lo, hi);
    for (int b = 0; b < 3; b++) {
        if (hi[b] < 0 || lo[b] >= all->hi[b])
            return 0;
        inside = inside && lo[b] >= 0 && hi[b] < all->hi[b];
    }
    points_remove(s->bone.voxels, s->bone.scene->event.bone.dims, all, &s->points, map, block->first, block->count,
                  inside);
    return block->count;
}

static ost_status open_reza(const methods_scene *scene, const method_setup *setup, void **state, ost_error *err)
{
    points_state *s = NULL;
    ost_status status = points_state_open(scene, setup, BLOCK, &s, err);
    *state = s;
    return status;
}

static ost_status remove_event(void *state, ost_error *err)
{
    points_state *s = state;
    const bench_scene *event = &s->bone.scene->event;
    const ost_voxel_box all = points_whole_bone(event->bone.dims);
    int64_t visited = 0;
    points_map map;
    ost_status status = points_map_make(&map, &event->pose, &event->bone, &event->tool.geometry, err);
    if (status != OST_OK)
        return status;
#if defined _OPENMP
#pragma omp parallel for schedule(dynamic, 4) num_threads(s->threads) reduction(+ : visited) if (s->threads > 1)
#endif
    for (int32_t b = 0; b < s->points.block_count; b++)
        visited += remove_block(s, &all, &map, &s->points.blocks[b]);
    s->visited = visited;
    return OST_OK;
}

const method method_reza = {
    .info = {.name = "reza", .title = "tool points, blocks outside the bone rejected",
             .source = "Faieghi et al. 2020 (thesis: Reza et al., 3.2.3 and Fig. 3.10)",
             .definition = METHODS_TOOL_TO_BONE},
    .per_bone_voxel = 2, .per_tool_voxel = 7,
    .native = true,
    .open = open_reza, .close = points_state_close, .restore = points_state_restore, .remove = remove_event,
    .result = points_state_result, .work = points_state_work,
};

#ifdef HAVE_OPENCL
static const char source[] = POINTS_CL_SOURCE
    "__kernel __attribute__((reqd_work_group_size(64, 1, 1)))\n"
    "void reza(ARGUMENTS, __global const int8 *blocks)\n"
    "{\n"
    "    const int8 block = blocks[get_group_id(0)];\n"
    "    const int4 l = (int4)(block.s2, block.s3, block.s4, 0), h = (int4)(block.s5, block.s6, block.s7, 0);\n"
    "    const int4 x = min(l * to_x, h * to_x), y = min(l * to_y, h * to_y), z = min(l * to_z, h * to_z);\n"
    "    const int4 p = max(l * to_x, h * to_x), q = max(l * to_y, h * to_y), r = max(l * to_z, h * to_z);\n"
    "    const int4 least = (int4)(base.x + x.x + x.y + x.z, base.y + y.x + y.y + y.z, base.z + z.x + z.y + z.z, 0);\n"
    "    const int4 most = (int4)(base.x + p.x + p.y + p.z, base.y + q.x + q.y + q.z, base.z + r.x + r.y + r.z, 0);\n"
    "    const int4 from = anchor + (least >> base.w), to = anchor + (most >> base.w);\n"
    "    if (to.x < lo.x || to.y < lo.y || to.z < lo.z || from.x >= hi.x || from.y >= hi.y || from.z >= hi.z)\n"
    "        return;\n"
    "    for (int n = (int)get_local_id(0); n < block.s1; n += 64) {\n"
    "        const int4 v = voxel_of(convert_int4(points[block.s0 + n]), MAP);\n"
    "        if (in_box(v, lo, hi))\n"
    "            clear_voxel(bone, v, dims);\n"
    "    }\n"
    "}\n";

static ost_status open_cl(const methods_scene *scene, const method_setup *setup, void **state, ost_error *err)
{
    points_cl *s = NULL;
    ost_status status = points_cl_open(scene, setup, BLOCK, source, "reza", &s, err);
    *state = s;
    return status;
}

static ost_status remove_cl(void *state, ost_error *err)
{
    points_cl *s = state;
    const ost_voxel_box all = points_whole_bone(s->scene->event.bone.dims);
    return points_cl_run(s, &all, 0, s->points.count, (size_t)s->points.block_count * GROUP, GROUP, err);
}

/* Counts the points in the blocks that the kernel does not skip. */
static void work_cl(void *state, method_work *out)
{
    const points_cl *s = state;
    const bench_scene *event = &s->scene->event;
    const int32_t size[3] = {event->bone.dims.x, event->bone.dims.y, event->bone.dims.z};
    points_map map;
    points_cl_work(state, out);
    out->visited = 0;
    if (points_map_make(&map, &event->pose, &event->bone, &event->tool.geometry, NULL) != OST_OK)
        return;
    for (int32_t b = 0; b < s->points.block_count; b++) {
        int32_t lo[3], hi[3];
        bounds_of(&s->points.blocks[b], &map, lo, hi);
        bool meets = true;
        for (int a = 0; a < 3; a++)
            meets = meets && hi[a] >= 0 && lo[a] < size[a];
        out->visited += meets ? s->points.blocks[b].count : 0;
    }
}
#endif

const method method_reza_cl = {
    .info = {.name = "reza-cl", .title = "tool points, blocks outside the bone rejected, on the device",
             .source = "Faieghi et al. 2020 (thesis: Reza et al., 3.2.3 and Fig. 3.10)",
             .definition = METHODS_TOOL_TO_BONE, .device = true},
    .native = true,
    .per_bone_voxel = 2, .per_tool_voxel = 7,
#ifdef HAVE_OPENCL
    .open = open_cl, .close = points_cl_close, .restore = points_cl_restore, .remove = remove_cl,
    .result = points_cl_result, .work = work_cl,
#endif
};
