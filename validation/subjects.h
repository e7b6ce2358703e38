/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Who is compared: the reference, and every way this machine can run the
 * others, as strings that ost_backend_open takes.
 *
 *   cpu   each instruction set that is here, with 1 thread and with 2, 3 and 7
 *         that share the smallest work (grain=1; smoke: one of the three, all
 *         of them among the sets); the best set with 3 threads and the
 *         thresholds of every day; the voxelizer by Embree where it was built in
 *   cl    each device that is not refused, with both sets of kernels, and with
 *         large data in parts (smoke: the set for GPUs in parts, the other not)
 *   plugin:FILE.so   somebody else's, when it is named; tried in a process of
 *                    its own first, as its code may do anything
 *   dump:DIR         what another program dumped, when it is named
 *
 * What cannot run is listed too, with its reason: a report must say what it
 * did not show.
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
    char what[SUBJECT_REASON]; /* for people: device and driver, instruction set */
    char device[64];           /* of OpenCL, as ost_backend_devices lists it, whatever words chose it; "": none */
    bool available;
    char reason[SUBJECT_REASON]; /* when not */
} subject;

typedef struct subject_list {
    int count;
    subject *subjects; /* owned; the reference first */
    bool opencl;       /* at least one OpenCL device is among them */
    char no_opencl[SUBJECT_REASON]; /* why not */
} subject_list;

/* wanted: NULL for all of the tier, or "cpu:isa=avx2;cl:device=0": specs with semicolons between, or "cpu", "cl" for all of theirs. */
ost_status subjects_find(plan_tier tier, const char *wanted, subject_list *out, ost_error *err);
void subjects_free(subject_list *list);

/* The instruction sets of the backend cpu; NULL behind the last. */
const char *subjects_isa(int isa);
/* Adds the backends cpu of a processor that has the instruction sets `here`, as subjects_find lists them. */
ost_status subjects_cpu(plan_tier tier, const bool here[], subject_list *list, ost_error *err);
/* The options of the n-th backend of each usable OpenCL device in a tier, behind the device's name and a comma; NULL behind the last. */
const char *subjects_cl_options(plan_tier tier, int n);

#endif
