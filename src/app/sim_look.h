/* SPDX-License-Identifier: Apache-2.0 */
/* What a simulation's frames show besides bone and tool (appearance.h). */
#ifndef OST_APP_SIM_LOOK_H
#define OST_APP_SIM_LOOK_H

#include "app/sim_show.h"

/* The bone as it is now is what was there before anything was cut: to be called before a resumed session's ticks. */
ost_status sim_look_remember(const sim_args *args, simulation *s, ost_error *err);
/* show has its viewer, subject and orbit; glenoid NULL: none is known. */
ost_status sim_look_make(const sim_args *args, simulation *s, const ost_glenoid *glenoid, ost_error *err);
void sim_look_free(sim_show *show);
/* Where the camera is. */
void sim_look_eye(const sim_show *show, double eye_mm[3]);

#endif
