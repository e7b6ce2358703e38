/* SPDX-License-Identifier: Apache-2.0 */
/* Quantises and checks poses (AR-POSE). */
#include "core/conditions.h"

#include <osteon/pose.h>

#include <math.h> /* for sqrt, which only a message uses */
#include <stdlib.h>

#include "core/integer.h"
#include "core/shortest.h"

ost_pose ost_pose_identity(void)
{
    return (ost_pose){.qw = OST_Q30_ONE};
}

/*
 * Checks | |q| - 1 | <= 1e-3 with integers: 999^2 * 2^60 <= N * 10^6 <= 1001^2 * 2^60.
 * N is the sum of the squares of the Q30 components, at most 4 * 2^62, so the products
 * fit in 128 bits.
 */
ost_status ost_pose_check(const ost_pose *pose, ost_error *err)
{
    const int64_t t[3] = {pose->t.x, pose->t.y, pose->t.z};
    for (int a = 0; a < 3; a++)
        if (t[a] > OST_LENGTH_MAX || t[a] < -OST_LENGTH_MAX)
            return ost_fail(err, OST_ERR_RANGE, "position %c = %.6f mm is beyond 8000 mm", "xyz"[a],
                            ost_pm_to_mm(t[a]));
    const int64_t q[4] = {pose->qw, pose->qx, pose->qy, pose->qz};
    ost_i128 norm = 0;
    for (int a = 0; a < 4; a++)
        norm += (ost_i128)q[a] * q[a];
    ost_i128 one = (ost_i128)1 << 60;
    if (norm * 1000000 < one * (999 * 999) || norm * 1000000 > one * (1001 * 1001))
        return ost_fail(err, OST_ERR_RANGE,
                        "quaternion (%.6g, %.6g, %.6g, %.6g) has length %.6g; it must be 1 to within 0.001",
                        (double)q[0] / OST_Q30_ONE, (double)q[1] / OST_Q30_ONE, (double)q[2] / OST_Q30_ONE,
                        (double)q[3] / OST_Q30_ONE, sqrt((double)norm) / OST_Q30_ONE);
    return OST_OK;
}

/* Returns true if a component fits in int32, as every component of a valid pose does: it is at most 1.001 * 2^30. */
static bool component_fits(int64_t value)
{
    return value >= INT32_MIN && value <= INT32_MAX;
}

static ost_status assemble(const int64_t t[3], const int64_t q[4], ost_pose *out, ost_error *err)
{
    for (int a = 0; a < 4; a++)
        if (!component_fits(q[a]))
            return ost_fail(
                err, OST_ERR_RANGE,
                "quaternion component q%c is %.6g; expected a unit quaternion, whose components are from -1 to 1",
                "wxyz"[a], (double)q[a] / OST_Q30_ONE);
    ost_pose pose = {{t[0], t[1], t[2]}, (int32_t)q[0], (int32_t)q[1], (int32_t)q[2], (int32_t)q[3]};
    ost_status status = ost_pose_check(&pose, err);
    if (status == OST_OK)
        *out = pose;
    return status;
}

ost_status ost_pose_from_decimals(const ost_decimal t_mm[3], const ost_decimal q[4], ost_pose *out, ost_error *err)
{
    int64_t t[3];
    int64_t c[4];
    for (int a = 0; a < 3; a++)
        if (!ost_decimal_to_pm(&t_mm[a], &t[a], NULL))
            return ost_fail(err, OST_ERR_RANGE, "position %c is beyond 8000 mm", "xyz"[a]);
    for (int a = 0; a < 4; a++)
        if (!ost_decimal_scale(&q[a], (uint64_t)OST_Q30_ONE, &c[a], NULL))
            return ost_fail(err, OST_ERR_RANGE,
                            "quaternion component q%c is out of range; expected a unit quaternion, whose components "
                            "are from -1 to 1",
                            "wxyz"[a]);
    return assemble(t, c, out, err);
}

ost_status ost_pose_from_doubles(const double t_mm[3], const double q[4], ost_pose *out, ost_error *err)
{
    int64_t t[3];
    int64_t c[4];
    for (int a = 0; a < 3; a++)
        if (!ost_pm_from_double(t_mm[a], &t[a]))
            return ost_fail(err, OST_ERR_RANGE, "position %c = %g mm is not a number within 8000 mm", "xyz"[a],
                            t_mm[a]);
    for (int a = 0; a < 4; a++) {
        ost_decimal decimal; /* A float stands for the shortest decimal number that reads as this float (AR-LEN-4). */
        if (!(q[a] >= -1.5 && q[a] <= 1.5) || !ost_decimal_shortest(q[a], false, &decimal) ||
            !ost_decimal_scale(&decimal, (uint64_t)OST_Q30_ONE, &c[a], NULL))
            return ost_fail(
                err, OST_ERR_RANGE,
                "quaternion component q%c is %g; expected a unit quaternion, whose components are from -1 to 1",
                "wxyz"[a], q[a]);
    }
    return assemble(t, c, out, err);
}
