/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The simulator's window: frames and what is written over them, the camera,
 * and the hand of the device mouse.
 *
 *   main thread: window, events, hand, frames          another: the loop
 *                     |--ost_hand_put------------------> mouse
 *                     '<------------------- ost_live --- operation
 */
#ifndef OST_APP_SIM_WINDOW_H
#define OST_APP_SIM_WINDOW_H

#include "app/sim_show.h"

typedef struct sim_window sim_window;

/* Into s->window; at once, since all else takes seconds. */
ost_status sim_window_open(const app_state *app, const sim_args *args, simulation *s, ost_error *err);
void sim_window_close(sim_window *window); /* NULL is allowed */

/* Where the hand begins: for the device mouse, and to be called before it is opened. */
ost_status sim_window_hand(simulation *s, const ost_pose *start, ost_error *err);
ost_hand *sim_window_hand_get(const simulation *s); /* NULL: none */

/*
 * The loop by a thread of its own, the window by this one, until one of them ends.  A window that is lost ends the loop as
 * a user's wish does, and what was done is reported and saved; sim_window_end says afterwards what it was.
 */
ost_status sim_window_serve(simulation *s, const ost_servo_options *how, ost_servo_tick *tick, ost_error *err);
ost_status sim_window_end(const simulation *s, ost_error *err);

#endif
