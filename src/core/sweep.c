/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The poses between two ticks (AR-SWEEP).  Let d be the greatest displacement of a corner of
 * the tool's box.  The number n of poses is the least for which d / n is at most half a bone voxel.
 *
 *     a o- - -o- - -o- - -o b      n = 3: poses k = 1, 2, 3; a belongs to the previous event
 *
 * All arithmetic uses integers, so that the poses are the same on every backend and in
 * every replay.
 */
#include <osteon/event.h>

#include "core/conditions.h"
#include "core/divider.h"
#include "core/rotation.h"

/*
 * Returns the dot product of two quaternions. The product is at most 2^60.01 if |q| <= 1.001 * 2^30 for both
 * quaternions, and at most 2^62.01 if only ost_rotation_fits is true for both.
 */
static int64_t dot(const ost_pose *a, const ost_pose *b)
{
    return (int64_t)a->qw * b->qw + (int64_t)a->qx * b->qx + (int64_t)a->qy * b->qy + (int64_t)a->qz * b->qz;
}

/*
 * Returns true if the length of the quaternion is near 1, which ost_map_make also requires. A pose whose components are
 * all zero, as in an uninitialised struct, is rejected here, because later code divides by N.
 */
static bool near_unit(const ost_pose *pose)
{
    const int64_t n = dot(pose, pose);
    return n >= OST_ROTATION_N_MIN && n <= OST_ROTATION_N_MAX;
}

/*
 * Computes RHE(M c / N) along one axis for the eight corners c of a box, numbered x + 2y + 4z. The
 * products of a row of M with lo and hi are computed once for all corners. The tool's box is within
 * 8 m of its origin, so |c| < sqrt(3) * 2^42.87 and |M c| <= N |c| < 2^60.01 * 2^43.66.
 */
static void turned(const ost_rotation *r, const ost_divider *by, int row, const ost_pm lo[3], const ost_pm hi[3],
                   int64_t out[8])
{
    ost_i128 part[3][2];
    for (int a = 0; a < 3; a++) {
        part[a][0] = (ost_i128)r->m[row][a] * lo[a];
        part[a][1] = (ost_i128)r->m[row][a] * hi[a];
    }
    for (int c = 0; c < 8; c++)
        out[c] = ost_rhe_by(by, part[0][c & 1] + part[1][c >> 1 & 1] + part[2][c >> 2]);
}

/*
 * Returns the greatest squared displacement |d|^2 of the box's corners between two poses. Each component of d is below
 * 2 * 2^43.66 + 2^43.87 < 2^45.4, so the sum of squares is below 2^92.4.
 */
static ost_i128 greatest_displacement_squared(const ost_pose *a, const ost_pose *b, const ost_tool_geometry *tool)
{
    const ost_rotation ra = ost_rotation_of(a), rb = ost_rotation_of(b);
    const ost_divider by_a = ost_divider_of(ra.n), by_b = ost_divider_of(rb.n);
    const int64_t dt[3] = {b->t.x - a->t.x, b->t.y - a->t.y, b->t.z - a->t.z};
    const ost_pm lo[3] = {tool->corner.x, tool->corner.y, tool->corner.z};
    const ost_pm hi[3] = {lo[0] + tool->dims.x * tool->voxel, lo[1] + tool->dims.y * tool->voxel,
                          lo[2] + tool->dims.z * tool->voxel};
    ost_i128 squared[8] = {0}, greatest = 0;
    for (int axis = 0; axis < 3; axis++) {
        int64_t from[8], to[8];
        turned(&ra, &by_a, axis, lo, hi, from);
        turned(&rb, &by_b, axis, lo, hi, to);
        for (int corner = 0; corner < 8; corner++) {
            const int64_t d = to[corner] - from[corner] + dt[axis];
            squared[corner] += (ost_i128)d * d;
        }
    }
    for (int corner = 0; corner < 8; corner++)
        greatest = squared[corner] > greatest ? squared[corner] : greatest;
    return greatest;
}

ost_status ost_sweep_count(const ost_pose *a, const ost_pose *b, const ost_tool_geometry *tool, ost_pm bone_voxel,
                           int *count, ost_error *err)
{
    ost_status status = ost_tool_geometry_check(tool, err);
    if (status != OST_OK)
        return status;
    if (bone_voxel < OST_SPACING_MIN || bone_voxel > OST_SPACING_MAX)
        return ost_fail(err, OST_ERR_RANGE, "bone voxel of %lld pm; expected 0.001 to 100 mm", (long long)bone_voxel);
    if (!ost_rotation_fits(a) || !ost_rotation_fits(b))
        return ost_fail(err, OST_ERR_RANGE, "invalid pose: expected a position within 8 m and a unit quaternion");
    if (!near_unit(a) || !near_unit(b))
        return ost_fail(err, OST_ERR_RANGE, "invalid pose: expected a unit quaternion");
    /*
     * If cos^2 of the angle between the quaternions is below 1/2, this angle exceeds 45 degrees, and
     * the rotation in space exceeds 90 degrees. The products are below 2^121.03.
     */
    ost_i128 d = dot(a, b);
    if (2 * d * d < (ost_i128)dot(a, a) * dot(b, b))
        return ost_fail(err, OST_ERR_RANGE, "the tool turns by more than 90 degrees in one tick");

    ost_i128 needed = 4 * greatest_displacement_squared(a, b, tool); /* < 2^94.4 */
    /* at most 10^22 < 2^73.1, so 4096^2 times this value is below 2^97.1 */
    ost_i128 voxel_squared = (ost_i128)bone_voxel * bone_voxel;
    ost_i128 n = 1;
    while (n <= OST_SWEEP_MAX && n * n * voxel_squared < needed)
        n++;
    if (n > OST_SWEEP_MAX)
        return ost_fail(err, OST_ERR_RANGE, "the tool moves by more than %d half voxels of the bone in one tick",
                        OST_SWEEP_MAX);
    *count = (int)n;
    return OST_OK;
}

/* Returns RHE(((n - k) a + k b) / n). |a|, |b| < 2^43 and n <= 2^12. */
static int64_t between(int64_t a, int64_t b, int64_t k, int64_t n)
{
    return ost_rhe_div((n - k) * a + k * b, n);
}

ost_pose ost_sweep_pose(const ost_pose *a, const ost_pose *b, int k, int n)
{
    int64_t sign = dot(a, b) < 0 ? -1 : 1;
    return (ost_pose){
        .t = {between(a->t.x, b->t.x, k, n), between(a->t.y, b->t.y, k, n), between(a->t.z, b->t.z, k, n)},
        .qw = (int32_t)between(a->qw, sign * b->qw, k, n),
        .qx = (int32_t)between(a->qx, sign * b->qx, k, n),
        .qy = (int32_t)between(a->qy, sign * b->qy, k, n),
        .qz = (int32_t)between(a->qz, sign * b->qz, k, n),
    };
}
