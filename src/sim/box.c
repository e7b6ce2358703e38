/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Proof that no voxel is missed: A voxel is hit only if the coordinates computed for its centre p are inside the
 * tool's grid. The error of these coordinates is at most 23 / 2^20 of a tool voxel (AR-MAP), so p itself lies in
 * the tool's box, which is the grid inflated by one tool voxel on every side. p also lies in the bone's box, which
 * contains all voxel centres. Therefore no axis separates the boxes, and p lies within the bone-aligned bounds of
 * the tool's box. The test of the axes and the bounds are computed with every rounding on the safe side.
 *
 * All lengths are doubled, so that centres and half extents are integers:
 *
 *   d   twice the vector from the centre of the bone's box to that of the tool's box,
 *       in the bone's frame
 *   b   the full extents of the bone's box (twice the half extents)
 *   e   the full extents of the tool's box
 *   r   RHE(2^30 M / N): the rotation; the error of each entry is at most 1/2
 *
 * Ranges: lengths are within 8 m, so |d|, b, e < 2^46, and |r| <= 2^30.  A product is
 * below 2^76 and a sum of six products below 2^79, far within 128 bits.  Every
 * dividend of a division by N is N times a length, or N 2^30, and below 2^46 N.
 */
#include "sim/box.h"

#include "core/conditions.h"
#include "core/divider.h"
#include "core/rotation.h"

typedef struct pair {
    int64_t d[3], b[3], e[3];
    int64_t r[3][3];
    ost_i128 slack;
} pair;

ost_box ost_box_of_bone(const ost_geometry *g)
{
    return (ost_box){
        .lo = g->origin,
        .hi = {g->origin.x + (g->dims.x - 1) * g->spacing.x, g->origin.y + (g->dims.y - 1) * g->spacing.y,
               g->origin.z + (g->dims.z - 1) * g->spacing.z},
    };
}

ost_box ost_box_of_tool(const ost_tool_geometry *g)
{
    const ost_pm v = g->voxel;
    return (ost_box){
        .lo = {g->corner.x - v, g->corner.y - v, g->corner.z - v},
        .hi = {g->corner.x + (g->dims.x + 1) * v, g->corner.y + (g->dims.y + 1) * v, g->corner.z + (g->dims.z + 1) * v},
    };
}

static int64_t magnitude(int64_t x)
{
    return x < 0 ? -x : x;
}

static ost_i128 magnitude128(ost_i128 x)
{
    return x < 0 ? -x : x;
}

/*
 * Computes twice the centre of the tool's box in the bone's frame. Each component is rounded half to even, so its
 * error is at most 1/2.
 */
static void centre_twice(const ost_box *tool, const ost_rotation *m, const ost_divider *by, const ost_pose *pose,
                         int64_t out[3])
{
    const int64_t c[3] = {tool->lo.x + tool->hi.x, tool->lo.y + tool->hi.y, tool->lo.z + tool->hi.z};
    const int64_t t[3] = {pose->t.x, pose->t.y, pose->t.z};
    for (int i = 0; i < 3; i++) {
        ost_i128 turned = (ost_i128)m->m[i][0] * c[0] + (ost_i128)m->m[i][1] * c[1] + (ost_i128)m->m[i][2] * c[2];
        out[i] = ost_rhe_by(by, turned) + 2 * t[i];
    }
}

static pair pair_of(const ost_box *bone, const ost_box *tool, const ost_pose *pose)
{
    const ost_rotation m = ost_rotation_of(pose);
    const ost_divider by = ost_divider_of(m.n);
    pair p = {
        .b = {bone->hi.x - bone->lo.x, bone->hi.y - bone->lo.y, bone->hi.z - bone->lo.z},
        .e = {tool->hi.x - tool->lo.x, tool->hi.y - tool->lo.y, tool->hi.z - tool->lo.z},
    };
    centre_twice(tool, &m, &by, pose, p.d);
    p.d[0] -= bone->lo.x + bone->hi.x;
    p.d[1] -= bone->lo.y + bone->hi.y;
    p.d[2] -= bone->lo.z + bone->hi.z;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            p.r[i][j] = ost_rhe_by(&by, (ost_i128)m.m[i][j] * (1 << 30));

    /*
     * Each test below compares sums of products of a length and an entry of r. A length occurs at most once in a
     * test, so the error of r contributes at most half the sum of all lengths. The error of d is 1/2 on each
     * axis. It is multiplied by the components of a unit vector, so it contributes at most sqrt(3) / 2 * 2^30
     * plus a few units.
     */
    for (int i = 0; i < 3; i++)
        p.slack += magnitude(p.d[i]) + p.b[i] + p.e[i];
    p.slack += (ost_i128)1 << 30;
    return p;
}

/* Returns true if axis i of the bone separates the boxes. */
static bool bone_axis_separates(const pair *p, int i)
{
    const ost_i128 one = (ost_i128)1 << 30;
    ost_i128 reach = one * p->b[i];
    for (int j = 0; j < 3; j++)
        reach += (ost_i128)magnitude(p->r[i][j]) * p->e[j];
    return one * magnitude(p->d[i]) > reach + p->slack;
}

/* Returns true if axis j of the tool separates the boxes. */
static bool tool_axis_separates(const pair *p, int j)
{
    ost_i128 apart = 0, reach = ((ost_i128)1 << 30) * p->e[j];
    for (int i = 0; i < 3; i++) {
        apart += (ost_i128)p->d[i] * p->r[i][j];
        reach += (ost_i128)magnitude(p->r[i][j]) * p->b[i];
    }
    return magnitude128(apart) > reach + p->slack;
}

/*
 * Returns true if the cross product of axis i of the bone and axis j of the tool separates the boxes. A cross
 * product of zero does not separate the boxes, because 0 > slack is false.
 */
static bool cross_axis_separates(const pair *p, int i, int j)
{
    const int i1 = (i + 1) % 3, i2 = (i + 2) % 3, j1 = (j + 1) % 3, j2 = (j + 2) % 3;
    ost_i128 apart = (ost_i128)p->d[i2] * p->r[i1][j] - (ost_i128)p->d[i1] * p->r[i2][j];
    ost_i128 reach = (ost_i128)p->b[i1] * magnitude(p->r[i2][j]) + (ost_i128)p->b[i2] * magnitude(p->r[i1][j]) +
                     (ost_i128)p->e[j1] * magnitude(p->r[i][j2]) + (ost_i128)p->e[j2] * magnitude(p->r[i][j1]);
    return magnitude128(apart) > reach + p->slack;
}

bool ost_boxes_meet(const ost_box *bone, const ost_box *tool, const ost_pose *pose)
{
    pair p = pair_of(bone, tool, pose);
    for (int i = 0; i < 3; i++)
        if (bone_axis_separates(&p, i) || tool_axis_separates(&p, i))
            return false;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            if (cross_axis_separates(&p, i, j))
                return false;
    return true;
}

bool ost_voxel_box_holds(const ost_voxel_box *box)
{
    return box->lo[0] < box->hi[0] && box->lo[1] < box->hi[1] && box->lo[2] < box->hi[2];
}

static int32_t clamp(int64_t value, int32_t hi)
{
    return (int32_t)(value < 0 ? 0 : value > hi ? hi : value);
}

/*
 * Alg. 2.8 clamps the corners of the tool to the bone's box and computes the bounds of the clamped corners. This
 * function computes the bounds first and then clamps them. The result is the same, because clamping acts on each
 * axis separately and preserves the order. The bounds are computed from the centre and the rotated extents: the
 * extent along bone axis i is sum_j |M[i][j]| e[j] / N, rounded up.
 *
 * Alg. 2.9 then converts the bounds to voxels. In Alg. 2.9 the origin is the centre of the bone's box; here it is the
 * origin of the bone's frame. On each axis, c and h are twice the centre and twice the half extent of the bounds. The
 * error of c is at most 1/2. Therefore, if a voxel centre o + k s satisfies
 *   c - h <= 2 (o + k s) <= c + h,  then
 *   ceil((c - h - 1 - 2o) / 2s) <= k <= floor((c + h + 1 - 2o) / 2s).
 */
ost_voxel_box ost_box_voxels(const ost_geometry *bone, const ost_box *tool, const ost_pose *pose)
{
    const ost_rotation m = ost_rotation_of(pose);
    const ost_divider by = ost_divider_of(m.n);
    const int64_t e[3] = {tool->hi.x - tool->lo.x, tool->hi.y - tool->lo.y, tool->hi.z - tool->lo.z};
    const int64_t o[3] = {bone->origin.x, bone->origin.y, bone->origin.z};
    const int64_t s[3] = {bone->spacing.x, bone->spacing.y, bone->spacing.z};
    const int32_t dims[3] = {bone->dims.x, bone->dims.y, bone->dims.z};
    int64_t c[3];
    centre_twice(tool, &m, &by, pose, c);
    ost_voxel_box box;
    for (int i = 0; i < 3; i++) {
        ost_i128 spread = (ost_i128)magnitude(m.m[i][0]) * e[0] + (ost_i128)magnitude(m.m[i][1]) * e[1] +
                          (ost_i128)magnitude(m.m[i][2]) * e[2];
        ost_i128 remainder;
        const int64_t h = -ost_floor_by(&by, -spread, &remainder);
        box.lo[i] = clamp(ost_ceil_div(c[i] - h - 1 - 2 * o[i], 2 * s[i]), dims[i]);
        box.hi[i] = clamp(ost_floor_div(c[i] + h + 1 - 2 * o[i], 2 * s[i]) + 1, dims[i]);
    }
    return box;
}
