/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Where a device's hand is in the bone's frame.
 *
 *   device's frame --axes--> a tool's frame: x right, y up, z toward who holds it
 *                  --start, scale--> the bone's frame
 *
 * With the handle at its centre and upright the tool is at `start`; pushed
 * away from who holds it, it goes along its own -z, the way it works.
 */
#ifndef OST_HAPTICS_WORKSPACE_H
#define OST_HAPTICS_WORKSPACE_H

#include <osteon/haptics.h>

typedef struct haptic_workspace {
    double at[3];          /* of start, m */
    double turn[3][3];     /* [row][column]: device's frame to the bone's */
    double rest[3][3];     /* of the tool as the device holds it: device's frame to the tool's, inverted */
    double scale;          /* metres of bone a metre of device */
} haptic_workspace;

/* axes[i]: which of the device's axes (0 x, 1 y, 2 z) is the tool's axis i; together a right-handed frame. */
haptic_workspace haptic_workspace_make(const ost_pose *start, const int axes[3], double scale);

/* position in m, frame[row][column] takes the handle's frame to the device's. A pose that is none when one of them is no number or far away. */
ost_pose haptic_workspace_pose(const haptic_workspace *workspace, const double position[3], const double frame[3][3]);

/* m and w x y z as a pose of integers; none when one of them is no number or far away. */
ost_pose haptic_pose_quantise(const double at[3], const double q[4]);

/* A vector of the bone's frame in the device's: forces and torques. */
void haptic_workspace_vector(const haptic_workspace *workspace, const double bone[3], double device[3]);

#endif
