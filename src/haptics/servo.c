/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Runs the servo loop.
 *
 *   due 0      due 1      due 2      due 3      due 4
 *    |--wake--[read, tick, write]--| . . .      |         every tick in time
 *    |--wake--[read, tick,   write]-----|       |         done after 1 was due:
 *                  missed:   tick 0, 1 skipped  ^ next    two deadlines missed
 *
 *   due 1 - lead: the loop wakes, rehearses, and waits without sleep until due 1
 *
 *   wake        time from the moment when a tick is due until it begins
 *   exec        time from the beginning of the tick until the wrench is written
 *   own         the part of exec that the tick itself used (thread_time.h)
 *   completion  time from the moment when the tick is due until the wrench is
 *               written; if it exceeds a period, a deadline is missed
 *
 * Due times are absolute: a late tick does not postpone later ticks. The world's clock counts the
 * ticks that were executed.
 *
 * `osteon bench --suite servo` measures the same loop with a tick that does nothing. The result
 * shows which deadlines are missed because of the machine alone.
 */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "core/clock.h"
#include "core/file.h"
#include "haptics/driver.h"
#include "haptics/thread_time.h"
#include "haptics/realtime.h"

enum { PERIOD_NS = 1000000 };

typedef struct servo {
    ost_haptic *device;
    ost_servo_options options;
    ost_servo_tick *tick;
    ost_servo_done *done;
    void *user;
    ost_servo_report *report;
    ost_servo_sample sample;
    int64_t due, wake_ns;
    /* `ready` is the time at the end of the sleep before a tick, and `begin` the time at the beginning of the tick */
    thread_time ready, begin;
    bool has_pose;
    int ticks_without_sample; /* number of consecutive ticks without a new pose */
} servo;

static void sleep_until(int64_t ns)
{
    const struct timespec t = {.tv_sec = ns / 1000000000, .tv_nsec = ns % 1000000000};
    while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &t, NULL) == EINTR)
        ;
}

static uint32_t ns32(int64_t ns)
{
    return ns < 0 ? 0 : ns < UINT32_MAX ? (uint32_t)ns : UINT32_MAX;
}

/* Returns the number of further ticks that became due before a tick ended. These ticks are skipped. */
static int64_t skipped_after(int64_t due, int64_t end, int64_t period)
{
    return end > due ? (end - due) / period : 0;
}

static bool end_with(servo *s, ost_servo_end end)
{
    s->report->end = end;
    return false;
}

/* Reads the device's state into the sample. Returns false if the loop must end. */
static bool take_pose(servo *s)
{
    switch (ost_haptic_read(s->device, &s->sample.state)) {
    case OST_HAPTIC_FRESH:
        s->has_pose = true;
        s->ticks_without_sample = 0;
        s->sample.declared = s->sample.tracking_lost = false;
        return true;
    case OST_HAPTIC_NO_SAMPLE:
        s->report->without_sample++;
        s->sample.declared = true;
        s->sample.tracking_lost = false;
        return ++s->ticks_without_sample < OST_SERVO_WATCHDOG_TICKS || end_with(s, OST_SERVO_WATCHDOG);
    case OST_HAPTIC_NOT_TRACKED:
        s->report->tracking_lost++;
        s->ticks_without_sample = 0;
        s->sample.declared = s->sample.tracking_lost = true;
        return true;
    case OST_HAPTIC_ENDED:
        return end_with(s, OST_SERVO_DEVICE_ENDED);
    case OST_HAPTIC_LOST:
        break;
    }
    return end_with(s, OST_SERVO_DEVICE_LOST);
}

/* Runs the tick that was due at s->due. Returns false if the loop must end. */
static bool run_loop(servo *s)
{
    ost_wrench wrench = {{0}, {0}};
    s->begin = thread_time_now();
    if (s->options.lead_ns == 0)
        s->ready = s->begin;
    s->wake_ns = s->begin.wall_ns - s->due;
    s->sample.wake_ns = ns32(s->wake_ns);
    if (!take_pose(s))
        return false;
    /* No tick runs before the device returns its first pose. The watchdog limits the time without a pose. */
    if (!s->has_pose && !s->sample.tracking_lost)
        return true;
    const bool more = s->tick(s->user, &s->sample, &wrench);
    ost_haptic_write(s->device, &wrench);
    const thread_time end = thread_time_now();
    const int64_t exec = end.wall_ns - s->begin.wall_ns;
    if (s->done)
        s->done(s->user, s->sample.number, ns32(exec));
    ost_servo_report *r = s->report;
    r->ticks++;
    ost_times_add(&r->wake, s->wake_ns > 0 ? (uint64_t)s->wake_ns : 0);
    ost_times_add(&r->exec, (uint64_t)exec);
    ost_times_add(&r->own, (uint64_t)thread_time_between(&s->begin, &end));
    ost_times_add(&r->completion, end.wall_ns > s->due ? (uint64_t)(end.wall_ns - s->due) : 0);
    s->sample.number++;
    s->sample.t_ns += s->options.period_ns;
    if (!more)
        return end_with(s, OST_SERVO_STOPPED);
    return !s->options.ticks || r->ticks < s->options.ticks || end_with(s, OST_SERVO_TICKS);
}

/*
 * Classifies the missed deadlines of a tick. The time since s->ready includes the rehearsals and the wait before the
 * tick, which may take lead_ns. Therefore lead_ns is subtracted from this time.
 */
static void count_missed(servo *s, uint64_t missed)
{
    const thread_time now = thread_time_now();
    ost_servo_report *r = s->report;
    const int64_t own = thread_time_between(&s->ready, &now) - s->options.lead_ns;
    switch (classify_missed_deadline(own, s->wake_ns, s->options.period_ns)) {
    case MISSED_BY_WORK: r->missed_by_work += missed; break;
    case MISSED_WOKEN_LATE: r->missed_woken_late += missed; break;
    case MISSED_PREEMPTED: r->missed_preempted += missed; break;
    }
    r->missed += missed;
}

/* Counts the missed deadlines of the tick that was due at s->due and has just been executed. Then advances s->due to
   the next tick. */
static void go_on(servo *s)
{
    const int64_t skipped = skipped_after(s->due, ost_clock_ns(), s->options.period_ns);
    ost_servo_report *r = s->report;
    if (skipped > 0)
        count_missed(s, (uint64_t)skipped + 1);
    r->longest_miss = (uint64_t)skipped > r->longest_miss ? (uint64_t)skipped : r->longest_miss;
    s->sample.missed = ns32(skipped);
    s->due += s->options.period_ns * (skipped + 1);
}

/*
 * After most of a period without work, caches contain less of the tick's data, wide registers are
 * powered down, and a sleeping core has to wake up. Together these effects cost about as much time
 * as the tick's work itself. Therefore the loop wakes lead_ns before the tick is due. It runs as
 * many rehearsals as fit into this time and then waits without sleep.
 */
static void get_ready(servo *s)
{
    const ost_servo_options *o = &s->options;
    sleep_until(s->due - o->lead_ns);
    if (o->lead_ns == 0)
        return;
    s->ready = thread_time_now();
    int64_t before, now = s->ready.wall_ns;
    do {
        o->rehearse(s->user);
        before = now;
        now = ost_clock_ns();
    } while (now + (now - before) < s->due);
    while (ost_clock_ns() < s->due)
        ;
}

static void run_clock(servo *s)
{
    s->due = ost_clock_ns() + s->options.period_ns;
    for (;;) {
        get_ready(s);
        if (!run_loop(s))
            break;
        go_on(s);
    }
}

static void run_without_clock(servo *s)
{
    do
        s->due = ost_clock_ns();
    while (run_loop(s));
}

/*
 * Called on the thread of a device with its own clock. The device determines when a tick runs. The delay of a tick is
 * measured with ost_clock_ns.
 */
static bool beat(void *user)
{
    servo *s = user;
    const int64_t begin = ost_clock_ns();
    if (s->due == 0)
        s->due = begin;
    if (!run_loop(s))
        return false;
    /* If a device runs early, the schedule is reset: the device's next tick is due one period after this tick. */
    if (begin < s->due)
        s->due = begin;
    go_on(s);
    return true;
}

/*
 * Returns the time in ms that the hypervisor has taken from all cores since boot. Returns -1 if the system does not
 * report this time.
 */
static int64_t stolen_ms(void)
{
    long long field[8];
    FILE *file;
    (void)ost_file_stream("/proc/stat", &file, NULL, NULL);
    char line[512];
    if (!file)
        return -1;
    int count = 0;
    if (fgets(line, sizeof line, file) && strncmp(line, "cpu ", 4) == 0) {
        const char *p = line + 4;
        for (; count < 8; count++) {
            p += strspn(p, " ");
            if (*p < '0' || *p > '9')
                break;
            for (field[count] = 0; *p >= '0' && *p <= '9'; p++)
                field[count] = field[count] * 10 + (*p - '0');
        }
    }
    fclose(file);
    return count == 8 ? field[7] * 10 : -1; /* the unit of the field is a hundredth of a second */
}

ost_status ost_servo_run(ost_haptic *device, const ost_servo_options *options, ost_servo_tick *tick,
                         ost_servo_done *done, void *user, ost_servo_report *report, ost_error *err)
{
    servo s = {.device = device, .tick = tick, .done = done, .user = user, .report = report};
    const haptic_driver *driver = device->driver;
    if (options)
        s.options = *options;
    memset(report, 0, sizeof *report);
    if (s.options.period_ns == 0)
        s.options.period_ns = PERIOD_NS;
    if (s.options.period_ns < 10000 || s.options.period_ns > INT64_C(1000000000))
        return ost_fail(err, OST_ERR_USAGE, "a period of %lld ns; expected 10,000 to 1,000,000,000",
                        (long long)s.options.period_ns);
    if (s.options.lead_ns < 0 || s.options.lead_ns > s.options.period_ns / 2)
        return ost_fail(err, OST_ERR_USAGE, "a rehearsal %lld ns before a tick; expected 0 to half a period",
                        (long long)s.options.lead_ns);
    if (s.options.no_clock && !(driver->caps & OST_HAPTIC_LOGICAL))
        return ost_fail(err, OST_ERR_USAGE, "device %s runs in real time: it needs the clock", driver->name);

    const bool rehearses = s.options.rehearse && !s.options.no_clock && !(driver->caps & OST_HAPTIC_OWN_CLOCK);
    report->lead_ns = s.options.lead_ns = rehearses ? s.options.lead_ns : 0;

    realtime_before before;
    ost_realtime_enter(!s.options.no_realtime, s.options.pinned ? s.options.core : -1, &before, &report->realtime);
    const int64_t stolen = stolen_ms();
    ost_status status = OST_OK;
    if (driver->caps & OST_HAPTIC_OWN_CLOCK)
        status = driver->run(device->instance, beat, &s, err);
    else if (s.options.no_clock)
        run_without_clock(&s);
    else
        run_clock(&s);
    /* When the loop has ended for any reason, the device must render no force. */
    const ost_wrench nothing = {{0}, {0}};
    ost_haptic_write(device, &nothing);
    const int64_t after = stolen_ms();
    report->stolen_ms = stolen < 0 || after < 0 ? -1 : after - stolen;
    ost_realtime_leave(&before);
    return status;
}
