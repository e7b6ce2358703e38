/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The thesis' removal in its original form: an OpenCL kernel over the voxels of a chunk, enqueued
 * for one chunk after the other (Alg. 2.10), on the device on which the backend cl is opened. Also
 * measures the cost of a launch alone: an empty kernel, enqueued and waited for.
 */
#ifndef OST_BENCH_THESIS_CL_H
#define OST_BENCH_THESIS_CL_H

#include "bench/scene.h"

typedef struct bench_cl bench_cl;

/*
 * Opens the device that `backend` selects by numbers ("cl:platform=0,device=1"; an omitted
 * number, or another backend, means 0). Returns NULL with the reason if there is none.
 */
bench_cl *bench_cl_open(const char *backend, char reason[BENCH_TEXT]);
void bench_cl_close(bench_cl *cl); /* cl may be NULL */
/* Returns the string by which the backend cl opens the same device. */
const char *bench_cl_spec(const bench_cl *cl);
const char *bench_cl_name(const bench_cl *cl);

/* Copies the event's chunks and tool to the device. Returns false if the device fails. */
bool bench_cl_take(bench_cl *cl, const bench_thesis *thesis);
bool bench_cl_restore(bench_cl *cl, const bench_thesis *thesis);
bool bench_cl_remove(bench_cl *cl, const bench_thesis *thesis);
/* Copies the chunks on the device into those of thesis. */
bool bench_cl_fetch(bench_cl *cl, bench_thesis *thesis);

/* Runs an empty kernel of one work group with one work item, and waits for it. */
bool bench_cl_launch(bench_cl *cl);

/* suite_removal.c: adds the static events on options->backend, which must be on cl's device. */
ost_status bench_removal_opencl(const bench_options *options, bench_table *table, bench_cl *cl, ost_error *err);

#endif
