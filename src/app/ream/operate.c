/* SPDX-License-Identifier: Apache-2.0 */
/* Executes an operation from the loading of its inputs to the end of its recording. */
#include "app/ream/ream.h"

#include <osteon/motor.h>
#include <stdlib.h>

#include "app/common/backend_choice.h"
#include "app/common/options.h"

/*
 * Number of ticks between two copies of the bone. The copies are made only for an OpenCL device, which may fail. A copy
 * takes about as long as 20 ticks.
 */
enum { SAVED_TICKS = 1024 };

static void job_free(ream_job *j)
{
    free(j->tick_ns);
    /* After an error, the recorder is still open. Closing it saves the ticks recorded so far. */
    ost_recorder_close(j->recorder, NULL, NULL);
    debrief_free(&j->debrief);
    ost_world_free(j->world);
    ost_path_free(&j->path);
    for (int i = 0; i < OPTION_LIST_MAX; i++)
        ost_tool_free(j->tools[i]);
    ost_bone_free(j->bone);
    ost_backend_close(j->backend);
}

static ost_status world_make(const app_state *app, const ream_args *args, ream_job *j, ost_error *err)
{
    const ost_world_options options = {
        .sweep_off = args->sweep == 0,
        .removal_period_ns = args->period_ns,
        .classes = args->classes,
        .saved_ticks = backend_is(app, "cl") && !args->no_failover ? SAVED_TICKS : 0,
    };
    ost_status status = ost_world_create(j->bone, &options, &j->world, err);
    for (int i = 0; i < args->tools.count && status == OST_OK; i++)
        status = ost_world_add_tool(j->world, args->tools.value[i], j->tools[i], NULL, err);
    return status;
}

static ost_status load_all(const app_state *app, const ream_args *args, ream_job *j, ost_error *err)
{
    ost_status status = backend_choose(app, &j->backend, err);
    /* Tools are small and are loaded first, so that an error in a tool is reported before the CT is read. */
    for (int i = 0; i < args->tools.count && status == OST_OK; i++) {
        status = load_tool(app, j->backend, args->tools.value[i], NULL, &args->how, &j->tools[i], NULL, err);
        if (status == OST_OK) {
            ost_dims d = ost_tool_geometry_get(j->tools[i])->dims;
            if (d.x > OST_TOOL_DIM_REMOVE_MAX || d.y > OST_TOOL_DIM_REMOVE_MAX || d.z > OST_TOOL_DIM_REMOVE_MAX)
                status = ost_fail(err, OST_ERR_RANGE,
                                  "%s: %d x %d x %d voxels; reaming needs at most %d per side: use a larger --voxel",
                                  args->tools.value[i], d.x, d.y, d.z, OST_TOOL_DIM_REMOVE_MAX);
        }
    }
    if (status == OST_OK)
        status = load_bone(app, j->backend, args->bone, &args->ct, false, &j->bone, &j->imported, err);
    if (status == OST_OK)
        status = ost_bone_info_get(j->bone, &j->before, err);
    const ost_tool_geometry *grids[OPTION_LIST_MAX] = {NULL};
    for (int i = 0; i < args->tools.count && status == OST_OK; i++)
        grids[i] = ost_tool_geometry_get(j->tools[i]);
    if (status == OST_OK)
        status = ream_path_make(app, &args->paths, &args->plan.target, &j->imported.meta, args->bone, grids,
                                args->tools.count, &args->gaps, &j->path, &j->gaps, err);
    return status;
}

static bool has_device_speed(const ost_path *path)
{
    for (size_t i = 0; i < path->count; i++)
        if (path->ticks[i].rpm == OST_RPM_OF_DEVICE)
            return true;
    return false;
}

/* Converts the path, which contains poses of the hand, to poses of the tool, which is rotated by the motor. */
static ost_status motor_run(const app_state *app, const ream_args *args, ream_job *j, ost_error *err)
{
    ost_motor motor = {0};
    if (args->rpm_given && !has_device_speed(&j->path))
        return usage_error(app, err, "--rpm %lld: %s contains motor speeds; omit --rpm", (long long)args->rpm,
                           args->paths.value[0]);
    return ost_motor_path(&j->path, (int32_t)args->rpm, &motor, err);
}

/* Determines the plan. If a debrief is requested, also copies the bone. */
static ost_status plan_take(const app_state *app, const ream_args *args, ream_job *j, ost_error *err)
{
    ost_status status = glenoid_plan_find(app, &args->plan, NULL, NULL, &j->imported.meta, args->bone,
                                          args->debrief != NULL, &j->plan, &j->planned, err);
    return status == OST_OK && args->debrief
               ? debrief_begin(j->bone, &j->plan, j->tools, args->tools.count, &j->debrief, err)
               : status;
}

static ost_status check_start(const app_state *app, const ream_args *args, ream_job *j, ost_error *err)
{
    start_setup setup = {.bone_name = args->bone,
                         .bone = j->bone,
                         .plan = j->planned ? &j->plan : NULL,
                         .names = &args->tools,
                         .tools = j->tools,
                         .strict = args->strict};
    start_poses(&j->path, setup.first);
    return start_check(app, &setup, &j->site, err);
}

ost_status ream_operate(const app_state *app, const ream_args *args, ost_error *err)
{
    ream_job j = {0};
    ost_status status = load_all(app, args, &j, err);
    if (status == OST_OK)
        status = motor_run(app, args, &j, err);
    if (status == OST_OK)
        status = world_make(app, args, &j, err);
    if (status == OST_OK)
        status = plan_take(app, args, &j, err);
    if (status == OST_OK) {
        status = check_start(app, args, &j, err);
        if (ream_may_fail_over(app, args, &j, status) && (status = ream_fail_over(app, &j, 0, err)) == OST_OK)
            status = check_start(app, args, &j, err);
    }
    if (status == OST_OK)
        status = ream_record_begin(args, &j, err);
    if (status == OST_OK)
        status = ream_run(app, args, &j, err);
    if (status == OST_OK) {
        status = ream_take_results(args, &j, err);
        if (ream_may_fail_over(app, args, &j, status) &&
            (status = ream_fail_over(app, &j, j.path.count, err)) == OST_OK)
            status = ream_take_results(args, &j, err);
    }
    if (status == OST_OK)
        status = ream_report(app, args, &j, err);
    if (status == OST_OK && args->debrief)
        status = debrief_end(app, &j.debrief, j.bone, ost_world_classes(j.world), args->bone, args->debrief, err);
    if (status == OST_OK)
        status = ream_record_end(app, args, &j, err);
    job_free(&j);
    return status;
}
