/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tools and poses for the kernels of removal: small, thin, full, empty and
 * noisy solids, at every ratio of voxels, with their tables in guarded memory.
 */
#ifndef OST_TESTS_SIMD_SOLIDS_H
#define OST_TESTS_SIMD_SOLIDS_H

#include "cpu/remove/remove.h"
#include "simd/check.h"

/*
 * The shape of this case, of every eight cases the same: its cells (with the
 * 64 bytes on either side that may be read), windows and voxels are inputs of
 * the case.  step is that of a pose of bone voxels which the shape serves.
 */
typedef struct solid {
    ost_shape shape;
    int32_t step[3][3];
    char text[100];
} solid;

void solid_make(check *c, solid *out);
/* Tables that no tool has: values anywhere in -64..64 (shape.h), any unit, few cells. */
void solid_cells(check *c, ost_cells *out);

#endif
