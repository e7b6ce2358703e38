/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Voxels as ray-box points (Majercik et al. 2018; thesis 2.6), drawn by the
 * processor: no display, no driver, the same picture to the bit on every
 * instruction set and number of threads.
 *
 * Every surface voxel is a point that covers a small rectangle of pixels; of
 * those it takes the ones whose ray meets its box, nearest voxel first.
 * Nothing here decides a voxel.
 */
#ifndef OSTEON_RENDER_H
#define OSTEON_RENDER_H

#include <osteon/picture.h>
#include <osteon/pose.h>

#ifdef __cplusplus
extern "C" {
#endif

enum { OST_FRAME_MAX = 8192 }; /* pixels on a side of a frame */

/*
 * Frame of a camera: x to the right of the picture, y up, looking along -z;
 * pose takes it into the bone's frame.  A view that is `a` high is 2 f tan(a / 2)
 * pixels high with a focal length of f pixels.
 */
typedef struct ost_camera {
    ost_pose pose;
    int32_t focal_milli; /* thousandths of a pixel, 1000 to 100,000,000 */
    int width, height;   /* pixels, 1 to OST_FRAME_MAX */
} ost_camera;

/* OST_ERR_RANGE, naming what is out of the ranges above. */
OST_API ost_status ost_camera_check(const ost_camera *camera, ost_error *err);

/* The pose of a camera at from_mm that looks at at_mm; up need be neither unit nor upright to the view. Sets camera->pose. */
OST_API ost_status ost_camera_look(const double from_mm[3], const double at_mm[3], const double up[3], ost_camera *camera, ost_error *err);

typedef enum ost_style {
    OST_STYLE_SMOOTH, /* each voxel lit by the normal of the surface about it, darker where that is hollow */
    OST_STYLE_FACES   /* the thesis: each face by its own normal */
} ost_style;

/*
 * What is seen through the camera of the voxels at or above the threshold,
 * which must be cubes.  isa is a level as OSTEON_ISA names them, NULL for the
 * best; threads 0 is one for every processor.
 */
typedef struct ost_points_options {
    int32_t threshold; /* 0 = 120 */
    ost_style style;
    const char *isa;
    int threads;
} ost_points_options;
OST_API ost_status ost_picture_points(const ost_volume *volume, const ost_camera *camera, const ost_points_options *options,
                                      ost_picture *out, ost_error *err);

#ifdef __cplusplus
}
#endif
#endif
