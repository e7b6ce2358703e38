/* SPDX-License-Identifier: Apache-2.0 */
#include "haptics/clutch.h"

#include <math.h>
#include <string.h>

static void product(const double a[4], const double b[4], double out[4])
{
    out[0] = a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3];
    out[1] = a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2];
    out[2] = a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1];
    out[3] = a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0];
}

static void conjugate(const double q[4], double out[4])
{
    out[0] = q[0];
    for (int i = 1; i < 4; i++)
        out[i] = -q[i];
}

static void turn(const double q[4], const double v[3], double out[3])
{
    const double pure[4] = {0, v[0], v[1], v[2]};
    double back[4], half[4], full[4];
    conjugate(q, back);
    product(q, pure, half);
    product(half, back, full);
    memcpy(out, full + 1, 3 * sizeof *out);
}

void haptic_pose_to_metres(const ost_pose *pose, double at[3], double q[4])
{
    ost_pose_to_doubles(pose, at, q);
    double length = 0;
    for (int i = 0; i < 4; i++)
        length += q[i] * q[i];
    for (int i = 0; i < 4; i++)
        q[i] /= sqrt(length);
    for (int i = 0; i < 3; i++)
        at[i] *= 1e-3;
}

haptic_clutch haptic_clutch_make(const ost_pose *start, double scale)
{
    haptic_clutch c = {.scale = scale, .world = {1, 0, 0, 0}};
    haptic_pose_to_metres(start, c.given_at, c.given_q);
    return c;
}

void haptic_clutch_lay(haptic_clutch *c)
{
    memcpy(c->world, c->given_q, sizeof c->world);
    c->laid = true;
}

void haptic_clutch_release(haptic_clutch *c)
{
    c->engaged = false;
}

void haptic_clutch_engage_at(haptic_clutch *c, const ost_pose *tool)
{
    c->engaged = false;
    haptic_pose_to_metres(tool, c->given_at, c->given_q);
}

static void take_hold(haptic_clutch *c, const double at[3], const double q[4])
{
    double back[4];
    conjugate(q, back);
    if (!c->laid)
        product(c->given_q, back, c->world);
    c->laid = c->engaged = true;
    memcpy(c->base_at, c->given_at, sizeof c->base_at);
    memcpy(c->base_q, c->given_q, sizeof c->base_q);
    memcpy(c->from_at, at, sizeof c->from_at);
    memcpy(c->from_q, q, sizeof c->from_q);
}

ost_pose haptic_clutch_pose(haptic_clutch *c, const double at[3], const double q[4])
{
    double moved[3], back[4], a[4], b[4], unworld[4];
    if (!c->engaged)
        take_hold(c, at, q);
    for (int i = 0; i < 3; i++)
        moved[i] = c->scale * (at[i] - c->from_at[i]);
    turn(c->world, moved, moved);
    for (int i = 0; i < 3; i++)
        c->given_at[i] = c->base_at[i] + moved[i];
    /* The tool's orientation is the product world (q from^-1) world^-1 base. */
    conjugate(c->from_q, back);
    product(q, back, a);
    product(c->world, a, b);
    conjugate(c->world, unworld);
    product(b, unworld, a);
    product(a, c->base_q, c->given_q);
    return haptic_pose_quantise(c->given_at, c->given_q);
}

ost_pose haptic_clutch_follow(haptic_clutch *c, const ost_pose *body)
{
    double at[3], q[4];
    haptic_pose_to_metres(body, at, q);
    return haptic_clutch_pose(c, at, q);
}

void haptic_clutch_vector(const haptic_clutch *c, const double bone[3], double body[3])
{
    double back[4];
    conjugate(c->world, back);
    turn(back, bone, body);
}
