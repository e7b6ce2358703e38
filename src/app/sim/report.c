/* SPDX-License-Identifier: Apache-2.0 */
#include "app/sim/sim.h"

#include <stdio.h>
#include <string.h>

#include "app/common/interrupt.h"
#include "app/common/result.h"
#include "app/common/print.h"
#include "app/common/progress.h"

static void put_times(const app_state *app, bool stats, const char *key, const char *what, const ost_times *times)
{
    const double p50 = ost_times_share_us(times, 0.5), p99 = ost_times_share_us(times, 0.99),
                 p999 = ost_times_share_us(times, 0.999);
    const double max = (double)times->max_ns * 1e-3;
    put(app->result, key,
        json_pack("{s:f,s:f,s:f,s:f,s:I}", "p50", p50, "p99", p99, "p99_9", p999, "max", max, "count",
                  (json_int_t)times->count));
    if (stats && times->count)
        print_line(app, "  %-30s %8.0f %8.0f %8.0f %10.0f us", what, p50, p99, p999, max);
}

static const char *end_text(ost_servo_end end)
{
    switch (end) {
    case OST_SERVO_TICKS: return "the time was over";
    case OST_SERVO_STOPPED: return interrupt_requested() ? "it was interrupted" : "the operation failed";
    case OST_SERVO_DEVICE_ENDED: return "the device has no further poses";
    case OST_SERVO_DEVICE_LOST: return "the device was lost";
    case OST_SERVO_WATCHDOG: return "the device delivered no sample for 5 ticks";
    }
    return "unknown";
}

/* Reports the device's counters, such as good and bad packets. */
static void report_counts(const app_state *app, bool stats, const simulation *s)
{
    ost_haptic_tally counts[OST_HAPTIC_COUNTS];
    const int count = ost_haptic_counts(s->device, counts);
    char text[320] = "", name[40], number[FORMAT_TEXT];
    if (count == 0)
        return;
    json_t *o = json_object();
    for (int i = 0; i < count; i++) {
        put_integer(o, counts[i].name, (int64_t)counts[i].value);
        snprintf(name, sizeof name, "%s", counts[i].name);
        for (char *p = name; (p = strchr(p, '_'));)
            *p = ' ';
        const size_t used = strlen(text);
        if (counts[i].value)
            snprintf(text + used, sizeof text - used, "%s%s %s", used ? ", " : "", name,
                     format_count(number, (int64_t)counts[i].value));
    }
    put(app->result, "device_counts", o);
    if (stats)
        print_line(app, "  counters of device %s: %s", ost_haptic_name(s->device), text[0] ? text : "all are 0");
}

static void report_times(const app_state *app, const sim_args *args, const simulation *s)
{
    const ost_servo_report *r = s->loop;
    const bool stats = args->stats;
    if (stats)
        print_line(app, "  %-30s %8s %8s %8s %10s", "", "median", "99 %", "99.9 %", "max");
    put_times(app, stats, "wake_us", "delay of a tick's begin", &r->wake);
    put_times(app, stats, "exec_us", "duration of a tick", &r->exec);
    put_times(app, stats, "own_us", "thread CPU time of a tick", &r->own);
    put_times(app, stats, "completion_us", "end of a tick, from its due time", &r->completion);
    if (!stats || args->no_clock)
        return;
    print_line(app, "  scheduling: %s; memory: %s; servo loop: %s%s", r->realtime.scheduling, r->realtime.memory,
               r->realtime.core, s->core >= 0 ? ", other threads on the other cores" : " core");
    if (r->lead_ns)
        print_line(app, "  each tick is rehearsed %lld us before it is due", (long long)r->lead_ns / 1000);
    if (r->stolen_ms > 0)
        print_line(app, "  the hypervisor took %lld ms from all cores together", (long long)r->stolen_ms);
}

static void report_force(const app_state *app, const sim_args *args, const simulation *s)
{
    json_t *o = app->result;
    put_text(o, "force", sim_force_names[args->force]);
    if (!s->force)
        return;
    char from[SIM_LIMIT_TEXT];
    sim_force_limit_text(args, from);
    put_real(o, "peak_force_n", s->done.peak_n);
    put_real(o, "peak_axial_n", s->done.peak_axial_n);
    put_real(o, "cutting_j", s->done.energy_j);
    put_real(o, "max_force_n", args->safety.max_force_n);
    put_real(o, "max_torque_nm", args->safety.max_torque_nm);
    put_text(o, "max_force_from", args->max_force_from);
    if (args->limits.force_n > 0)
        put_real(o, "device_force_n", args->limits.force_n);
    if (args->limits.continuous_n > 0)
        put_real(o, "device_continuous_n", args->limits.continuous_n);
    put_integer(o, "contact_ticks", (int64_t)s->done.touching_ticks);
    put_integer(o, "damped_ticks", (int64_t)s->done.damped_ticks);
    if (!args->stats)
        return;
    print_line(app,
               "  hand force: %.2f N at most; contact force: %.0f N at most; %.1f J of cutting in %.1f s of contact",
               s->done.peak_n, s->done.peak_axial_n, s->done.energy_j, (double)s->done.touching_ticks * 1e-3);
    print_line(app, "  limit of the hand force: %g N (%s)", args->safety.max_force_n, from);
}

static void report_tracking(const app_state *app, const simulation *s)
{
    json_t *o = app->result;
    put_integer(o, "gaps", (int64_t)s->gaps.gaps);
    put_integer(o, "dropouts", (int64_t)s->done.dropouts);
    put_real(o, "dropout_s", (double)s->done.dropout_ticks * 1e-3);
    put_real(o, "longest_dropout_s", (double)s->done.longest_dropout * 1e-3);
    if (s->done.dropouts)
        print_line(app,
                   "  the device lost tracking %llu time%s, %.3f s in all, at most %.3f s; the tool remained in place",
                   (unsigned long long)s->done.dropouts, s->done.dropouts == 1 ? "" : "s",
                   (double)s->done.dropout_ticks * 1e-3, (double)s->done.longest_dropout * 1e-3);
}

void sim_report_loop(const app_state *app, const sim_args *args, const simulation *s)
{
    const ost_servo_report *r = s->loop;
    char a[FORMAT_TEXT], b[FORMAT_TEXT];
    json_t *o = app->result;
    put_text(o, "device", args->device);
    if (s->resumed) {
        put_text(o, "resumed", args->resume);
        put_integer(o, "ticks_before", (int64_t)s->before);
        print_line(app, "%s: %s recorded ticks were executed again before this operation", args->resume,
                   format_count(a, (int64_t)s->before));
    }
    put_text(o, "end", end_text(r->end));
    put_integer(o, "ticks", (int64_t)r->ticks);
    put_integer(o, "missed", (int64_t)r->missed);
    put_integer(o, "missed_by_work", (int64_t)r->missed_by_work);
    put_integer(o, "missed_woken_late", (int64_t)r->missed_woken_late);
    put_integer(o, "missed_preempted", (int64_t)r->missed_preempted);
    put_integer(o, "rehearsed_us", r->lead_ns / 1000);
    put_integer(o, "longest_miss", (int64_t)r->longest_miss);
    put_integer(o, "ticks_without_sample", (int64_t)r->without_sample);
    put_integer(o, "stolen_ms", r->stolen_ms);
    put_integer(o, "faults", (int64_t)s->done.faults);
    put_integer(o, "fault_ticks", (int64_t)s->done.fault_ticks);
    put_text(o, "scheduling", r->realtime.scheduling);
    put_text(o, "memory", r->realtime.memory);
    put_text(o, "core", r->realtime.core);
    print_line(app, "%s ticks; %s", format_count(a, (int64_t)r->ticks), end_text(r->end));
    if (!args->no_clock && r->missed)
        print_line(app, "  deadlines missed: %s in %s ticks: %llu woken late, %llu preempted, %llu by the work of a "
                   "tick",
                   format_count(a, (int64_t)r->missed), format_count(b, (int64_t)r->ticks),
                   (unsigned long long)r->missed_woken_late, (unsigned long long)r->missed_preempted,
                   (unsigned long long)r->missed_by_work);
    else if (!args->no_clock)
        print_line(app, "  deadlines missed: 0 in %s ticks", format_count(a, (int64_t)r->ticks));
    report_times(app, args, s);
    report_force(app, args, s);
    report_tracking(app, s);
    report_counts(app, args->stats, s);
    if (s->done.faults)
        warn(app, "%s reported %llu fault%s, which affected %llu tick%s; the last fault: %s", args->device,
             (unsigned long long)s->done.faults, s->done.faults == 1 ? "" : "s",
             (unsigned long long)s->done.fault_ticks, s->done.fault_ticks == 1 ? "" : "s",
             ost_fault_text(s->done.last_fault));
}

ost_status sim_device_end(app_state *app, const sim_args *args, const simulation *s, ost_error *err)
{
    char a[FORMAT_TEXT];
    if (s->loop->end != OST_SERVO_DEVICE_LOST && s->loop->end != OST_SERVO_WATCHDOG)
        return OST_OK;
    app->answered = true;
    return ost_fail(err, OST_ERR_UNAVAILABLE, "device %s: %s after %s ticks, before the end of the operation%s%s%s",
                    ost_haptic_name(s->device), end_text(s->loop->end), format_count(a, (int64_t)s->loop->ticks),
                    args->record ? "; the ticks before are in " : "", args->record ? args->record : "",
                    args->record ? ", which --resume continues" : "");
}

/* Makes the debrief. Motion and forces are read from the recording, which is complete at this time. */
static ost_status debrief_make(const app_state *app, const sim_args *args, simulation *s, ost_error *err)
{
    ost_session *session;
    ost_status status = ost_session_open(args->record, &session, err);
    if (status != OST_OK)
        return status;
    status = debrief_session(&s->debrief, session, UINT64_MAX, err);
    ost_session_close(session);
    if (status == OST_OK)
        status = debrief_end(app, &s->debrief, s->bone, ost_world_classes(s->world), args->record, args->debrief, err);
    return status;
}

ost_status sim_finish(const app_state *app, const sim_args *args, simulation *s, ost_error *err)
{
    ost_world_totals totals;
    ost_digest root, file;
    char a[FORMAT_TEXT], hex[OST_DIGEST_HEX];
    json_t *o = app->result;
    ost_world_totals_get(s->world, &totals);
    ost_status status = ost_bone_digest(s->bone, NULL, &root, err);
    if (status != OST_OK)
        return status;
    put_integer(o, "removals", (int64_t)totals.removals);
    put_integer(o, "removed_voxels", (int64_t)totals.removed_voxels);
    put_digest(o, "sha256", &root);
    const double voxel = ost_pm_to_mm(s->imported.cubic.spacing.x);
    print_line(app, "  bone removed: %s voxels, %.1f mm3; grid %s", format_count(a, (int64_t)totals.removed_voxels),
               (double)totals.removed_voxels * voxel * voxel * voxel, ost_digest_hex(&root, hex));
    if ((status = start_check_end(&s->site, s->bone, err)) != OST_OK)
        return status;
    start_check_report(app, &s->site, voxel * voxel * voxel);
    if (args->out) {
        const ost_write_options write = {.compress = args->compress, .progress = progress_show};
        status = ost_bone_write(args->out, s->bone, &s->imported.meta, &write, err);
        if (status == OST_OK && (status = file_digest(args->out, &file, err)) == OST_OK) {
            put_text(o, "out", args->out);
            put_digest(o, "file_sha256", &file);
            print_line(app, "  written to %s", args->out);
        }
    }
    if (status == OST_OK && s->recorder) {
        const ost_session_end end = {.ticks = totals.ticks,
                                     .removals = totals.removals,
                                     .removed_voxels = totals.removed_voxels,
                                     .has_root = true,
                                     .root = root};
        ost_recorder *recorder = s->recorder;
        s->recorder = NULL;
        status = ost_recorder_close(recorder, &end, err);
        if (status == OST_OK) {
            put_text(o, "session", args->record);
            print_line(app, "  recorded in %s", args->record);
        }
    }
    return status == OST_OK && args->debrief ? debrief_make(app, args, s, err) : status;
}
