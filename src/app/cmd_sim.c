/* SPDX-License-Identifier: Apache-2.0 */
/*
 * osteon sim: a device moves the tool, a thousand times a second.
 *
 *   bone, tools --> world --> operation <--ticks-- ost_servo_run <--poses-- device
 *                                 '--> session
 *
 * With --resume a session's ticks are done first, and the operation goes on
 * from there; a new recording holds both.
 *
 * Without a window so far: --headless.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "app/backend_choice.h"
#include "app/interrupt.h"
#include "app/load.h"
#include "app/progress.h"
#include "app/ream_path.h"
#include "app/result.h"
#include "app/say.h"
#include "app/session_keys.h"
#include "app/sim_watch.h"

enum { ROOM = 65536 }; /* records that wait for the disk: 65 s */

typedef struct sim_args {
    const char *device, *bone, *out, *record, *classes_text, *session, *resume;
    option_list tools, paths;
    ct_options ct;
    tool_options how;
    target_options target;
    option_decimal rate, seconds, idle;
    int64_t period_ns;
    uint64_t ticks, idle_ticks;
    ost_density_classes classes;
    int64_t force; /* of force_names */
    bool force_given, headless, no_clock, no_realtime, compress, sweep_off, bone_given, tools_given;
} sim_args;

static const char *const force_names[] = {"off", "energy", "instant"};

typedef struct simulation {
    ost_backend *backend;
    ost_bone *bone;
    ost_import_result imported;
    ost_tool *tools[OPTION_LIST_MAX];
    ost_path path;
    ost_world *world;
    ost_recorder *recorder;
    ost_haptic *device;
    ost_force *force;   /* NULL: none is given */
    ost_operation *operation;
    ost_servo_report *loop;
    ost_operation_report done;
    ost_session *resumed; /* NULL: it begins */
    ost_tick last;        /* of it */
    uint64_t before;      /* its ticks */
} simulation;

static void simulation_free(simulation *s)
{
    free(s->loop);
    ost_operation_free(s->operation);
    ost_force_free(s->force);
    ost_haptic_close(s->device);
    ost_recorder_close(s->recorder, NULL, NULL);
    ost_session_close(s->resumed);
    ost_world_free(s->world);
    ost_path_free(&s->path);
    for (int i = 0; i < OPTION_LIST_MAX; i++)
        ost_tool_free(s->tools[i]);
    ost_bone_free(s->bone);
    ost_backend_close(s->backend);
}

static bool device_is(const sim_args *args, const char *name)
{
    const size_t length = strcspn(args->device, ":");
    return strlen(name) == length && memcmp(args->device, name, length) == 0;
}

static ost_status load_all(const app_state *app, sim_args *args, simulation *s, ost_error *err)
{
    ost_status status = backend_choose(app, &s->backend, err);
    for (int i = 0; i < args->tools.count && status == OST_OK; i++)
        status = load_tool(app, s->backend, args->tools.value[i], NULL, &args->how, &s->tools[i], NULL, err);
    if (status == OST_OK)
        status = load_bone(app, s->backend, args->bone, &args->ct, false, &s->bone, &s->imported, err);
    const ost_tool_geometry *grids[OPTION_LIST_MAX] = {NULL};
    for (int i = 0; i < args->tools.count && status == OST_OK; i++)
        grids[i] = ost_tool_geometry_get(s->tools[i]);
    if (status == OST_OK && !device_is(args, "replay"))
        status = ream_path_make(app, &args->paths, &args->target, &s->imported.meta, args->bone, grids, args->tools.count, &s->path, err);
    const ost_world_options options = {.sweep_off = args->sweep_off, .removal_period_ns = args->period_ns, .classes = args->classes};
    if (status == OST_OK)
        status = ost_world_create(s->bone, &options, &s->world, err);
    for (int i = 0; i < args->tools.count && status == OST_OK; i++)
        status = ost_world_add_tool(s->world, args->tools.value[i], s->tools[i], NULL, err);
    if (status != OST_OK)
        return status;
    const ost_haptic_setup setup = {
        .path = &s->path,
        .session = args->session,
        .start = s->path.count ? s->path.ticks[0].pose : ost_pose_identity(),
    };
    return ost_haptic_open(args->device, &setup, &s->device, err);
}

/* A device that renders forces gets one unless --force off; one that does not has none to be asked for. */
static ost_status force_make(const app_state *app, sim_args *args, simulation *s, ost_error *err)
{
    ost_haptic_info info = {0};
    for (int i = 0; i < ost_haptic_count(); i++)
        if (ost_haptic_describe(i, &info, err) == OST_OK && device_is(args, info.name))
            break;
    const bool renders = info.name && device_is(args, info.name) && (info.caps & OST_HAPTIC_FORCE);
    if (!args->force_given)
        args->force = renders;
    if (args->force && !renders)
        return usage_error(app, err, "--force %s: device %s renders no force", force_names[args->force], args->device);
    if (!args->force)
        return OST_OK;
    ost_force_params params = ost_force_defaults();
    params.mode = args->force == 2 ? OST_FORCE_INSTANT : OST_FORCE_ENERGY;
    ost_status status = ost_force_create(s->bone, &params, &s->force, err);
    if (status == OST_ERR_UNAVAILABLE && !args->force_given) {
        warn(app, "%s; none is given", err->text);
        args->force = 0;
        *err = (ost_error){0};
        return OST_OK;
    }
    for (int i = 0; i < args->tools.count && status == OST_OK; i++)
        status = ost_force_add_tool(s->force, s->tools[i], err);
    return status;
}

static ost_status record_begin(const sim_args *args, simulation *s, ost_error *err)
{
    if (!args->record)
        return OST_OK;
    const session_setup setup = {
        .bone = args->bone,
        .tools = args->tools,
        .ct = args->ct,
        .how = args->how,
        .sweep_off = args->sweep_off,
        .removal_period_ns = args->period_ns,
        .classes = *ost_world_classes(s->world),
    };
    ost_session_header *header;
    ost_status status = session_keys_make(&setup, s->backend, s->bone, s->tools, args->device, &header, err);
    if (status != OST_OK)
        return status;
    status = ost_session_header_set(header, "tick_ns", "1000000", err);
    if (status == OST_OK)
        status = ost_session_header_set(header, "force", force_names[args->force], err);
    if (status == OST_OK)
        status = ost_recorder_open(args->record, header, &(ost_recorder_options){.room = ROOM}, &s->recorder, err);
    ost_session_header_free(header);
    return status;
}

/* What the session says of bone, tools and world goes before what is usual; files may have been moved. */
static ost_status resume_open(const app_state *app, sim_args *args, simulation *s, ost_error *err)
{
    session_setup setup;
    char missing[OST_SESSION_MISSING];
    struct stat a, b;
    if (args->record && stat(args->record, &a) == 0 && stat(args->resume, &b) == 0 && a.st_dev == b.st_dev && a.st_ino == b.st_ino)
        return usage_error(app, err, "--record %s: it is what is resumed; record into another file, which will hold both", args->record);
    ost_status status = ost_session_open(args->resume, &s->resumed, err);
    if (status != OST_OK)
        return status;
    if (ost_session_summary_of(s->resumed)->whole_ticks == 0)
        return ost_fail(err, OST_ERR_INPUT, "%s: has no tick that could be done again", args->resume);
    const ost_session_summary *sum = ost_session_summary_of(s->resumed);
    if (sum->whole_ticks < sum->ticks && ost_session_missing(s->resumed, missing)[0])
        warn(app, "%s: %s", args->resume, missing);
    status = session_keys_read(args->resume, ost_session_header_of(s->resumed), &setup, err);
    if (status != OST_OK)
        return status;
    args->bone = args->bone_given ? args->bone : setup.bone;
    args->tools = args->tools_given ? args->tools : setup.tools;
    args->ct = setup.ct;
    args->how = setup.how;
    args->sweep_off = setup.sweep_off;
    args->period_ns = setup.removal_period_ns;
    args->classes = setup.classes;
    return OST_OK;
}

/* Its ticks, each as recorded, into the world and into the new recording. */
static ost_status resume_run(const sim_args *args, simulation *s, ost_error *err)
{
    const session_setup names = {.bone = args->bone, .tools = args->tools};
    const uint64_t count = ost_session_summary_of(s->resumed)->whole_ticks;
    ost_status status = session_keys_check(args->resume, ost_session_header_of(s->resumed), &names, s->bone, s->tools, err);
    while (status == OST_OK && s->before < count) {
        ost_record record;
        ost_step_result step;
        bool more;
        status = ost_session_next(s->resumed, &record, &more, err);
        if (status != OST_OK || !more)
            break;
        if (record.kind == OST_RECORD_TICK) {
            status = ost_world_step(s->world, &record.as.tick.tick, &step, err);
            if (status == OST_OK && ost_step_digest(&step, ost_world_classes(s->world)->count) != record.as.tick.digest)
                status = ost_fail(err, OST_ERR_INPUT, "%s: tick %llu comes out otherwise than recorded; osteon replay --verify says where",
                                  args->resume, (unsigned long long)record.as.tick.number);
            s->last = record.as.tick.tick;
            s->before++;
        }
        if (status == OST_OK && s->recorder && record.kind != OST_RECORD_END)
            ost_recorder_put_patiently(s->recorder, &record);
        if (s->before % 16 == 0)
            progress_show(NULL, "resuming", (double)s->before / (double)count);
    }
    progress_clear();
    return status;
}

/* Ends the loop as a user asks for it, so that what was recorded is whole. */
static bool tick(void *operation, const ost_servo_sample *sample, ost_wrench *wrench)
{
    return ost_operation_tick(operation, sample, wrench) && !interrupt_asked();
}

/* The loop, with somebody who tells people meanwhile, and a signal as a wish to end. */
static ost_status serve(const app_state *app, const sim_args *args, const ost_servo_options *how, simulation *s, ost_error *err)
{
    sim_watch *watch;
    ost_status status = sim_watch_begin(app, s->recorder, args->record, ROOM, args->no_clock ? 0 : (double)(how->ticks + how->idle_ticks) * 1e-3,
                                        &watch, err);
    if (status != OST_OK)
        return status;
    interrupt_begin();
    status = ost_servo_run(s->device, how, tick, ost_operation_done, s->operation, s->loop, err);
    interrupt_end();
    sim_watch_end(watch);
    return status;
}

static ost_status run(const app_state *app, const sim_args *args, simulation *s, ost_error *err)
{
    s->loop = malloc(sizeof *s->loop);
    if (!s->loop)
        return ost_fail(err, OST_ERR_MEMORY, "no memory for the times of a run");
    const ost_operation_options what = {
        .recorder = s->recorder,
        .force = s->force,
        .tool = s->resumed ? s->last.tool : 0,
        .steps_before = s->before,
        .last = s->resumed ? &s->last : NULL,
    };
    ost_status status = ost_operation_create(s->world, &what, &s->operation, err);
    if (status != OST_OK)
        return status;
    const ost_servo_options how = {
        .ticks = args->ticks,
        .idle_ticks = args->no_clock ? 0 : args->idle_ticks,
        .no_clock = args->no_clock,
        .no_realtime = args->no_realtime || args->no_clock,
    };
    if (!app->json && !app->quiet && !args->no_clock && args->ticks)
        say(app, "%s moves %s in %s for %.4g s%s", args->device, args->tools.value[0], args->bone, (double)args->ticks * 1e-3,
            how.idle_ticks ? ", with as quiet a loop before and after for comparison" : "");
    status = serve(app, args, &how, s, err);
    ost_operation_report_get(s->operation, &s->done);
    if (status == OST_OK && s->done.status != OST_OK)
        status = ost_fail(err, s->done.status, "tick %llu: %.500s", (unsigned long long)s->loop->ticks, s->done.error.text);
    return status == OST_OK ? ost_backend_finish(s->backend, err) : status;
}

static void put_times(const app_state *app, const char *key, const char *what, const ost_times *times)
{
    const double p50 = ost_times_share_us(times, 0.5), p99 = ost_times_share_us(times, 0.99), p999 = ost_times_share_us(times, 0.999);
    const double max = (double)times->max_ns * 1e-3;
    put(app->result, key, json_pack("{s:f,s:f,s:f,s:f,s:I}", "p50", p50, "p99", p99, "p99_9", p999, "max", max, "count", (json_int_t)times->count));
    if (times->count)
        say(app, "  %-22s %8.0f %8.0f %8.0f %10.0f us", what, p50, p99, p999, max);
}

static const char *end_text(ost_servo_end end)
{
    switch (end) {
    case OST_SERVO_TICKS: return "the time was over";
    case OST_SERVO_ASKED: return interrupt_asked() ? "it was asked to end" : "the world failed";
    case OST_SERVO_DEVICE_ENDED: return "the device had nothing more to give";
    case OST_SERVO_DEVICE_LOST: return "the device was lost";
    case OST_SERVO_WATCHDOG: return "the device was silent for 5 ticks";
    }
    return "unknown";
}

static void report_loop(const app_state *app, const sim_args *args, const simulation *s)
{
    const ost_servo_report *r = s->loop;
    char a[SAY_TEXT];
    json_t *o = app->result;
    put_text(o, "device", args->device);
    if (s->resumed) {
        put_text(o, "resumed", args->resume);
        put_integer(o, "ticks_before", (int64_t)s->before);
        say(app, "%s: %s ticks done again, and on", args->resume, say_count(a, (int64_t)s->before));
    }
    put_text(o, "end", end_text(r->end));
    put_integer(o, "ticks", (int64_t)r->ticks);
    put_integer(o, "missed", (int64_t)r->missed);
    put_integer(o, "longest_miss", (int64_t)r->longest_miss);
    put_integer(o, "stale", (int64_t)r->stale);
    put_integer(o, "idle_ticks", (int64_t)r->idle_ticks);
    put_integer(o, "idle_missed", (int64_t)r->idle_missed);
    put_integer(o, "stolen_ms", r->stolen_ms);
    put_integer(o, "faults", (int64_t)s->done.faults);
    put_integer(o, "fault_ticks", (int64_t)s->done.fault_ticks);
    put_text(o, "scheduling", r->realtime.scheduling);
    put_text(o, "memory", r->realtime.memory);
    say(app, "%s ticks: %s", say_count(a, (int64_t)r->ticks), end_text(r->end));
    say(app, "  %-22s %8s %8s %8s %10s", "", "median", "99 %", "99.9 %", "max");
    put_times(app, "wake_us", "late by", &r->wake);
    put_times(app, "exec_us", "a tick takes", &r->exec);
    put_times(app, "completion_us", "done after", &r->completion);
    put_times(app, "idle_wake_us", "a quiet loop, late by", &r->idle_wake);
    if (!args->no_clock) {
        say(app, "  deadlines missed: %llu of %llu; by the quiet loop %llu of %llu", (unsigned long long)r->missed, (unsigned long long)r->ticks,
            (unsigned long long)r->idle_missed, (unsigned long long)r->idle_ticks);
        say(app, "  scheduling: %s; memory: %s", r->realtime.scheduling, r->realtime.memory);
        if (r->stolen_ms > 0)
            say(app, "  the machine is a virtual one: %lld ms of its cores went elsewhere meanwhile", (long long)r->stolen_ms);
    }
    put_text(o, "force", force_names[args->force]);
    if (s->force) {
        put_real(o, "peak_force_n", s->done.peak_n);
        put_real(o, "peak_axial_n", s->done.peak_axial_n);
        put_real(o, "cutting_j", s->done.energy_j);
        put_integer(o, "contact_ticks", (int64_t)s->done.touching_ticks);
        put_integer(o, "damped_ticks", (int64_t)s->done.damped_ticks);
        say(app, "  force: %.2f N at most on the hand, which stands for %.0f N on the bone; %.1f J of cutting in %.1f s of contact",
            s->done.peak_n, s->done.peak_axial_n, s->done.energy_j, (double)s->done.touching_ticks * 1e-3);
    }
    if (s->done.faults)
        warn(app, "%s: %llu faults, %llu ticks long; the last: %s", args->device, (unsigned long long)s->done.faults,
             (unsigned long long)s->done.fault_ticks, ost_fault_text(s->done.last_fault));
}

static ost_status finish(const app_state *app, const sim_args *args, simulation *s, ost_error *err)
{
    ost_world_totals totals;
    ost_digest root, file;
    char a[SAY_TEXT], hex[OST_DIGEST_HEX];
    json_t *o = app->result;
    ost_world_totals_get(s->world, &totals);
    ost_status status = ost_bone_digest(s->bone, NULL, &root, err);
    if (status != OST_OK)
        return status;
    put_integer(o, "removals", (int64_t)totals.removals);
    put_integer(o, "removed_voxels", (int64_t)totals.removed_voxels);
    put_digest(o, "sha256", &root);
    say(app, "  %s voxels removed\n  grid %s", say_count(a, (int64_t)totals.removed_voxels), ost_digest_hex(&root, hex));
    if (args->out) {
        const ost_write_options write = {.compress = args->compress};
        status = ost_bone_write(args->out, s->bone, &s->imported.meta, &write, err);
        if (status == OST_OK && (status = file_digest(args->out, &file, err)) == OST_OK) {
            put_text(o, "out", args->out);
            put_digest(o, "file_sha256", &file);
            say(app, "  written to %s", args->out);
        }
    }
    if (status == OST_OK && s->recorder) {
        const ost_session_end end = {
            .ticks = totals.ticks, .removals = totals.removals, .removed_voxels = totals.removed_voxels, .has_root = true, .root = root};
        ost_recorder *recorder = s->recorder;
        s->recorder = NULL;
        status = ost_recorder_close(recorder, &end, err);
        if (status == OST_OK) {
            put_text(o, "session", args->record);
            say(app, "  recorded in %s", args->record);
        }
    }
    return status;
}

/* Seconds as ticks of a millisecond. */
static ost_status ticks_of(const app_state *app, const char *name, const option_decimal *seconds, uint64_t *ticks, ost_error *err)
{
    int64_t ms;
    if (!ost_decimal_scale(&seconds->value, 1000, &ms, NULL) || ms < 0 || ms > INT64_C(86400000))
        return usage_error(app, err, "--%s %s: must be from 0 to 86400", name, seconds->text);
    *ticks = (uint64_t)ms;
    return OST_OK;
}

static ost_status check_args(app_state *app, sim_args *args, ost_error *err)
{
    ost_status status = ream_period(app, &args->rate, &args->period_ns, err);
    if (!args->headless)
        return ost_fail(err, OST_ERR_UNAVAILABLE, "this version of osteon has no window; --headless runs without one");
    if (status == OST_OK && args->classes_text && (status = ost_density_classes_parse(args->classes_text, &args->classes, err)) != OST_OK)
        ost_fail_context(err, "--classes");
    args->ticks = 10000;
    if (status == OST_OK && args->seconds.text)
        status = ticks_of(app, "seconds", &args->seconds, &args->ticks, err);
    args->idle_ticks = args->ticks < 10000 ? args->ticks : 10000;
    if (status == OST_OK && args->idle.text)
        status = ticks_of(app, "idle", &args->idle, &args->idle_ticks, err);
    if (status != OST_OK)
        return status;
    if (args->ticks == 0)
        return usage_error(app, err, "--seconds 0 is no time at all");
    if (device_is(args, "replay")) {
        if (args->paths.count != 1)
            return usage_error(app, err, "--device replay needs one --path SESSION");
        args->session = args->paths.value[0];
    }
    /* What a session records must be what a replay reads again. */
    args->tools_given = args->tools.count > 0;
    if (!args->tools.count && !args->resume)
        args->tools = (option_list){1, {"builtin:reamer"}};
    if (!args->paths.count)
        args->paths = (option_list){1, {"builtin:glenoid-slow"}};
    if (!args->resume && args->tools.count > 1 && args->paths.count > args->tools.count)
        return usage_error(app, err, "%d paths and %d tools: give one tool for all, or a tool for each path, in the same order",
                           args->paths.count, args->tools.count);
    /* One thread serves the device; the other cores are for whoever records and looks on. */
    if (!app->threads && strcmp(app->backend, "cpu") == 0)
        app->threads = 1;
    if (args->record && (status = out_check(app, args->record, "session", err)) != OST_OK)
        return status;
    return args->out ? out_check(app, args->out, "nrrd|nii|nii.gz|txt", err) : OST_OK;
}

ost_status cmd_sim(app_state *app, int argc, char **argv, ost_error *err)
{
    sim_args args = {.device = "sim", .bone = "builtin:scapula", .ct = CT_OPTIONS_DEFAULT, .how = TOOL_OPTIONS_DEFAULT};
    target_options *t = &args.target;
    const option options[] = {
        {.name = "device", .kind = OPTION_TEXT, .out = &args.device, .value = "NAME",
         .help = "null, script, replay, sim (default), openhaptics or dhd,\nwith options as in\nsim:grip=light,seed=2,tremor=200 (micrometres)"},
        {.name = "headless", .kind = OPTION_FLAG, .out = &args.headless, .help = "without a window, which this version does not have"},
        {.name = "seconds", .kind = OPTION_DECIMAL, .out = &args.seconds, .value = "N", .help = "how long (default: 10)"},
        {.name = "idle", .kind = OPTION_DECIMAL, .out = &args.idle, .value = "N",
         .help = "seconds of a loop that does nothing, half before and half after,\nfor comparison (default: as --seconds, at most 10)"},
        {.name = "resume", .kind = OPTION_TEXT, .out = &args.resume, .value = "SESSION",
         .help = "go on with the operation of a session: its bone, tools, options"},
        {.name = "bone", .kind = OPTION_TEXT, .out = &args.bone, .given = &args.bone_given, .value = "BONE", .help = "a bone, a CT, or a built-in one (default: builtin:scapula)"},
        {.name = "tool", .kind = OPTION_LIST, .out = &args.tools, .value = "TOOL", .help = "a tool; may repeat (default: builtin:reamer)"},
        {.name = "path", .kind = OPTION_LIST, .out = &args.paths, .value = "PATH",
         .help = "where the tool or the simulated hand goes: as for osteon ream\n(default: builtin:glenoid-slow); of --device replay a session"},
        {.name = "out", .kind = OPTION_TEXT, .out = &args.out, .value = "FILE", .help = "the bone afterwards: .nrrd, or .nii, .nii.gz, .txt"},
        {.name = "record", .kind = OPTION_TEXT, .out = &args.record, .value = "SESSION", .help = "write down every tick; the name ends in .session"},
        {.name = "at", .kind = OPTION_POINT, .out = &t->at, .given = &t->at_given, .value = "X,Y,Z",
         .help = "centre of the glenoid's face, for the built-in paths\n(default: what the bone's file says)"},
        {.name = "axis", .kind = OPTION_VECTOR, .out = t->axis, .given = &t->axis_given, .value = "X,Y,Z",
         .help = "direction into the bone there (default: the file's)"},
        {.name = "side", .kind = OPTION_CHOICE, .out = &t->side, .given = &t->side_given, .value = "left|right",
         .help = "of the body (default: the file's, else right)"},
        {.name = "force", .kind = OPTION_CHOICE, .out = &args.force, .given = &args.force_given, .value = "off|energy|instant",
         .help = "what the hand feels: energy, bone gives way as it is cut;\ninstant, it is gone at once (default: energy if the device\nrenders forces)"},
        {.name = "rate", .kind = OPTION_DECIMAL, .out = &args.rate, .value = "HZ", .help = "remove so many times a second (default: every tick)"},
        {.name = "classes", .kind = OPTION_TEXT, .out = &args.classes_text, .value = "NAME:HU,...", .help = "density classes to count by, each from its HU up"},
        {.name = "no-clock", .kind = OPTION_FLAG, .out = &args.no_clock, .help = "one tick after the other, as fast as they go: the same operation"},
        {.name = "no-realtime", .kind = OPTION_FLAG, .out = &args.no_realtime, .help = "ask the system for no priority and no locked memory"},
        TOOL_OPTIONS(args.how),
        CT_OPTIONS(args.ct),
        {.name = "compress", .kind = OPTION_FLAG, .out = &args.compress, .help = "gzip a .nrrd"},
        {.name = NULL}};
    const usage_text usage = {
        .synopsis = "--headless [--device NAME] [--seconds N] [options]",
        .about = "The simulator: a device moves the tool a thousand times a second, bone goes in every\n"
                 "tick, and how punctual that was is said, beside a loop that does nothing.",
        .options = options,
        .notes = "Tool and bone as for osteon ream. The loop asks for SCHED_FIFO and locked memory and says\n"
                 "what it got. One thread works unless --threads says otherwise.",
        .example = "  osteon sim --headless --device sim --seconds 60 --record today.session\n"
                   "  osteon replay today.session --verify --backend ref\n"
                   "  osteon sim --headless --resume today.session --record tomorrow.session",
    };
    ost_status status;
    if (!options_parse(app, &usage, argc, argv, &status, err) || (status = check_args(app, &args, err)) != OST_OK)
        return status;
    simulation s = {0};
    progress_begin(app);
    if (args.resume)
        status = resume_open(app, &args, &s, err);
    if (status == OST_OK)
        status = load_all(app, &args, &s, err);
    if (status == OST_OK)
        status = force_make(app, &args, &s, err);
    if (status == OST_OK)
        status = record_begin(&args, &s, err);
    if (status == OST_OK && s.resumed)
        status = resume_run(&args, &s, err);
    if (status == OST_OK)
        status = run(app, &args, &s, err);
    if (status == OST_OK) {
        report_loop(app, &args, &s);
        status = finish(app, &args, &s, err);
    }
    simulation_free(&s);
    return status;
}
