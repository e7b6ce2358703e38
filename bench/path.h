/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The path of a reaming tool: it enters the bone along its own axis at 20 um per tick and turns
 * about it by less than half a degree per tick, so that every tick is one pose (AR-SWEEP-3) and
 * removes voxels.
 */
#ifndef OST_BENCH_PATH_H
#define OST_BENCH_PATH_H

#include "bench/scene.h"

enum { PATH_TICKS = 2000, PATH_TICKS_QUICK = 100 };

/* Makes ticks of 1 ms for tool 0. The tool's working face points toward -z of its own frame. *out
   must be freed by free. */
ost_status bench_path_make(const bench_scene *scene, int count, ost_tick **out, ost_error *err);

/* Times of a repeated sequence: `means` contains the mean of each repetition, `ticks` the times
   of all ticks, and `best` the minimum of each tick over all repetitions. */
typedef struct bench_sequence {
    bench_series means, ticks;
    double *best;  /* owned; count elements */
    int count;
} bench_sequence;

ost_status bench_sequence_init(bench_sequence *sequence, int count, ost_error *err);
void bench_sequence_add(bench_sequence *sequence, const double *ns);
/* Stores the mean, p50, p99 and maximum, both of all ticks and of the minima of the ticks, which
   contain no interruptions. */
void bench_sequence_row(bench_sequence *sequence, bench_row *row);
void bench_sequence_free(bench_sequence *sequence);

/* The two rows of suite_sequence.c. */
ost_status bench_removal_sequence(const bench_options *options, bench_table *table, ost_error *err);
ost_status bench_tick_sequence(const bench_options *options, bench_table *table, ost_error *err);

#endif
