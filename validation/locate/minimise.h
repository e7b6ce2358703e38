/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A case that shows a difference, made small: fewer ticks, tools, samples,
 * triangles, a part of the bone, as long as the same backend still differs in
 * the same stage and the difference still looks the same.
 *
 *   case, difference --candidates--> worker on the backend, reference here --same stage and class?--> keep --> ...
 *
 * Delta debugging, with many candidates to a process since a device takes
 * longer to open than a small case to run.  The number of processes is
 * bounded, and so is each one's time; without a clock in its decisions two
 * runs give the same small case.  What is left is small, not the smallest.
 */
#ifndef OST_VALIDATION_MINIMISE_H
#define OST_VALIDATION_MINIMISE_H

#include "validation/locate/case_file.h"
#include "validation/locate/finding.h"

typedef struct minimised {
    scene_cut cut;
    compare_difference difference; /* of what is left */
    finding found;
    uint64_t samples, triangles, ticks; /* left */
    ost_dims rect;
    int tools;
    int runs;   /* processes */
} minimised;

/* program: to start workers with; folder: for files, which are removed.  *out is of use where *done. */
ost_status minimise(const plan_case *c, const char *spec, const compare_difference *d, const finding *f, const char *program, const char *folder, minimised *out,
                    bool *done, ost_error *err);

/* "1 tick, 1 tool of 12 triangles, 8 samples in 2 x 2 x 2 voxels" */
const char *minimised_text(const minimised *m, char text[MINIMISED_TEXT]);

#endif
