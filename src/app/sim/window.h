/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The simulator's window: frames and the HUD, the camera, and the simulated hand of the device
 * mouse.
 *
 *   main thread: window, events, hand, frames          second thread: servo loop
 *                     |--ost_mouse_input_put------------------> mouse
 *                     '<------------------- ost_live_channel --- operation
 */
#ifndef OST_APP_SIM_WINDOW_H
#define OST_APP_SIM_WINDOW_H

#include "app/sim/show.h"

typedef struct sim_window sim_window;

/* Opens s->window. Called first, because all other preparation takes seconds. */
ost_status sim_window_open(const app_state *app, const sim_args *args, simulation *s, ost_error *err);
void sim_window_close(sim_window *window); /* window may be NULL */

/* Creates the device mouse's input with the hand's initial pose. Must be called before the device is opened. */
ost_status sim_window_mouse_create(simulation *s, const ost_pose *start, ost_error *err);
ost_mouse_input *sim_window_mouse(const simulation *s);    /* NULL if another device is used */

/*
 * Runs the servo loop on a separate thread and the window on the calling thread, until either of
 * them ends. If the window is lost, the loop ends as if the user had ended it, and the operation is
 * reported and saved. sim_window_end then returns the reason.
 */
ost_status sim_window_run(simulation *s, const ost_servo_options *how, ost_servo_tick *tick, ost_error *err);
ost_status sim_window_end(const simulation *s, ost_error *err);

#endif
