/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Describes the first difference of a case. The function compare_case finds its position; the functions
 * below determine the chunk, the difference class, and the operands of the first differing voxel.
 *
 *   difference, both traces, scene --finding_make--> chunk, class, operands
 */
#ifndef OST_VALIDATION_FINDING_H
#define OST_VALIDATION_FINDING_H

#include "validation/locate/operands.h"
#include "difference/pattern.h"

enum { MINIMISED_TEXT = 256 };

typedef struct finding {
    /* chunk of the first differing voxel, or of the first differing line of the report; chunk_size is 0 if the chunk
       is unknown */
    int32_t chunk[3];
    int chunk_size;
    /* class of the difference (ost_pattern_name), "report-only" or "steps"; NULL if grids could not be compared */
    const char *class;
    char text[PATTERN_TEXT]; /* the evidence for the class, as a sentence */
    operands operands;
    /* name of the bundle's file that contains a small case with the same difference; "" if there is no such file */
    char reproduce[96];
    char small[MINIMISED_TEXT]; /* description of the minimised case (minimised_text) */
} finding;

/* Describes d, the first difference of a case with the scene s. `ref` and `got` are the compared traces, and
   `in_ref` and `in_got` are the ranges of the case in these traces. */
void finding_make(const scene *s, const trace *ref, compare_range in_ref, const trace *got, compare_range in_got,
                  const compare_difference *d, finding *out);

/* Makes the scene of a case and describes the case's difference as finding_make does. The caller frees the result
   with free(). Returns NULL if the scene cannot be made or memory is exhausted. */
finding *finding_of_case(const plan_case *c, const trace *ref, compare_range in_ref, const trace *got,
                         compare_range in_got, const compare_difference *d);

#endif
