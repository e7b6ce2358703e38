/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The method of Zheng et al. (thesis, section 3.2.3 and Fig. 3.11) maps only those tool points of a sparse buffer that
 * may lie in the bone:
 *
 *   the bone's box, mapped to the tool's grid --> the slices of points that it contains
 *   for each point of these slices: map it to a bone voxel; if the voxel is in the intersection box, remove it
 *
 * The points are sorted by slices of the tool's grid, so the points of all other slices are skipped without being read.
 * The removed set is the same as in yau.c, because the box contains every bone voxel that a point can hit.
 */
#include "reproduction/methods/points_cl.h"

/* Determines the range of the points in those slices of the tool's grid that the bone's box enters. */
static void select_points(const bench_scene *event, const method_points *points, int32_t *first, int32_t *count)
{
    const ost_voxel_box all = points_whole_bone(event->bone.dims);
    int32_t lo[3], hi[3];
    points_ranges_of_box(&event->map, &all, event->tool.geometry.dims, lo, hi);
    *first = points_first_from(points, lo[2]);
    *count = points_first_from(points, hi[2] + 1) - *first;
    for (int a = 0; a < 3; a++)
        if (lo[a] > hi[a])
            *count = 0;
}

static ost_status open_zheng(const methods_scene *scene, const method_setup *setup, void **state, ost_error *err)
{
    points_state *s = NULL;
    ost_status status = points_state_open(scene, setup, 0, &s, err);
    *state = s;
    return status;
}

static ost_status remove_event(void *state, ost_error *err)
{
    points_state *s = state;
    const bench_scene *event = &s->bone.scene->event;
    int32_t first, count;
    points_map map;
    ost_status status = points_map_make(&map, &event->pose, &event->bone, &event->tool.geometry, err);
    if (status != OST_OK)
        return status;
    select_points(event, &s->points, &first, &count);
    points_remove_range(s, &s->bone.scene->region, &map, first, count);
    return OST_OK;
}

const method method_zheng = {
    .info = {.name = "zheng", .title = "tool points in the intersection box",
             .source = "Zheng et al., as described in the thesis, 3.2.3 and Fig. 3.11",
             .definition = METHODS_TOOL_TO_BONE},
    .per_bone_voxel = 2, .per_tool_voxel = 6,
    .native = true,
    .open = open_zheng, .close = points_state_close, .restore = points_state_restore, .remove = remove_event,
    .result = points_state_result, .work = points_state_work,
};

#ifdef HAVE_OPENCL
static const char source[] = POINTS_CL_SOURCE
    "__kernel void zheng(ARGUMENTS)\n"
    "{\n"
    "    const int n = (int)get_global_id(0);\n"
    "    if (n >= count)\n"
    "        return;\n"
    "    const int4 v = voxel_of(convert_int4(points[first + n]), MAP);\n"
    "    if (in_box(v, lo, hi))\n"
    "        clear_voxel(bone, v, dims);\n"
    "}\n";

static ost_status open_cl(const methods_scene *scene, const method_setup *setup, void **state, ost_error *err)
{
    points_cl *s = NULL;
    ost_status status = points_cl_open(scene, setup, 0, source, "zheng", &s, err);
    *state = s;
    return status;
}

static ost_status remove_cl(void *state, ost_error *err)
{
    points_cl *s = state;
    int32_t first, count;
    select_points(&s->scene->event, &s->points, &first, &count);
    s->visited = count;
    return points_cl_run(s, &s->scene->region, first, count, points_cl_items(count), 0, err);
}
#endif

const method method_zheng_cl = {
    .info = {.name = "zheng-cl", .title = "tool points in the intersection box, on the device",
             .source = "Zheng et al., as described in the thesis, 3.2.3 and Fig. 3.11",
             .definition = METHODS_TOOL_TO_BONE, .device = true},
    .native = true,
    .per_bone_voxel = 2, .per_tool_voxel = 6,
#ifdef HAVE_OPENCL
    .open = open_cl, .close = points_cl_close, .restore = points_cl_restore, .remove = remove_cl,
    .result = points_cl_result, .work = points_cl_work,
#endif
};
