/* SPDX-License-Identifier: Apache-2.0 */
/* Prints the progress and the recorder's state on a thread of normal priority while the servo thread runs. */
#ifndef OST_APP_SIM_WATCH_H
#define OST_APP_SIM_WATCH_H

#include "app/common/app.h"

typedef struct sim_watch sim_watch;

/* Starts the thread. recorder may be NULL; capacity is that of its ring, in records. name, app and
   recorder must outlive the watch. seconds: the expected duration, 0 if unknown. */
ost_status sim_watch_begin(const app_state *app, ost_recorder *recorder, const char *name, uint64_t capacity,
                           double seconds, sim_watch **out, ost_error *err);
/* Stops the thread, waits until it has ended, and frees watch, which may be NULL. */
void sim_watch_end(sim_watch *watch);

#endif
