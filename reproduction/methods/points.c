/* SPDX-License-Identifier: Apache-2.0 */
/* Makes the list of a tool's points, and the map from points to bone voxels for a pose. */
#include "reproduction/methods/points.h"

#include <stdlib.h>
#include <string.h>

#include "core/integer.h"
#include "core/rotation.h"

enum { FRACTION = 20 };

static bool cutting(const ost_tool_volume *tool, int32_t i, int32_t j, int32_t k)
{
    const ost_dims d = tool->geometry.dims;
    if (i < 0 || j < 0 || k < 0 || i >= d.x || j >= d.y || k >= d.z)
        return false;
    return tool->voxels[i + (int64_t)d.x * (j + (int64_t)d.y * k)] == OST_TOOL_CUTTING;
}

/* Returns true if a cutting voxel has a face neighbour that is not cutting. */
static bool on_surface(const ost_tool_volume *tool, int32_t i, int32_t j, int32_t k)
{
    return !(cutting(tool, i - 1, j, k) && cutting(tool, i + 1, j, k) && cutting(tool, i, j - 1, k) &&
             cutting(tool, i, j + 1, k) && cutting(tool, i, j, k - 1) && cutting(tool, i, j, k + 1));
}

static int16_t half_steps(int32_t i, int32_t dim)
{
    return (int16_t)(2 * i + 1 - dim);
}

/* Visits the points of a tool block by block. If the lists are allocated, stores the points and the blocks that
   contain points. Sets the number of blocks and returns the number of points. */
static int64_t visit(method_points *points, const ost_tool_volume *tool, methods_points which, ost_dims block)
{
    const ost_dims d = tool->geometry.dims;
    int64_t count = 0;
    int32_t blocks = 0;
    for (int32_t z = 0; z < d.z; z += block.z)
        for (int32_t y = 0; y < d.y; y += block.y)
            for (int32_t x = 0; x < d.x; x += block.x) {
                const int64_t first = count;
                points_block bounds = {.lo = {INT16_MAX, INT16_MAX, INT16_MAX},
                                       .hi = {INT16_MIN, INT16_MIN, INT16_MIN}};
                for (int32_t k = z; k < z + block.z && k < d.z; k++)
                    for (int32_t j = y; j < y + block.y && j < d.y; j++) {
                        const uint8_t *row = tool->voxels + d.x * (j + (int64_t)d.y * k);
                        for (int32_t i = x; i < x + block.x && i < d.x; i++) {
                            if (row[i] != OST_TOOL_CUTTING ||
                                (which == METHODS_POINTS_SURFACE && !on_surface(tool, i, j, k)))
                                continue;
                            const int16_t e[3] = {half_steps(i, d.x), half_steps(j, d.y), half_steps(k, d.z)};
                            for (int a = 0; a < 3; a++) {
                                if (points->e[a])
                                    points->e[a][count] = e[a];
                                bounds.lo[a] = e[a] < bounds.lo[a] ? e[a] : bounds.lo[a];
                                bounds.hi[a] = e[a] > bounds.hi[a] ? e[a] : bounds.hi[a];
                            }
                            count++;
                        }
                    }
                if (count == first)
                    continue;
                if (points->blocks) {
                    bounds.first = (int32_t)first;
                    bounds.count = (int32_t)(count - first);
                    points->blocks[blocks] = bounds;
                }
                blocks++;
            }
    points->block_count = blocks;
    return count;
}

ost_status method_points_init(method_points *points, const ost_tool_volume *tool, methods_points which, int block,
                              ost_error *err)
{
    const ost_dims d = tool->geometry.dims;
    const ost_dims cut = block ? (ost_dims){block, block, block} : d;
    *points = (method_points){.dims = d};
    const int64_t count = visit(points, tool, which, cut);
    if (count > INT32_MAX)
        return ost_fail(err, OST_ERR_RANGE, "a tool of %lld points; at most 2^31 - 1 are possible", (long long)count);
    points->count = (int32_t)count;
    bool made = true;
    for (int a = 0; a < 3; a++)
        made = (points->e[a] = malloc(((size_t)count + 1) * sizeof *points->e[a])) && made;
    if (block)
        made = (points->blocks = malloc(((size_t)points->block_count + 1) * sizeof *points->blocks)) && made;
    if (!made) {
        method_points_free(points);
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for %lld tool points", (long long)count);
    }
    visit(points, tool, which, cut);
    if (!block)
        points->block_count = 0;
    return OST_OK;
}

void method_points_free(method_points *points)
{
    for (int a = 0; a < 3; a++)
        free(points->e[a]);
    free(points->blocks);
    *points = (method_points){0};
}

static bool make_steps(points_map *out, const ost_rotation *r, const ost_geometry *bone,
                       const ost_tool_geometry *tool)
{
    const int32_t dims[3] = {tool->dims.x, tool->dims.y, tool->dims.z};
    const ost_i128 divisor = (ost_i128)2 * r->n * bone->spacing.x;
    bool fits = true;
    for (int b = 0; b < 3; b++) {
        int64_t sum = INT64_C(1) << out->fraction;
        for (int a = 0; a < 3; a++) {
            const ost_i128 step = ost_rhe_div128((ost_i128)r->m[b][a] * tool->voxel * (1 << out->fraction), divisor);
            out->step[a][b] = (int32_t)step;
            sum += dims[a] * (int64_t)(step < 0 ? -step : step);
        }
        fits = fits && sum < INT64_C(1) << 30;
    }
    return fits;
}

ost_status points_map_make(points_map *out, const ost_pose *pose, const ost_geometry *bone,
                           const ost_tool_geometry *tool, ost_error *err)
{
    ost_map limits;
    ost_status status = ost_map_make(pose, bone, tool, &limits, err);
    if (status != OST_OK)
        return status;
    const ost_rotation r = ost_rotation_of(pose);
    const ost_pm twice_centre[3] = {2 * tool->corner.x + tool->dims.x * tool->voxel,
                                    2 * tool->corner.y + tool->dims.y * tool->voxel,
                                    2 * tool->corner.z + tool->dims.z * tool->voxel};
    const ost_pm offset[3] = {pose->t.x - bone->origin.x, pose->t.y - bone->origin.y, pose->t.z - bone->origin.z};
    const ost_pm s = bone->spacing.x;
    const ost_i128 divisor = (ost_i128)2 * r.n * s;
    out->fraction = FRACTION;
    while (!make_steps(out, &r, bone, tool))
        out->fraction--;
    for (int b = 0; b < 3; b++) {
        ost_i128 n = (ost_i128)r.n * (2 * offset[b] + s);
        for (int a = 0; a < 3; a++)
            n += (ost_i128)r.m[b][a] * twice_centre[a];
        const ost_i128 anchor = ost_floor_div128(n, divisor);
        out->anchor[b] = (int32_t)anchor;
        out->base[b] = (int32_t)ost_rhe_div128((n - anchor * divisor) * (1 << out->fraction), divisor);
    }
    return OST_OK;
}
