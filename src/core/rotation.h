/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The rotation of a pose as exact integers (AR-POSE-4): R = M / N, where M is the matrix of
 * products of the quaternion's components and N is the sum of their squares.  Nothing is rounded,
 * so rotations by 90 degrees are exact: q = (c, 0, 0, c) gives N = 2c^2, and the entries of M are 0
 * and +-2c^2.
 *
 * Ranges: a component of a quaternion that was read is at most 1.001 * 2^30 + 1.
 * ost_rotation_fits checks a slightly weaker bound, 2^30 + 2^21.  Each product is then below
 * 2^60.01.  N and twice every sum of two products are below 2^62.01, so they fit in int64.  The
 * value of N is checked afterwards.
 */
#ifndef OST_CORE_ROTATION_H
#define OST_CORE_ROTATION_H

#include <osteon/pose.h>

#define OST_ROTATION_N_MIN (INT64_C(1) << 59)
#define OST_ROTATION_N_MAX ((INT64_C(1) << 60) + (INT64_C(1) << 52))

/*
 * Returns true if the position is within 8 m and the components of the quaternion are at most 2^30
 * + 2^21 in magnitude. The arithmetic on poses requires both conditions.
 */
static inline bool ost_rotation_fits(const ost_pose *pose)
{
    const int32_t q = OST_Q30_ONE + (1 << 21);
    return pose->qw >= -q && pose->qw <= q && pose->qx >= -q && pose->qx <= q && pose->qy >= -q && pose->qy <= q &&
           pose->qz >= -q && pose->qz <= q && pose->t.x >= -OST_LENGTH_MAX && pose->t.x <= OST_LENGTH_MAX &&
           pose->t.y >= -OST_LENGTH_MAX && pose->t.y <= OST_LENGTH_MAX && pose->t.z >= -OST_LENGTH_MAX &&
           pose->t.z <= OST_LENGTH_MAX;
}

typedef struct ost_rotation {
    int64_t m[3][3]; /* numerators [row][column] of the rotation matrix: p_bone = M p_tool / n + t */
    int64_t n;
} ost_rotation;

static inline ost_rotation ost_rotation_of(const ost_pose *pose)
{
    int64_t w = pose->qw, x = pose->qx, y = pose->qy, z = pose->qz;
    return (ost_rotation){
        .m = {{w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)},
              {2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)},
              {2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z}},
        .n = w * w + x * x + y * y + z * z,
    };
}

#endif
