/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A camera in front of a grid, in voxels.
 *
 * The camera's frame: x to the right of the picture, y up, z toward the viewer;
 * the view direction is -z.  The camera's pose maps that frame to the bone's and
 * is quantised as every pose is.  All further values follow by a few additions,
 * products and divisions, each rounded once.  So cameras and pictures are
 * bit-identical on all machines.
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
    /* voxels; a voxel with a corner nearer than this along forward is not drawn */
    float near;
    int width, height;
} ost_eye;

/* Returns the scalar product; the order of rounding is the same everywhere. */
static inline float ost_eye_dot(const float a[3], const float b[3])
{
    return (a[0] * b[0] + a[1] * b[1]) + a[2] * b[2];
}

/* Returns the eye of a camera in the bone's voxels. ost_camera_check must have accepted the camera. */
ost_eye ost_eye_make(const ost_camera *camera, const ost_geometry *bone);
/* Does the same for an object at a pose: its grid is in its own frame, which the pose maps to the bone's. */
ost_eye ost_eye_make_from(const ost_camera *camera, const ost_geometry *grid, const ost_pose *pose);

#endif
