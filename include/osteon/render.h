/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Draws voxels as ray-box points (Majercik et al. 2018; thesis 2.6) on the CPU, without a display
 * or a graphics driver.  The picture is bit-identical for every instruction set and number of
 * threads.
 *
 * Every surface voxel is a point that covers a small rectangle of pixels.  A voxel is a candidate
 * for a pixel of its rectangle if the pixel's ray intersects the voxel's box; the pixel shows the
 * nearest candidate.  Nothing here affects the removal of voxels.
 *
 * Threads: the functions share no state; a volume that is passed as const may be read by several threads.
 */
#ifndef OSTEON_RENDER_H
#define OSTEON_RENDER_H

#include <osteon/picture.h>
#include <osteon/pose.h>

#ifdef __cplusplus
extern "C" {
#endif

enum { OST_FRAME_MAX = 8192 }; /* maximum width and height of a frame in pixels */

/*
 * A camera. In its frame, x points to the right of the picture, y points up, and the view direction is -z. The pose
 * maps this frame to the bone's frame. With a focal length of f pixels and a vertical angle of view a, the picture
 * is 2 f tan(a / 2) pixels high.
 */
typedef struct ost_camera {
    ost_pose pose;
    int32_t focal_milli; /* focal length in thousandths of a pixel, 1000 to 100,000,000 */
    int width, height;   /* size of the picture in pixels, 1 to OST_FRAME_MAX */
} ost_camera;

/* Returns OST_ERR_RANGE, with the offending value in err, if a value of the camera is out of its range. */
OST_API ost_status ost_camera_check(const ost_camera *camera, ost_error *err);

/*
 * Sets camera->pose so that the camera is at from_mm and its view direction points to at_mm. `up` does not need to be a
 * unit vector or perpendicular to the view direction. Returns OST_ERR_RANGE if the two positions are equal or if `up`
 * is parallel to the view direction.
 */
OST_API ost_status ost_camera_look_at(const double from_mm[3], const double at_mm[3], const double up[3],
                                      ost_camera *camera, ost_error *err);

typedef enum ost_style {
    OST_STYLE_SMOOTH, /* each voxel is lit according to the surface normal around it; hollows are darker */
    OST_STYLE_FACES   /* each face is lit according to its own normal, as in the thesis */
} ost_style;

/* Options of ost_picture_points. A zero-initialised struct selects the defaults. */
typedef struct ost_points_options {
    int32_t threshold; /* threshold; 0 selects 120 */
    ost_style style;
    /* Name of an instruction set level, as in the environment variable OSTEON_ISA. NULL selects the best level of
     * this machine. */
    const char *isa;
    int threads;       /* number of threads; 0 selects one for each processor */
} ost_points_options;
/*
 * Draws the voxels at or above the threshold as seen by the camera. Returns OST_ERR_RANGE if ost_camera_check rejects
 * the camera, if the voxels are not cubes, or if the camera is more than 32768 voxels away from the bone. Returns
 * OST_ERR_USAGE for an unknown instruction set, OST_ERR_UNAVAILABLE for an instruction set that this machine lacks, and
 * OST_ERR_MEMORY if memory is exhausted. The caller frees *out with ost_picture_free.
 */
OST_API ost_status ost_picture_points(const ost_volume *volume, const ost_camera *camera,
                                      const ost_points_options *options, ost_picture *out, ost_error *err);

#ifdef __cplusplus
}
#endif
#endif
