/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The subjects of a campaign: the reference, and every configuration in which this machine can run the
 * other backends. A configuration is a string that ost_backend_open accepts.
 *
 *   cpu   each available instruction set, with 1 thread and with 2, 3 and 7
 *         threads that divide even the smallest amount of work (grain=1); the best set with
 *         3 threads and the default thresholds; the voxelizer with Embree, if Embree
 *         was compiled in. In the smoke tier each set runs with 1 thread and one of
 *         the counts 2, 3 and 7, and the last set also with the missing counts
 *   cl    each device that is not refused, with both kernel sets, each with the
 *         data undivided and with large data in parts. In the smoke tier the kernel set
 *         for GPUs runs only with data in parts, and the other set only with undivided data
 *   plugin:FILE.so   a plugin, if the user names it; it is first opened in a
 *                    separate process, because its code may crash or change the process
 *   dump:DIR         the dump of another program, if the user names it
 *
 * Subjects that cannot run are listed with the reason, because a report must
 * name what it does not cover.
 */
#ifndef OST_VALIDATION_SUBJECTS_H
#define OST_VALIDATION_SUBJECTS_H

#include <osteon/backend.h>

#include "validation/plan.h"

#define SUBJECT_DENSE "dense" /* name of the second implementation, which also computes the steps (dense/steps.h) */
#define SUBJECT_DUMP "dump:" /* prefix of a subject that is a folder of grids from another program (dump.h) */
enum { SUBJECT_SPEC = 512, SUBJECT_REASON = 320 };
typedef struct subject {
    char spec[SUBJECT_SPEC];
    char what[SUBJECT_REASON]; /* device, driver and instruction set, for reports */
    /* OpenCL device as listed by ost_backend_devices, independent of the spec that selected it; "" if there is none */
    char device[64];
    bool available;
    char reason[SUBJECT_REASON]; /* why the subject cannot run here; "" if it can */
} subject;

typedef struct subject_list {
    int count;
    subject *subjects; /* owned; the reference comes first */
    bool opencl;       /* true if an OpenCL device is available */
    char no_opencl[SUBJECT_REASON]; /* why no OpenCL device is available */
} subject_list;

/* Finds the subjects. `wanted` is a list of specs separated by semicolons, as in "cpu:isa=avx2;cl:device=0", or NULL
   for all subjects of the tier. The specs "cpu" and "cl" alone select all subjects of that backend. */
ost_status subjects_find(plan_tier tier, const char *wanted, subject_list *out, ost_error *err);
void subjects_free(subject_list *list);

/* Returns the name of instruction set number `isa` of the cpu backend, or NULL after the last one. */
const char *subjects_isa(int isa);
/* Adds the subjects of the cpu backend for a processor with the instruction sets `here`, in the order of
   subjects_find. */
ost_status subjects_cpu(plan_tier tier, const bool here[], subject_list *list, ost_error *err);
/* Returns the options of the n-th subject that a tier runs on each usable OpenCL device, or NULL after the last one.
   The spec of a subject consists of the device's name, a comma and these options. */
const char *subjects_cl_options(plan_tier tier, int n);

#endif
