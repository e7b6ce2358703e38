/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Computes the camera of one eye of a headset.
 *
 *   The picture of an eye is asymmetric: the forward axis does not pass through its centre.
 *
 *        left   axis  right             tan(angle) = pixels from the axis / focal length
 *      |--------|-----------|
 */
#ifndef OST_HEADSET_PROJECTION_H
#define OST_HEADSET_PROJECTION_H

#include <stdbool.h>
#include <stdint.h>

/* Angles from the forward axis to the picture's edges, in radians; positive to the right and up. */
typedef struct ost_headset_fov {
    double left, right, up, down;
} ost_headset_fov;

typedef struct ost_headset_projection {
    int32_t focal_milli;  /* focal length in thousandths of a pixel */
    double middle[2];     /* position of the forward axis in the picture, in pixels from the left and top edges */
    ost_headset_fov fov;  /* angles of the picture's edges, which cover at least the requested angles */
} ost_headset_projection;

/*
 * Computes the projection of a picture of width x height pixels that covers the requested angles. Pixels are square, so
 * a picture that is wider or higher than the angles require covers larger angles, equally on both sides. Returns false
 * if an angle is NaN or not within 85 degrees, if right <= left or up <= down, or if the focal length is less than a
 * pixel.
 */
bool ost_headset_project(const ost_headset_fov *fov, int width, int height, ost_headset_projection *out);

#endif
