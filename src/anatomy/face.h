/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Finds the face of the glenoid, that is, its rim, plane, centre and inward axis. The bone's surface is sampled by
 * rays parallel to the axis.
 *
 *              rim                     rim      The surface is followed outward from the axis in 72 directions,
 *   outward     .-.      dish         .-.       until it falls by 3 mm or ends. The rim is the last position within
 *      ^       /   '-.___________.---'   \      1 mm of the highest position so far (docs/reference/metrics.md).
 *      |      /            |              \
 *                          v inward
 */
#ifndef OST_ANATOMY_FACE_H
#define OST_ANATOMY_FACE_H

#include "anatomy/field.h"

/*
 * The parameters of a measurement. The surface is where the share of bone equals `level`. Only the directions k of the
 * rim with k % every == first are used.
 */
typedef struct anatomy_variant {
    double level;
    int every, first;
} anatomy_variant;

typedef struct anatomy_face {
    double centre[3], inward[3];  /* centre of the face, and unit vector along the axis into the bone */
    double rim[OST_RIM_MAX][3];   /* positions on the rim; rim[k] is valid only if seen[k] */
    /* for each direction, the highest position between the centre and the rim; the face's plane is fitted to these
     * positions */
    double crest[OST_RIM_MAX][3];
    bool seen[OST_RIM_MAX];
    double seen_share;            /* share of the directions in which the rim was found, from 0 to 1 */
    double residual;              /* RMS distance in mm of the crest points from their plane */
} anatomy_face;

/*
 * Finds the face near face->centre, viewed along face->inward, and replaces both with the exact centre and axis.
 * Returns false if the rim cannot be found in half of the directions.
 */
bool ost_anatomy_face_find(const anatomy_field *field, const anatomy_variant *variant, anatomy_face *face);
/* Finds the rim around face->centre, a position on the face. Does not change face->centre and face->inward. */
void ost_anatomy_face_rim(const anatomy_field *field, const anatomy_variant *variant, anatomy_face *face);
/*
 * Moves the centre to the middle of the rim's extents along and across the direction `superior`, and stores these
 * extents in *height and *width. Makes the axis perpendicular to two mean chords of the rim. The chord along `superior`
 * determines the inclination, and the chord across `superior` determines the version.
 *
 * Returns false if the rim is not found on both sides, or if the axis meets no bone.
 */
bool ost_anatomy_face_align(const anatomy_field *field, const anatomy_variant *variant, const double superior[3],
                            anatomy_face *face, double *height, double *width);

#endif
