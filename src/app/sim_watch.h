/* SPDX-License-Identifier: Apache-2.0 */
/* While the servo's thread works: a plain one that tells people how far it is and how its recorder does. */
#ifndef OST_APP_SIM_WATCH_H
#define OST_APP_SIM_WATCH_H

#include "app/app.h"

typedef struct sim_watch sim_watch;

/* recorder may be NULL; room is its; name, app and recorder outlive the watch. seconds: how long it will take, 0 when nobody knows. */
ost_status sim_watch_begin(const app_state *app, ost_recorder *recorder, const char *name, uint64_t room, double seconds, sim_watch **out,
                           ost_error *err);
/* Waits for its thread; NULL is allowed. */
void sim_watch_end(sim_watch *watch);

#endif
