/* SPDX-License-Identifier: Apache-2.0 */
#include "haptics/clutch.h"

#include <string.h>

#include "core/quaternion.h"

haptic_clutch ost_haptic_clutch_make(const ost_pose *start, double scale)
{
    haptic_clutch c = {.scale = scale, .world = {1, 0, 0, 0}};
    ost_haptic_pose_to_metres(start, c.given_at, c.given_q);
    return c;
}

void ost_haptic_clutch_lay(haptic_clutch *c)
{
    memcpy(c->world, c->given_q, sizeof c->world);
    c->laid = true;
}

void ost_haptic_clutch_release(haptic_clutch *c)
{
    c->engaged = false;
}

void ost_haptic_clutch_engage_at(haptic_clutch *c, const ost_pose *tool)
{
    c->engaged = false;
    ost_haptic_pose_to_metres(tool, c->given_at, c->given_q);
}

static void take_hold(haptic_clutch *c, const double at[3], const double q[4])
{
    double back[4];
    ost_quaternion_conjugate(q, back);
    if (!c->laid)
        ost_quaternion_product(c->given_q, back, c->world);
    c->laid = c->engaged = true;
    memcpy(c->base_at, c->given_at, sizeof c->base_at);
    memcpy(c->base_q, c->given_q, sizeof c->base_q);
    memcpy(c->from_at, at, sizeof c->from_at);
    memcpy(c->from_q, q, sizeof c->from_q);
}

ost_pose ost_haptic_clutch_pose(haptic_clutch *c, const double at[3], const double q[4])
{
    double moved[3], back[4], a[4], b[4], unworld[4];
    if (!c->engaged)
        take_hold(c, at, q);
    for (int i = 0; i < 3; i++)
        moved[i] = c->scale * (at[i] - c->from_at[i]);
    ost_quaternion_rotate(c->world, moved, moved);
    for (int i = 0; i < 3; i++)
        c->given_at[i] = c->base_at[i] + moved[i];
    /* orientation of the tool = world * (q * from^-1) * world^-1 * base */
    ost_quaternion_conjugate(c->from_q, back);
    ost_quaternion_product(q, back, a);
    ost_quaternion_product(c->world, a, b);
    ost_quaternion_conjugate(c->world, unworld);
    ost_quaternion_product(b, unworld, a);
    ost_quaternion_product(a, c->base_q, c->given_q);
    return ost_haptic_pose_quantise(c->given_at, c->given_q);
}

ost_pose ost_haptic_clutch_follow(haptic_clutch *c, const ost_pose *body)
{
    double at[3], q[4];
    ost_haptic_pose_to_metres(body, at, q);
    return ost_haptic_clutch_pose(c, at, q);
}

void ost_haptic_clutch_vector(const haptic_clutch *c, const double bone[3], double body[3])
{
    double back[4];
    ost_quaternion_conjugate(c->world, back);
    ost_quaternion_rotate(back, bone, body);
}
