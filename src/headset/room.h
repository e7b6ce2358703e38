/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Places the bone in the room.
 *
 *   room    metres; the origin is at the eyes when the headset starts; x right, y up, z toward the viewer (OpenXR's
 *           space LOCAL)
 *   bone    millimetres, shown in true size; the target of a view is OST_ROOM_AHEAD_M in front of the room's origin,
 *           and the view's directions right, up and back are the room's x, y and z
 */
#ifndef OST_HEADSET_ROOM_H
#define OST_HEADSET_ROOM_H

#include <osteon/pose.h>

#define OST_ROOM_AHEAD_M 0.5

typedef struct ost_room {
    double at[3]; /* target of the view, in the bone's frame, in mm */
    double q[4];  /* rotation from the room's axes to the bone's axes, as a quaternion w x y z */
} ost_room;

/*
 * Creates a room. `right`, `up` and `back` are the axes of the view in the bone's frame. They must be orthogonal unit
 * vectors that form a right-handed frame.
 */
ost_room ost_room_make(const double at_mm[3], const double right[3], const double up[3], const double back[3]);
/*
 * Converts a pose in the room (metres, unit quaternion w x y z) to a pose in the bone's frame. Returns OST_ERR_RANGE if
 * a number is NaN or the position is more than 8 m from the bone's origin.
 */
ost_status ost_room_pose(const ost_room *room, const double at_m[3], const double q[4], ost_pose *out, ost_error *err);

#endif
