/* SPDX-License-Identifier: Apache-2.0 */
#include "app/sim/camera.h"

#include <math.h>

static const double FLIGHT_S = 0.35, PI = 3.141592653589793;
/*
 * The effect of holding a key for one second. PAN_KEY and TURN_KEY are in picture heights, and NEAR_KEY is in steps of
 * the mouse wheel.
 */
static const double PAN_KEY = 0.45, TURN_KEY = 0.36, NEAR_KEY = 12;

sim_camera sim_camera_at(ost_view_name view, const ost_view_subject *subject, double voxel_mm)
{
    /* Limits of the camera's distance, in voxels and in mm. The renderer's limits are greater: 2^15 voxels, 8000 mm. */
    const double voxels = 8192, most = 1500;
    return (sim_camera){.orbit = ost_view_orbit(view, subject, NULL), .subject = *subject, .home = view,
                        .farthest = fmin(most, fmax(2 * subject->size, voxels * voxel_mm))};
}

/*
 * Limits the distance of the camera from its target, and of the target from the subject. Otherwise, a drag in a window
 * of a few pixels would move the camera very far.
 */
static void clamp(sim_camera *camera)
{
    ost_orbit *o = &camera->orbit;
    double d[3], length = 0;
    for (int a = 0; a < 3; a++) {
        d[a] = o->at[a] - camera->subject.middle[a];
        length += d[a] * d[a];
    }
    length = sqrt(length);
    for (int a = 0; a < 3 && length > camera->farthest; a++)
        o->at[a] = camera->subject.middle[a] + d[a] * camera->farthest / length;
    o->distance = fmin(o->distance, camera->farthest);
}

void sim_camera_fly(sim_camera *camera, ost_view_name view, const ost_pose *tool, double now_s)
{
    camera->from = camera->orbit;
    camera->to = ost_view_orbit(view, &camera->subject, tool);
    /* the camera turns in the direction of the smaller angle */
    camera->from.azimuth = camera->to.azimuth + remainder(camera->from.azimuth - camera->to.azimuth, 2 * PI);
    camera->begin_s = now_s;
    camera->flying = true;
}

void sim_camera_step(sim_camera *camera, double now_s)
{
    const double t = (now_s - camera->begin_s) / FLIGHT_S;
    if (!camera->flying)
        return;
    if (!(t < 1)) {
        camera->orbit = camera->to;
        camera->flying = false;
        return;
    }
    const double s = t > 0 ? t * t * (3 - 2 * t) : 0;
    const ost_orbit *a = &camera->from, *b = &camera->to;
    ost_orbit *o = &camera->orbit;
    o->azimuth = a->azimuth + s * (b->azimuth - a->azimuth);
    o->elevation = a->elevation + s * (b->elevation - a->elevation);
    o->distance = a->distance * pow(b->distance / a->distance, s);
    for (int i = 0; i < 3; i++)
        o->at[i] = a->at[i] + s * (b->at[i] - a->at[i]);
}

void sim_camera_turn(sim_camera *camera, double dx, double dy, int height)
{
    if (dx == 0 && dy == 0)
        return;
    camera->flying = false;
    ost_orbit_turn(&camera->orbit, dx, dy, height);
}

void sim_camera_shift(sim_camera *camera, double dx, double dy, int height)
{
    if (dx == 0 && dy == 0)
        return;
    camera->flying = false;
    ost_orbit_shift(&camera->orbit, dx, dy, height);
    clamp(camera);
}

void sim_camera_near(sim_camera *camera, double steps)
{
    if (steps == 0)
        return;
    camera->flying = false;
    ost_orbit_near(&camera->orbit, steps);
    clamp(camera);
}

void sim_camera_hold(sim_camera *camera, int right, int up, int nearer, bool shift, double dt)
{
    const int height = 1000;
    if (shift)
        sim_camera_shift(camera, -PAN_KEY * dt * height * right, PAN_KEY * dt * height * up, height);
    else
        sim_camera_turn(camera, -TURN_KEY * dt * height * right, TURN_KEY * dt * height * up, height);
    sim_camera_near(camera, NEAR_KEY * dt * nearer);
}
