/* SPDX-License-Identifier: Apache-2.0 */
#include "haptics/workspace.h"

#include <math.h>

#include "core/quaternion.h"

#define PM_PER_M (1000.0 * (double)OST_PM_PER_MM)

static void multiply(const double a[3][3], const double b[3][3], double out[3][3])
{
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            out[i][j] = a[i][0] * b[0][j] + a[i][1] * b[1][j] + a[i][2] * b[2][j];
}

haptic_workspace ost_haptic_workspace_make(const ost_pose *start, const int axes[3], double scale)
{
    haptic_workspace w = {
        .scale = scale,
        .at = {(double)start->t.x / PM_PER_M, (double)start->t.y / PM_PER_M, (double)start->t.z / PM_PER_M}};
    double tool[3][3], to_tool[3][3] = {{0}};
    ost_pose_matrix(start, tool);
    for (int i = 0; i < 3; i++) {
        to_tool[i][axes[i]] = 1;
        w.identity[axes[i]][i] = 1;
    }
    multiply(tool, to_tool, w.turn);
    return w;
}

void ost_haptic_pose_to_metres(const ost_pose *pose, double at[3], double q[4])
{
    ost_pose_to_doubles(pose, at, q);
    ost_quaternion_unit(q);
    for (int i = 0; i < 3; i++)
        at[i] *= 1e-3;
}

/* A pose whose quaternion is zero is invalid; callers treat it as a fault. */
static const ost_pose NO_POSE;

static bool quantise(double value, double unit, double most, int64_t *out)
{
    const double v = value * unit;
    if (!(fabs(v) <= most))
        return false;
    *out = (int64_t)rint(v);
    return true;
}

ost_pose ost_haptic_pose_quantise(const double at[3], const double q[4])
{
    int64_t t[3], r[4];
    for (int i = 0; i < 3; i++)
        if (!quantise(at[i], PM_PER_M, (double)OST_LENGTH_MAX, &t[i]))
            return NO_POSE;
    for (int i = 0; i < 4; i++)
        if (!quantise(q[i], OST_Q30_ONE, 1.001 * OST_Q30_ONE, &r[i]))
            return NO_POSE;
    return (ost_pose){{t[0], t[1], t[2]}, (int32_t)r[0], (int32_t)r[1], (int32_t)r[2], (int32_t)r[3]};
}

ost_pose ost_haptic_workspace_pose(const haptic_workspace *w, const double position[3], const double frame[3][3])
{
    double turned[3][3], m[3][3], columns[3][3], at[3], q[4];
    multiply(w->turn, frame, turned);
    multiply(turned, w->identity, m);
    for (int i = 0; i < 3; i++) {
        const double moved = w->turn[i][0] * position[0] + w->turn[i][1] * position[1] + w->turn[i][2] * position[2];
        at[i] = w->at[i] + w->scale * moved;
        for (int j = 0; j < 3; j++)
            columns[j][i] = m[i][j];
    }
    ost_quaternion_of_columns(columns, q);
    return ost_haptic_pose_quantise(at, q);
}

void ost_haptic_workspace_vector(const haptic_workspace *w, const double bone[3], double device[3])
{
    for (int i = 0; i < 3; i++)
        device[i] = w->turn[0][i] * bone[0] + w->turn[1][i] * bone[1] + w->turn[2][i] * bone[2];
}
