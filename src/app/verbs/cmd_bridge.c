/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Implements `osteon bridge`: the remote end of `osteon sim --device udp`.
 *
 *   device <-- ost_servo_run, here --> ost_bridge_run <--packets--> osteon sim, on the other machine
 */
#include <stdlib.h>
#include <string.h>

#include "app/common/interrupt.h"
#include "app/input/load.h"
#include "app/common/options.h"
#include "app/common/result.h"
#include "app/common/print.h"
#include "haptics/bridge.h"

typedef struct bridge_args {
    const char *to, *key, *device, *path;
    option_decimal seconds;
    bool no_realtime;
} bridge_args;

/* Reads a path from a CSV table of ticks or from a session. */
static ost_status path_of(const app_state *app, const char *name, ost_path *out, ost_error *err)
{
    ost_file_kind kind;
    const bool known = ost_file_kind_find(name, &kind, NULL) == OST_OK;
    return known && kind == OST_FILE_SESSION ? load_session_path(app, name, out, err)
                                             : ost_path_read_csv(name, out, err);
}

static void put_times(const app_state *app, const char *key, const char *what, const ost_times *times)
{
    const double p50 = ost_times_share_us(times, 0.5), p99 = ost_times_share_us(times, 0.99),
                 max = (double)times->max_ns * 1e-3;
    put(app->result, key,
        json_pack("{s:f,s:f,s:f,s:I}", "p50", p50, "p99", p99, "max", max, "count", (json_int_t)times->count));
    if (times->count)
        print_line(app, "  %-22s %8.0f %8.0f %10.0f us", what, p50, p99, max);
}

static const char *end_text(const bridge_report *r)
{
    switch (r->loop.end) {
    case OST_SERVO_TICKS: return "the time was over";
    case OST_SERVO_STOPPED: return r->ended ? "the simulation is over" : "it was interrupted";
    case OST_SERVO_DEVICE_ENDED: return "the device has no further poses";
    case OST_SERVO_DEVICE_LOST: return "the device was lost";
    case OST_SERVO_WATCHDOG: return "the device delivered no sample for 5 ticks";
    }
    return "unknown";
}

static void report(const app_state *app, const bridge_args *args, const bridge_report *r)
{
    json_t *o = app->result;
    char a[FORMAT_TEXT], b[FORMAT_TEXT], c[FORMAT_TEXT];
    put_text(o, "device", args->device);
    put_text(o, "to", r->to);
    put_text(o, "end", end_text(r));
    put_integer(o, "ticks", (int64_t)r->loop.ticks);
    put_integer(o, "missed", (int64_t)r->loop.missed);
    put_integer(o, "sent", (int64_t)r->sent);
    put_integer(o, "states", (int64_t)r->states);
    put_integer(o, "bad", (int64_t)r->bad);
    put_integer(o, "late", (int64_t)r->late);
    put_integer(o, "replayed", (int64_t)r->replayed);
    put_integer(o, "limps", (int64_t)r->limps);
    put_real(o, "limp_s", (double)r->limp_ticks * 1e-3);
    put_integer(o, "unseen", (int64_t)r->loop.tracking_lost);
    put_integer(o, "fault_ticks", (int64_t)r->fault_ticks);
    put_real(o, "peak_force_n", r->peak_n);
    print_line(app, "%s ticks of %s with %s: %s", format_count(a, (int64_t)r->loop.ticks), args->device, r->to,
               end_text(r));
    print_line(app, "  %-22s %8s %8s %10s", "", "median", "99 %", "max");
    put_times(app, "wake_us", "late by", &r->loop.wake);
    put_times(app, "exec_us", "a tick takes", &r->loop.exec);
    put_times(app, "round_trip_us", "there and back", &r->round_trip);
    print_line(app, "  %s packets sent, %s states received; %s of them invalid, %llu late, %llu duplicate",
               format_count(a, (int64_t)r->sent), format_count(b,
               (int64_t)(r->states + r->bad + r->late + r->replayed)), format_count(c, (int64_t)r->bad),
               (unsigned long long)r->late, (unsigned long long)r->replayed);
    print_line(app, "  force: %.2f N at most; switched off %llu time%s, %.3f s in all", r->peak_n,
               (unsigned long long)r->limps, r->limps == 1 ? "" : "s", (double)r->limp_ticks * 1e-3);
}

static ost_status run(app_state *app, const bridge_args *args, uint64_t ticks, ost_error *err)
{
    ost_path path = {0};
    ost_haptic *device = NULL;
    bridge_report *r = malloc(sizeof *r);
    if (!r)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for the times of a run");
    const bool replay = strcmp(args->device, "replay") == 0;
    ost_status status = args->path && !replay ? path_of(app, args->path, &path, err) : OST_OK;
    const ost_haptic_setup setup = {.path = &path, .session = replay ? args->path : NULL, .start = ost_pose_identity()};
    if (status == OST_OK)
        status = ost_haptic_open(args->device, &setup, &device, err);
    if (status == OST_OK) {
        const bridge_options options = {.to = args->to,
                                        .key = args->key,
                                        .ticks = ticks,
                                        .no_realtime = args->no_realtime,
                                        .stop_requested = interrupt_requested};
        interrupt_begin();
        status = ost_bridge_run(device, &options, r, err);
        interrupt_end();
    }
    if (status == OST_OK)
        report(app, args, r);
    if (status == OST_OK && (r->loop.end == OST_SERVO_DEVICE_LOST || r->loop.end == OST_SERVO_WATCHDOG)) {
        app->answered = true;
        status = ost_fail(err, OST_ERR_UNAVAILABLE, "device %s: %s after %llu ticks", args->device, end_text(r),
                          (unsigned long long)r->loop.ticks);
    }
    ost_haptic_close(device);
    ost_path_free(&path);
    free(r);
    return status;
}

ost_status cmd_bridge(app_state *app, int argc, char **argv, ost_error *err)
{
    bridge_args args = {.device = "sim"};
    const option options[] = {
        {.name = "to", .kind = OPTION_TEXT, .out = &args.to, .value = "HOST:PORT", .required = true,
         .help = "address at which osteon sim --device udp receives"},
        {.name = "key", .kind = OPTION_TEXT, .out = &args.key, .value = "FILE", .required = true,
         .help = "file with the key that the simulation uses"},
        {.name = "device", .kind = OPTION_TEXT, .out = &args.device, .value = "NAME",
         .help = "device of this machine, as for osteon sim (default: sim)"},
        {.name = "path", .kind = OPTION_TEXT, .out = &args.path, .value = "PATH",
         .help = "path of the hand for the devices sim and script, a .csv or a session; only its motion is used: "
                 "the tool is where the simulation has it"},
        {.name = "seconds", .kind = OPTION_DECIMAL, .out = &args.seconds, .value = "N",
         .help = "duration (default: until the program is interrupted or the device ends)"},
        {.name = "no-realtime", .kind = OPTION_FLAG, .out = &args.no_realtime,
         .help = "request neither real-time priority nor locked memory"},
        {.name = NULL}};
    const usage_text usage = {
        .synopsis = "--to HOST:PORT --key FILE --device NAME [options]",
        .about = "Connects a device of this machine to a simulation on another machine. The force is\n"
                 "computed on this machine, from the latest plane that the simulation sent. A slow\n"
                 "link therefore delays the force but never makes it unstable. If the link fails, the\n"
                 "force becomes zero.",
        .options = options,
        .notes = "The key is a file of at least 16 bytes that only its owner may read, the same on\n"
                 "both machines. Packets are authenticated with the key, but not encrypted.",
        .example = "  (umask 077; head -c 32 /dev/urandom >osteon.key)\n"
                   "  osteon sim --headless --device udp:bind=0.0.0.0,key=osteon.key --seconds 600\n"
                   "  osteon bridge --to simulator:4707 --key osteon.key --device openhaptics",
    };
    ost_status status;
    int64_t ms = 0;
    if (!options_parse(app, &usage, argc, argv, &status, err))
        return status;
    if (args.seconds.text &&
        (!ost_decimal_scale(&args.seconds.value, 1000, &ms, NULL) || ms < 1 || ms > INT64_C(86400000)))
        return usage_error(app, err, "--seconds %s: must be from 0.001 to 86400", args.seconds.text);
    static const char *const shown[] = {"mouse", "openxr"};
    for (size_t i = 0; i < sizeof shown / sizeof shown[0]; i++)
        if (spec_is(args.device, shown[i]))
            return usage_error(app, err, "--device %s: works only in osteon sim", shown[i]);
    if (args.path && strncmp(args.path, "builtin:", 8) == 0)
        return usage_error(app, err, "--path %s: built-in paths need osteon sim; expected a .csv or a session",
                           args.path);
    return run(app, &args, (uint64_t)ms, err);
}
