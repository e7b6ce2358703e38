/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The map of one pose (AR-MAP) from bone voxels to tool voxels, computed with 128-bit
 * integers once per pose and once per block of 16^3 voxels.
 *
 *   p_bone = R p_tool + t,  R = M / N      =>  p_tool = M' (p_bone - t) / N     (M' = M transposed)
 *   p_bone = o + s (i, j, k)                   centre of a bone voxel
 *   u      = 2^20 (p_tool - corner) / v        tool coordinate, v the tool's voxel
 *
 * With the common divisor N v, this is
 *
 *   origin[a]    = 2^20 ((M' (o - t))[a] - N corner[a])
 *   column[b][a] = 2^20 M[b][a] s
 *
 * Ranges (checked in ost_map_make; lengths in pm, 8 m < 2^42.87):
 *   2^59 <= N <= 2^60 + 2^52     N / 2^60 is at most 1.001^2 = 1.002001 for a pose that was read, and at least
 *                                cos^2(22.5 degrees) for an interpolated pose
 *   |M[b][a]| <= N               because M / N is a rotation
 *   |o - t| <= sqrt(3) * 16 m    so |M' (o - t)| <= N * 2^44.66 on any axis; the same bound applies if o is replaced
 *                                by any voxel centre of the grid, because all are within 8 m (AR-GRID)
 *   |corner| <= 8 m              so the bracket is below N * 2^45.03 < 2^105.04
 *   |origin| < 2^125.04          the same bound applies to every partial sum origin + i column[0] + ... in the grid
 *   s, v <= 100 mm < 2^36.55     so |column| < 2^116.56, divisor < 2^96.56
 *   s <= 16 v                    so |column / divisor| <= 2^20 * 16, and after RHE |step| <= 2^24
 */
#include <osteon/event.h>

#include "core/conditions.h"
#include "core/divider.h"
#include "core/int128.h"
#include "core/rotation.h"

static ost_status check(const ost_geometry *bone, const ost_tool_geometry *tool, ost_error *err)
{
    char s[OST_PM_TEXT], v[OST_PM_TEXT];
    ost_status status = ost_geometry_check(bone, "bone", err);
    if (status == OST_OK)
        status = ost_tool_geometry_check(tool, err);
    if (status != OST_OK)
        return status;
    if (bone->spacing.x != bone->spacing.y || bone->spacing.x != bone->spacing.z)
        return ost_fail(err, OST_ERR_USAGE,
                        "a bone needs equal spacing on its axes; resample it to cubic voxels first");
    if (bone->spacing.x > OST_MAP_RATIO_MAX * tool->voxel)
        return ost_fail(err, OST_ERR_RANGE,
                        "a bone voxel of %s mm is more than %d tool voxels of %s mm; use larger tool voxels",
                        ost_pm_format(bone->spacing.x, s), OST_MAP_RATIO_MAX, ost_pm_format(tool->voxel, v));
    if (tool->dims.x > OST_TOOL_DIM_REMOVE_MAX || tool->dims.y > OST_TOOL_DIM_REMOVE_MAX ||
        tool->dims.z > OST_TOOL_DIM_REMOVE_MAX)
        return ost_fail(err, OST_ERR_RANGE, "a tool of %d x %d x %d voxels; removal takes up to %d an axis",
                        tool->dims.x, tool->dims.y, tool->dims.z, OST_TOOL_DIM_REMOVE_MAX);
    return OST_OK;
}

ost_status ost_map_make(const ost_pose *pose, const ost_geometry *bone, const ost_tool_geometry *tool, ost_map *out,
                        ost_error *err)
{
    ost_status status = check(bone, tool, err);
    if (status != OST_OK)
        return status;
    if (!ost_rotation_fits(pose))
        return ost_fail(err, OST_ERR_RANGE, "invalid pose: expected a position within 8 m and a unit quaternion");
    ost_rotation r = ost_rotation_of(pose);
    if (r.n < OST_ROTATION_N_MIN || r.n > OST_ROTATION_N_MAX)
        return ost_fail(err, OST_ERR_RANGE, "invalid pose: quaternion (%d, %d, %d, %d) / 2^30; expected unit length",
                        pose->qw, pose->qx, pose->qy, pose->qz);

    const ost_i128 one = (ost_i128)1 << OST_MAP_FRACTION;
    const ost_pm from[3] = {bone->origin.x - pose->t.x, bone->origin.y - pose->t.y, bone->origin.z - pose->t.z};
    const ost_pm corner[3] = {tool->corner.x, tool->corner.y, tool->corner.z};

    const ost_i128 divisor = (ost_i128)r.n * tool->voxel;
    const ost_divider by = ost_divider_of(divisor);
    out->divisor = ost_int128_of(divisor);
    for (int a = 0; a < 3; a++) {
        ost_i128 turned = (ost_i128)r.m[0][a] * from[0] + (ost_i128)r.m[1][a] * from[1] + (ost_i128)r.m[2][a] * from[2];
        out->origin[a] = ost_int128_of(one * (turned - (ost_i128)r.n * corner[a]));
        for (int b = 0; b < 3; b++) {
            const ost_i128 column = one * r.m[b][a] * bone->spacing.x;
            out->column[b][a] = ost_int128_of(column);
            out->step[b][a] = (int32_t)ost_rhe_by(&by, column);
        }
    }
    return OST_OK;
}

/*
 * Computes the base of a block. Returns false if the block lies outside the tool's
 * grid (AR-MAP-5).  A coordinate of the block is base + d with |d| <= D, where
 * D = 15 * (sum of |step| over the bone's axes) <= 15 * (sqrt(3) * 2^24 + 3/2)
 * < 435,884,881 < 2^29, because |x| + |y| + |z| <= sqrt(3) for a column of a
 * rotation, and each RHE adds at most 1/2.
 *   base <  -2^29         every coordinate is < 0
 *   base >= 2^30 + 2^29   every coordinate is > 2^30, that is, beyond 1024 tool voxels
 *   otherwise             -2^30 < coordinate < 2^31, so the coordinate and every partial sum fit in int32
 */
bool ost_map_block_base(const ost_map *map, ost_dims block, int32_t base[3])
{
    const ost_i128 low = -((ost_i128)1 << 29);
    const ost_i128 high = ((ost_i128)1 << 30) + ((ost_i128)1 << 29);
    for (int a = 0; a < 3; a++) {
        const ost_i128 exact = ost_i128_of(map->origin[a]) +
                               OST_MAP_BLOCK * (block.x * ost_i128_of(map->column[0][a]) +
                                                block.y * ost_i128_of(map->column[1][a]) +
                                                block.z * ost_i128_of(map->column[2][a]));
        const ost_i128 rounded = ost_rhe_div128(exact, ost_i128_of(map->divisor));
        if (rounded < low || rounded >= high)
            return false;
        base[a] = (int32_t)rounded;
    }
    return true;
}
