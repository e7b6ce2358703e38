/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Makes the static events of the thesis (Figs. 3.6 and 3.7, Tables 3.3 to 3.5) on a bone of 128^3 active voxels of
 * 0.47 mm. With chunks of 32^3 voxels, there are events of the reamer with three voxel sizes, and one event of the peg
 * drill. With chunks of 16^3 and 64^3 voxels, there is one event of each tool. Each tool has one pose. Poses and
 * densities are the same as in `osteon bench --suite removal` (bench/scene.c).
 */
#include "validation/scene_parts.h"

#include <osteon/phantom.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define UM (OST_PM_PER_MM / 1000)

enum { SIDE = 128 };

static const struct {
    ost_tool_kind kind;
    ost_pm voxel;
    int chunk_size;
} events[] = {{OST_TOOL_REAMER, 1000 * UM, 32}, {OST_TOOL_REAMER, 750 * UM, 32}, {OST_TOOL_REAMER, 500 * UM, 32},
              {OST_TOOL_PEG, 500 * UM, 32},     {OST_TOOL_REAMER, 500 * UM, 16}, {OST_TOOL_REAMER, 500 * UM, 64},
              {OST_TOOL_PEG, 500 * UM, 16},     {OST_TOOL_PEG, 500 * UM, 64}};

static ost_pose pose_of(ost_tool_kind kind)
{
    if (kind == OST_TOOL_REAMER)
        return (ost_pose){.t = {INT64_C(43125000000), INT64_C(48105000000), INT64_C(41711000000)},
                          .qw = 530420327, .qx = -283588849, .qy = 416957394, .qz = -785684210};
    return (ost_pose){.t = {INT64_C(30607000000), INT64_C(38954000000), INT64_C(14925000000)},
                      .qw = 105468265, .qx = 288463883, .qy = -358551709, .qz = 964379184};
}

static ost_status full_bone(scene *s, int chunk_size, ost_error *err)
{
    const ost_geometry g = {{SIDE, SIDE, SIDE}, {470 * UM, 470 * UM, 470 * UM}, {0, 0, 0}};
    ost_volume ct;
    ost_status status = ost_volume_init(&ct, &g, err);
    if (status != OST_OK)
        return status;
    for (int32_t k = 0, v = 0; k < SIDE; k++)
        for (int32_t j = 0; j < SIDE; j++)
            for (int32_t i = 0; i < SIDE; i++, v++)
                ct.voxels[v] = (int16_t)(120 + ((i * 7 + j * 13 + k * 29) & 1023));
    status = scene_ct_of_volume(s, &ct, err);
    ost_volume_free(&ct);
    s->cubic = g.spacing.x;
    s->chunk_size = chunk_size;
    s->threshold = 120;
    return status;
}

ost_status scene_static(scene *s, int number, ost_error *err)
{
    const ost_tool_kind kind = events[number].kind;
    ost_mesh mesh = {0};
    ost_pm3 lo, hi;
    ost_tool_geometry grid;
    scene_tool *tool = &s->tools[0];
    ost_status status = full_bone(s, events[number].chunk_size, err);
    *tool = (scene_tool){.rule = OST_FILL_WINDING};
    snprintf(tool->name, sizeof tool->name, "%s", kind == OST_TOOL_REAMER ? "reamer" : "peg");
    s->tool_count = 1;
    if (status == OST_OK)
        status = ost_tool_make(kind, NULL, &mesh, err);
    if (status == OST_OK)
        status = ost_mesh_bounds(&mesh, &lo, &hi, err);
    if (status == OST_OK)
        status = ost_tool_geometry_from_bounds(lo, hi, events[number].voxel, &grid, err);
    if (status == OST_OK)
        status = ost_mesh_snap(&mesh, &grid, &tool->cutting, err);
    if (status == OST_OK)
        status = ost_path_init(&s->path, 1, err);
    if (status == OST_OK)
        s->path.ticks[0] = (ost_tick){.t_ns = 0, .tool = 0, .rpm = OST_RPM_ON, .pose = pose_of(kind)};
    ost_mesh_free(&mesh);
    return status;
}
