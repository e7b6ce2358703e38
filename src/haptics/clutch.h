/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A clutch between a body (a device, or a pose that a device already mapped to
 * the bone's frame) and a tool at another position.
 *
 *   body     from ----> at          tool     given ----> given + world (at - from)
 *
 * When the clutch engages, the tool stays where it is; from then on it follows
 * the body's motion.  When it engages for the first time, the body's axes are
 * aligned with the tool's, and later engagements keep that alignment: moving to
 * the right remains moving to the right.
 */
#ifndef OST_HAPTICS_CLUTCH_H
#define OST_HAPTICS_CLUTCH_H

#include "haptics/workspace.h"

typedef struct haptic_clutch {
    double scale;                    /* metres of tool motion for a metre of body motion */
    double given_at[3], given_q[4];  /* the tool's last pose: m and w x y z, in the bone's frame */
    double base_at[3], base_q[4];    /* the tool's pose when the clutch engaged */
    double from_at[3], from_q[4];    /* the body's pose at the same moment */
    double world[4];                 /* rotates the body's frame into the bone's */
    bool engaged, laid;
} haptic_clutch;

/* Converts a pose to metres and a quaternion of length 1. */
void haptic_pose_to_metres(const ost_pose *pose, double at[3], double q[4]);

haptic_clutch haptic_clutch_make(const ost_pose *start, double scale);
/*
 * Aligns the body's frame with the tool's start pose, whatever the body's orientation when it
 * is first seen. For devices that define right and up.
 */
void haptic_clutch_lay(haptic_clutch *clutch);
/* Disengages the clutch. The next pose engages it with the tool where it is. */
void haptic_clutch_release(haptic_clutch *clutch);
/* Disengages the clutch and sets the tool's pose. */
void haptic_clutch_engage_at(haptic_clutch *clutch, const ost_pose *tool);
/*
 * Returns the tool's pose for a body at `at` (m) with orientation q (length 1), engaging the
 * clutch if necessary. Returns an invalid pose if a value is not finite or is too far away.
 */
ost_pose haptic_clutch_pose(haptic_clutch *clutch, const double at[3], const double q[4]);
/* Like haptic_clutch_pose, with the body's pose given in the bone's frame. */
ost_pose haptic_clutch_follow(haptic_clutch *clutch, const ost_pose *body);
/* Rotates a vector, for example a force, from the bone's frame to the body's. */
void haptic_clutch_vector(const haptic_clutch *clutch, const double bone[3], double body[3]);

#endif
