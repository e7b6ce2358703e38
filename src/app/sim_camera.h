/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The camera of a window, as people know it from 3D programs: views by name,
 * to which it flies in a moment, and by hand from there.
 */
#ifndef OST_APP_SIM_CAMERA_H
#define OST_APP_SIM_CAMERA_H

#include "render/views.h"

typedef struct sim_camera {
    ost_orbit orbit;       /* now */
    ost_orbit from, to;    /* of the flight */
    double begin_s;
    bool flying;
    ost_view_subject subject;
    ost_view_name home;    /* where it began */
    double farthest;       /* mm, from what it looks at; that stays as near to the subject's middle */
} sim_camera;

/* voxel_mm: the smallest that is drawn, of which a frame takes no more than so many from the eye. */
sim_camera sim_camera_at(ost_view_name view, const ost_view_subject *subject, double voxel_mm);
/* tool: its pose, or NULL. */
void sim_camera_fly(sim_camera *camera, ost_view_name view, const ost_pose *tool, double now_s);
/* To where the flight is by now. */
void sim_camera_step(sim_camera *camera, double now_s);

/* By pixels of a picture so high, and by steps of a wheel; a flight ends where it is. */
void sim_camera_turn(sim_camera *camera, double dx, double dy, int height);
void sim_camera_shift(sim_camera *camera, double dx, double dy, int height);
void sim_camera_near(sim_camera *camera, double steps);
/* Keys that are down for so long: -1, 0 or 1 to the right, up and nearer. */
void sim_camera_hold(sim_camera *camera, int right, int up, int nearer, bool shift, double dt);

#endif
