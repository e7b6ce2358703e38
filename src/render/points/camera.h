/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A camera in front of a grid, in voxels.
 *
 * The camera's frame has x to the right of the picture, y up, and z toward the viewer; the view direction is -z. The
 * camera's pose maps this frame to the bone's frame and is quantised like every pose. All other values are computed
 * from the pose by a few additions, multiplications and divisions, each rounded once, so cameras and pictures are
 * bit-identical on all machines.
 *
 *   ray of pixel (x, y):   d = (x + 1/2 - w/2) right - (y + 1/2 - h/2) up + focal forward
 *   in voxels:             voxel (i, j, k) is the cube of side 1 centred at (i, j, k)
 */
#ifndef OST_RENDER_CAMERA_H
#define OST_RENDER_CAMERA_H

#include <osteon/render.h>

typedef struct ost_eye {
    float at[3];                           /* in voxels */
    float right[3], up[3], forward[3];     /* unit vectors, within float precision */
    float focal;                           /* pixels */
    /* position in pixels, from the left and top edges, of the point at which the forward axis passes through the
       picture. The point is the middle of the picture, except for a headset, whose frames only OpenGL draws */
    float half_w, half_h;
    /* distance of the near plane along the forward axis, in voxels; a voxel is drawn only if all its corners are beyond
       this plane */
    float near;
    int width, height;
} ost_eye;

/* Returns the dot product. The order of the additions is fixed, so the result is bit-identical on all machines. */
static inline float ost_eye_dot(const float a[3], const float b[3])
{
    return (a[0] * b[0] + a[1] * b[1]) + a[2] * b[2];
}

/* Returns the eye of a camera in voxel coordinates of the bone. The camera must have passed ost_camera_check. */
ost_eye ost_eye_make(const ost_camera *camera, const ost_geometry *bone);
/* Returns the eye of a camera in voxel coordinates of an object. `pose` maps the frame of the object's grid to the
   bone's frame. The camera must have passed ost_camera_check. */
ost_eye ost_eye_make_from(const ost_camera *camera, const ost_geometry *grid, const ost_pose *pose);

#endif
