/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Prints the progress and the state of the recorder. A thread of normal priority prints them while the servo thread
 * runs.
 */
#ifndef OST_APP_SIM_WATCH_H
#define OST_APP_SIM_WATCH_H

#include "app/common/app.h"

typedef struct sim_watch sim_watch;

/*
 * Starts the thread. `recorder` may be NULL; `capacity` is the number of records in its ring. `name`, `app` and
 * `recorder` must outlive the watch. `seconds` is the expected duration, or 0 if it is unknown.
 */
ost_status sim_watch_begin(const app_state *app, ost_recorder *recorder, const char *name, uint64_t capacity,
                           double seconds, sim_watch **out, ost_error *err);
/* Stops the thread, waits until the thread has ended, and frees `watch`. `watch` may be NULL. */
void sim_watch_end(sim_watch *watch);

#endif
