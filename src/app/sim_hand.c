/* SPDX-License-Identifier: Apache-2.0 */
#include "app/sim_hand.h"

#include <math.h>
#include <string.h>

static const double A_PIXEL = 0.006; /* radians */

sim_hand sim_hand_at(const ost_pose *pose, int32_t tool)
{
    sim_hand hand = {.tool = tool};
    double n = 0;
    ost_pose_to_doubles(pose, hand.at, hand.q);
    for (int i = 0; i < 4; i++)
        n += hand.q[i] * hand.q[i];
    for (int i = 0; i < 4; i++)
        hand.q[i] /= sqrt(n);
    return hand;
}

void sim_hand_drag(sim_hand *hand, const ost_orbit *orbit, double dx, double dy, int height)
{
    double right[3], up[3], back[3], depth = orbit->distance;
    ost_orbit_frame(orbit, right, up, back);
    for (int a = 0; a < 3; a++)
        depth -= (hand->at[a] - orbit->at[a]) * back[a];
    const double mm = fmax(depth, 1) / (OST_VIEW_FOCAL * height);
    for (int a = 0; a < 3; a++)
        hand->at[a] += mm * (dx * right[a] - dy * up[a]);
}

static void multiply(const double a[4], const double b[4], double out[4])
{
    const double r[4] = {a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3], a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
                         a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1], a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0]};
    double n = 0;
    for (int i = 0; i < 4; i++)
        n += r[i] * r[i];
    for (int i = 0; i < 4; i++)
        out[i] = r[i] / sqrt(n);
}

static void turn_about(sim_hand *hand, const double axis[3], double angle)
{
    const double s = sin(angle / 2), turn[4] = {cos(angle / 2), s * axis[0], s * axis[1], s * axis[2]};
    multiply(turn, hand->q, hand->q);
}

void sim_hand_turn(sim_hand *hand, const ost_orbit *orbit, double dx, double dy)
{
    double right[3], up[3], back[3];
    ost_orbit_frame(orbit, right, up, back);
    turn_about(hand, up, A_PIXEL * dx);
    turn_about(hand, right, A_PIXEL * dy);
}

void sim_hand_twist(sim_hand *hand, double angle)
{
    const double turn[4] = {cos(angle / 2), 0, 0, sin(angle / 2)};
    multiply(hand->q, turn, hand->q);
}

void sim_hand_axis(const sim_hand *hand, double axis[3])
{
    const double w = hand->q[0], x = hand->q[1], y = hand->q[2], z = hand->q[3];
    axis[0] = -2 * (x * z + w * y);
    axis[1] = -2 * (y * z - w * x);
    axis[2] = -(w * w - x * x - y * y + z * z);
}

void sim_hand_push(sim_hand *hand, double mm)
{
    double axis[3];
    sim_hand_axis(hand, axis);
    for (int a = 0; a < 3; a++)
        hand->at[a] += mm * axis[a];
}

bool sim_hand_state(const sim_hand *hand, ost_haptic_state *out)
{
    *out = (ost_haptic_state){.tool = hand->tool, .buttons = hand->pedal ? OST_MOUSE_PEDAL : 0};
    return ost_pose_from_doubles(hand->at, hand->q, &out->pose, NULL) == OST_OK;
}
