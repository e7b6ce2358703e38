/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The subjects of a campaign: the reference, and every way in which this
 * machine can run the other backends, as strings that ost_backend_open takes.
 *
 *   cpu   each instruction set that is here, with 1 thread and with 2, 3 and 7
 *         that share the smallest work (grain=1; smoke: one of the three, all
 *         of them among the sets); the best set with 3 threads and the
 *         thresholds of every day; the voxelizer by Embree where it was built in
 *   cl    each device that is not refused, with both sets of kernels, and with
 *         large data in parts (smoke: the set for GPUs in parts, the other not)
 *   plugin:FILE.so   a plugin, if it is named; opened in a process of its own
 *                    first, as its code may do anything
 *   dump:DIR         the dump of another program, if it is named
 *
 * Subjects that cannot run are listed with the reason: a report must name what
 * it does not cover.
 */
#ifndef OST_VALIDATION_SUBJECTS_H
#define OST_VALIDATION_SUBJECTS_H

#include <osteon/backend.h>

#include "validation/plan.h"

#define SUBJECT_DENSE "dense" /* the second implementation, with steps of its own (dense/steps.h) */
#define SUBJECT_DUMP "dump:" /* and a folder of grids that were made elsewhere (dump.h) */
enum { SUBJECT_SPEC = 512, SUBJECT_REASON = 320 };
typedef struct subject {
    char spec[SUBJECT_SPEC];
    char what[SUBJECT_REASON]; /* description: device and driver, instruction set */
    char device[64];           /* OpenCL device as ost_backend_devices lists it, however it was chosen; "" if none */
    bool available;
    char reason[SUBJECT_REASON]; /* if not available */
} subject;

typedef struct subject_list {
    int count;
    subject *subjects; /* owned; the reference first */
    bool opencl;       /* at least one OpenCL device is among them */
    char no_opencl[SUBJECT_REASON]; /* the reason if there is none */
} subject_list;

/* wanted: NULL for all of the tier, or "cpu:isa=avx2;cl:device=0": specs with semicolons between, or "cpu", "cl" for all of theirs. */
ost_status subjects_find(plan_tier tier, const char *wanted, subject_list *out, ost_error *err);
void subjects_free(subject_list *list);

/* Returns the name of an instruction set of the backend cpu; NULL after the last. */
const char *subjects_isa(int isa);
/* Adds the backends cpu of a processor that has the instruction sets `here`, as subjects_find lists them. */
ost_status subjects_cpu(plan_tier tier, const bool here[], subject_list *list, ost_error *err);
/* The options of the n-th backend of each usable OpenCL device in a tier, behind the device's name and a comma; NULL behind the last. */
const char *subjects_cl_options(plan_tier tier, int n);

#endif
