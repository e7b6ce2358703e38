/* SPDX-License-Identifier: Apache-2.0 */
#include "validation/dense/steps.h"

static ost_int128 int128_of(wide a)
{
    uint64_t words[2];
    wide_to_words(a, words);
    return (ost_int128){.low = words[0], .high = (int64_t)words[1]};
}

static wide wide_of_int128(ost_int128 v)
{
    return wide_plus(wide_times(wide_of(v.high), wide_power_of_two(64)),
                     wide_plus(wide_times(wide_of((int64_t)(v.low >> 32)), wide_power_of_two(32)),
                               wide_of((int64_t)(v.low & 0xffffffff))));
}

/*
 * Computes the map of bone voxel (i, j, k) to tool coordinates: U_a = 2^20 (((q* (p - t) q)_a / N) - corner_a) / s_t
 * with p = o + (i s, j s, k s). q and t are the rotation and position of the pose; o and s are the origin and spacing
 * of the bone; s_t is the tool's voxel size. The common denominator is N s_t.
 */
void steps_map(const ost_pose *pose, const ost_geometry *bone, const ost_tool_geometry *tool, ost_map *out)
{
    const wide n = steps_norm(pose), divisor = wide_times(n, wide_of(tool->voxel)), one = wide_power_of_two(20);
    const wide from[3] = {wide_minus(wide_of(bone->origin.x), wide_of(pose->t.x)),
                          wide_minus(wide_of(bone->origin.y), wide_of(pose->t.y)),
                          wide_minus(wide_of(bone->origin.z), wide_of(pose->t.z))};
    const ost_pm corner[3] = {tool->corner.x, tool->corner.y, tool->corner.z},
                 spacing[3] = {bone->spacing.x, bone->spacing.y, bone->spacing.z};
    wide turned[3];
    steps_turn(pose, true, from, turned);
    out->divisor = int128_of(divisor);
    for (int a = 0; a < 3; a++)
        out->origin[a] = int128_of(wide_times(one, wide_minus(turned[a], wide_times(n, wide_of(corner[a])))));
    for (int b = 0; b < 3; b++) {
        /* vector from a bone voxel to the next one along axis b */
        wide way[3] = {wide_of(0), wide_of(0), wide_of(0)};
        way[b] = wide_of(spacing[b]);
        steps_turn(pose, true, way, turned);
        for (int a = 0; a < 3; a++) {
            const wide column = wide_times(one, turned[a]);
            out->column[b][a] = int128_of(column);
            out->step[b][a] = (int32_t)wide_to_int64(wide_nearest(column, divisor));
        }
    }
}

bool steps_block_base(const ost_map *map, const int32_t first[3], int32_t base[3])
{
    const wide divisor = wide_of_int128(map->divisor), low = wide_negated(wide_power_of_two(29)),
               high = wide_times(wide_of(3), wide_power_of_two(29));
    for (int a = 0; a < 3; a++) {
        wide at = wide_of_int128(map->origin[a]);
        for (int b = 0; b < 3; b++)
            at = wide_plus(at, wide_times(wide_of(first[b]), wide_of_int128(map->column[b][a])));
        const wide nearest = wide_nearest(at, divisor);
        if (wide_order(nearest, low) < 0 || wide_order(nearest, high) >= 0)
            return false;
        base[a] = (int32_t)wide_to_int64(nearest);
    }
    return true;
}
