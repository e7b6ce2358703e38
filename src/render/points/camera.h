/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A camera in front of a grid, in voxels.
 *
 * The camera's frame: x to the right of the picture, y up, z toward who looks;
 * it looks along -z.  Its pose takes that frame into the bone's and is
 * quantised as every pose is; what follows from it is a few additions,
 * products and divisions, each rounded once.  So a camera is the same bits
 * everywhere, and so is the picture.
 *
 *   ray of pixel (x, y):   d = (x + 1/2 - w/2) right - (y + 1/2 - h/2) up + focal forward
 *   in voxels:             voxel (i, j, k) is the cube of side 1 about (i, j, k)
 */
#ifndef OST_RENDER_CAMERA_H
#define OST_RENDER_CAMERA_H

#include <osteon/render.h>

typedef struct ost_eye {
    float at[3];                           /* in voxels */
    float right[3], up[3], forward[3];     /* unit, to float's accuracy */
    float focal;                           /* pixels */
    float half_w, half_h;                  /* pixels */
    float near;                            /* voxels; a voxel of which a corner is nearer along forward is not drawn */
    int width, height;
} ost_eye;

/* Rounded in this order everywhere. */
static inline float ost_eye_dot(const float a[3], const float b[3])
{
    return (a[0] * b[0] + a[1] * b[1]) + a[2] * b[2];
}

/* camera was checked. */
ost_eye ost_eye_make(const ost_camera *camera, const ost_geometry *bone);
/* The same from what is at a pose: its grid is in its own frame, which the pose takes into the bone's. */
ost_eye ost_eye_make_from(const ost_camera *camera, const ost_geometry *grid, const ost_pose *pose);

#endif
