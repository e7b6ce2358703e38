/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Voxels as ray-box points (Majercik et al. 2018; thesis 2.6), drawn by the
 * processor without a display or driver.  The picture is bit-identical for every
 * instruction set and number of threads.
 *
 * Every surface voxel is a point that covers a small rectangle of pixels.  A
 * pixel of the rectangle shows the voxel if its ray meets the voxel's box; the
 * nearest voxel is kept.  Nothing here affects the removal of voxels.
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
 * The camera's frame: x to the right of the picture, y up, view direction -z;
 * pose maps it to the bone's frame.  With a focal length of f pixels and a
 * vertical angle of view a, the picture is 2 f tan(a / 2) pixels high.
 */
typedef struct ost_camera {
    ost_pose pose;
    int32_t focal_milli; /* thousandths of a pixel, 1000 to 100,000,000 */
    int width, height;   /* pixels, 1 to OST_FRAME_MAX */
} ost_camera;

/* Returns OST_ERR_RANGE, with the offending value in err, if a value is outside the ranges above. */
OST_API ost_status ost_camera_check(const ost_camera *camera, ost_error *err);

/*
 * Sets camera->pose to that of a camera at from_mm directed at at_mm.  up need
 * be neither a unit vector nor perpendicular to the view direction.
 */
OST_API ost_status ost_camera_look_at(const double from_mm[3], const double at_mm[3], const double up[3],
                                      ost_camera *camera, ost_error *err);

typedef enum ost_style {
    OST_STYLE_SMOOTH, /* each voxel lit by the normal of the surface around it, darker in hollows */
    OST_STYLE_FACES   /* the thesis: each face by its own normal */
} ost_style;

/*
 * Draws the voxels at or above the threshold, which must be cubes, as seen by
 * the camera.  isa is a level as in OSTEON_ISA, NULL for the best; threads 0
 * means one for each processor.  The caller owns the picture.
 */
typedef struct ost_points_options {
    int32_t threshold; /* 0 = 120 */
    ost_style style;
    const char *isa;
    int threads;
} ost_points_options;
/* Draws the picture described above. The caller owns *out. */
OST_API ost_status ost_picture_points(const ost_volume *volume, const ost_camera *camera,
                                      const ost_points_options *options, ost_picture *out, ost_error *err);

#ifdef __cplusplus
}
#endif
#endif
