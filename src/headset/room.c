/* SPDX-License-Identifier: Apache-2.0 */
#include "headset/room.h"

#include <math.h>
#include <string.h>

#include "core/quaternion.h"

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
    const double v[3] = {at_m[0], at_m[1], at_m[2] + OST_ROOM_AHEAD_M};
    double turned[3], at[3], both[4];
    ost_quaternion_rotate(room->q, v, turned);
    for (int a = 0; a < 3; a++)
        at[a] = room->at[a] + 1000 * turned[a];
    ost_quaternion_product(room->q, q, both);
    /* Runtimes compute in floats, which is not accurate enough for the quaternion of a pose, so it is normalized
     * here. */
    const double length = ost_quaternion_unit(both);
    if (!(fabs(length - 1) < 0.01))
        return ost_fail(err, OST_ERR_RANGE, "the headset reports an orientation whose quaternion has the length %g",
                        length);
    return ost_pose_from_doubles(at, both, out, err);
}
