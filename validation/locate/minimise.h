/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Reduces a case that shows a difference to fewer ticks, tools, samples and triangles, and to a part of the
 * bone. A reduction is accepted only if the same backend still has a difference of the same class in the
 * same stage.
 *
 *   case, difference --candidates--> worker on the backend, reference here --same stage and class?--> keep --> ...
 *
 * The method is delta debugging with many candidates per process, because opening a
 * device takes longer than running a small case. The number of processes and the
 * time of each process are limited. If no process exceeds its time limit, no decision
 * depends on a clock, and two runs give the same small case. The result is small, but
 * not the smallest possible.
 */
#ifndef OST_VALIDATION_MINIMISE_H
#define OST_VALIDATION_MINIMISE_H

#include "validation/locate/case_file.h"
#include "validation/locate/finding.h"

typedef struct minimised {
    scene_cut cut;
    compare_difference difference; /* the difference that the minimised case shows */
    finding found;
    uint64_t samples, triangles, ticks; /* number of samples, triangles and ticks of the minimised case */
    ost_dims rect;
    int tools;
    int runs;   /* number of workers that the minimisation has run */
} minimised;

/* Minimises a case. `program` is the path of this program's file, which workers run. Temporary files are written to
   `folder` and removed afterwards. *out is valid only if *done is true. */
ost_status minimise(const plan_case *c, const char *spec, const compare_difference *d, const finding *f,
                    const char *program, const char *folder, minimised *out, bool *done, ost_error *err);

/* Describes the contents of the small case in a string such as "1 tick, 1 tool of 12 triangles, 8 samples in 2 x 2 x 2
   voxels". */
const char *minimised_text(const minimised *m, char text[MINIMISED_TEXT]);

#endif
