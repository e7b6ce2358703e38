/* SPDX-License-Identifier: Apache-2.0 */
#include "app/input/tool_shape.h"

#include <math.h>

#define REAMER_MM 16.0

static double ends_mm(ost_pm corner, ost_pm voxel, int32_t index)
{
    return ost_pm_to_mm(corner + index * voxel);
}

ost_status tool_shape_of(const ost_tool *tool, tool_shape *out, ost_error *err)
{
    ost_tool_volume volume;
    ost_status status = ost_tool_download(tool, &volume, err);
    *out = (tool_shape){.is = {.kind = OST_METRICS_OTHER}};
    if (status != OST_OK)
        return status;
    const ost_tool_geometry *g = &volume.geometry;
    const int32_t dims[3] = {g->dims.x, g->dims.y, g->dims.z};
    const ost_pm corner[3] = {g->corner.x, g->corner.y, g->corner.z};
    int32_t lo[3] = {dims[0], dims[1], dims[2]}, hi[3] = {0};
    int64_t i = 0;
    for (int32_t z = 0; z < dims[2]; z++)
        for (int32_t y = 0; y < dims[1]; y++)
            for (int32_t x = 0; x < dims[0]; x++, i++) {
                const int32_t at[3] = {x, y, z};
                for (int a = 0; a < 3 && volume.voxels[i] == OST_TOOL_CUTTING; a++) {
                    lo[a] = at[a] < lo[a] ? at[a] : lo[a];
                    hi[a] = at[a] + 1 > hi[a] ? at[a] + 1 : hi[a];
                }
            }
    ost_tool_volume_free(&volume);
    if (hi[0] == 0)
        return OST_OK; /* A tool without cutting voxels has no tip. */
    double size[3];
    for (int a = 0; a < 3; a++) {
        const double from = ends_mm(corner[a], g->voxel, lo[a]), to = ends_mm(corner[a], g->voxel, hi[a]);
        size[a] = to - from;
        out->tip_mm[a] = a == 2 ? from : from <= 0 && to >= 0 ? 0 : (from + to) / 2;
    }
    const double width = fmax(size[0], size[1]);
    out->is = (ost_metrics_tool){
        .kind = width >= REAMER_MM ? OST_METRICS_REAMER : size[2] >= 2 * width ? OST_METRICS_DRILL : OST_METRICS_OTHER,
        .radius_mm = width / 2,
        .length_mm = size[2],
    };
    return OST_OK;
}

void tool_shape_at(const tool_shape *shape, const ost_pose *pose, double tip_mm[3], double axis[3])
{
    double t[3], q[4], size = 0;
    ost_pose_to_doubles(pose, t, q);
    for (int i = 0; i < 4; i++)
        size += q[i] * q[i];
    for (int i = 0; i < 4; i++)
        q[i] /= sqrt(size);
    const double w = q[0], x = q[1], y = q[2], z = q[3];
    const double m[3][3] = {{1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)},
                            {2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)},
                            {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)}};
    for (int a = 0; a < 3; a++) {
        axis[a] = -m[a][2];
        tip_mm[a] = t[a] + m[a][0] * shape->tip_mm[0] + m[a][1] * shape->tip_mm[1] + m[a][2] * shape->tip_mm[2];
    }
}
