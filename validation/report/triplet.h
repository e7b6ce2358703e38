/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Three pictures of one place in two volumes: the reference's, the other's,
 * and what differs, each as an axial, a coronal and a sagittal slice through
 * the slices where most differs.  A voxel is a square, so that one that
 * differs can be seen; how they differ is told by pattern as well as by colour.
 */
#ifndef OST_VALIDATION_REPORT_TRIPLET_H
#define OST_VALIDATION_REPORT_TRIPLET_H

#include <osteon/picture.h>

#include "validation/report/pictures.h"

typedef struct triplet {
    const ost_volume *reference, *got;
    bool tool;       /* voxels are classes, not densities */
    int32_t at[3];   /* the slices */
    int32_t lo[3], n[3]; /* what of them is shown */
} triplet;

/* False when nothing differs. */
bool triplet_of(const ost_volume *reference, const ost_volume *got, bool tool, triplet *out);
ost_status triplet_draw(const triplet *t, picture_role role, ost_picture *out, ost_error *err);

#endif
