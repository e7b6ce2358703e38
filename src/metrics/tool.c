/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Derives the role, the size and the tip of a tool from the voxels of its cutting part.
 *
 *         |z|          the axis is the z axis of the tool's frame if this axis passes
 *       .-'-'-.        through the cutting part; otherwise, it passes through the middle
 *       '--.--'        of the cutting part; the tip is the bottom of the lowest cutting
 *          tip         voxel, on the axis
 */
#include <math.h>

#include <osteon/metrics.h>

#include "core/quaternion.h"
#include "core/vector.h"

/* Computes the range of indices of the cutting voxels along each axis; hi is exclusive. Returns false if there are no
   cutting voxels. */
static bool range_of(const ost_tool_volume *volume, int32_t lo[3], int32_t hi[3])
{
    const ost_dims *n = &volume->geometry.dims;
    bool found = false;
    int64_t i = 0;
    for (int32_t z = 0; z < n->z; z++)
        for (int32_t y = 0; y < n->y; y++)
            for (int32_t x = 0; x < n->x; x++, i++) {
                const int32_t at[3] = {x, y, z};
                if (volume->voxels[i] != OST_TOOL_CUTTING)
                    continue;
                for (int a = 0; a < 3; a++) {
                    lo[a] = found && lo[a] < at[a] ? lo[a] : at[a];
                    hi[a] = found && hi[a] > at[a] + 1 ? hi[a] : at[a] + 1;
                }
                found = true;
            }
    return found;
}

ost_status ost_metrics_tool_make(const ost_tool *tool, ost_metrics_tool *out, ost_error *err)
{
    ost_tool_volume volume;
    int32_t lo[3], hi[3];
    *out = (ost_metrics_tool){.kind = OST_METRICS_OTHER};
    const ost_status status = ost_tool_download(tool, &volume, err);
    if (status != OST_OK)
        return status;
    const ost_pm corner[3] = {volume.geometry.corner.x, volume.geometry.corner.y, volume.geometry.corner.z},
                 voxel = volume.geometry.voxel;
    const bool found = range_of(&volume, lo, hi);
    ost_tool_volume_free(&volume);
    if (!found)
        return OST_OK;
    double size[3];
    for (int a = 0; a < 3; a++) {
        const double from = ost_pm_to_mm(corner[a] + lo[a] * voxel), to = ost_pm_to_mm(corner[a] + hi[a] * voxel);
        size[a] = to - from;
        out->tip_mm[a] = a == 2 ? from : from <= 0 && to >= 0 ? 0 : (from + to) / 2;
    }
    const double width = fmax(size[0], size[1]);
    out->radius_mm = width / 2;
    out->length_mm = size[2];
    if (width >= OST_METRICS_REAMER_MM)
        out->kind = OST_METRICS_REAMER;
    else if (size[2] >= 2 * width)
        out->kind = OST_METRICS_DRILL;
    return OST_OK;
}

void ost_metrics_tip(const ost_metrics_tool *tool, const ost_pose *pose, double mm[3], double axis[3])
{
    double t[3], q[4], m[3][3];
    ost_pose_to_doubles(pose, t, q);
    ost_quaternion_unit(q);
    ost_quaternion_matrix(q, m);
    for (int a = 0; a < 3; a++) {
        axis[a] = -m[a][2];
        mm[a] = t[a] + ost_vector_dot(m[a], tool->tip_mm);
    }
}
