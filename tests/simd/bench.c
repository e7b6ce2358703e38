/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Times kernels, alternating between the instruction sets. In every round each instruction set runs for
 * about ROUND_NS, so that other load on the machine affects all instruction sets equally. The output is the
 * median of the rounds and the speed relative to the scalar kernel.
 */
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "simd/check.h"

enum { ROUNDS = 25, ROUND_NS = 30000, CALLS_MAX = 20000 };

struct check_bench {
    const check_kernel *kernel;
    ost_isa only;
};

static double now_ns(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return 1e9 * (double)t.tv_sec + (double)t.tv_nsec;
}

/* Returns the time per call in ns. If `prepare` is not NULL, each call is timed separately. */
static double time_calls(check_call_fn *call, void (*prepare)(void *), check_fn *kernel, void *arguments, int calls)
{
    double sum = 0;
    if (prepare) {
        for (int i = 0; i < calls; i++) {
            prepare(arguments);
            const double begin = now_ns();
            call(kernel, arguments);
            sum += now_ns() - begin;
        }
    } else {
        const double begin = now_ns();
        for (int i = 0; i < calls; i++)
            call(kernel, arguments);
        sum = now_ns() - begin;
    }
    return sum / calls;
}

static int by_value(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static bool shown(ost_isa only, int isa)
{
    return isa == OST_ISA_SCALAR || (ost_isa_available((ost_isa)isa) && (only == OST_ISA_COUNT || isa == (int)only));
}

void bench_heading(ost_isa only)
{
    printf("ns a call, median of %d rounds by turns; (times the scalar kernel's speed)\n%-14s %-34s", ROUNDS,
           "function", "work");
    for (int isa = 0; isa < OST_ISA_COUNT; isa++)
        if (shown(only, isa))
            printf(isa == OST_ISA_SCALAR ? "  %9s" : "  %17s", ost_isa_name((ost_isa)isa));
    printf("  best\n");
}

void bench_time(check_bench *b, const char *work, check_call_fn *call, void (*prepare)(void *arguments),
                void *arguments, double items, const char *what)
{
    static double ns[OST_ISA_COUNT][ROUNDS];
    check_fn *kernel[OST_ISA_COUNT];
    int calls[OST_ISA_COUNT];
    for (int isa = 0; isa < OST_ISA_COUNT; isa++) {
        kernel[isa] = shown(b->only, isa) ? b->kernel->of((ost_isa)isa) : NULL;
        for (int lower = 0; lower < isa && kernel[isa]; lower++)
            if (kernel[lower] == kernel[isa])
                kernel[isa] = NULL;
        if (!kernel[isa])
            continue;
        time_calls(call, prepare, kernel[isa], arguments, 3);
        const double one = time_calls(call, prepare, kernel[isa], arguments, 3);
        calls[isa] = one * CALLS_MAX < ROUND_NS ? CALLS_MAX : one > ROUND_NS ? 1 : (int)(ROUND_NS / one);
    }
    for (int round = 0; round < ROUNDS; round++)
        for (int isa = 0; isa < OST_ISA_COUNT; isa++)
            if (kernel[isa])
                ns[isa][round] = time_calls(call, prepare, kernel[isa], arguments, calls[isa]);
    printf("%-14s %-34s", b->kernel->name, work);
    double best = 1e300;
    for (int isa = 0; isa < OST_ISA_COUNT; isa++) {
        if (!shown(b->only, isa))
            continue;
        if (!kernel[isa]) {
            printf("  %17s", "-");
            continue;
        }
        qsort(ns[isa], ROUNDS, sizeof ns[isa][0], by_value);
        const double median = ns[isa][ROUNDS / 2];
        best = median < best ? median : best;
        if (isa == OST_ISA_SCALAR)
            printf("  %9.1f", median);
        else
            printf("  %9.1f (%5.1f)", median, ns[OST_ISA_SCALAR][ROUNDS / 2] / median);
    }
    printf("  %.3g ns a %s\n", best / items, what);
    fflush(stdout);
}

void bench_run(const check_kernel *kernel, ost_isa only)
{
    check_bench b = {.kernel = kernel, .only = only};
    kernel->bench(&b);
    guard_reset();
}
