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

#include "app/input/removal_options.h"

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
    return ream_operate(app, &args, err);
}
