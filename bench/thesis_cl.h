/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The thesis' removal in its original form (Alg. 2.10): an OpenCL kernel processes the voxels of one
 * chunk, and is enqueued for one chunk after the other. The kernel runs on the device on which the
 * backend cl is opened. An empty kernel, for which the host waits, shows the cost of a launch alone.
 */
#ifndef OST_BENCH_THESIS_CL_H
#define OST_BENCH_THESIS_CL_H

#include "bench/scene.h"

typedef struct bench_cl bench_cl;

/*
 * Opens the device whose platform and device numbers are in the string `backend`, such as "cl:platform=0,device=1". A
 * missing number is 0. If the string names a backend other than cl, both numbers are 0. Returns NULL and the reason if
 * the device does not exist or cannot be opened.
 */
bench_cl *bench_cl_open(const char *backend, char reason[BENCH_TEXT]);
void bench_cl_close(bench_cl *cl); /* cl may be NULL */
/* Returns the options string with which the backend cl opens the same device. */
const char *bench_cl_spec(const bench_cl *cl);
const char *bench_cl_name(const bench_cl *cl);

/* Copies the event's chunks and tool to the device. Returns false if the device fails. */
bool bench_cl_take(bench_cl *cl, const bench_thesis *thesis);
bool bench_cl_restore(bench_cl *cl, const bench_thesis *thesis);
bool bench_cl_remove(bench_cl *cl, const bench_thesis *thesis);
/* Copies the chunks from the device to the host's chunks in `thesis`. */
bool bench_cl_fetch(bench_cl *cl, bench_thesis *thesis);

/* Runs an empty kernel with a single work item, and waits for its end. */
bool bench_cl_launch(bench_cl *cl);

/* Adds rows that measure the static removal events on the backend options->backend. This backend must
   use the same device as `cl`. Defined in suite_removal.c. */
ost_status bench_removal_opencl(const bench_options *options, bench_table *table, bench_cl *cl, ost_error *err);

#endif
