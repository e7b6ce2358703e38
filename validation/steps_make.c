/* SPDX-License-Identifier: Apache-2.0 */
#include "validation/steps_make.h"

#include "sim/box.h"
#include "validation/dense/steps.h"

static ost_status by_core(const ost_pose *pose, const ost_geometry *bone, const ost_tool_geometry *tool,
                          steps_pose *out, ost_error *err)
{
    const ost_box of_bone = ost_box_of_bone(bone), of_tool = ost_box_of_tool(tool);
    int32_t first[3][3];
    const ost_status status = ost_map_make(pose, bone, tool, &out->map, err);
    if (status != OST_OK)
        return status;
    steps_blocks(bone->dims, first);
    for (int k = 0; k < 3; k++)
        out->near[k] = ost_map_block_base(&out->map,
                                          (ost_dims){first[k][0] / OST_MAP_BLOCK, first[k][1] / OST_MAP_BLOCK,
                                                     first[k][2] / OST_MAP_BLOCK},
                                          out->base[k]);
    out->reaches = ost_boxes_meet(&of_bone, &of_tool, pose);
    if (out->reaches)
        out->box = ost_box_voxels(bone, &of_tool, pose);
    out->reaches = out->reaches && ost_voxel_box_holds(&out->box);
    return OST_OK;
}

/* Returns true if the tool may be used with the bone according to AR-MAP-2. */
static bool is_supported(const ost_geometry *bone, const ost_tool_geometry *tool)
{
    enum { MOST = 1024, RATIO = 16 };
    return bone->spacing.x <= RATIO * tool->voxel && tool->dims.x <= MOST && tool->dims.y <= MOST &&
           tool->dims.z <= MOST;
}

static ost_status by_second(const ost_pose *pose, const ost_geometry *bone, const ost_tool_geometry *tool,
                            steps_pose *out, ost_error *err)
{
    int32_t first[3][3];
    if (!is_supported(bone, tool))
        return ost_fail(err, OST_ERR_RANGE, "the tool is too wide or too fine for the bone (AR-MAP-2)");
    steps_map(pose, bone, tool, &out->map);
    steps_blocks(bone->dims, first);
    for (int k = 0; k < 3; k++)
        out->near[k] = steps_block_base(&out->map, first[k], out->base[k]);
    out->reaches = steps_bounds(pose, bone, tool, &out->box) && steps_reaches(&out->map, bone, tool, &out->box);
    return OST_OK;
}

ost_status steps_pose_of(bool second, const ost_pose *pose, const ost_geometry *bone, const ost_tool_geometry *tool,
                         steps_pose *out, ost_error *err)
{
    *out = (steps_pose){.pose = *pose};
    return (second ? by_second : by_core)(pose, bone, tool, out, err);
}

int steps_count_of(bool second, const ost_pose *a, const ost_pose *b, const ost_tool_geometry *tool, ost_pm bone_voxel)
{
    int count;
    if (second)
        return steps_sweep_count(a, b, tool, bone_voxel);
    return ost_sweep_count(a, b, tool, bone_voxel, &count, NULL) == OST_OK ? count : 0;
}

ost_pose steps_between(bool second, const ost_pose *a, const ost_pose *b, int k, int count)
{
    return count == 1 ? *b : second ? steps_sweep_pose(a, b, k, count) : ost_sweep_pose(a, b, k, count);
}

ost_status steps_meshes_of(bool second, const scene_tool *t, ost_snapped_mesh out[2], bool *own, ost_error *err)
{
    *own = second && t->raw[0].triangle_count > 0;
    out[0] = t->cutting;
    out[1] = t->noncutting;
    if (!*own)
        return OST_OK;
    ost_tool_geometry grid = t->cutting.grid;
    out[0] = out[1] = (ost_snapped_mesh){.fraction_bits = 0};
    if (!t->grid_given && !steps_tool_grid(t->raw, t->cutting.grid.voxel, &grid))
        return ost_fail(err, OST_ERR_RANGE, "there is no tool grid around the mesh (AR-TOOL-1, AR-TOOL-2)");
    ost_status status = steps_snap(&t->raw[0], &grid, &out[0], err);
    if (status == OST_OK && t->raw[1].triangle_count)
        status = steps_snap(&t->raw[1], &grid, &out[1], err);
    return status;
}

void steps_meshes_free(ost_snapped_mesh meshes[2], bool own)
{
    for (int k = 0; own && k < 2; k++)
        ost_snapped_mesh_free(&meshes[k]);
}

ost_status steps_path_of(bool second, const scene *s, ost_path *out, bool *own, ost_error *err)
{
    *own = second && s->handle_path.count > 0;
    *out = s->path;
    return *own ? steps_motor_path(&s->handle_path, s->handle_rpm, out, err) : OST_OK;
}
