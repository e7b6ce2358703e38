/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Describes a case's first difference in addition to its position, which compare.h
 * finds: the chunk, the difference class, and the operands of its first voxel.
 *
 *   difference, both traces, scene --finding_make--> chunk, class, operands
 */
#ifndef OST_VALIDATION_FINDING_H
#define OST_VALIDATION_FINDING_H

#include "validation/locate/operands.h"
#include "validation/locate/pattern.h"

enum { MINIMISED_TEXT = 256 };

typedef struct finding {
    int32_t chunk[3];  /* chunk of the first voxel or of the report's first line; chunk_size is 0 if it is not known */
    int chunk_size;
    const char *class; /* pattern_name, "report-only", or NULL if the grids cannot be compared */
    char text[PATTERN_TEXT]; /* the evidence for the class */
    operands operands;
    char reproduce[96]; /* file in the bundle with a small case that shows the same difference; "" if there is none */
    char small[MINIMISED_TEXT]; /* the contents of the small case (minimised_text) */
} finding;

/* Describes d, the first difference between the traces ref and got of a case with this scene. in_ref and in_got are the
   records of the case in the traces. */
void finding_make(const scene *s, const trace *ref, compare_range in_ref, const trace *got, compare_range in_got,
                  const compare_difference *d, finding *out);

/* Makes the scene of a case and describes its difference as finding_make does. The caller frees the result with free().
   Returns NULL if the scene cannot be made or memory is exhausted. */
finding *finding_of_case(const plan_case *c, const trace *ref, compare_range in_ref, const trace *got,
                         compare_range in_got, const compare_difference *d);

#endif
