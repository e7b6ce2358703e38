/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What is known of a case's first difference, besides where compare.h finds
 * it: the chunk, what it looks like, and the operands of its first voxel.
 *
 *   difference, both traces, scene --finding_make--> chunk, class, operands
 */
#ifndef OST_VALIDATION_FINDING_H
#define OST_VALIDATION_FINDING_H

#include "validation/locate/operands.h"
#include "validation/locate/pattern.h"

enum { MINIMISED_TEXT = 256 };

typedef struct finding {
    int32_t chunk[3];  /* of the first voxel or of the report's first line; chunk_size 0: no chunk is known */
    int chunk_size;
    const char *class; /* pattern_name, "report-only", or NULL where grids cannot be compared */
    char text[PATTERN_TEXT]; /* what the class rests on */
    operands operands;
    char reproduce[96]; /* the bundle's file of a small case that shows the same; "" without one */
    char small[MINIMISED_TEXT]; /* what is left in it */
} finding;

void finding_make(const scene *s, const trace *ref, compare_range in_ref, const trace *got, compare_range in_got, const compare_difference *d, finding *out);

/* The same for a case of a plan; the caller's to free(), NULL when there is no memory for it. */
finding *finding_of_case(const plan_case *c, const trace *ref, compare_range in_ref, const trace *got, compare_range in_got, const compare_difference *d);

#endif
