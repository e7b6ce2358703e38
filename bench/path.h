/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The path of a reaming tool. In each tick the tool advances 20 um into the bone along its own axis,
 * and rotates about this axis by less than half a degree. Therefore the sweep of every tick has one
 * pose (AR-SWEEP-3), and every tick removes voxels.
 */
#ifndef OST_BENCH_PATH_H
#define OST_BENCH_PATH_H

#include "bench/scene.h"

enum { PATH_TICKS = 2000, PATH_TICKS_QUICK = 100 };

/* Creates `count` ticks of 1 ms for tool 0. The tool's working face points toward -z in the tool's coordinates. The
   caller frees *out with free. */
ost_status bench_path_make(const bench_scene *scene, int count, ost_tick **out, ost_error *err);

/* The times of repeated runs of a sequence of ticks. `means` contains the mean tick time of each run, and `ticks`
   contains the times of all ticks. best[i] is the minimum time of tick i over all runs. */
typedef struct bench_sequence {
    bench_series means, ticks;
    double *best;  /* owned; count elements */
    int count;
} bench_sequence;

ost_status bench_sequence_init(bench_sequence *sequence, int count, ost_error *err);
void bench_sequence_add(bench_sequence *sequence, const double *ns);
/* Stores these figures in the row: the mean time of a tick; p50, p99 and maximum of all times; mean, p99 and maximum of
   the times in `best`, which exclude interruptions by other processes. */
void bench_sequence_row(bench_sequence *sequence, bench_row *row);
void bench_sequence_free(bench_sequence *sequence);

/* bench_removal_sequence measures only the removal events of the path, and bench_tick_sequence measures the complete
   ticks. Both functions are defined in suite_sequence.c. */
ost_status bench_removal_sequence(const bench_options *options, bench_table *table, ost_error *err);
ost_status bench_tick_sequence(const bench_options *options, bench_table *table, ost_error *err);

#endif
