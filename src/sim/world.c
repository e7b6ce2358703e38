/* SPDX-License-Identifier: Apache-2.0 */
/* Creates a world, and adds tools to it. */
#include "sim/world.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/backend.h"
#include "sim/box.h"

ost_status ost_world_create(ost_bone *bone, const ost_world_options *options, ost_world **out, ost_error *err)
{
    *out = NULL;
    if (!bone)
        return ost_fail(err, OST_ERR_USAGE, "a world needs a bone");
    ost_world_options chosen = options ? *options : (ost_world_options){0};
    if (chosen.removal_period_ns < 0)
        return ost_fail(err, OST_ERR_USAGE, "a removal period of %lld ns; expected 0 or more",
                        (long long)chosen.removal_period_ns);
    if (chosen.saved_ticks < 0 || chosen.saved_ticks > OST_WORLD_SAVED_TICKS_MAX)
        return ost_fail(err, OST_ERR_USAGE, "%d ticks to keep; expected 0 to %d", (int)chosen.saved_ticks,
                        OST_WORLD_SAVED_TICKS_MAX);
    if (chosen.classes.count == 0)
        chosen.classes = ost_density_classes_default();
    ost_status status = ost_density_classes_check(&chosen.classes, err);
    if (status != OST_OK)
        return status;

    ost_world *world = calloc(1, sizeof *world);
    if (!world)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a world");
    world->options = chosen;
    world->geometry = bone->geometry;
    world->chunk_size = bone->chunk_size;
    world->bone = (ost_entity){
        .name = "bone",
        .box = ost_box_of_bone(&bone->geometry),
        .input = {.pose = ost_pose_identity(), .event = ost_pose_identity()},
        .voxels = {.bone = bone},
    };
    world->clock.tool = -1;
    status = ost_world_saved_make(world, err);
    if (status != OST_OK) {
        ost_world_free(world);
        return status;
    }
    *out = world;
    return OST_OK;
}

void ost_world_free(ost_world *world)
{
    if (!world)
        return;
    ost_world_saved_free(world);
    ost_removal_report_free(&world->report);
    free(world->maps);
    free(world->boxes);
    free(world);
}

ost_status ost_world_add_tool(ost_world *world, const char *name, const ost_tool *tool, int *index, ost_error *err)
{
    if (!tool)
        return ost_fail(err, OST_ERR_USAGE, "no tool given");
    if (world->tool_count == OST_WORLD_TOOLS_MAX)
        return ost_fail(err, OST_ERR_USAGE, "a world holds up to %d tools", OST_WORLD_TOOLS_MAX);
    if (tool->backend != world->bone.voxels.bone->backend)
        return ost_fail(err, OST_ERR_USAGE, "tool '%s' is on another backend than the bone", name ? name : "");
    /*
     * If the tool is too large, or its voxels are too small for this bone, ost_map_make fails at every pose. This
     * call detects the error before the first tick.
     */
    ost_pose identity = ost_pose_identity();
    ost_map map;
    ost_status status = ost_map_make(&identity, &world->geometry, &tool->geometry, &map, err);
    /*
     * The box of the event below contains no voxel. The event makes the backend compute its data for this tool and this
     * bone before the first tick.
     */
    const ost_voxel_box nowhere = {{0, 0, 0}, {0, 0, 0}};
    const ost_removal_event nothing = {
        .pose_count = 1, .maps = &map, .boxes = &nowhere, .classes = &world->options.classes};
    if (status == OST_OK)
        status = ost_bone_collide(world->bone.voxels.bone, tool, &nothing, &world->report, err);
    if (status == OST_OK)
        status = ost_world_save_tool(world, world->tool_count, tool, err);
    if (status != OST_OK)
        return status;

    ost_entity *entity = &world->tools[world->tool_count];
    *entity = (ost_entity){
        .box = ost_box_of_tool(&tool->geometry),
        .input = {.pose = identity, .event = identity},
        .voxels = {.tool = tool},
    };
    snprintf(entity->name, sizeof entity->name, "%s", name ? name : "");
    if (index)
        *index = world->tool_count;
    world->tool_count++;
    return OST_OK;
}

ost_status ost_world_reserve_poses(ost_world *world, int count, ost_error *err)
{
    if (count <= world->capacity)
        return OST_OK;
    ost_map *maps = realloc(world->maps, (size_t)count * sizeof *maps);
    if (maps)
        world->maps = maps;
    ost_voxel_box *boxes = realloc(world->boxes, (size_t)count * sizeof *boxes);
    if (boxes)
        world->boxes = boxes;
    if (!maps || !boxes)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a sweep of %d poses", count);
    world->capacity = count;
    return OST_OK;
}

ost_status ost_world_reserve(ost_world *world, ost_error *err)
{
    const ost_dims d = world->geometry.dims;
    const int n = world->chunk_size;
    const size_t chunks = (size_t)((d.x + n - 1) / n) * (size_t)((d.y + n - 1) / n) * (size_t)((d.z + n - 1) / n);
    ost_status status = ost_world_reserve_poses(world, OST_SWEEP_MAX, err);
    /* Each event below may reach every chunk, so the backend allocates the memory for the largest possible event. */
    const ost_voxel_box all = {{0, 0, 0}, {d.x, d.y, d.z}};
    for (int t = 0; t < world->tool_count && status == OST_OK; t++) {
        const ost_removal_event event = {
            .pose_count = 1, .maps = world->maps, .boxes = &all, .classes = &world->options.classes};
        const ost_pose identity = ost_pose_identity();
        status = ost_map_make(&identity, &world->geometry, ost_tool_geometry_get(world->tools[t].voxels.tool),
                              &world->maps[0], err);
        if (status == OST_OK)
            status = ost_bone_collide(world->bone.voxels.bone, world->tools[t].voxels.tool, &event, &world->report,
                                      err);
    }
    if (status != OST_OK || world->report.capacity >= chunks)
        return status;
    ost_chunk_report *grown = realloc(world->report.chunks, chunks * sizeof *grown);
    if (!grown)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a report of %zu chunks", chunks);
    world->report.chunks = grown;
    world->report.capacity = chunks;
    return OST_OK;
}

void ost_world_totals_get(const ost_world *world, ost_world_totals *out)
{
    *out = world->clock.totals;
}

const ost_density_classes *ost_world_classes(const ost_world *world)
{
    return &world->options.classes;
}
