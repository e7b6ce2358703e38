/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The hand that a mouse moves: where it is to be, in the bone's frame.
 * Directions are those of the picture: right, up, and back toward who looks.
 */
#ifndef OST_APP_SIM_HAND_H
#define OST_APP_SIM_HAND_H

#include <osteon/haptics.h>

#include "render/views.h"

typedef struct sim_hand {
    double at[3]; /* mm */
    double q[4];  /* unit: w x y z */
    int32_t tool;
    bool pedal;
} sim_hand;

sim_hand sim_hand_at(const ost_pose *pose, int32_t tool);
/* By pixels, at the depth where it is. */
void sim_hand_drag(sim_hand *hand, const ost_orbit *orbit, double dx, double dy, int height);
/* Turned by pixels, about the picture's up and right. */
void sim_hand_turn(sim_hand *hand, const ost_orbit *orbit, double dx, double dy);
/* About its own axis, in radians. */
void sim_hand_twist(sim_hand *hand, double angle);
/* Along its own axis, the way it works, in mm. */
void sim_hand_push(sim_hand *hand, double mm);
/* Its axis, the way it works; a unit vector. */
void sim_hand_axis(const sim_hand *hand, double axis[3]);
/* What a device is given; false when that is beyond what poses can be. */
bool sim_hand_state(const sim_hand *hand, ost_haptic_state *out);

#endif
