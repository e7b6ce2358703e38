/* SPDX-License-Identifier: Apache-2.0 */
#include "app/sim/handle.h"

#include <math.h>
#include <string.h>

#include "core/quaternion.h"

static const double A_PIXEL = 0.006; /* rotation in radians per pixel */

sim_handle sim_handle_at(const ost_pose *pose, int32_t tool)
{
    sim_handle handle = {.tool = tool};
    ost_pose_to_doubles(pose, handle.at, handle.q);
    ost_quaternion_unit(handle.q);
    return handle;
}

void sim_handle_drag(sim_handle *handle, const ost_orbit *orbit, double dx, double dy, int height)
{
    double right[3], up[3], back[3], depth = orbit->distance;
    ost_orbit_frame(orbit, right, up, back);
    for (int a = 0; a < 3; a++)
        depth -= (handle->at[a] - orbit->at[a]) * back[a];
    const double mm = fmax(depth, 1) / (OST_VIEW_FOCAL * height);
    for (int a = 0; a < 3; a++)
        handle->at[a] += mm * (dx * right[a] - dy * up[a]);
}

static void turn_about(sim_handle *handle, const double axis[3], double angle)
{
    const double s = sin(angle / 2), turn[4] = {cos(angle / 2), s * axis[0], s * axis[1], s * axis[2]};
    ost_quaternion_product(turn, handle->q, handle->q);
    ost_quaternion_unit(handle->q);
}

void sim_handle_turn(sim_handle *handle, const ost_orbit *orbit, double dx, double dy)
{
    double right[3], up[3], back[3];
    ost_orbit_frame(orbit, right, up, back);
    turn_about(handle, up, A_PIXEL * dx);
    turn_about(handle, right, A_PIXEL * dy);
}

void sim_handle_twist(sim_handle *handle, double angle)
{
    const double turn[4] = {cos(angle / 2), 0, 0, sin(angle / 2)};
    ost_quaternion_product(handle->q, turn, handle->q);
    ost_quaternion_unit(handle->q);
}

/* Computes the direction in which the tool works, as a unit vector. */
static void working_direction(const sim_handle *handle, double axis[3])
{
    const double w = handle->q[0], x = handle->q[1], y = handle->q[2], z = handle->q[3];
    axis[0] = -2 * (x * z + w * y);
    axis[1] = -2 * (y * z - w * x);
    axis[2] = -(w * w - x * x - y * y + z * z);
}

void sim_handle_push(sim_handle *handle, double mm)
{
    double axis[3];
    working_direction(handle, axis);
    for (int a = 0; a < 3; a++)
        handle->at[a] += mm * axis[a];
}

bool sim_handle_state(const sim_handle *handle, ost_haptic_state *out)
{
    *out = (ost_haptic_state){.tool = handle->tool, .buttons = handle->pedal ? OST_MOUSE_PEDAL : 0};
    return ost_pose_from_doubles(handle->at, handle->q, &out->pose, NULL) == OST_OK;
}
