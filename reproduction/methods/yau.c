/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The method of Yau et al. (thesis, section 3.2.3 and Fig. 3.12) maps a sparse buffer of tool points to a single buffer
 * of bone voxels, without culling:
 *
 *   for each point of the tool: map it to a bone voxel; if the voxel is in the bone's grid, remove it
 *
 * The thesis states neither the layout of the buffers nor the order of the points. Here the points are in the order of
 * the tool's grid, because this order is best for the caches.
 */
#include "reproduction/methods/points_cl.h"

static ost_status open_yau(const methods_scene *scene, const method_setup *setup, void **state, ost_error *err)
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
    const ost_voxel_box all = points_whole_bone(event->bone.dims);
    points_map map;
    ost_status status = points_map_make(&map, &event->pose, &event->bone, &event->tool.geometry, err);
    if (status == OST_OK)
        points_remove_range(s, &all, &map, 0, s->points.count);
    return status;
}

const method method_yau = {
    .info = {.name = "yau", .title = "tool points, no culling",
             .source = "Yau et al., as described in the thesis, 3.2.3 and Fig. 3.12",
             .definition = METHODS_TOOL_TO_BONE},
    .per_bone_voxel = 2, .per_tool_voxel = 6,
    .native = true,
    .open = open_yau, .close = points_state_close, .restore = points_state_restore, .remove = remove_event,
    .result = points_state_result, .work = points_state_work,
};

#ifdef HAVE_OPENCL
static const char source[] = POINTS_CL_SOURCE
    "__kernel void yau(ARGUMENTS)\n"
    "{\n"
    "    const int n = (int)get_global_id(0);\n"
    "    if (n >= count)\n"
    "        return;\n"
    "    const int4 v = voxel_of(convert_int4(points[n]), MAP);\n"
    "    if (in_box(v, lo, hi))\n"
    "        clear_voxel(bone, v, dims);\n"
    "}\n";

static ost_status open_cl(const methods_scene *scene, const method_setup *setup, void **state, ost_error *err)
{
    points_cl *s = NULL;
    ost_status status = points_cl_open(scene, setup, 0, source, "yau", &s, err);
    *state = s;
    return status;
}

static ost_status remove_cl(void *state, ost_error *err)
{
    points_cl *s = state;
    const ost_voxel_box all = points_whole_bone(s->scene->event.bone.dims);
    s->visited = s->points.count;
    return points_cl_run(s, &all, 0, s->points.count, points_cl_items(s->points.count), 0, err);
}
#endif

const method method_yau_cl = {
    .info = {.name = "yau-cl", .title = "tool points, no culling, on the device",
             .source = "Yau et al., as described in the thesis, 3.2.3 and Fig. 3.12",
             .definition = METHODS_TOOL_TO_BONE, .device = true},
    .native = true,
    .per_bone_voxel = 2, .per_tool_voxel = 6,
#ifdef HAVE_OPENCL
    .open = open_cl, .close = points_cl_close, .restore = points_cl_restore, .remove = remove_cl,
    .result = points_cl_result, .work = points_cl_work,
#endif
};
