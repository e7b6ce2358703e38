/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Computes the operands of a voxel, which are the values that a developer would print first. The operands
 * are computed again with the reference's arithmetic, from the inputs of the case and the reference's
 * results of the previous stages.
 *
 *   rect     the samples of the voxel, and the rule for duplicates             AR-CT
 *   cubic    for each axis, the division that gives the source voxel           AR-CUB
 *   resample as for cubic, with the cubic grid as the source
 *   chunks   density, threshold                                                AR-CHK
 *   tool     the row's crossings, the winding number, the row's sum            AR-VOX
 *   tick     the event's poses; for the pose that determined the voxel, the    AR-SWEEP,
 *            point in tool coordinates (fixed point), the tool voxel there     AR-MAP, AR-REM
 *            and its class
 *
 * The operands give the correct result. They do not show which operand was different in the other backend.
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

/* Computes the operands of the first voxel of the difference d. If d is not a difference of voxels, there are no
   operands. `before` is the bone before the tick if the difference is in a tick; if not, `before` is NULL. */
void operands_of(const scene *s, const trace *ref, compare_range in_ref, const compare_difference *d,
                 const int16_t *before, operands *out);

#endif
