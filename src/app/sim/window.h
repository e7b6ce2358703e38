/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The simulator's window. It shows frames and the HUD, controls the camera, and moves the simulated hand of the
 * device `mouse`.
 *
 *   main thread: window, events, hand, frames          second thread: servo loop
 *                     |--ost_mouse_input_put------------------> mouse
 *                     '<------------------- ost_live_channel --- operation
 */
#ifndef OST_APP_SIM_WINDOW_H
#define OST_APP_SIM_WINDOW_H

#include "app/sim/show.h"

typedef struct sim_window sim_window;

/* Opens s->window. Called before everything else, because loading the bone takes seconds. */
ost_status sim_window_open(const app_state *app, const sim_args *args, simulation *s, ost_error *err);
void sim_window_close(sim_window *window); /* window may be NULL */

/*
 * Creates the input of the device `mouse`, with the initial pose of the hand. Must be called before the device is
 * opened.
 */
ost_status sim_window_mouse_create(simulation *s, const ost_pose *start, ost_error *err);
/* Returns the input of the device `mouse`; NULL with any other device. */
ost_mouse_input *sim_window_mouse(const simulation *s);

/*
 * Runs the servo loop on a separate thread and the window on the calling thread, until one of the two ends. If the
 * window is lost, the loop ends as if the user had ended it; the operation is reported and saved, and sim_window_end
 * returns the reason.
 */
ost_status sim_window_run(simulation *s, const ost_servo_options *how, ost_servo_tick *tick, ost_error *err);
ost_status sim_window_end(const simulation *s, ost_error *err);

#endif
