/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A clutch couples a body with a tool at a different position. The body is a device, or a pose that
 * a device has already mapped to the bone's frame.
 *
 *   body     from ----> at          tool     base ----> base + scale * world (at - from)
 *
 * When the clutch engages, the tool stays where it is. From then on, the tool follows the body's
 * motion. The first engagement aligns the body's axes with those of the tool. Later engagements
 * keep this alignment, so that a motion to the right remains a motion to the right.
 */
#ifndef OST_HAPTICS_CLUTCH_H
#define OST_HAPTICS_CLUTCH_H

#include "haptics/workspace.h"

typedef struct haptic_clutch {
    double scale;                    /* metres of tool motion per metre of body motion */
    /* latest pose of the tool in the bone's frame, position in m and quaternion w x y z */
    double given_at[3], given_q[4];
    double base_at[3], base_q[4];    /* pose of the tool when the clutch engaged */
    double from_at[3], from_q[4];    /* pose of the body when the clutch engaged */
    double world[4];                 /* rotation from the body's frame to the bone's frame */
    bool engaged, laid;
} haptic_clutch;

haptic_clutch ost_haptic_clutch_make(const ost_pose *start, double scale);
/*
 * Aligns the body's frame with the tool's start pose, regardless of the body's first orientation. Drivers call this
 * function for devices whose axes have a fixed meaning, such as right and up.
 */
void ost_haptic_clutch_lay(haptic_clutch *clutch);
/* Disengages the clutch, so that the tool stops following the body. The next pose engages the clutch with the
   tool at its current position. */
void ost_haptic_clutch_release(haptic_clutch *clutch);
/* Sets the tool's pose and disengages the clutch. The next pose engages the clutch with the tool at its new pose. */
void ost_haptic_clutch_engage_at(haptic_clutch *clutch, const ost_pose *tool);
/*
 * Returns the tool's pose for a body at the position `at` (m) with the orientation q (length 1).
 * Engages the clutch if it is not engaged. Returns an invalid pose if a value is not finite or is
 * too large.
 */
ost_pose ost_haptic_clutch_pose(haptic_clutch *clutch, const double at[3], const double q[4]);
/* Computes the same pose as ost_haptic_clutch_pose, but for a body whose pose is given in the bone's frame. */
ost_pose ost_haptic_clutch_follow(haptic_clutch *clutch, const ost_pose *body);
/* Rotates a vector, for example a force, from the bone's frame to the body's frame. */
void ost_haptic_clutch_vector(const haptic_clutch *clutch, const double bone[3], double body[3]);

#endif
