/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Maps a device's handle into the bone's frame.
 *
 *   device's frame --axes--> a tool's frame: x right, y up, z toward the operator
 *                  --start, scale--> the bone's frame
 *
 * When the handle is centred and upright, the tool has its start pose. Pushing the handle away from
 * the operator moves the tool along the tool's -z, its working direction.
 */
#ifndef OST_HAPTICS_WORKSPACE_H
#define OST_HAPTICS_WORKSPACE_H

#include <osteon/haptics.h>

typedef struct haptic_workspace {
    double at[3];          /* position of the start pose, in metres */
    /* element [row][column] of the rotation from the device's frame to the bone's frame */
    double turn[3][3];
    /* rotation from the tool's frame to the device's frame while the handle is upright */
    double identity[3][3];
    double scale;          /* motion in metres in the bone's frame per metre of motion of the device */
} haptic_workspace;

/*
 * Creates a mapping. axes[i] is the device axis (0 x, 1 y, 2 z) that becomes the tool's axis i. The axes must form a
 * right-handed frame.
 */
haptic_workspace ost_haptic_workspace_make(const ost_pose *start, const int axes[3], double scale);

/*
 * Returns the tool's pose for a handle at `position` (m). The matrix frame[row][column] rotates the handle's frame into
 * the device's frame. Returns an invalid pose if a value is not finite or is too large.
 */
ost_pose ost_haptic_workspace_pose(const haptic_workspace *workspace, const double position[3],
                                   const double frame[3][3]);

/* Converts a pose to metres and a quaternion of length 1. */
void ost_haptic_pose_to_metres(const ost_pose *pose, double at[3], double q[4]);
/* Converts a position in metres and a quaternion w x y z to an integer pose. The result is invalid
   if a value is not finite or is too large. */
ost_pose ost_haptic_pose_quantise(const double at[3], const double q[4]);

/* Rotates a vector, for example a force or torque, from the bone's frame to the device's frame. */
void ost_haptic_workspace_vector(const haptic_workspace *workspace, const double bone[3], double device[3]);

#endif
