/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Makes a case that shows a difference small: fewer ticks, tools, samples,
 * triangles, a part of the bone, as long as the same backend still differs in
 * the same stage with a difference of the same class.
 *
 *   case, difference --candidates--> worker on the backend, reference here --same stage and class?--> keep --> ...
 *
 * The method is delta debugging with many candidates per process, since a device
 * takes longer to open than a small case to run.  The number of processes and the
 * time of each are limited.  No decision depends on a clock, so two runs give the
 * same small case.  The result is small, but not the smallest possible.
 */
#ifndef OST_VALIDATION_MINIMISE_H
#define OST_VALIDATION_MINIMISE_H

#include "validation/locate/case_file.h"
#include "validation/locate/finding.h"

typedef struct minimised {
    scene_cut cut;
    compare_difference difference; /* the difference of the small case */
    finding found;
    uint64_t samples, triangles, ticks; /* numbers in the small case */
    ost_dims rect;
    int tools;
    int runs;   /* number of processes that were started */
} minimised;

/* Minimises a case. program: this program's file, for workers; folder: a folder for temporary files, which are removed.
   *out is valid only if *done is true. */
ost_status minimise(const plan_case *c, const char *spec, const compare_difference *d, const finding *f,
                    const char *program, const char *folder, minimised *out, bool *done, ost_error *err);

/* Writes the contents as text: "1 tick, 1 tool of 12 triangles, 8 samples in 2 x 2 x 2 voxels". */
const char *minimised_text(const minimised *m, char text[MINIMISED_TEXT]);

#endif
