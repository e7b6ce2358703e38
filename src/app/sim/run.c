/* SPDX-License-Identifier: Apache-2.0 */
#include "app/sim/sim.h"

#include <stdlib.h>
#include <string.h>

#include "app/common/interrupt.h"
#include "app/common/print.h"
#include "app/sim/headset.h"
#include "app/sim/window.h"
#include "app/sim/watch.h"

/*
 * The default time by which a rehearsal precedes its tick. The time is sufficient, because the computations of a tick
 * with the reamer take 60 us at the median and 150 us at the 99.9th percentile (docs/log/0.1.md).
 */
enum { REHEARSE_US = 250 };

void sim_pin(const sim_args *args, simulation *s)
{
    s->core = args->no_pin || args->no_clock ? -1 : ost_servo_core();
    if (s->core >= 0 && !ost_servo_core_leave(s->core))
        s->core = -1;
}

/*
 * Runs a tick. Returns false at the end of the operation or after a signal, so that the loop ends in an orderly way and
 * the recording is complete.
 */
static bool tick(void *operation, const ost_servo_sample *sample, ost_wrench *wrench)
{
    return ost_operation_tick(operation, sample, wrench) && !interrupt_requested();
}

/*
 * Returns the time in ns by which a rehearsal precedes its tick, or 0 for no rehearsal. By default, rehearsals are off
 * on an OpenCL device, where a rehearsal would cost one more launch. They are also off on a shared core, where a
 * rehearsal would take time from other threads.
 */
static int64_t lead_ns(const sim_args *args, const simulation *s)
{
    const bool pays = s->core >= 0 && strncmp(ost_backend_name(s->backend), "cpu", 3) == 0;
    return 1000 * (args->rehearse_given ? args->rehearse_us : pays ? REHEARSE_US : 0);
}

/* Runs the servo loop, and a second thread that reports progress. A signal requests the end of the loop. */
static ost_status run_loop(const app_state *app, const sim_args *args, const ost_servo_options *how, simulation *s,
                           ost_error *err)
{
    sim_watch *watch;
    const double seconds = args->no_clock || !how->ticks ? 0 : (double)how->ticks * 1e-3;
    ost_status status = sim_watch_begin(app, s->recorder, args->record, SIM_RECORDER_CAPACITY, seconds, &watch, err);
    if (status != OST_OK)
        return status;
    if (s->headset)
        status = sim_headset_start(s, err);
    else if (s->show && !s->window)
        status = sim_show_begin(s->show, err);
    if (status != OST_OK) {
        sim_watch_end(watch);
        return status;
    }
    interrupt_begin();
    status = s->window ? sim_window_run(s, how, tick, err)
                       : ost_servo_run(s->device, how, tick, ost_operation_done, s->operation, s->loop, err);
    interrupt_end();
    if (s->headset)
        sim_headset_stop(s);
    if (s->show) {
        const ost_status shown = sim_show_end(s->show, status == OST_OK ? err : NULL);
        status = status == OST_OK ? shown : status;
    }
    sim_watch_end(watch);
    return status;
}

ost_status sim_run(const app_state *app, const sim_args *args, simulation *s, ost_error *err)
{
    s->loop = malloc(sizeof *s->loop);
    if (!s->loop)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for the times of a run");
    ost_operation_options what = {
        .recorder = s->recorder,
        .force = s->force,
        .live = s->show ? s->show->live : NULL,
        .safety = &args->safety,
        .tool = s->resumed ? s->last.tool : 0,
        .tools = args->tools.count,
        .rpm = (int32_t)args->rpm,
        .motor_waits = args->motor_waits,
        .motor = s->motor,
        .home = s->home,
        .steps_before = s->before,
        .last = s->resumed ? &s->last : NULL,
        .depth_of = s->show ? sim_scene_depth : NULL,
        .depth_user = s->show ? &s->show->scene : NULL,
    };
    memcpy(what.buttons, args->buttons, sizeof what.buttons);
    ost_status status = ost_operation_create(s->world, &what, &s->operation, err);
    if (status != OST_OK)
        return status;
    const ost_servo_options how = {
        .ticks = args->ticks,
        .no_clock = args->no_clock,
        .no_realtime = args->no_realtime || args->no_clock,
        .pinned = s->core >= 0,
        .core = s->core,
        .lead_ns = lead_ns(args, s),
        .rehearse = ost_operation_rehearse,
    };
    if (!app->json && !app->quiet && !args->no_clock && args->ticks)
        print_line(app, "device %s moves %s in %s for %.4g s", args->device, args->tools.value[0], args->bone,
                   (double)args->ticks * 1e-3);
    char about[OST_HAPTIC_TEXT];
    if (!app->quiet && ost_haptic_about(s->device, about)[0])
        print_line_to(stderr, "osteon sim: device %s %s", ost_haptic_name(s->device), about);
    status = run_loop(app, args, &how, s, err);
    ost_operation_report_get(s->operation, &s->done);
    if (status == OST_OK && s->done.status != OST_OK)
        status = ost_fail(err, s->done.status, "tick %llu: %.500s", (unsigned long long)s->loop->ticks,
                          s->done.error.text);
    return status == OST_OK ? ost_backend_finish(s->backend, err) : status;
}
