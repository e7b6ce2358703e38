/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests the servo loop with devices made for these tests: devices without samples, lost devices, late devices, and
 * devices with their own clock. No test compares times. The tests check counts, and whether the loop detects a tick
 * that is certainly too long. Covers: REQ-SERVO
 */
#include "harness.h"

#include <pthread.h>
#include <sched.h>
#include <time.h>
#include <unistd.h>

#include "haptics/driver.h"
#include "haptics/thread_time.h"

/*
 * A device that returns given answers, one letter per read. Every further read returns the answer of the
 * last letter. The letters are F (fresh), S (no sample), U (not tracked) and E (ended); any other letter
 * means lost.
 */
static struct haptic_instance {
    const char *answers;
    int reads, writes;
    ost_wrench last;
} fake;

static ost_status fake_open(const char *options, const ost_haptic_setup *setup, haptic_instance **out, ost_error *err)
{
    (void)options;
    (void)setup;
    (void)err;
    *out = &fake;
    return OST_OK;
}

static void fake_close(haptic_instance *instance)
{
    (void)instance;
}

static ost_haptic_answer fake_read(haptic_instance *f, ost_haptic_state *state)
{
    const char answer = *f->answers;
    if (f->answers[1])
        f->answers++;
    f->reads++;
    if (answer == 'F')
        *state = (ost_haptic_state){.pose = {.t = {f->reads, 0, 0}, .qw = OST_Q30_ONE}, .tool = -1, .buttons = 5};
    return answer == 'F'   ? OST_HAPTIC_FRESH
           : answer == 'S' ? OST_HAPTIC_NO_SAMPLE
           : answer == 'U' ? OST_HAPTIC_NOT_TRACKED
           : answer == 'E' ? OST_HAPTIC_ENDED
                           : OST_HAPTIC_LOST;
}

static void fake_write(haptic_instance *f, const ost_wrench *wrench)
{
    f->writes++;
    f->last = *wrench;
}

/* A device with its own thread, which calls `beat` until `beat` returns false. The function fake_run waits for the
   thread. */
typedef struct own_clock {
    haptic_beat *beat;
    void *user;
    int beats;
} own_clock;

static void *own_thread(void *user)
{
    own_clock *c = user;
    const struct timespec pause = {.tv_nsec = 100000};
    do {
        c->beats++;
        nanosleep(&pause, NULL);
    } while (c->beat(c->user));
    return NULL;
}

static int own_beats;

static ost_status fake_run(haptic_instance *instance, haptic_beat *beat, void *user, ost_error *err)
{
    (void)instance;
    (void)err;
    own_clock c = {beat, user, 0};
    pthread_t thread;
    assert_int_equal(pthread_create(&thread, NULL, own_thread, &c), 0);
    assert_int_equal(pthread_join(thread, NULL), 0);
    own_beats = c.beats;
    return OST_OK;
}

static const haptic_driver polled = {.name = "polled",
                                     .caps = OST_HAPTIC_FORCE | OST_HAPTIC_LOGICAL,
                                     .open = fake_open,
                                     .close = fake_close,
                                     .read = fake_read,
                                     .write = fake_write};
static const haptic_driver timed = {.name = "timed",
                                    .caps = OST_HAPTIC_FORCE,
                                    .open = fake_open,
                                    .close = fake_close,
                                    .read = fake_read,
                                    .write = fake_write};
static const haptic_driver own = {.name = "own",
                                  .caps = OST_HAPTIC_FORCE | OST_HAPTIC_OWN_CLOCK,
                                  .open = fake_open,
                                  .close = fake_close,
                                  .read = fake_read,
                                  .write = fake_write,
                                  .run = fake_run};

static bool never(char reason[256])
{
    snprintf(reason, 256, "its library is not here");
    return false;
}
static const haptic_driver absent = {.name = "absent", .usable = never, .open = fake_open, .close = fake_close};

typedef struct seen {
    uint64_t ticks, declared, tracking_lost, done, missed;
    uint64_t stop_at;  /* the tick at which the loop is stopped; 0 means never */
    uint64_t sleep_at; /* this tick takes 12 ms */
    uint64_t rehearsals, rehearsed; /* number of rehearsals, and number of ticks that follow a rehearsal */
    uint64_t rehearsals_before;
    ost_haptic_state last;
    int64_t t_ns;
} seen;

static bool on_tick(void *user, const ost_servo_sample *sample, ost_wrench *wrench)
{
    seen *s = user;
    assert_int_equal(sample->number, s->ticks);
    assert_int_equal(sample->t_ns, (int64_t)s->ticks * 1000000);
    assert_true(wrench->force_n[0] == 0);
    s->ticks++;
    s->declared += sample->declared;
    s->tracking_lost += sample->tracking_lost;
    s->missed += sample->missed;
    s->last = sample->state;
    wrench->force_n[0] = 2;
    s->rehearsed += s->rehearsals > s->rehearsals_before;
    s->rehearsals_before = s->rehearsals;
    if (s->ticks == s->sleep_at) {
        const struct timespec long_time = {.tv_nsec = 12000000};
        nanosleep(&long_time, NULL);
    }
    return s->ticks != s->stop_at;
}

static void on_done(void *user, uint64_t number, uint32_t exec_ns)
{
    seen *s = user;
    (void)exec_ns;
    assert_int_equal(number, s->done);
    s->done++;
    assert_true(fake.last.force_n[0] == 2); /* The wrench of this tick has been written. */
}

static ost_servo_report report;

static seen run_with(const haptic_driver *driver, const char *answers, const ost_servo_options *options, seen s)
{
    ost_error err = {0};
    ost_haptic *device;
    fake = (struct haptic_instance){.answers = answers};
    assert_ok(ost_haptic_open_driver(driver, "", NULL, &device, &err));
    assert_ok(ost_servo_run(device, options, on_tick, on_done, &s, &report, &err));
    assert_int_equal(report.ticks, s.ticks);
    assert_int_equal(s.done, s.ticks);
    assert_int_equal(report.exec.count, s.ticks);
    assert_int_equal(report.wake.count, s.ticks);
    assert_int_equal(report.completion.count, s.ticks);
    /* The last force must be zero, whatever ended the loop. */
    assert_true(fake.last.force_n[0] == 0);
    assert_int_equal(fake.writes, (int)s.ticks + 1);
    ost_haptic_close(device);
    return s;
}

static void reason_of_the_end_is_reported(void **state)
{
    (void)state;
    const ost_servo_options fast = {.no_clock = true, .no_realtime = true},
                            hundred = {.no_clock = true, .no_realtime = true, .ticks = 100};
    assert_int_equal(run_with(&polled, "F", &hundred, (seen){0}).ticks, 100);
    assert_int_equal(report.end, OST_SERVO_TICKS);
    assert_string_equal(report.realtime.scheduling, "as it was");
    assert_int_equal(run_with(&polled, "F", &fast, (seen){.stop_at = 7}).ticks, 7);
    assert_int_equal(report.end, OST_SERVO_STOPPED);
    assert_int_equal(run_with(&polled, "FFFE", &fast, (seen){0}).ticks, 3);
    assert_int_equal(report.end, OST_SERVO_DEVICE_ENDED);
    assert_int_equal(run_with(&polled, "FFL", &fast, (seen){0}).ticks, 2);
    assert_int_equal(report.end, OST_SERVO_DEVICE_LOST);
    assert_int_equal(run_with(&polled, "E", &fast, (seen){0}).ticks, 0);
}

static void missing_samples_end_the_loop(void **state)
{
    (void)state;
    alarm(60); /* The alarm ends the test if the servo loop does not end, for example without its watchdog. */
    const ost_servo_options fast = {.no_clock = true, .no_realtime = true};
    /* For up to four ticks without a sample, the last pose is used. A fifth tick in a row ends the loop. */
    seen s = run_with(&polled, "FFSSSSFSSSSFE", &fast, (seen){0});
    assert_int_equal(s.ticks, 12);
    assert_int_equal(s.declared, 8);
    assert_int_equal(s.last.buttons, 5);
    assert_int_equal(report.without_sample, 8);
    assert_int_equal(report.end, OST_SERVO_DEVICE_ENDED);
    s = run_with(&polled, "FSSSSS", &fast, (seen){0});
    assert_int_equal(s.ticks, 5);
    assert_int_equal(report.end, OST_SERVO_WATCHDOG);
    /* No tick runs before the device's first pose. */
    s = run_with(&polled, "S", &fast, (seen){0});
    assert_int_equal(s.ticks, 0);
    assert_int_equal(report.end, OST_SERVO_WATCHDOG);
    alarm(0);
}

static void lost_tracking_does_not_end_the_loop(void **state)
{
    (void)state;
    const ost_servo_options fast = {.no_clock = true, .no_realtime = true},
                            hundred = {.no_clock = true, .no_realtime = true, .ticks = 100};
    seen s = run_with(&polled, "FUUUUUUUUUUFSSSSUSSSSFE", &fast, (seen){0});
    assert_int_equal(s.ticks, 22);
    assert_int_equal(s.tracking_lost, 11);
    assert_int_equal(s.declared, 19);
    assert_int_equal(report.tracking_lost, 11);
    assert_int_equal(report.without_sample, 8);
    assert_int_equal(report.end, OST_SERVO_DEVICE_ENDED);
    /* If a device is not tracked at the start, time advances and the ticks are marked as having no pose. */
    s = run_with(&polled, "U", &hundred, (seen){0});
    assert_int_equal(s.tracking_lost, 100);
    assert_int_equal(s.last.pose.qw, 0);
    assert_int_equal(report.end, OST_SERVO_TICKS);
    s = run_with(&polled, "UUSSSSS", &fast, (seen){0});
    assert_int_equal(s.ticks, 2);
    assert_int_equal(report.end, OST_SERVO_WATCHDOG);
}

static void long_tick_counts_missed_deadlines(void **state)
{
    (void)state;
    const ost_servo_options options = {.ticks = 30, .no_realtime = true};
    const seen s = run_with(&timed, "F", &options, (seen){.sleep_at = 10});
    assert_int_equal(s.ticks, 30);
    /* The tick of 12 ms fills its own period of 1 ms and at least 11 further periods. */
    assert_true(report.longest_miss >= 11);
    assert_true(report.missed >= 12);
    assert_true(s.missed >= 11);
    assert_true(report.exec.max_ns >= 12000000);
    assert_true(report.completion.max_ns >= 12000000);
    assert_true(ost_times_share_us(&report.exec, 1) >= 12000);
    /* The tick waited without using the processor. The waiting time nevertheless counts as work of the tick. */
    assert_true(report.own.max_ns >= 12000000);
    assert_true(report.missed_by_work >= 12);
    assert_int_equal(report.missed_by_work + report.missed_woken_late + report.missed_preempted, report.missed);
}

static void missed_deadlines_are_classified(void **state)
{
    (void)state;
    const thread_time from = {.wall_ns = 5000, .cpu_ns = 700, .waits = 3},
                      taken = {.wall_ns = 9000, .cpu_ns = 800, .waits = 3},
                      waited = {.wall_ns = 9000, .cpu_ns = 800, .waits = 4},
                      coarse = {.wall_ns = 9000, .cpu_ns = 9700, .waits = 3};
    assert_int_equal(thread_time_between(&from, &taken), 100);
    assert_int_equal(thread_time_between(&from, &waited), 4000);
    /* A processor time above the wall time is possible, because the times come from different clocks. */
    assert_int_equal(thread_time_between(&from, &coarse), 4000);
    assert_int_equal(classify_missed_deadline(501, 0, 1000), MISSED_BY_WORK);
    /* If the cause is uncertain, the miss is attributed to the tick's work. */
    assert_int_equal(classify_missed_deadline(501, 5000, 1000), MISSED_BY_WORK);
    assert_int_equal(classify_missed_deadline(500, 1000, 1000), MISSED_WOKEN_LATE);
    assert_int_equal(classify_missed_deadline(500, 999, 1000), MISSED_PREEMPTED);
}

/* Tests the measurement of a thread's processor time and waiting time on this machine. */
static void thread_time_is_measured(void **state)
{
    (void)state;
    const thread_time begin = thread_time_now();
    thread_time now = begin;
    while (now.cpu_ns - begin.cpu_ns < 2000000 || now.wall_ns - begin.wall_ns < 2000000)
        now = thread_time_now();
    assert_true(thread_time_between(&begin, &now) >= 2000000);
    assert_true(now.wall_ns - begin.wall_ns >= thread_time_between(&begin, &now));
    const struct timespec pause = {.tv_nsec = 3000000};
    nanosleep(&pause, NULL);
    const thread_time later = thread_time_now();
    assert_true(thread_time_between(&now, &later) >= 3000000);
}

static void device_with_its_own_clock(void **state)
{
    (void)state;
    const ost_servo_options options = {.ticks = 50, .no_realtime = true};
    seen s = run_with(&own, "F", &options, (seen){0});
    assert_int_equal(s.ticks, 50);
    assert_int_equal(own_beats, 50);
    assert_int_equal(report.end, OST_SERVO_TICKS);
    s = run_with(&own, "FFL", &options, (seen){0});
    assert_int_equal(s.ticks, 2);
    assert_int_equal(report.end, OST_SERVO_DEVICE_LOST);
}

static void on_rehearsal(void *user)
{
    ((seen *)user)->rehearsals++;
}

/*
 * A loop that waits for the clock must rehearse at least once before every tick. If the device's
 * own thread runs the ticks, there must be no rehearsal.
 */
static void every_tick_is_rehearsed(void **state)
{
    (void)state;
    const ost_servo_options options = {.ticks = 20, .no_realtime = true, .lead_ns = 250000, .rehearse = on_rehearsal};
    seen s = run_with(&timed, "F", &options, (seen){0});
    assert_int_equal(s.rehearsed, 20);
    assert_int_equal(report.lead_ns, 250000);
    s = run_with(&own, "F", &options, (seen){0});
    assert_int_equal(s.rehearsals, 0);
    assert_int_equal(report.lead_ns, 0);
    const ost_servo_options at_once = {.ticks = 20,
                                       .no_realtime = true,
                                       .no_clock = true,
                                       .lead_ns = 250000,
                                       .rehearse = on_rehearsal},
                            never = {.ticks = 20, .no_realtime = true, .rehearse = on_rehearsal},
                            nothing = {.ticks = 20, .no_realtime = true, .lead_ns = 250000};
    assert_int_equal(run_with(&polled, "F", &at_once, (seen){0}).rehearsals, 0);
    assert_int_equal(run_with(&timed, "F", &never, (seen){0}).rehearsals, 0);
    assert_int_equal(run_with(&timed, "F", &nothing, (seen){0}).ticks, 20);
    assert_int_equal(report.lead_ns, 0);
}

static void invalid_options_are_refused(void **state)
{
    (void)state;
    ost_error err = {0};
    ost_haptic *device;
    seen s = {0};
    assert_int_equal(ost_haptic_open_driver(&absent, "", NULL, &device, &err), OST_ERR_UNAVAILABLE);
    assert_string_equal(err.text, "device absent: its library is not here");
    fake = (struct haptic_instance){.answers = "F"};
    assert_ok(ost_haptic_open_driver(&timed, "", NULL, &device, &err));
    assert_int_equal(ost_servo_run(device, &(ost_servo_options){.no_clock = true}, on_tick, NULL, &s, &report, &err),
                     OST_ERR_USAGE);
    assert_int_equal(ost_servo_run(device, &(ost_servo_options){.period_ns = 9999}, on_tick, NULL, &s, &report, &err),
                     OST_ERR_USAGE);
    assert_int_equal(ost_servo_run(device, &(ost_servo_options){.lead_ns = 500001}, on_tick, NULL, &s, &report, &err),
                     OST_ERR_USAGE);
    assert_int_equal(ost_servo_run(device, &(ost_servo_options){.lead_ns = -1}, on_tick, NULL, &s, &report, &err),
                     OST_ERR_USAGE);
    assert_int_equal(s.ticks, 0);
    ost_haptic_close(device);
}

/* All settings that the loop changed are restored. */
static void thread_settings_are_restored(void **state)
{
    (void)state;
    const int policy = sched_getscheduler(0);
    const ost_servo_options options = {.ticks = 3};
    run_with(&timed, "F", &options, (seen){0});
    assert_int_equal(sched_getscheduler(0), policy);
    assert_true(report.realtime.scheduling[0] && report.realtime.memory[0]);
    printf("# %s; memory %s\n", report.realtime.scheduling, report.realtime.memory);
}

typedef struct placed {
    int core;   /* core of the loop */
    int away;   /* number of ticks that ran on another core */
    bool apart; /* true if a thread that is created after ost_servo_core_leave may not run on the core of the loop */
} placed;

static void *find_allowed_cores(void *user)
{
    placed *p = user;
    cpu_set_t set;
    p->apart = sched_getaffinity(0, sizeof set, &set) == 0 && !CPU_ISSET(p->core, &set);
    return NULL;
}

static bool on_placed_tick(void *user, const ost_servo_sample *sample, ost_wrench *wrench)
{
    placed *p = user;
    (void)sample;
    (void)wrench;
    p->away += sched_getcpu() != p->core;
    return true;
}

/*
 * The loop runs on its own core. Threads that are created after ost_servo_core_leave must not run on this core. The
 * thread that ran the loop must not run on it after the loop, either.
 */
static void loop_has_its_own_core(void **state)
{
    (void)state;
    ost_error err = {0};
    cpu_set_t before, set;
    ost_haptic *device;
    pthread_t thread;
    placed p = {.core = ost_servo_core()};
    if (p.core < 0)
        skip();
    assert_int_equal(sched_getaffinity(0, sizeof before, &before), 0);
    assert_true(CPU_ISSET(p.core, &before));
    assert_true(ost_servo_core_leave(p.core));
    assert_int_equal(pthread_create(&thread, NULL, find_allowed_cores, &p), 0);
    pthread_join(thread, NULL);
    assert_true(p.apart);
    fake = (struct haptic_instance){.answers = "F"};
    assert_ok(ost_haptic_open_driver(&polled, "", NULL, &device, &err));
    const ost_servo_options options = {
        .ticks = 20, .no_clock = true, .no_realtime = true, .pinned = true, .core = p.core};
    assert_ok(ost_servo_run(device, &options, on_placed_tick, NULL, &p, &report, &err));
    assert_int_equal(p.away, 0);
    assert_int_equal(sched_getaffinity(0, sizeof set, &set), 0);
    assert_false(CPU_ISSET(p.core, &set));
    printf("# on %s\n", report.realtime.core);
    /* The loop also runs if the requested core does not exist. */
    const ost_servo_options elsewhere = {
        .ticks = 2, .no_clock = true, .no_realtime = true, .pinned = true, .core = CPU_SETSIZE};
    assert_ok(ost_servo_run(device, &elsewhere, on_placed_tick, NULL, &p, &report, &err));
    assert_non_null(strstr(report.realtime.core, "any, not core"));
    assert_false(ost_servo_core_leave(-1));
    ost_haptic_close(device);
    assert_int_equal(sched_setaffinity(0, sizeof before, &before), 0);
    /* If there is only one core, it is not reserved. */
    CPU_ZERO(&set);
    CPU_SET(p.core, &set);
    assert_int_equal(sched_setaffinity(0, sizeof set, &set), 0);
    assert_int_equal(ost_servo_core(), -1);
    assert_false(ost_servo_core_leave(p.core));
    assert_int_equal(sched_setaffinity(0, sizeof before, &before), 0);
}

static void quantiles_of_recorded_times(void **state)
{
    (void)state;
    static ost_times t;
    memset(&t, 0, sizeof t);
    assert_true(ost_times_share_us(&t, 0.5) == 0);
    for (uint64_t us = 1; us <= 1000; us++)
        ost_times_add(&t, us * 1000 - 1);
    assert_true(ost_times_share_us(&t, 0.5) == 500);
    assert_true(ost_times_share_us(&t, 0.99) == 990);
    assert_true(ost_times_share_us(&t, 0.999) == 999);
    assert_true(ost_times_share_us(&t, 1) == 999.999);
    ost_times_add(&t, UINT64_C(17500000));
    assert_true(ost_times_share_us(&t, 1) == 17500);
    ost_times_add(&t, UINT64_C(99000000000)); /* beyond the last bin */
    assert_true(ost_times_share_us(&t, 1) <= 99000000);
    assert_int_equal(t.count, 1002);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(reason_of_the_end_is_reported),
        cmocka_unit_test(missing_samples_end_the_loop),
        cmocka_unit_test(lost_tracking_does_not_end_the_loop),
        cmocka_unit_test(long_tick_counts_missed_deadlines),
        cmocka_unit_test(missed_deadlines_are_classified),
        cmocka_unit_test(thread_time_is_measured),
        cmocka_unit_test(device_with_its_own_clock),
        cmocka_unit_test(every_tick_is_rehearsed),
        cmocka_unit_test(invalid_options_are_refused),
        cmocka_unit_test(thread_settings_are_restored),
        cmocka_unit_test(loop_has_its_own_core),
        cmocka_unit_test(quantiles_of_recorded_times),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
