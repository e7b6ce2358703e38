/* SPDX-License-Identifier: Apache-2.0 */
#include "validation/dense/steps.h"

/* Returns the dot product of the quaternions of two poses, the P of AR-SWEEP-3. */
static wide dot(const ost_pose *a, const ost_pose *b)
{
    const int32_t p[4] = {a->qw, a->qx, a->qy, a->qz}, q[4] = {b->qw, b->qx, b->qy, b->qz};
    wide sum = wide_of(0);
    for (int c = 0; c < 4; c++)
        sum = wide_plus(sum, wide_times(wide_of(p[c]), wide_of(q[c])));
    return sum;
}

/* Computes the position of a corner of the tool's grid at a pose (AR-SWEEP-1). Bit a of `which` is 0 for the near
   end of axis a and 1 for the far end. */
static void image(const ost_pose *pose, const ost_tool_geometry *tool, int which, wide out[3])
{
    const ost_pm near[3] = {tool->corner.x, tool->corner.y, tool->corner.z}, t[3] = {pose->t.x, pose->t.y, pose->t.z};
    const int32_t dims[3] = {tool->dims.x, tool->dims.y, tool->dims.z};
    wide corner[3], turned[3];
    for (int a = 0; a < 3; a++)
        corner[a] = wide_plus(wide_of(near[a]),
                              which >> a & 1 ? wide_times(wide_of(dims[a]), wide_of(tool->voxel)) : wide_of(0));
    steps_turn(pose, false, corner, turned);
    for (int a = 0; a < 3; a++)
        out[a] = wide_plus(wide_nearest(turned[a], steps_norm(pose)), wide_of(t[a]));
}

static wide greatest_way_squared(const ost_pose *a, const ost_pose *b, const ost_tool_geometry *tool)
{
    wide greatest = wide_of(0);
    for (int which = 0; which < 8; which++) {
        wide from[3], to[3], sum = wide_of(0);
        image(a, tool, which, from);
        image(b, tool, which, to);
        for (int axis = 0; axis < 3; axis++) {
            const wide d = wide_minus(to[axis], from[axis]);
            sum = wide_plus(sum, wide_times(d, d));
        }
        if (wide_order(sum, greatest) > 0)
            greatest = sum;
    }
    return greatest;
}

/* Returns true if n poses are sufficient: 4 |d|^2 <= n^2 s^2. d is the motion, way_squared is |d|^2, and s is the
   bone's spacing. */
static bool enough(int n, wide way_squared, ost_pm s)
{
    const wide reach = wide_times(wide_of(n), wide_of(s));
    return wide_order(wide_times(wide_of(4), way_squared), wide_times(reach, reach)) <= 0;
}

int steps_sweep_count(const ost_pose *a, const ost_pose *b, const ost_tool_geometry *tool, ost_pm bone_voxel)
{
    enum { MOST = 4096 };
    const wide p = dot(a, b);
    if (wide_order(wide_times(wide_of(2), wide_times(p, p)), wide_times(steps_norm(a), steps_norm(b))) < 0)
        return 0;
    const wide way_squared = greatest_way_squared(a, b, tool);
    if (!enough(MOST, way_squared, bone_voxel))
        return 0;
    /* In each step of the bisection, n poses are sufficient, and `short_of` poses are not sufficient. */
    int short_of = 0, n = MOST;
    while (n - short_of > 1) {
        const int middle = (short_of + n) / 2;
        *(enough(middle, way_squared, bone_voxel) ? &n : &short_of) = middle;
    }
    return n;
}

static int64_t between(int64_t a, int64_t b, int k, int n)
{
    return wide_to_int64(wide_nearest(
        wide_plus(wide_times(wide_of(n - k), wide_of(a)), wide_times(wide_of(k), wide_of(b))), wide_of(n)));
}

ost_pose steps_sweep_pose(const ost_pose *a, const ost_pose *b, int k, int n)
{
    const int64_t sign = dot(a, b).negative ? -1 : 1;
    return (ost_pose){
        .t = {between(a->t.x, b->t.x, k, n), between(a->t.y, b->t.y, k, n), between(a->t.z, b->t.z, k, n)},
        .qw = (int32_t)between(a->qw, sign * b->qw, k, n),
        .qx = (int32_t)between(a->qx, sign * b->qx, k, n),
        .qy = (int32_t)between(a->qy, sign * b->qy, k, n),
        .qz = (int32_t)between(a->qz, sign * b->qz, k, n)};
}
