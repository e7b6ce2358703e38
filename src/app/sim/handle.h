/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The simulated hand that a mouse moves. The struct contains the hand's target pose in the bone's frame. Directions
 * refer to the picture: right, up, and back towards the camera.
 */
#ifndef OST_APP_SIM_HANDLE_H
#define OST_APP_SIM_HANDLE_H

#include <osteon/haptics.h>

#include "render/views.h"

typedef struct sim_handle {
    double at[3]; /* position in mm */
    double q[4];  /* orientation, a unit quaternion w x y z */
    int32_t tool;
    bool pedal;
} sim_handle;

sim_handle sim_handle_at(const ost_pose *pose, int32_t tool);
/* Moves the hand at its current depth. dx and dy are in pixels of a picture that is `height` pixels high. */
void sim_handle_drag(sim_handle *handle, const ost_orbit *orbit, double dx, double dy, int height);
/* Turns the hand about the picture's up and right directions. dx and dy are in picture pixels. */
void sim_handle_turn(sim_handle *handle, const ost_orbit *orbit, double dx, double dy);
/* Rotates the hand about the tool's axis by an angle in radians. */
void sim_handle_twist(sim_handle *handle, double angle);
/* Moves the hand along the tool's axis by a length in mm; positive values move it towards the bone. */
void sim_handle_push(sim_handle *handle, double mm);
/*
 * Stores in *out the state that a device with the pose of the hand would report. Returns false if the pose is out of
 * range.
 */
bool sim_handle_state(const sim_handle *handle, ost_haptic_state *out);

#endif
