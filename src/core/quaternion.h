/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Quaternions w, x, y, z and rotation matrices in doubles, for devices, cameras and built-in paths. They are not used
 * in the arithmetic on voxels, whose rotations are exact (core/rotation.h). Each function evaluates its sums from left
 * to right, and tests of built-in paths and devices depend on this order.
 */
#ifndef OST_CORE_QUATERNION_H
#define OST_CORE_QUATERNION_H

#include <math.h>
#include <string.h>

#include "core/rotation.h"

/* Computes the product a b, the rotation by b followed by the rotation by a. `out` may be `a` or `b`. */
static inline void ost_quaternion_product(const double a[4], const double b[4], double out[4])
{
    const double r[4] = {
        a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3], a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
        a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1], a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0]};
    memcpy(out, r, sizeof r);
}

/* Computes the conjugate, which is the inverse of a unit quaternion. */
static inline void ost_quaternion_conjugate(const double q[4], double out[4])
{
    out[0] = q[0];
    for (int i = 1; i < 4; i++)
        out[i] = -q[i];
}

/* Scales q to length 1. Returns the previous length; a quaternion of length 0 becomes NaN. */
static inline double ost_quaternion_unit(double q[4])
{
    const double length = sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    for (int i = 0; i < 4; i++)
        q[i] /= length;
    return length;
}

/* Rotates the vector v by the unit quaternion q. `out` may be `v`. */
static inline void ost_quaternion_rotate(const double q[4], const double v[3], double out[3])
{
    const double pure[4] = {0, v[0], v[1], v[2]};
    double inverse[4], r[4];
    ost_quaternion_conjugate(q, inverse);
    ost_quaternion_product(q, pure, r);
    ost_quaternion_product(r, inverse, r);
    memcpy(out, r + 1, 3 * sizeof *out);
}

/* Computes the matrix of a unit quaternion, as m[row][column]. */
static inline void ost_quaternion_matrix(const double q[4], double m[3][3])
{
    const double w = q[0], x = q[1], y = q[2], z = q[3];
    const double r[3][3] = {{1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)},
                            {2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)},
                            {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)}};
    memcpy(m, r, sizeof r);
}

/* Computes the matrix of a pose from the exact rotation (core/rotation.h), as m[row][column]. */
static inline void ost_pose_matrix(const ost_pose *pose, double m[3][3])
{
    const ost_rotation exact = ost_rotation_of(pose);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            m[i][j] = (double)exact.m[i][j] / (double)exact.n;
}

#endif
