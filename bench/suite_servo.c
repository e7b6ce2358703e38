/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Measures the servo loop without an operation. The result shows how many deadlines are missed because of the machine.
 *
 *   servo/empty   a tick does nothing
 *   servo/spin    a tick reads the clock for SPIN_US, about as long as a tick of an operation takes
 *
 * Both are measured, because a hypervisor interrupts a busy core more than an idle one. The rows contain
 * the delay from the planned to the actual beginning of a tick. The rows have no baseline: the deadlines
 * that `osteon sim` misses are compared with the results of this suite.
 */
#include "bench/bench.h"

#include <osteon/haptics.h>
#include <stdio.h>
#include <stdlib.h>

enum { TICKS = 5000, QUICK_TICKS = 50, SPIN_US = 100 };

typedef struct loop {
    bench_series delay;
    int64_t spin_ns;
} loop;

static bool tick(void *user, const ost_servo_sample *sample, ost_wrench *wrench)
{
    loop *l = user;
    (void)wrench;
    const int64_t begin = bench_now();
    bench_series_add(&l->delay, sample->wake_ns);
    while (bench_now() - begin < l->spin_ns)
        ;
    return true;
}

static ost_status run(const bench_options *options, int64_t spin_us, bench_row *row, ost_error *err)
{
    loop l = {.spin_ns = spin_us * 1000};
    ost_haptic *device = NULL;
    ost_servo_report *report = malloc(sizeof *report);
    ost_status status = report ? ost_haptic_open("null", NULL, &device, err)
                               : ost_fail(err, OST_ERR_MEMORY, "out of memory for the times of a servo loop");
    if (status == OST_OK) {
        const int core = ost_servo_core();
        const ost_servo_options how = {.ticks = options->quick ? QUICK_TICKS : (uint64_t)bench_repeat(options, TICKS),
                                       .pinned = core >= 0,
                                       .core = core};
        status = ost_servo_run(device, &how, tick, NULL, &l, report, err);
    }
    if (status == OST_OK) {
        row->equal = true;
        bench_row_ours(row, &l.delay);
        snprintf(row->baseline_reason, BENCH_TEXT, "a servo loop has no baseline");
        bench_row_extra(row, "p99_us", bench_series_at(&l.delay, 0.99) * 1e-3);
        bench_row_extra(row, "p99_9_us", bench_series_at(&l.delay, 0.999) * 1e-3);
        bench_row_extra(row, "ticks", (double)report->ticks);
        bench_row_extra(row, "missed", (double)report->missed);
        bench_row_extra(row, "longest_miss", (double)report->longest_miss);
        bench_row_extra(row, "stolen_ms", (double)report->stolen_ms);
    }
    ost_haptic_close(device);
    bench_series_free(&l.delay);
    free(report);
    return status;
}

ost_status bench_servo(const bench_options *options, bench_table *table, ost_error *err)
{
    static const struct {
        const char *name;
        int64_t spin_us;
    } rows[] = {{"servo/empty", 0}, {"servo/spin", SPIN_US}};
    ost_status status = OST_OK;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0] && status == OST_OK; i++) {
        if (!bench_wanted(options, rows[i].name))
            continue;
        bench_row *row = bench_row_add(table, rows[i].name, "us", 1);
        status = row ? run(options, rows[i].spin_us, row, err)
                     : ost_fail(err, OST_ERR_MEMORY, "out of memory for a row");
    }
    return status;
}
