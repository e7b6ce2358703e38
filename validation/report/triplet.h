/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Three pictures of one position in two volumes: the reference, the other volume,
 * and the difference.  Each has an axial, a coronal and a sagittal slice through
 * the position with the most differences.  A voxel is a square, so that a single
 * difference is visible; the kind of a difference is shown by pattern and colour.
 */
#ifndef OST_VALIDATION_REPORT_TRIPLET_H
#define OST_VALIDATION_REPORT_TRIPLET_H

#include <osteon/picture.h>

#include "validation/report/pictures.h"

typedef struct triplet {
    const ost_volume *reference, *got;
    bool tool;       /* true: voxels are classes, not densities */
    int32_t at[3];   /* indices of the slices */
    int32_t lo[3], n[3]; /* the range of voxels that is shown */
} triplet;

/* Chooses the slices. Returns false if nothing differs. */
bool triplet_of(const ost_volume *reference, const ost_volume *got, bool tool, triplet *out);
ost_status triplet_draw(const triplet *t, picture_role role, ost_picture *out, ost_error *err);

#endif
