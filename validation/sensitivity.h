/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Would the campaign have noticed?  Mistakes that a port can make are made on
 * purpose, one at a time, at random places and rates, and compared by the same
 * code that compares backends.
 *
 *   small scene --reference--> trace ----------------.
 *        |------dense, right--> trace --compare--> equal, or a false alarm
 *        '------dense, with a mistake--> trace --compare--> found, where
 *
 * Of each injection is known whether the mistake was made at all (triggered),
 * and which voxel or line of a report it changed first, since the dense
 * backend runs every stage a second time without it (dense/deviation.h).
 *
 *   changed    something that a backend hands out became another
 *   detected   the comparison found a difference
 *   located    it named the record (stage; tool or tick) and the voxel, or the
 *              chunk's line in the report, in which the mistake first showed
 *   survived   made, and nothing changed: the kind's table says when that is so
 *
 * The mistakes are made in validation/dense, in no backend: the proof is of
 * the comparison.  Kinds that change nothing in the first pass are made
 * everywhere in four scenes more; what stays silent then is reported.
 */
#ifndef OST_VALIDATION_SENSITIVITY_H
#define OST_VALIDATION_SENSITIVITY_H

#include "validation/dense/deviation.h"
#include "validation/locate/pattern.h"
#include "validation/plan.h"

typedef struct sensitivity_counts {
    uint64_t injected, triggered, changed, detected, located, survived;
    uint64_t not_detected, not_located; /* of those that changed something: defects of the comparison */
} sensitivity_counts;

/* What the differences of a kind looked like; one more for those of the report alone, and one for those without grids to compare. */
enum { SENSITIVITY_CLASSES = PATTERNS + 2 };
const char *sensitivity_class_name(int class);

typedef struct sensitivity {
    uint64_t seed;
    sensitivity_counts all, of[DEVIATION_KINDS];
    uint64_t classes[DEVIATION_KINDS][SENSITIVITY_CLASSES];
    int kinds_changed, kinds_noticed; /* kinds with a mistake that changed a result; those of which all were found and located */
    uint64_t clean_runs, false_alarms;
    char first_problem[300]; /* of a miss or a false alarm: which, with what repeats it */
} sensitivity;

/* How many injections a tier makes in the first pass. Smoke's are each kind once, everywhere. */
uint64_t sensitivity_injections(plan_tier tier);

/* On so many threads, and the same whatever their number. show may be NULL; one thread at a time calls it. */
ost_status sensitivity_run(uint64_t seed, uint64_t injections, int jobs, void (*show)(void *user, const char *what, double share), void *user,
                           sensitivity *out, ost_error *err);

/* This mistake alone, in the scene of this number. */
ost_status sensitivity_of(const deviation *how, uint64_t seed, int scene_number, sensitivity *out, ost_error *err);

#endif
