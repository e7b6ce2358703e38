/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The face of the glenoid: rim, plane, centre and inward axis, from the surface that rays along the axis meet.
 *
 *              rim                     rim      from the axis outward, in 72 directions, the rim is the last
 *   outward     .-.      dish         .-.       position within 1 mm of the highest position so far, before the
 *      ^       /   '-.___________.---'   \      surface falls by 3 mm or ends (docs/reference/metrics.md)
 *      |      /            |              \
 *                          v inward
 */
#ifndef OST_ANATOMY_FACE_H
#define OST_ANATOMY_FACE_H

#include "anatomy/field.h"

/* The surface is where the share is `level`; every `every`-th direction of the rim is used. */
typedef struct anatomy_variant {
    double level;
    int every, first;
} anatomy_variant;

typedef struct anatomy_face {
    double centre[3], inward[3];  /* centre on the face; unit vector into the bone */
    double rim[OST_RIM_MAX][3];   /* positions on the rim; only those with seen */
    double crest[OST_RIM_MAX][3]; /* highest positions up to the rim, to which the plane is fitted */
    bool seen[OST_RIM_MAX];
    double seen_share;            /* share of the directions in which the rim was found */
    double residual;              /* RMS distance of the rim from its plane, mm */
} anatomy_face;

/*
 * Finds the face near face->centre, seen along face->inward, which are both replaced. Returns false if the rim
 * cannot be found in half of the directions.
 */
bool anatomy_face_find(const anatomy_field *field, const anatomy_variant *variant, anatomy_face *face);
/* Finds the rim around face->centre, which lies on the face, along face->inward; these two are not changed. */
void anatomy_face_rim(const anatomy_field *field, const anatomy_variant *variant, anatomy_face *face);
/*
 * Moves the centre to the middle of the rim's extents along `superior` and across it, and measures these extents.  The
 * axis becomes perpendicular to the mean chord of the rim through the centre along `superior` (inclination) and to the
 * one across it (version).  Returns false if the rim is not found on both sides, or the axis meets no bone.
 */
bool anatomy_face_align(const anatomy_field *field, const anatomy_variant *variant, const double superior[3],
                        anatomy_face *face, double *height, double *width);

#endif
