/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The thesis' removal as it was: an OpenCL kernel over the voxels of a chunk,
 * enqueued for chunk after chunk (Alg. 2.10), on the device that backend cl
 * is opened on.  And what a launch alone costs there: an empty kernel,
 * enqueued and waited for.
 */
#ifndef OST_BENCH_THESIS_CL_H
#define OST_BENCH_THESIS_CL_H

#include "bench/scene.h"

typedef struct bench_cl bench_cl;

/*
 * The device that backend names by numbers ("cl:platform=0,device=1"; what is
 * left out, and another backend, mean 0).  NULL without one, with the reason.
 */
bench_cl *bench_cl_open(const char *backend, char reason[BENCH_TEXT]);
void bench_cl_close(bench_cl *cl); /* NULL is allowed */
/* How backend cl is told to open the same one. */
const char *bench_cl_spec(const bench_cl *cl);
const char *bench_cl_name(const bench_cl *cl);

/* The event's chunks and tool on the device; false when the device refuses. */
bool bench_cl_take(bench_cl *cl, const bench_thesis *thesis);
bool bench_cl_restore(bench_cl *cl, const bench_thesis *thesis);
bool bench_cl_remove(bench_cl *cl, const bench_thesis *thesis);
/* The chunks as they are there, into the thesis' own. */
bool bench_cl_fetch(bench_cl *cl, bench_thesis *thesis);

/* An empty kernel of one work group of one item, waited for. */
bool bench_cl_launch(bench_cl *cl);

/* suite_removal.c: the static events on options->backend, which is on cl's device. */
ost_status bench_removal_opencl(const bench_options *options, bench_table *table, bench_cl *cl, ost_error *err);

#endif
