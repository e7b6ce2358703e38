/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Executes one tick (thesis, Algs. 2.7-2.10).
 *
 *   tick: tool, pose, motor speed
 *     motor on, and removal due?                             no: only the tool moves
 *     n poses from the last event's pose to this pose        AR-SWEEP
 *     for each: boxes intersect? voxels that it can hit?     Algs. 2.7-2.9
 *     backend.remove with the poses that can hit a voxel     Alg. 2.10
 *
 * All operations that can fail precede the first change. Maps are computed in scratch memory, a backend that fails
 * leaves the bone unchanged, and the state of the world is written last.
 */
#include "sim/world.h"

#include <stdlib.h>
#include <string.h>

#include "core/conditions.h"
#include "core/integer.h"
#include "sim/box.h"

static ost_status check_tick(const ost_world *world, const ost_tick *tick, ost_error *err)
{
    if (tick->tool < 0 || tick->tool >= world->tool_count)
        return ost_fail(err, OST_ERR_USAGE, "a tick at %lld ns uses tool %d; the world has %d", (long long)tick->t_ns,
                        tick->tool, world->tool_count);
    if (world->clock.totals.ticks > 0 && tick->t_ns <= world->clock.t_ns)
        return ost_fail(err, OST_ERR_USAGE, "a tick at %lld ns after one at %lld ns; time must increase",
                        (long long)tick->t_ns, (long long)world->clock.t_ns);
    if (tick->rpm == OST_RPM_OF_DEVICE)
        return ost_fail(err, OST_ERR_USAGE, "a tick at %lld ns has the pose of a device and no motor speed; convert "
                        "the path with ost_motor_path", (long long)tick->t_ns);
    if (tick->rpm < OST_RPM_ON || tick->rpm > OST_RPM_MAX)
        return ost_fail(err, OST_ERR_USAGE, "a tick at %lld ns has a motor speed of %d rpm; expected 0 to %d",
                        (long long)tick->t_ns, tick->rpm, OST_RPM_MAX);
    return ost_pose_check(&tick->pose, err);
}

/*
 * Returns true if a removal is due. A removal is due in the first tick after one of three events: the tool was
 * selected, the tool was lifted, or the motor was switched on. Afterwards, a removal is due in the first tick of every
 * period.
 */
static bool removal_is_due(const ost_world *world, const ost_tick *tick, bool taken_up)
{
    const int64_t period = world->options.removal_period_ns;
    return taken_up || !world->clock.running || period == 0 ||
           ost_floor_div(tick->t_ns, period) != ost_floor_div(world->clock.removal_t, period);
}

/*
 * Returns the rotation of the motor from the first pose of the next sweep up to and including this tick
 * (AR-MOTOR-6).
 */
static int64_t turned_by(const ost_world *world, const ost_tick *tick, bool taken_up)
{
    if (taken_up || world->clock.totals.ticks == 0 || tick->rpm <= 0)
        return world->clock.turned;
    /*
     * Time increases, so the difference of the times is exact modulo 2^64. The product ns * rpm is computed only if it
     * is at most `left`, so it cannot overflow.
     */
    const uint64_t ns = (uint64_t)tick->t_ns - (uint64_t)world->clock.t_ns;
    const int64_t left = OST_MOTOR_TURN - world->clock.turned;
    return ns > (uint64_t)(left / tick->rpm) ? OST_MOTOR_TURN : world->clock.turned + (int64_t)ns * tick->rpm;
}

static ost_status count_poses(const ost_world *world, const ost_entity *tool, const ost_tick *tick, bool taken_up,
                              int *count, ost_error *err)
{
    *count = 1;
    if (taken_up || world->options.sweep_off)
        return OST_OK;
    if (turned_by(world, tick, taken_up) > OST_MOTOR_TURN / 4)
        return ost_fail(err, OST_ERR_RANGE,
                        "the motor turns the tool by more than 90 degrees between two removals: %d rpm needs shorter "
                        "ticks, a higher rate or a lower speed",
                        tick->rpm);
    return ost_sweep_count(&tool->input.event, &tick->pose, ost_tool_geometry_get(tool->voxels.tool),
                           world->geometry.spacing.x, count, err);
}

/*
 * Returns the voxels that the tool can hit at the given pose. If the boxes of tool and bone do not intersect, the
 * result is an empty box.
 */
static ost_voxel_box reach(const ost_world *world, const ost_entity *tool, const ost_pose *pose)
{
    const ost_dims d = world->geometry.dims;
    if (world->options.broad_phase_off)
        return (ost_voxel_box){.hi = {d.x, d.y, d.z}};
    if (!ost_boxes_meet(&world->bone.box, &tool->box, pose))
        return (ost_voxel_box){0};
    return ost_box_voxels(&world->geometry, &tool->box, pose);
}

/* Computes the map and the box of each pose that can hit a voxel, in the order of the sweep. */
static ost_status prepare(ost_world *world, const ost_entity *tool, const ost_tick *tick, int count,
                          ost_removal_event *event, ost_error *err)
{
    ost_status status = ost_world_reserve_poses(world, count, err);
    int used = 0;
    for (int k = 1; k <= count && status == OST_OK; k++) {
        ost_pose pose = count == 1 ? tick->pose : ost_sweep_pose(&tool->input.event, &tick->pose, k, count);
        status = ost_map_make(&pose, &world->geometry, ost_tool_geometry_get(tool->voxels.tool), &world->maps[used],
                              err);
        if (status != OST_OK)
            break;
        world->boxes[used] = reach(world, tool, &pose);
        used += ost_voxel_box_holds(&world->boxes[used]);
    }
    *event = (ost_removal_event){
        .pose_count = used, .maps = world->maps, .boxes = world->boxes, .classes = &world->options.classes};
    return status;
}

static void bound_chunks(const ost_world *world, const ost_removal_event *event, ost_step_result *result)
{
    for (int p = 0; p < event->pose_count; p++)
        for (int a = 0; a < 3; a++) {
            int32_t lo = event->boxes[p].lo[a] / world->chunk_size;
            int32_t hi = (event->boxes[p].hi[a] - 1) / world->chunk_size + 1;
            result->chunk_lo[a] = p == 0 || lo < result->chunk_lo[a] ? lo : result->chunk_lo[a];
            result->chunk_hi[a] = p == 0 || hi > result->chunk_hi[a] ? hi : result->chunk_hi[a];
        }
}

static void add_totals(ost_world_totals *totals, const ost_removal_report *report, int poses)
{
    totals->removals++;
    totals->poses += (uint64_t)poses;
    totals->removed_voxels += report->total_voxels;
    for (int c = 0; c < OST_CLASS_MAX; c++) {
        totals->removed_by_class[c] += report->voxels[c];
        totals->density_by_class[c] += report->density[c];
    }
}

static ost_status run_event(ost_world *world, ost_entity *tool, const ost_tick *tick, bool taken_up,
                            ost_step_result *result, ost_error *err)
{
    int count;
    ost_removal_event event;
    ost_status status = count_poses(world, tool, tick, taken_up, &count, err);
    if (status == OST_OK)
        status = prepare(world, tool, tick, count, &event, err);
    if (status == OST_OK && event.pose_count > 0)
        status = ost_bone_remove(world->bone.voxels.bone, tool->voxels.tool, &event, &world->report, err);
    if (status != OST_OK)
        return status;
    if (event.pose_count == 0)
        ost_removal_report_clear(&world->report);
    result->removal = true;
    result->boxes_meet = event.pose_count > 0;
    result->pose_count = count;
    result->report = &world->report;
    bound_chunks(world, &event, result);
    add_totals(&world->clock.totals, &world->report, count);
    world->clock.removal_t = tick->t_ns;
    return OST_OK;
}

ost_status ost_world_advance(ost_world *world, const ost_tick *tick, ost_step_result *result, ost_error *err)
{
    *result = (ost_step_result){0};
    ost_status status = check_tick(world, tick, err);
    if (status != OST_OK)
        return status;

    ost_entity *tool = &world->tools[tick->tool];
    const bool taken_up = tick->tool != world->clock.tool || tick->lifted, on = tick->rpm != 0;
    const bool due = on && removal_is_due(world, tick, taken_up);
    if (due) {
        status = run_event(world, tool, tick, taken_up, result, err);
        if (status != OST_OK) {
            *result = (ost_step_result){0};
            return status;
        }
    }
    world->clock.turned = due || !on ? 0 : turned_by(world, tick, taken_up);
    if (due || !on)
        tool->input.event = tick->pose;
    tool->input.pose = tick->pose;
    world->clock.running = on;
    world->clock.tool = tick->tool;
    world->clock.t_ns = tick->t_ns;
    world->clock.totals.ticks++;
    return OST_OK;
}

ost_status ost_world_rehearse(ost_world *world, int index, const ost_pose *pose, ost_error *err)
{
    const ost_tick tick = {.tool = index, .rpm = OST_RPM_ON, .pose = *pose, .t_ns = world->clock.t_ns + 1};
    ost_removal_event event;
    ost_status status = check_tick(world, &tick, err);
    if (status != OST_OK)
        return status;
    const ost_entity *tool = &world->tools[index];
    status = prepare(world, tool, &tick, 1, &event, err);
    if (status == OST_OK && event.pose_count > 0)
        status = ost_bone_collide(world->bone.voxels.bone, tool->voxels.tool, &event, &world->report, err);
    return status;
}

ost_status ost_world_step(ost_world *world, const ost_tick *tick, ost_step_result *result, ost_error *err)
{
    ost_step_result ignored;
    if (!result)
        result = &ignored;
    *result = (ost_step_result){0};
    ost_status status = ost_world_save(world, err);
    if (status == OST_OK)
        status = ost_world_advance(world, tick, result, err);
    if (status == OST_OK)
        ost_world_save_tick(world, tick);
    return status;
}
