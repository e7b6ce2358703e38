/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Draws three pictures of one position: of the reference, of the other volume, and of the difference. Each
 * picture has an axial, a coronal and a sagittal slice through the position with the most differences. A
 * voxel is drawn as a square, so that a single difference is visible. Pattern and colour show the type of a
 * difference.
 */
#ifndef OST_VALIDATION_REPORT_TRIPLET_H
#define OST_VALIDATION_REPORT_TRIPLET_H

#include <osteon/picture.h>

#include "validation/report/pictures.h"

typedef struct triplet {
    const ost_volume *reference, *got;
    bool tool;       /* true if the voxels are classes of a tool, false if they are densities */
    int32_t at[3];   /* indices of the slices */
    int32_t lo[3], n[3]; /* the part of the grid that is shown: first voxel, and number of voxels, on each axis */
} triplet;

/* Chooses the slices to show. Returns false if the grids are equal. */
bool triplet_of(const ost_volume *reference, const ost_volume *got, bool tool, triplet *out);
ost_status triplet_draw(const triplet *t, picture_role role, ost_picture *out, ost_error *err);

#endif
