/* SPDX-License-Identifier: Apache-2.0 */
#include "headset/room.h"

#include <math.h>
#include <string.h>

static void product(const double a[4], const double b[4], double out[4])
{
    out[0] = a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3];
    out[1] = a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2];
    out[2] = a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1];
    out[3] = a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0];
}

ost_room ost_room_make(const double at_mm[3], const double right[3], const double up[3], const double back[3])
{
    ost_room room;
    const double columns[3][3] = {
        {right[0], right[1], right[2]}, {up[0], up[1], up[2]}, {back[0], back[1], back[2]}};
    memcpy(room.at, at_mm, sizeof room.at);
    ost_quaternion_of_columns(columns, room.q);
    return room;
}

ost_status ost_room_pose(const ost_room *room, const double at_m[3], const double q[4], ost_pose *out, ost_error *err)
{
    const double *r = room->q, v[4] = {0, at_m[0], at_m[1], at_m[2] + OST_ROOM_AHEAD_M},
                 back[4] = {r[0], -r[1], -r[2], -r[3]};
    double half[4], turned[4], at[3], both[4], length = 0;
    product(r, v, half);
    product(half, back, turned);
    for (int a = 0; a < 3; a++)
        at[a] = room->at[a] + 1000 * turned[1 + a];
    product(r, q, both);
    /* Runtimes compute in floats, which is not accurate enough for the quaternion of a pose, so it is normalized
     * here. */
    for (int i = 0; i < 4; i++)
        length += both[i] * both[i];
    length = sqrt(length);
    if (!(fabs(length - 1) < 0.01))
        return ost_fail(err, OST_ERR_RANGE, "the headset reports an orientation whose quaternion has the length %g",
                        length);
    for (int i = 0; i < 4; i++)
        both[i] /= length;
    return ost_pose_from_doubles(at, both, out, err);
}
