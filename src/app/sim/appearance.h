/* SPDX-License-Identifier: Apache-2.0 */
/* The appearance of a simulation's frames besides bone and tool (appearance.h). */
#ifndef OST_APP_SIM_APPEARANCE_H
#define OST_APP_SIM_APPEARANCE_H

#include "app/sim/show.h"

/* Stores the current bone as the uncut one. Must be called before a resumed session's ticks. */
ost_status sim_appearance_store_uncut(const sim_args *args, simulation *s, ost_error *err);
/* Applies the appearance. The viewer, subject and orbit of the show must be set. glenoid: NULL if
   it is not known. */
ost_status sim_appearance_make(const sim_args *args, simulation *s, const ost_glenoid *glenoid, ost_error *err);
void sim_appearance_free(sim_show *show);
/* Computes the camera's position. */
void sim_appearance_eye(const sim_show *show, double eye_mm[3]);

#endif
