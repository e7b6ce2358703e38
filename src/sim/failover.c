/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Continues on another backend after a backend has failed (failover).
 *
 *   bone  ----o=========o=========o====x           o  copied to the host
 *             |         |         |    |           =  ticks recorded since the copy
 *             '---------'---------'    the backend fails in this tick
 *                                 |
 *   other                         o====-------->   the copy, the recorded ticks again, then further ticks
 *
 * A tick uses integer arithmetic only, and every backend gives the same grids and
 * reports. Therefore executing the recorded ticks again on another backend gives
 * the same bone and the same totals.
 */
#include "sim/world.h"

#include <string.h>

#include "core/backend.h"

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
        const ost_tool_volume volume = {.geometry = world->tools[i].voxels.tool->geometry,
                                        .voxels = world->saved->tools[i]};
        status = ost_tool_upload(backend, &volume, &out[i], err);
    }
    return status;
}

/* Replaces the bone and the tools, restores the state before the recorded ticks, and executes these ticks again. */
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

/* The part of a world's state that repeat_ticks changes. */
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
        return ost_fail(err, OST_ERR_USAGE, "this world saves no ticks from which to continue (saved_ticks is 0)");
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
