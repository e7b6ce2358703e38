/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The camera of a window, with the usual controls of 3D programs. The camera moves freely, or flies within a short time
 * to a named view.
 */
#ifndef OST_APP_SIM_CAMERA_H
#define OST_APP_SIM_CAMERA_H

#include "render/views.h"

typedef struct sim_camera {
    ost_orbit orbit;
    ost_orbit from, to;    /* start and end of the flight */
    double begin_s;
    bool flying;
    ost_view_subject subject;
    ost_view_name home;    /* name of the initial view */
    /*
     * Maximum distance in mm between the camera and its target, and between the target and the middle of the subject.
     */
    double farthest;
} sim_camera;

/*
 * Makes a camera. voxel_mm is the size of the smallest voxel that is drawn. The renderer limits the camera's distance
 * to a number of voxels, so this size determines the maximum distance in mm.
 */
sim_camera sim_camera_at(ost_view_name view, const ost_view_subject *subject, double voxel_mm);
/* Begins a flight to a view. `tool` is the pose of the tool, or NULL. */
void sim_camera_fly(sim_camera *camera, ost_view_name view, const ost_pose *tool, double now_s);
/* Advances the flight to the time now_s. Does nothing if the camera is not in flight. */
void sim_camera_step(sim_camera *camera, double now_s);

/*
 * The following functions move the camera by pixels of a picture with the given height, or by steps of the mouse wheel.
 * If the camera is in flight, the flight ends at the current position.
 */
void sim_camera_turn(sim_camera *camera, double dx, double dy, int height);
void sim_camera_shift(sim_camera *camera, double dx, double dy, int height);
void sim_camera_near(sim_camera *camera, double steps);
/* Moves the camera according to the keys that are held, for dt seconds. `right`, `up` and `nearer` are -1, 0 or 1. */
void sim_camera_hold(sim_camera *camera, int right, int up, int nearer, bool shift, double dt);

#endif
