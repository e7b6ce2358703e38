/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Computes the grid of a tool from the bounds of its mesh (AR-TOOL; thesis, Alg. 2.1).
 *
 *   corner = RHE((2 min - s) / 2s) * s - s        MinVoxelCoords
 *   far    = RHE((2 max + s) / 2s) * s + s
 *   dims   = (far - corner) / s
 *
 *      corner        min                   max         far
 *        |<- s..2s ->|#######################|<- s..2s ->|
 *
 * For every m, RHE(m - 1/2) <= m <= RHE(m + 1/2), and both results differ from m by at most one.
 * Therefore the margin on each side of the mesh is one to two empty voxels wide.
 *
 * Ranges: |min|, |max| <= 8e12 (OST_LENGTH_MAX) and s <= 1e11, so every sum and
 * product is below 2e13, far below 2^63.
 */
#include <osteon/tool.h>

#include "core/conditions.h"
#include "core/integer.h"

static ost_status axis(char name, ost_pm min, ost_pm max, ost_pm voxel, ost_pm *corner, int32_t *dim, ost_error *err)
{
    char a[OST_PM_TEXT], b[OST_PM_TEXT], s[OST_PM_TEXT];
    if (min > max)
        return ost_fail(err, OST_ERR_USAGE, "tool bounds: %c runs from %s down to %s mm", name, ost_pm_format(min, a),
                        ost_pm_format(max, b));
    if (min < -OST_LENGTH_MAX || max > OST_LENGTH_MAX)
        return ost_fail(err, OST_ERR_RANGE, "tool bounds: %c from %s to %s mm lies beyond +-8000 mm", name,
                        ost_pm_format(min, a), ost_pm_format(max, b));
    *corner = ost_rhe_div(2 * min - voxel, 2 * voxel) * voxel - voxel;
    ost_pm far = ost_rhe_div(2 * max + voxel, 2 * voxel) * voxel + voxel;
    int64_t n = (far - *corner) / voxel;
    if (n > OST_TOOL_DIM_MAX)
        return ost_fail(
            err, OST_ERR_RANGE,
            "the tool is %lld voxels long in %c (%s to %s mm at %s mm); expected at most %d; use larger voxels",
            (long long)n, name, ost_pm_format(min, a), ost_pm_format(max, b), ost_pm_format(voxel, s),
            OST_TOOL_DIM_MAX);
    *dim = (int32_t)n;
    return OST_OK;
}

ost_status ost_tool_geometry_from_bounds(ost_pm3 min, ost_pm3 max, ost_pm voxel, ost_tool_geometry *out, ost_error *err)
{
    char s[OST_PM_TEXT];
    if (voxel < OST_TOOL_VOXEL_MIN || voxel > OST_SPACING_MAX)
        return ost_fail(err, OST_ERR_RANGE, "a tool voxel of %s mm is outside 0.001 to 100 mm",
                        ost_pm_format(voxel, s));
    ost_tool_geometry g = {.voxel = voxel};
    ost_status status = axis('x', min.x, max.x, voxel, &g.corner.x, &g.dims.x, err);
    if (status == OST_OK)
        status = axis('y', min.y, max.y, voxel, &g.corner.y, &g.dims.y, err);
    if (status == OST_OK)
        status = axis('z', min.z, max.z, voxel, &g.corner.z, &g.dims.z, err);
    if (status != OST_OK)
        return status;
    status = ost_tool_geometry_check(&g, err);
    if (status != OST_OK)
        return status;
    *out = g;
    return OST_OK;
}
