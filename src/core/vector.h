/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Vectors of doubles, for cameras, views and metrics.  They are not used in the arithmetic on
 * voxels.  Pixels are not computed with these vectors but with separate float operations in a fixed
 * order (render/points/splat.h).
 */
#ifndef OST_CORE_VECTOR_H
#define OST_CORE_VECTOR_H

#include <math.h>

static inline double ost_vector_dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static inline double ost_vector_length(const double v[3])
{
    return sqrt(ost_vector_dot(v, v));
}

static inline double ost_vector_distance(const double a[3], const double b[3])
{
    const double d[3] = {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
    return ost_vector_length(d);
}

/* Writes the cross product a x b to out, which must not be a or b. */
static inline void ost_vector_cross(const double a[3], const double b[3], double out[3])
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

/* Scales v to length 1. A zero vector is set to the unit vector of the given axis.  Returns the previous length. */
static inline double ost_vector_unit(double v[3], int axis)
{
    const double length = ost_vector_length(v);
    for (int a = 0; a < 3; a++)
        v[a] = length > 0 ? v[a] / length : a == axis;
    return length;
}

#endif
