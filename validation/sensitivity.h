/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Measures whether the campaign would have found an error. Mistakes that a port could contain are made deliberately,
 * one at a time, at random positions and rates. The code that compares backends then compares the results.
 *
 *   small scene --reference--> trace ----------------.
 *        |------dense, correct--> trace --compare--> equal, or a false alarm
 *        '------dense, with a mistake--> trace --compare--> detected or not, and the position
 *
 * The dense backend runs every stage a second time without the mistake (dense/deviation.h). Each injection
 * therefore records whether the erroneous code was executed (triggered), and which voxel or line of a
 * report it changed first.
 *
 *   changed    the mistake changed a result that the backend returns
 *   detected   the comparison found a difference
 *   located    the comparison named the record (stage; tool or tick) and the voxel,
 *              or the chunk's line in the report, that the mistake changed first
 *   survived   the erroneous code was executed, but no result changed; the table of
 *              mistakes lists when this can happen
 *
 * The mistakes are made in validation/dense and in no backend under test, so this measurement tests the
 * comparison. Mistakes that change no result in the first pass are repeated at every position in four more
 * scenes. The report lists the mistakes that change no result in these scenes either.
 */
#ifndef OST_VALIDATION_SENSITIVITY_H
#define OST_VALIDATION_SENSITIVITY_H

#include "validation/dense/deviation.h"
#include "difference/pattern.h"
#include "validation/plan.h"

typedef struct sensitivity_counts {
    uint64_t injected, triggered, changed, detected, located, survived;
    /* Numbers of changed results that were not detected or not located. Each one is a defect of the comparison. */
    uint64_t not_detected, not_located;
} sensitivity_counts;

/* The number of difference classes: one for each pattern, one for differences only in the report, and one for all
   other differences, for which no grids are compared. */
enum { SENSITIVITY_CLASSES = PATTERNS + 2 };
const char *sensitivity_class_name(int class);

typedef struct sensitivity {
    uint64_t seed;
    sensitivity_counts all, of[DEVIATION_KINDS];
    uint64_t classes[DEVIATION_KINDS][SENSITIVITY_CLASSES];
    /* number of kinds of mistakes that changed a result, and number of those that were always detected and located */
    int kinds_changed, kinds_noticed;
    uint64_t clean_runs, false_alarms;
    /* the first mistake that was not detected or not located, or the first false alarm, with the seeds that reproduce
       it; "" if there is none */
    char first_problem[300];
} sensitivity;

/* Returns the number of injections in the first pass of a tier. In the smoke tier each mistake is made once, in every
   unit. */
uint64_t sensitivity_injections(plan_tier tier);

/* Runs all injections on `jobs` threads. The result does not depend on the number of threads. `show` may be NULL; it
   is never called by two threads at the same time. */
ost_status sensitivity_run(uint64_t seed, uint64_t injections, int jobs,
                           void (*show)(void *user, const char *what, double share), void *user, sensitivity *out,
                           ost_error *err);

#endif
