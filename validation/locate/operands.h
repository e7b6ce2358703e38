/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The operands that decided a voxel, which a developer would print first. They
 * are computed again by the reference's arithmetic from the case's inputs and
 * the reference's own results of the previous stages.
 *
 *   rect     the samples that fall on the voxel, and the rule between them     AR-CT
 *   cubic    per axis the division that gives the source voxel                 AR-CUB
 *   resample the same, from the cubic grid
 *   chunks   density, threshold                                                AR-CHK
 *   tool     the row's crossings, the winding number, the row's sum            AR-VOX
 *   tick     the event's poses; the one that decides, the point in tool        AR-SWEEP,
 *            coordinates (fixed point), its tool voxel and what that is        AR-MAP, AR-REM
 *
 * They are the operands of the right result. They do not show which of them was
 * different in the other backend.
 */
#ifndef OST_VALIDATION_OPERANDS_H
#define OST_VALIDATION_OPERANDS_H

#include "validation/compare.h"
#include "validation/scene.h"

enum { OPERANDS_MAX = 20, OPERAND_NAME = 24, OPERAND_VALUE = 240 };
typedef struct operand_line {
    char name[OPERAND_NAME], value[OPERAND_VALUE];
} operand_line;

typedef struct operands {
    int count;
    operand_line lines[OPERANDS_MAX];
} operands;

/* Computes the operands of the first voxel of d; none if d is not a difference of voxels. before: for a tick the
   previous bone, else NULL. */
void operands_of(const scene *s, const trace *ref, compare_range in_ref, const compare_difference *d,
                 const int16_t *before, operands *out);

#endif
