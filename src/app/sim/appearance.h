/* SPDX-License-Identifier: Apache-2.0 */
/* Sets the appearance of everything in a simulation's frames except bone and tool (app/picture/appearance.h). */
#ifndef OST_APP_SIM_APPEARANCE_H
#define OST_APP_SIM_APPEARANCE_H

#include "app/sim/show.h"

/* Stores the current bone as the uncut bone. Must be called before the ticks of a resumed session are run. */
ost_status sim_appearance_store_uncut(const sim_args *args, simulation *s, ost_error *err);
/*
 * Applies the appearance. The viewer, the subject and the orbit of the show must be set. `glenoid` is NULL if it is
 * not known.
 */
ost_status sim_appearance_make(const sim_args *args, simulation *s, const ost_glenoid *glenoid, ost_error *err);
void sim_appearance_free(sim_show *show);
/* Computes the position of the camera, in mm. */
void sim_appearance_eye(const sim_show *show, double eye_mm[3]);

#endif
