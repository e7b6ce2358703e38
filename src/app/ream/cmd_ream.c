/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Implements `osteon ream`: moves tools along paths and removes bone.
 *
 *   --bone --load_bone--> bone ----------------.
 *   --tool --load_tool--> tools --------------. \
 *   --path --ream_path_make--> poses of a hand --ost_motor_path--> ticks --> ost_world_step, one tick at a time
 *                                              |
 *                  --out <--ost_bone_write--- bone
 *               --record <--ost_recorder_put- tick, digest
 *
 * If an OpenCL device fails during the run and --no-failover is not given, the `cpu` backend continues from the last
 * complete tick (ost_world_failover) and produces the same grid.
 */
#include "app/ream/ream.h"

#include <osteon/motor.h>
#include <stdlib.h>

#include "app/common/backend_choice.h"
#include "app/common/print.h"
#include "app/common/result.h"
#include "app/input/removal_options.h"

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

/* Checks the options as far as possible before any file is read. */
static ost_status check_args(app_state *app, ream_args *args, ost_error *err)
{
    ost_status status = ream_period(app, &args->rate, &args->period_ns, err);
    if (status == OST_OK)
        status = ream_max_gap(app, args->max_gap, &args->gaps, err);
    if (status == OST_OK && args->classes_text &&
        (status = ost_density_classes_parse(args->classes_text, &args->classes, err)) != OST_OK)
        ost_fail_context(err, "--classes");
    if (status != OST_OK)
        return status;
    if (!args->tools.count)
        return usage_error(app, err, "--tool TOOL is missing");
    if (!args->paths.count)
        return usage_error(app, err, "--path PATH is missing");
    if (args->tools.count > 1 && args->paths.count > args->tools.count)
        return usage_error(app, err,
                           "%d paths and %d tools; pass one tool for all paths, or one per path in the same order",
                           args->paths.count, args->tools.count);
    if (args->record && (status = out_check(app, args->record, "session", err)) != OST_OK)
        return status;
    if (args->debrief && (status = out_check(app, args->debrief, "html", err)) != OST_OK)
        return status;
    return out_check(app, args->out, "nrrd|nii|nii.gz|txt", err);
}

ost_status cmd_ream(app_state *app, int argc, char **argv, ost_error *err)
{
    ream_args args = {.ct = CT_OPTIONS_DEFAULT, .how = TOOL_OPTIONS_DEFAULT, .sweep = 1, .rpm = OST_RPM_REAMER};
    target_options *t = &args.plan.target;
    const option options[] = {
        {.name = "bone",
         .kind = OPTION_TEXT,
         .out = &args.bone,
         .value = "BONE",
         .required = true,
         .help = "a bone that osteon import wrote, a CT, or builtin:scapula"},
        {.name = "tool",
         .kind = OPTION_LIST,
         .out = &args.tools,
         .value = "TOOL",
         .help = "a tool grid that osteon voxelize wrote, a mesh, or builtin:reamer; may repeat"},
        {.name = "path",
         .kind = OPTION_LIST,
         .out = &args.paths,
         .value = "PATH",
         .help = "a CSV, a session, builtin:peg-hole or builtin:glenoid-ream; may repeat: the paths follow each "
                 "other, each with the tool given at the same place"},
        {.name = "out",
         .kind = OPTION_OUTPUT,
         .out = &args.out,
         .value = "FILE",
         .required = true,
         .help = "the remaining bone: .nrrd, .nii, .nii.gz or .txt"},
        {.name = "record",
         .kind = OPTION_OUTPUT,
         .out = &args.record,
         .value = "SESSION",
         .help = "record every tick, for osteon replay, info and export; the name ends in .session"},
        {.name = "debrief",
         .kind = OPTION_OUTPUT,
         .out = &args.debrief,
         .value = "FILE.html",
         .help = "page that compares the result with the plan: angles, depths, hole, seat, pictures"},
        HEADING("glenoid and plan"),
        TARGET_OPTIONS(*t, "centre of the glenoid's face, for the built-in paths (default: as in the bone's file)"),
        GLENOID_PLAN_OPTIONS(args.plan),
        HEADING("removal"),
        RPM_OPTION(args.rpm, &args.rpm_given),
        RATE_OPTION(args.rate),
        SWEEP_OPTION(args.sweep),
        MAX_GAP_OPTION(args.max_gap),
        CLASSES_OPTION(args.classes_text),
        STRICT_OPTION(args.strict),
        {.name = "no-failover",
         .kind = OPTION_FLAG,
         .out = &args.no_failover,
         .help = "with --backend cl: stop if the device fails (default: continue on cpu after the last complete "
                 "tick, with the same result)"},
        HEADING("reading a CT"),
        CT_OPTIONS(args.ct),
        HEADING("reading a mesh"),
        TOOL_OPTIONS(args.how),
        HEADING("writing"),
        COMPRESS_OPTION(args.compress),
        {.name = NULL}};
    const usage_text usage = {
        .synopsis = "--bone BONE --tool TOOL --path PATH --out FILE [options]",
        .about = "Moves tools along a path and removes the bone that they cover.",
        .options = options,
        .notes = "Lengths are in millimetres, densities in HU. A path file has lines\n"
                 "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz[,tool][,lifted][,rpm] (or x_m,y_m,z_m; plain or gzip).\n"
                 "A row is a tick. Its pose transforms the tool's frame to the bone's frame; a row of\n"
                 "nan lifts the tool. The bone has the frame of the CT: x points to the patient's\n"
                 "left, y to the back, z to the head (LPS).",
        .example = "  osteon ream --bone builtin:scapula --out reamed.nrrd \\\n"
                   "    --tool builtin:peg --path builtin:peg-hole \\\n"
                   "    --tool builtin:reamer --path builtin:glenoid-ream\n"
                   "  osteon ream --bone shoulder.nii.gz --tool reamer.stl --path builtin:glenoid-ream \\\n"
                   "    --at -117.8,196.5,-159 --axis 1,0,0 --side right --out reamed.nrrd",
    };
    ost_status status;
    if (!options_parse(app, &usage, argc, argv, &status, err) || (status = check_args(app, &args, err)) != OST_OK)
        return status;
    ream_job j = {0};
    status = load_all(app, &args, &j, err);
    if (status == OST_OK)
        status = motor_run(app, &args, &j, err);
    if (status == OST_OK)
        status = world_make(app, &args, &j, err);
    if (status == OST_OK)
        status = plan_take(app, &args, &j, err);
    if (status == OST_OK) {
        status = check_start(app, &args, &j, err);
        if (ream_may_fail_over(app, &args, &j, status) && (status = ream_fail_over(app, &j, 0, err)) == OST_OK)
            status = check_start(app, &args, &j, err);
    }
    if (status == OST_OK)
        status = ream_record_begin(&args, &j, err);
    if (status == OST_OK)
        status = ream_run(app, &args, &j, err);
    if (status == OST_OK) {
        status = ream_take_results(&args, &j, err);
        if (ream_may_fail_over(app, &args, &j, status) &&
            (status = ream_fail_over(app, &j, j.path.count, err)) == OST_OK)
            status = ream_take_results(&args, &j, err);
    }
    if (status == OST_OK)
        status = ream_report(app, &args, &j, err);
    if (status == OST_OK && args.debrief)
        status = debrief_end(app, &j.debrief, j.bone, ost_world_classes(j.world), args.bone, args.debrief, err);
    if (status == OST_OK)
        status = ream_record_end(app, &args, &j, err);
    job_free(&j);
    return status;
}
