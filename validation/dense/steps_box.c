/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Computes the voxels that a broad phase must include (AR-REM-5): the voxels whose centres lie in the bone-aligned
 * bounds of the tool's grid, after the grid is enlarged by one tool voxel on each side. docs/spec/arithmetic.md
 * prescribes no box, so these voxels are only a bound. The box of sim/box.h includes them if a voxel is inside the
 * tool's grid. If no voxel is inside, that box may be empty.
 */
#include "validation/dense/steps.h"

#include <string.h>

/* Compares the coordinate o + i * s with the fraction bound / n. Returns the sign of i * s * n - (bound - o * n). */
static int side(int64_t i, ost_pm o, ost_pm s, wide bound, wide n)
{
    return wide_order(wide_times(wide_plus(wide_of(o), wide_times(wide_of(i), wide_of(s))), n), bound);
}

bool steps_bounds(const ost_pose *pose, const ost_geometry *bone, const ost_tool_geometry *tool, ost_voxel_box *out)
{
    const ost_pm near[3] = {tool->corner.x, tool->corner.y, tool->corner.z}, t[3] = {pose->t.x, pose->t.y, pose->t.z};
    const ost_pm o[3] = {bone->origin.x, bone->origin.y, bone->origin.z},
                 s[3] = {bone->spacing.x, bone->spacing.y, bone->spacing.z};
    const int32_t dims[3] = {tool->dims.x, tool->dims.y, tool->dims.z},
                  n[3] = {bone->dims.x, bone->dims.y, bone->dims.z};
    const wide norm = steps_norm(pose);
    wide least[3], most[3];
    for (int which = 0; which < 8; which++) {
        wide corner[3], at[3];
        for (int a = 0; a < 3; a++)
            corner[a] = wide_plus(wide_of(near[a]),
                                  wide_times(wide_of(which >> a & 1 ? dims[a] + 1 : -1), wide_of(tool->voxel)));
        steps_turn(pose, false, corner, at);
        for (int a = 0; a < 3; a++) {
            at[a] = wide_plus(at[a], wide_times(wide_of(t[a]), norm));
            least[a] = which == 0 || wide_order(at[a], least[a]) < 0 ? at[a] : least[a];
            most[a] = which == 0 || wide_order(at[a], most[a]) > 0 ? at[a] : most[a];
        }
    }
    /* Finds by bisection the first voxel that is not before the bounds, and the first voxel after the bounds. */
    for (int a = 0; a < 3; a++) {
        int32_t below = 0, above = n[a], first = 0, last = n[a];
        while (below < above) {
            const int32_t middle = (below + above) / 2;
            *(side(middle, o[a], s[a], least[a], norm) < 0
                  ? &below
                  : &above) = side(middle, o[a], s[a], least[a], norm) < 0 ? middle + 1 : middle;
        }
        while (first < last) {
            const int32_t middle = (first + last) / 2;
            *(side(middle, o[a], s[a], most[a], norm) <= 0
                  ? &first
                  : &last) = side(middle, o[a], s[a], most[a], norm) <= 0 ? middle + 1 : middle;
        }
        out->lo[a] = below;
        out->hi[a] = first;
        if (below >= first) {
            *out = (ost_voxel_box){{0, 0, 0}, {0, 0, 0}};
            return false;
        }
    }
    return true;
}

enum { BLOCK = 16 };

/* Returns true if at least one bone voxel of the block lies inside the tool's grid (AR-MAP-4). 64 bits are
   sufficient, because |base| < 2^31 and |15 step| < 2^28. */
static bool block_reaches(const ost_map *map, const ost_tool_geometry *tool, const ost_dims bone, const int32_t f[3],
                          const int32_t base[3])
{
    const int64_t end[3] = {(int64_t)tool->dims.x << 20, (int64_t)tool->dims.y << 20, (int64_t)tool->dims.z << 20};
    for (int a = 0; a < 3; a++) { /* no voxel can be hit if all corners lie beyond the same side of the grid */
        int64_t least = base[a], most = base[a];
        for (int b = 0; b < 3; b++)
            *(map->step[b][a] < 0 ? &least : &most) += (BLOCK - 1) * (int64_t)map->step[b][a];
        if (most < 0 || least >= end[a])
            return false;
    }
    for (int32_t z = 0; z < BLOCK && f[2] + z < bone.z; z++)
        for (int32_t y = 0; y < BLOCK && f[1] + y < bone.y; y++)
            for (int32_t x = 0; x < BLOCK && f[0] + x < bone.x; x++) {
                bool inside = true;
                for (int a = 0; a < 3 && inside; a++) {
                    const int64_t u = base[a] + x * (int64_t)map->step[0][a] + y * (int64_t)map->step[1][a] +
                                      z * (int64_t)map->step[2][a];
                    inside = u >= 0 && u < end[a];
                }
                if (inside)
                    return true;
            }
    return false;
}

bool steps_reaches(const ost_map *map, const ost_geometry *bone, const ost_tool_geometry *tool,
                   const ost_voxel_box *bounds)
{
    for (int32_t z = bounds->lo[2] / BLOCK * BLOCK; z < bounds->hi[2]; z += BLOCK)
        for (int32_t y = bounds->lo[1] / BLOCK * BLOCK; y < bounds->hi[1]; y += BLOCK)
            for (int32_t x = bounds->lo[0] / BLOCK * BLOCK; x < bounds->hi[0]; x += BLOCK) {
                const int32_t f[3] = {x, y, z};
                int32_t base[3];
                if (steps_block_base(map, f, base) && block_reaches(map, tool, bone->dims, f, base))
                    return true;
            }
    return false;
}
