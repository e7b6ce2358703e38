/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Failover to another backend when one fails.
 *
 *   bone  ----o=========o=========o====x           o  copied to the host
 *             |         |         |    |           =  ticks recorded since the copy
 *             '---------'---------'    the backend fails in this tick
 *                                 |
 *   other                         o====-------->   the copy, the recorded ticks again, then further ticks
 *
 * A tick is integer arithmetic and every backend gives the same grids, so
 * executing the recorded ticks again on another backend gives the same bone and
 * the same totals.  A copy is replaced only by a complete new one.
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
        return ost_fail(err, OST_ERR_MEMORY, "no memory for a copy of the bone, %zu voxels", count);
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
        return ost_fail(err, OST_ERR_MEMORY, "no memory for %zu ticks", ticks);
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
        /* A tool's initial state is the same as in ost_world_add_tool. */
        world->saved->inputs[index] = (ost_input_component){.pose = ost_pose_identity(), .event = ost_pose_identity()};
    } else {
        status = ost_fail(err, OST_ERR_MEMORY, "no memory for a copy of a tool, %zu voxels", count);
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

/* -------------------------------------------------------------- failover */

static ost_status make_bone(const ost_world *world, ost_backend *backend, ost_bone **out, ost_error *err)
{
    const ost_bone *old = world->bone.voxels.bone;
    ost_status status = ost_bone_create(backend, &world->geometry, old->chunk_size, old->threshold, out, err);
    return status == OST_OK ? ost_bone_upload(*out, 0, world->geometry.dims.z, world->saved->voxels, err) : status;
}

static ost_status make_tools(const ost_world *world, ost_backend *backend, ost_tool **out, ost_error *err)
{
    ost_status status = OST_OK;
    for (int i = 0; i < world->tool_count && status == OST_OK; i++) {
        /* ost_tool_upload reads only the geometry and the classes. */
        const ost_tool_volume volume = {.geometry = world->tools[i].voxels.tool->geometry, .voxels = world->saved->tools[i]};
        status = ost_tool_upload(backend, &volume, &out[i], err);
    }
    return status;
}

/*
 * Restores the state before the recorded ticks, with the new bone and tools, and executes these
 * ticks again.
 */
static ost_status repeat_ticks(ost_world *world, ost_bone *bone, ost_tool *const *tools, ost_error *err)
{
    const ost_world_saved *saved = world->saved;
    world->bone.voxels.bone = bone;
    for (int i = 0; i < world->tool_count; i++) {
        world->tools[i].voxels.tool = tools[i];
        world->tools[i].input = saved->inputs[i];
    }
    world->clock = saved->clock;
    ost_status status = OST_OK;
    for (int32_t i = 0; i < saved->count && status == OST_OK; i++) {
        ost_step_result ignored;
        status = ost_world_advance(world, &saved->ticks[i], &ignored, err);
    }
    return status == OST_OK ? ost_backend_finish(bone->backend, err) : status;
}

/* The state that repeat_ticks changes. */
typedef struct world_state {
    ost_entity bone, tools[OST_WORLD_TOOLS_MAX];
    ost_world_clock clock;
} world_state;

static void put_back(ost_world *world, const world_state *before)
{
    world->bone = before->bone;
    memcpy(world->tools, before->tools, sizeof world->tools);
    world->clock = before->clock;
}

ost_status ost_world_failover(ost_world *world, ost_backend *backend, ost_bone **bone, ost_tool **tools, ost_error *err)
{
    *bone = NULL;
    for (int i = 0; i < OST_WORLD_TOOLS_MAX; i++)
        tools[i] = NULL;
    if (!world->saved)
        return ost_fail(err, OST_ERR_USAGE, "this world keeps nothing to go on from (keep_ticks)");
    world_state before = {.bone = world->bone, .clock = world->clock};
    memcpy(before.tools, world->tools, sizeof before.tools);
    ost_status status = make_bone(world, backend, bone, err);
    if (status == OST_OK)
        status = make_tools(world, backend, tools, err);
    if (status == OST_OK)
        status = repeat_ticks(world, *bone, tools, err);
    if (status == OST_OK)
        return OST_OK;
    put_back(world, &before);
    for (int i = 0; i < world->tool_count; i++) {
        ost_tool_free(tools[i]);
        tools[i] = NULL;
    }
    ost_bone_free(*bone);
    *bone = NULL;
    return status;
}
