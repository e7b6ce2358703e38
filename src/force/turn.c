/* SPDX-License-Identifier: Apache-2.0 */
#include "force/turn.h"

#include <math.h>
#include <string.h>

#include "core/vector.h"
#include "force/vibration.h"

void ost_turn_between(const double a[4], const double b[4], double out[3])
{
    const double w = a[0], x = -a[1], y = -a[2], z = -a[3]; /* conjugate of a */
    const double real = b[0] * w - b[1] * x - b[2] * y - b[3] * z;
    const double imaginary[3] = {b[0] * x + b[1] * w + b[2] * z - b[3] * y, b[0] * y - b[1] * z + b[2] * w + b[3] * x,
                                 b[0] * z + b[1] * y - b[2] * x + b[3] * w};
    const double n = sqrt(real * real + ost_vector_dot(imaginary, imaginary));
    for (int i = 0; i < 3; i++)
        out[i] = (real < 0 ? -2 : 2) * imaginary[i] / n;
}

void ost_turn_about_axis(const double q[4], double angle, double out[4])
{
    double s, c;
    ost_sin_cos(angle / 2, &s, &c);
    const double turned[4] = {q[0] * c - q[3] * s, q[1] * c + q[2] * s, q[2] * c - q[1] * s, q[3] * c + q[0] * s};
    memcpy(out, turned, sizeof turned);
}

void ost_turn_quaternion(const ost_pose *pose, double q[4])
{
    q[0] = pose->qw;
    q[1] = pose->qx;
    q[2] = pose->qy;
    q[3] = pose->qz;
}

double ost_turn_less_64(double angle)
{
    const double most = 2 * 3.14159265358979323846 * 64;
    return angle > most ? angle - most : angle < -most ? angle + most : angle;
}
