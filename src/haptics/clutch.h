/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A clutch between a body that is seen somewhere and a tool that is somewhere
 * else.
 *
 *   seen     from ----> at          tool     given ----> given + world (at - from)
 *
 * When it takes hold the tool stays where it is, and from there on goes as the
 * body goes.  At its first hold the body's axes are laid on the tool's, and
 * that is kept: after the second, right is still right.
 */
#ifndef OST_HAPTICS_CLUTCH_H
#define OST_HAPTICS_CLUTCH_H

#include "haptics/workspace.h"

typedef struct haptic_clutch {
    double scale;                    /* metres of tool a metre of body */
    double given_at[3], given_q[4];  /* of the tool, last: m and w x y z, in the bone's frame */
    double base_at[3], base_q[4];    /* of the tool when it took hold */
    double from_at[3], from_q[4];    /* of the body then */
    double world[4];                 /* turns the body's frame into the bone's */
    bool held, laid;
} haptic_clutch;

/* Writes a pose as metres and a quaternion of length 1. */
void haptic_pose_to_metres(const ost_pose *pose, double at[3], double q[4]);

haptic_clutch haptic_clutch_make(const ost_pose *start, double scale);
/* The body's frame is the tool's at the start, however the body lies when it is first seen: for devices with a right and an up. */
void haptic_clutch_lay(haptic_clutch *clutch);
/* The next pose takes hold where the tool is. */
void haptic_clutch_release(haptic_clutch *clutch);
/* The same, and the tool is elsewhere. */
void haptic_clutch_place(haptic_clutch *clutch, const ost_pose *tool);
/* at in m, q of length 1: where the tool is now; none when that is no pose. */
ost_pose haptic_clutch_pose(haptic_clutch *clutch, const double at[3], const double q[4]);
/* The same with the body's pose in the bone's frame. */
ost_pose haptic_clutch_follow(haptic_clutch *clutch, const ost_pose *body);
/* A vector of the bone's frame in the body's: forces. */
void haptic_clutch_vector(const haptic_clutch *clutch, const double bone[3], double body[3]);

#endif
