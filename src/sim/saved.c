/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Stores a copy of a world, and the ticks executed since the copy was made. A failover (failover.c) starts from the
 * copy and executes the stored ticks. A copy is replaced only when a new copy is complete.
 */
#include "sim/world.h"

#include <stdlib.h>
#include <string.h>

#include "core/backend.h"

static ost_status copy_bone(ost_world *world, ost_error *err)
{
    ost_world_saved *saved = world->saved;
    const size_t count = (size_t)ost_dims_count(world->geometry.dims);
    int16_t *voxels = malloc(count * sizeof *voxels);
    if (!voxels)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a copy of the bone, %zu voxels", count);
    ost_status status = ost_bone_download(world->bone.voxels.bone, 0, world->geometry.dims.z, voxels, err);
    if (status != OST_OK) {
        free(voxels);
        return status;
    }
    free(saved->voxels);
    saved->voxels = voxels;
    saved->count = 0;
    for (int i = 0; i < OST_WORLD_TOOLS_MAX; i++)
        saved->inputs[i] = world->tools[i].input;
    saved->clock = world->clock;
    return OST_OK;
}

ost_status ost_world_saved_make(ost_world *world, ost_error *err)
{
    const size_t ticks = (size_t)world->options.saved_ticks;
    if (ticks == 0)
        return OST_OK;
    world->saved = calloc(1, sizeof *world->saved);
    if (world->saved)
        world->saved->ticks = malloc(ticks * sizeof *world->saved->ticks);
    if (!world->saved || !world->saved->ticks)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for %zu ticks", ticks);
    return copy_bone(world, err);
}

void ost_world_saved_free(ost_world *world)
{
    if (!world->saved)
        return;
    free(world->saved->voxels);
    for (int i = 0; i < OST_WORLD_TOOLS_MAX; i++)
        free(world->saved->tools[i]);
    free(world->saved->ticks);
    free(world->saved);
    world->saved = NULL;
}

ost_status ost_world_save_tool(ost_world *world, int index, const ost_tool *tool, ost_error *err)
{
    if (!world->saved)
        return OST_OK;
    ost_tool_volume volume;
    ost_status status = ost_tool_download(tool, &volume, err);
    if (status != OST_OK)
        return status;
    const size_t count = (size_t)ost_dims_count(volume.geometry.dims);
    uint8_t *classes = malloc(count);
    if (classes) {
        memcpy(classes, volume.voxels, count);
        world->saved->tools[index] = classes;
        /* The tool gets the initial state that ost_world_add_tool gives to a new tool. */
        world->saved->inputs[index] = (ost_input_component){.pose = ost_pose_identity(), .event = ost_pose_identity()};
    } else {
        status = ost_fail(err, OST_ERR_MEMORY, "out of memory for a copy of a tool, %zu voxels", count);
    }
    ost_tool_volume_free(&volume);
    return status;
}

ost_status ost_world_save(ost_world *world, ost_error *err)
{
    if (!world->saved || world->saved->count < world->options.saved_ticks)
        return OST_OK;
    return copy_bone(world, err);
}

void ost_world_save_tick(ost_world *world, const ost_tick *tick)
{
    if (world->saved)
        world->saved->ticks[world->saved->count++] = *tick;
}
