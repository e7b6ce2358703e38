/* SPDX-License-Identifier: Apache-2.0 */
/*
 * osteon ream: moves tools along paths and removes bone.
 *
 *   --bone --load_bone--> bone ----------------.
 *   --tool --load_tool--> tools --------------. \
 *   --path --ream_path_make--> poses of a hand --ost_motor_path--> ticks --> ost_world_step, a tick at a time
 *                                              |
 *                  --out <--ost_bone_write--- bone
 *               --record <--ost_recorder_put- tick, digest
 *
 * If an OpenCL device fails during the run, the backend cpu continues from the last complete tick
 * (ost_world_failover) and produces the same grid, unless --no-failover is given.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <osteon/motor.h>

#include "app/common/backend_choice.h"
#include "app/debrief/debrief.h"
#include "app/input/glenoid_plan.h"
#include "app/input/load.h"
#include "app/common/progress.h"
#include "app/common/result.h"
#include "app/common/print.h"
#include "app/session/record.h"
#include "app/input/start_check.h"

typedef struct ream_args {
    const char *bone, *out, *record, *classes_text;
    option_list tools, paths;
    ct_options ct;
    tool_options how;
    glenoid_plan_options plan;
    const char *debrief, *max_gap;
    ost_path_options gaps; /* from max_gap */
    option_decimal rate;
    int64_t period_ns; /* from rate; 0: removal at every tick */
    int64_t rpm;
    bool rpm_given;
    ost_density_classes classes; /* from classes_text; count 0: the default classes */
    int sweep; /* index in "off|on" */
    bool compress, no_failover, strict;
} ream_args;

/* Ticks between two copies of the bone, for a device that may fail: a copy costs about as much as
   20 ticks. */
enum { SAVED_TICKS = 1024 };

/* All resources of a run, freed together by job_free. */
typedef struct job {
    ost_backend *backend;
    ost_bone *bone;
    ost_import_result imported;
    ost_bone_info before, after;
    ost_digest root;   /* digest of the bone at the end */
    ost_tool *tools[OPTION_LIST_MAX];
    ost_path path;
    ream_gaps gaps;    /* gaps in path */
    ost_world *world;
    ost_recorder *recorder; /* NULL if nothing is recorded */
    uint32_t *tick_ns; /* duration of each step */
    double run_ms;
    bool met;          /* the boxes of bone and tool met at some tick */
    ost_metrics_plan plan;
    bool planned;      /* plan is set */
    debrief debrief;   /* empty without --debrief */
    start_checked site;
    bool failed_over;  /* the backend is no longer the requested one */
} job;

static void job_free(job *j)
{
    free(j->tick_ns);
    /* The recorder is still open if something else has failed: the ticks until then remain recorded. */
    ost_recorder_close(j->recorder, NULL, NULL);
    debrief_free(&j->debrief);
    ost_world_free(j->world);
    ost_path_free(&j->path);
    for (int i = 0; i < OPTION_LIST_MAX; i++)
        ost_tool_free(j->tools[i]);
    ost_bone_free(j->bone);
    ost_backend_close(j->backend);
}

static ost_status world_make(const app_state *app, const ream_args *args, job *j, ost_error *err)
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

static ost_status load_all(const app_state *app, const ream_args *args, job *j, ost_error *err)
{
    ost_status status = backend_choose(app, &j->backend, err);
    /* Tools are loaded first: they are small, and an error in them is reported before the CT is read. */
    for (int i = 0; i < args->tools.count && status == OST_OK; i++) {
        status = load_tool(app, j->backend, args->tools.value[i], NULL, &args->how, &j->tools[i], NULL, err);
        if (status == OST_OK) {
            ost_dims d = ost_tool_geometry_get(j->tools[i])->dims;
            if (d.x > OST_TOOL_DIM_REMOVE_MAX || d.y > OST_TOOL_DIM_REMOVE_MAX || d.z > OST_TOOL_DIM_REMOVE_MAX)
                status = ost_fail(err, OST_ERR_RANGE, "%s: %d x %d x %d voxels; at most %d on a side can ream: use a larger --voxel",
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
        status = ream_path_make(app, &args->paths, &args->plan.target, &j->imported.meta, args->bone, grids, args->tools.count, &args->gaps, &j->path,
                                &j->gaps, err);
    return status;
}

static bool has_device_speed(const ost_path *path)
{
    for (size_t i = 0; i < path->count; i++)
        if (path->ticks[i].rpm == OST_RPM_OF_DEVICE)
            return true;
    return false;
}

/* Replaces the path's poses by those of tools that the motor turns. */
static ost_status motor_run(const app_state *app, const ream_args *args, job *j, ost_error *err)
{
    ost_motor motor = {0};
    if (args->rpm_given && !has_device_speed(&j->path))
        return usage_error(app, err, "--rpm %lld: %s has the speeds of its motor in it; leave --rpm out", (long long)args->rpm, args->paths.value[0]);
    return ost_motor_path(&j->path, (int32_t)args->rpm, &motor, err);
}

/* Finds the plan, and stores a copy of the bone for the debrief if there is to be one. */
static ost_status plan_take(const app_state *app, const ream_args *args, job *j, ost_error *err)
{
    ost_status status = glenoid_plan_find(app, &args->plan, NULL, NULL, &j->imported.meta, args->bone, args->debrief != NULL, &j->plan, &j->planned, err);
    return status == OST_OK && args->debrief ? debrief_begin(j->bone, &j->plan, j->tools, args->tools.count, &j->debrief, err) : status;
}

static ost_status check_start(const app_state *app, const ream_args *args, job *j, ost_error *err)
{
    start_setup setup = {.bone_name = args->bone, .bone = j->bone, .plan = j->planned ? &j->plan : NULL, .names = &args->tools,
                         .tools = j->tools, .strict = args->strict};
    start_poses(&j->path, setup.first);
    return start_check(app, &setup, &j->site, err);
}

static ost_status record_begin(const ream_args *args, job *j, ost_error *err)
{
    if (!args->record)
        return OST_OK;
    const session_setup setup = {
        .bone = args->bone,
        .tools = args->tools,
        .ct = args->ct,
        .how = args->how,
        .sweep_off = args->sweep == 0,
        .removal_period_ns = args->period_ns,
        .classes = *ost_world_classes(j->world),
        .plan = j->planned ? &j->plan : NULL,
    };
    return session_record(args->record, &setup, j->backend, j->bone, j->tools, "path", NULL, NULL, &j->recorder, err);
}

static uint32_t at_most_32(uint64_t n)
{
    return n < UINT32_MAX ? (uint32_t)n : UINT32_MAX;
}

/* Records a tick. Ticks that could not be recorded are reported when the recorder is closed. */
static ost_status record_tick(job *j, size_t number, const ost_step_result *step, ost_error *err)
{
    const ost_record record = {
        .kind = OST_RECORD_TICK,
        .as.tick = {.number = number,
                    .tick = j->path.ticks[number],
                    .flags = (step->removal ? OST_TICK_REMOVAL : 0) | (step->boxes_meet ? OST_TICK_MET : 0),
                    .digest = ost_step_digest(step, ost_world_classes(j->world)->count),
                    .removed = step->report ? at_most_32(step->report->total_voxels) : 0,
                    .touched = step->report ? at_most_32(step->report->touched_voxels) : 0,
                    .poses = (uint16_t)step->pose_count},
    };
    if (j->recorder)
        ost_recorder_put_waiting(j->recorder, &record);
    return j->debrief.before.voxels ? debrief_tick(&j->debrief, &record.as.tick, err) : OST_OK;
}

static void record_note(const job *j, size_t tick, const char *text)
{
    if (!j->recorder)
        return;
    ost_record record = {.kind = OST_RECORD_NOTE, .as.note.t_ns = tick < j->path.count ? j->path.ticks[tick].t_ns : 0};
    snprintf(record.as.note.text, sizeof record.as.note.text, "%s", text);
    ost_recorder_put_waiting(j->recorder, &record);
}

static ost_status record_end(const app_state *app, const ream_args *args, job *j, ost_error *err)
{
    if (!j->recorder)
        return OST_OK;
    ost_world_totals totals;
    ost_world_totals_get(j->world, &totals);
    const ost_session_end end = {
        .ticks = totals.ticks, .removals = totals.removals, .removed_voxels = totals.removed_voxels, .has_root = true, .root = j->root};
    ost_recorder *recorder = j->recorder;
    j->recorder = NULL;
    ost_status status = ost_recorder_close(recorder, &end, err);
    if (status != OST_OK) {
        ost_fail_context(err, "%s is whole, but the recording is not", args->out);
        return status;
    }
    put_text(app->result, "session", args->record);
    print_line(app, "  recorded in %s", args->record);
    return OST_OK;
}

/* Returns true if the device may be the cause of the failure. Other errors would occur on the
   backend cpu as well. */
static bool may_fail_over(const app_state *app, const ream_args *args, const job *j, ost_status status)
{
    return backend_is(app, "cl") && !args->no_failover && !j->failed_over &&
           (status == OST_ERR_UNAVAILABLE || status == OST_ERR_MEMORY || status == OST_ERR_INTERNAL);
}

/* Moves the world to the backend cpu after the device's failure, which err describes. ticks:
   complete ticks so far. */
static ost_status fail_over(const app_state *app, job *j, size_t ticks, ost_error *err)
{
    ost_tool *tools[OST_WORLD_TOOLS_MAX];
    ost_bone *bone = NULL;
    ost_backend *cpu = NULL;
    ost_error why = {0};
    char spec[40] = "cpu";
    if (app->threads)
        snprintf(spec, sizeof spec, "cpu:threads=%lld", (long long)app->threads);
    ost_status status = ost_backend_open(spec, &cpu, &why);
    if (status == OST_OK)
        status = ost_world_failover(j->world, cpu, &bone, tools, &why);
    if (status != OST_OK) {
        ost_backend_close(cpu);
        char text[OST_ERROR_TEXT];
        snprintf(text, sizeof text, "%s", err->text);
        return ost_fail(err, status, "%.300s; nor can the backend cpu go on: %.280s", text, why.text);
    }
    for (int i = 0; i < OPTION_LIST_MAX; i++) {
        ost_tool_free(j->tools[i]);
        j->tools[i] = i < OST_WORLD_TOOLS_MAX ? tools[i] : NULL;
    }
    ost_bone_free(j->bone);
    ost_backend_close(j->backend);
    j->bone = bone;
    j->backend = cpu;
    j->failed_over = true;
    progress_clear();
    warn(app, "%s; backend cpu goes on after %zu whole ticks, to the same grid", err->text, ticks);
    record_note(j, ticks, "the device failed; backend cpu goes on");
    put(app->result, "failover", json_pack("{s:I,s:s}", "ticks", (json_int_t)ticks, "reason", err->text));
    *err = (ost_error){0};
    return OST_OK;
}

static ost_status run(const app_state *app, const ream_args *args, job *j, ost_error *err)
{
    ost_status status = OST_OK;
    j->tick_ns = malloc(j->path.count * sizeof *j->tick_ns);
    if (!j->tick_ns)
        return ost_fail(err, OST_ERR_MEMORY, "no memory for the times of %zu ticks", j->path.count);
    progress_begin(app);
    double start = now_ms();
    for (size_t i = 0; i < j->path.count; i++) {
        ost_step_result step;
        double before = now_ms();
        status = ost_world_step(j->world, &j->path.ticks[i], &step, err);
        if (may_fail_over(app, args, j, status) && (status = fail_over(app, j, i, err)) == OST_OK)
            status = ost_world_step(j->world, &j->path.ticks[i], &step, err);
        double ns = (now_ms() - before) * 1e6;
        if (status != OST_OK) {
            ost_fail_context(err, "%s: tick %zu at %.6f s", args->paths.count == 1 ? args->paths.value[0] : "path", i,
                             (double)j->path.ticks[i].t_ns * 1e-9);
            break;
        }
        j->tick_ns[i] = ns < 4e9 ? (uint32_t)ns : UINT32_MAX;
        if ((j->recorder || args->debrief) && (status = record_tick(j, i, &step, err)) != OST_OK)
            break;
        j->met |= step.removal && step.boxes_meet;
        if (i % 16 == 0)
            progress_show(NULL, "reaming", (double)i / (double)j->path.count);
    }
    if (status == OST_OK) {
        status = ost_backend_finish(j->backend, err);
        if (may_fail_over(app, args, j, status))
            status = fail_over(app, j, j->path.count, err);
    }
    j->run_ms = now_ms() - start;
    progress_clear();
    return status;
}

static int ascending(const void *a, const void *b)
{
    uint32_t x = *(const uint32_t *)a, y = *(const uint32_t *)b;
    return (x > y) - (x < y);
}

/* Reports percentiles of the tick times by nearest rank. Sorts tick_ns. */
static void put_tick_times(const app_state *app, job *j)
{
    size_t n = j->path.count;
    qsort(j->tick_ns, n, sizeof *j->tick_ns, ascending);
    double p50 = j->tick_ns[(n - 1) * 50 / 100] * 1e-3;
    double p99 = j->tick_ns[(n - 1) * 99 / 100] * 1e-3;
    double max = j->tick_ns[n - 1] * 1e-3;
    put(app->result, "tick_us", json_pack("{s:f,s:f,s:f}", "p50", p50, "p99", p99, "max", max));
    print_line(app, "  a tick: %.4g us median, %.4g us at 99 %%, %.4g us at most", p50, p99, max);
}

static void put_classes(const app_state *app, const ost_world_totals *totals, const ost_density_classes *classes, double voxel_mm3)
{
    json_t *array = json_array();
    char text[FORMAT_TEXT];
    for (int c = 0; c < classes->count; c++) {
        int64_t voxels = (int64_t)totals->removed_by_class[c];
        json_t *row = json_object();
        put_text(row, "name", classes->name[c]);
        put_integer(row, "from_hu", classes->border[c]);
        put_integer(row, "voxels", voxels);
        put_real(row, "mm3", (double)voxels * voxel_mm3);
        put_integer(row, "density_sum", totals->density_by_class[c]);
        append(array, row);
        if (voxels)
            print_line(app, "  %-12s %12s voxels %10.1f mm3, %.0f HU on average", classes->name[c], format_count(text, voxels),
                       (double)voxels * voxel_mm3, (double)totals->density_by_class[c] / (double)voxels);
    }
    put(app->result, "removed_by_class", array);
}

/* Warns that nothing was removed and prints both positions: the usual reason is a wrong coordinate system. */
static void warn_nothing(const app_state *app, const job *j)
{
    ost_pm3 lo = j->before.geometry.origin, hi = lo, at = j->path.ticks[j->path.count / 2].pose.t;
    hi.x += j->before.geometry.spacing.x * (j->before.geometry.dims.x - 1);
    hi.y += j->before.geometry.spacing.y * (j->before.geometry.dims.y - 1);
    hi.z += j->before.geometry.spacing.z * (j->before.geometry.dims.z - 1);
    char a[FORMAT_TEXT], b[FORMAT_TEXT], c[FORMAT_TEXT];
    warn(app, "no bone was removed: the tool %s; the bone's grid is from %s to %s, the tool halfway at %s",
         j->met ? "came into the grid but met no bone" : "never came near", format_point(a, lo), format_point(b, hi), format_point(c, at));
}

/* Reads from the backend what the report needs, then writes the bone, so that a failure leaves no file. */
static ost_status take_results(const ream_args *args, job *j, ost_error *err)
{
    const ost_write_options write = {.compress = args->compress};
    ost_status status = ost_bone_digest(j->bone, NULL, &j->root, err);
    if (status == OST_OK)
        status = ost_bone_info_get(j->bone, &j->after, err);
    if (status == OST_OK)
        status = start_check_end(&j->site, j->bone, err);
    if (status == OST_OK)
        status = ost_bone_write(args->out, j->bone, &j->imported.meta, &write, err);
    return status;
}

static ost_status report(const app_state *app, const ream_args *args, job *j, ost_error *err)
{
    ost_digest file;
    ost_world_totals totals;
    char a[FORMAT_TEXT], b[FORMAT_TEXT], c[FORMAT_TEXT];
    ost_status status = file_digest(args->out, &file, err);
    if (status != OST_OK)
        return status;
    ost_world_totals_get(j->world, &totals);
    double voxel = ost_pm_to_mm(j->before.geometry.spacing.x), mm3 = voxel * voxel * voxel;
    json_t *o = app->result;
    put_text(o, "bone", args->bone);
    put_text(o, "out", args->out);
    put_integer(o, "ticks", (int64_t)totals.ticks);
    put_integer(o, "removals", (int64_t)totals.removals);
    put_integer(o, "poses", (int64_t)totals.poses);
    put_integer(o, "removed_voxels", (int64_t)totals.removed_voxels);
    put_real(o, "removed_mm3", (double)totals.removed_voxels * mm3);
    put_integer(o, "active_voxels_before", j->before.active_voxels);
    put_integer(o, "active_voxels", j->after.active_voxels);
    put_integer(o, "active_chunks", j->after.active_chunks);
    put_integer(o, "chunk", j->before.chunk_size);
    put_real(o, "run_ms", j->run_ms);
    if (!totals.removed_voxels)
        warn_nothing(app, j);
    print_line(app, "%s: %s of %s bone voxels removed, %.1f mm3", args->out, format_count(a, (int64_t)totals.removed_voxels),
               format_count(b, j->before.active_voxels), (double)totals.removed_voxels * mm3);
    put_classes(app, &totals, ost_world_classes(j->world), mm3);
    start_check_report(app, &j->site, mm3);
    print_line(app, "  %s ticks, %s removals, in %s", format_count(a, (int64_t)totals.ticks), format_count(b, (int64_t)totals.removals),
               format_time(c, j->run_ms));
    ream_print_gaps(app, &j->gaps);
    put_tick_times(app, j);
    put_digest(o, "sha256", &j->root);
    put_digest(o, "file_sha256", &file);
    char hex[OST_DIGEST_HEX];
    print_line(app, "  grid %s", ost_digest_hex(&j->root, hex));
    return OST_OK;
}

/* Checks everything that can be checked before a file is read. */
static ost_status check_args(app_state *app, ream_args *args, ost_error *err)
{
    ost_status status = ream_period(app, &args->rate, &args->period_ns, err);
    if (status == OST_OK)
        status = ream_max_gap(app, args->max_gap, &args->gaps, err);
    if (status == OST_OK && args->classes_text && (status = ost_density_classes_parse(args->classes_text, &args->classes, err)) != OST_OK)
        ost_fail_context(err, "--classes");
    if (status != OST_OK)
        return status;
    if (!args->tools.count)
        return usage_error(app, err, "--tool TOOL is missing");
    if (!args->paths.count)
        return usage_error(app, err, "--path PATH is missing");
    if (args->tools.count > 1 && args->paths.count > args->tools.count)
        return usage_error(app, err, "%d paths and %d tools: give one tool for all, or a tool for each path, in the same order",
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
        {.name = "bone", .kind = OPTION_TEXT, .out = &args.bone, .value = "BONE", .required = true,
         .help = "a bone that import wrote, a CT, or builtin:scapula"},
        {.name = "tool", .kind = OPTION_LIST, .out = &args.tools, .value = "TOOL",
         .help = "a tool that voxelize wrote, a mesh, or builtin:reamer; may repeat"},
        {.name = "path", .kind = OPTION_LIST, .out = &args.paths, .value = "PATH",
         .help = "a CSV, a session, builtin:peg-hole or builtin:glenoid-ream; may repeat, path after path, each with its tool in the same order"},
        {.name = "out", .kind = OPTION_TEXT, .out = &args.out, .value = "FILE", .required = true,
         .help = "the reamed bone: .nrrd, or .nii, .nii.gz, .txt"},
        {.name = "at", .kind = OPTION_POINT, .out = &t->at, .given = &t->at_given, .value = "X,Y,Z",
         .help = "centre of the glenoid's face, for the built-in paths\n(default: what the bone's file says)"},
        {.name = "axis", .kind = OPTION_VECTOR, .out = t->axis, .given = &t->axis_given, .value = "X,Y,Z",
         .help = "direction into the bone there (default: the file's)"},
        {.name = "side", .kind = OPTION_CHOICE, .out = &t->side, .given = &t->side_given, .value = "left|right",
         .help = "of the body (default: the file's, else the axis determines it)"},
        {.name = "rate", .kind = OPTION_DECIMAL, .out = &args.rate, .value = "HZ", .help = "remove so many times a second (default: every tick)"},
        MAX_GAP_OPTION(args.max_gap),
        {.name = "rpm", .kind = OPTION_INTEGER, .out = &args.rpm, .given = &args.rpm_given, .min = 0, .max = OST_RPM_MAX, .value = "N",
         .help = "turns a minute of the tool's motor, clockwise from behind; 0: off, and\nnothing is removed (default: 200)"},
        {.name = "sweep", .kind = OPTION_CHOICE, .out = &args.sweep, .value = "off|on",
         .help = "fill in between two ticks (default: on)"},
        {.name = "classes", .kind = OPTION_TEXT, .out = &args.classes_text, .value = "NAME:HU,...",
         .help = "density classes to count by, each from its HU up\n(default: cartilage:120,cancellous:150,cortical:650)"},
        TOOL_OPTIONS(args.how),
        CT_OPTIONS(args.ct),
        STRICT_OPTION(args.strict),
        {.name = "no-failover", .kind = OPTION_FLAG, .out = &args.no_failover,
         .help = "with --backend cl: stop when the device fails; else cpu goes on\nfrom the last whole tick, to the same grid"},
        {.name = "compress", .kind = OPTION_FLAG, .out = &args.compress, .help = "gzip a .nrrd"},
        {.name = "debrief", .kind = OPTION_TEXT, .out = &args.debrief, .value = "FILE.html",
         .help = "what it has come to, against the plan: angles, depths, hole, seat;\na page with pictures"},
        GLENOID_PLAN_OPTIONS(args.plan),
        {.name = "record", .kind = OPTION_TEXT, .out = &args.record, .value = "SESSION",
         .help = "write down every tick: osteon replay does it again, osteon info and\nexport read it; the name ends in .session"},
        {.name = NULL}};
    const usage_text usage = {
        .synopsis = "--bone BONE --tool TOOL --path PATH --out FILE [options]",
        .about = "Moves tools along a path and removes the bone they meet: the main job.",
        .options = options,
        .notes = "Lengths are in millimetres, densities in HU. A path file has lines\n"
                 "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz[,tool][,lifted][,rpm] (or x_m,y_m,z_m; plain or gzip):\n"
                 "a row is a tick, and its pose takes the tool's frame into the bone's; a row of nan\n"
                 "lifts the tool. The bone's frame is the CT's: x to the patient's\n"
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
    job j = {0};
    status = load_all(app, &args, &j, err);
    if (status == OST_OK)
        status = motor_run(app, &args, &j, err);
    if (status == OST_OK)
        status = world_make(app, &args, &j, err);
    if (status == OST_OK)
        status = plan_take(app, &args, &j, err);
    if (status == OST_OK) {
        status = check_start(app, &args, &j, err);
        if (may_fail_over(app, &args, &j, status) && (status = fail_over(app, &j, 0, err)) == OST_OK)
            status = check_start(app, &args, &j, err);
    }
    if (status == OST_OK)
        status = record_begin(&args, &j, err);
    if (status == OST_OK)
        status = run(app, &args, &j, err);
    if (status == OST_OK) {
        status = take_results(&args, &j, err);
        if (may_fail_over(app, &args, &j, status) && (status = fail_over(app, &j, j.path.count, err)) == OST_OK)
            status = take_results(&args, &j, err);
    }
    if (status == OST_OK)
        status = report(app, &args, &j, err);
    if (status == OST_OK && args.debrief)
        status = debrief_end(app, &j.debrief, j.bone, ost_world_classes(j.world), args.bone, args.debrief, err);
    if (status == OST_OK)
        status = record_end(app, &args, &j, err);
    job_free(&j);
    return status;
}
