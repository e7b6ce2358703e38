/* SPDX-License-Identifier: Apache-2.0 */
/* Fits spheres and planes to points by least squares. */
#ifndef OST_CORE_FIT_H
#define OST_CORE_FIT_H

#include <stdbool.h>
#include <stddef.h>

/*
 * Fits a sphere by linear least squares. The sphere's equation |p|^2 = 2 c.p + k is linear in the centre c and in k.
 * Returns false if the points do not determine a sphere.
 */
bool ost_fit_sphere(const double (*points)[3], size_t count, double centre[3], double *radius);
/*
 * Fits a plane to points by least squares of the distances along the unit vector `along`, which must not lie in the
 * plane. *normal is set to the unit normal on the side of `along`, and *mean to the mean of the points, which lies in
 * the plane. Returns false if there are fewer than three points or if the points are collinear.
 */
bool ost_fit_plane(const double (*points)[3], size_t count, const double along[3], double normal[3], double mean[3]);

#endif
