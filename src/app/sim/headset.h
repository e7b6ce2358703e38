/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Shows an operation in a headset, and passes the controller's pose to the device `openxr`.
 *
 *   headset's thread: frames for two eyes, controller       main thread: servo loop
 *                     |--ost_hand_input_put--------------------> openxr
 *                     '<------------------- ost_live_channel --- operation
 */
#ifndef OST_APP_SIM_HEADSET_H
#define OST_APP_SIM_HEADSET_H

#include "app/sim/show.h"
#include "haptics/hand.h"

typedef struct sim_headset sim_headset;

/* Finds the headset and sets s->headset. Called first, because the other preparations take seconds. */
ost_status sim_headset_open(const sim_args *args, simulation *s, ost_error *err);
/* Closes the headset. The device must be closed first. `headset` may be NULL. */
void sim_headset_close(sim_headset *headset);
ost_hand_input *sim_headset_hand(const simulation *s); /* NULL without a headset */

/*
 * Starts the thread that draws frames. If the headset or its runtime ends, the servo loop ends as if the user had ended
 * it; the operation is reported and saved, and sim_headset_end returns the reason.
 */
ost_status sim_headset_start(simulation *s, ost_error *err);
/* Waits for the thread and ends the session. Must be called after the servo loop has ended. */
void sim_headset_stop(simulation *s);
void sim_headset_report(const app_state *app, const simulation *s);
ost_status sim_headset_end(const simulation *s, ost_error *err);

#endif
