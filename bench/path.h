/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A tool at work: it enters the bone along its own axis, 20 um a tick, and
 * turns by less than half a degree a tick about it, so that every tick is one
 * pose (AR-SWEEP-3) and every one removes something.
 */
#ifndef OST_BENCH_PATH_H
#define OST_BENCH_PATH_H

#include "bench/scene.h"

enum { PATH_TICKS = 2000, PATH_TICKS_QUICK = 100 };

/* Ticks of 1 ms with tool 0; the tool's working face is toward -z of its own frame. Free with free. */
ost_status bench_path_make(const bench_scene *scene, int count, ost_tick **out, ost_error *err);

/* Mean of each repetition into means, every tick into ticks, and per tick the least of all repetitions into best. */
typedef struct bench_sequence {
    bench_series means, ticks;
    double *best;  /* owned, count of them */
    int count;
} bench_sequence;

ost_status bench_sequence_init(bench_sequence *sequence, int count, ost_error *err);
void bench_sequence_add(bench_sequence *sequence, const double *ns);
/* Mean, with p50, p99 and max beside it: of all ticks, and of the least times a tick took (that is, without interruptions). */
void bench_sequence_row(bench_sequence *sequence, bench_row *row);
void bench_sequence_free(bench_sequence *sequence);

/* The two rows of suite_sequence.c. */
ost_status bench_removal_sequence(const bench_options *options, bench_table *table, ost_error *err);
ost_status bench_tick_sequence(const bench_options *options, bench_table *table, ost_error *err);

#endif
