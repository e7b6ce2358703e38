/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tools and poses for testing the removal kernels: small, thin, full, empty and noisy solids, at every ratio of voxel
 * sizes. The tables of the tools are in guarded memory.
 */
#ifndef OST_TESTS_SIMD_SOLIDS_H
#define OST_TESTS_SIMD_SOLIDS_H

#include "cpu/remove/remove.h"
#include "simd/check.h"

/*
 * A shape, and the steps of a pose for it. Eight consecutive cases have the same shape. The cells of the
 * shape (with 64 readable bytes on each side), its windows and its bits are inputs of the case (check_input).
 * The pose has the voxel ratio for which the shape was made.
 */
typedef struct solid {
    ost_shape shape;
    int32_t step[3][3];
    char text[100];
} solid;

void solid_make(check *c, solid *out);
/* Makes a few random cells with values in -64..64 (shape.h) and a random unit. No real tool has such cells. */
void solid_cells(check *c, ost_cells *out);

#endif
