/* SPDX-License-Identifier: Apache-2.0 */
/* Manages tool grids in host memory (AR-TOOL). */
#include <osteon/tool.h>

#include <stdlib.h>

#include "core/huge_pages.h"

ost_status ost_tool_volume_init(ost_tool_volume *tool, const ost_tool_geometry *geometry, ost_error *err)
{
    *tool = (ost_tool_volume){.geometry = *geometry};
    ost_status status = ost_tool_geometry_check(geometry, err);
    if (status != OST_OK)
        return status;
    size_t count = (size_t)ost_dims_count(geometry->dims);
    tool->voxels = calloc(count, 1);
    if (!tool->voxels)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a tool grid of %zu voxels", count);
    ost_request_huge_pages(tool->voxels, count);
    return OST_OK;
}

void ost_tool_volume_free(ost_tool_volume *tool)
{
    if (!tool)
        return;
    free(tool->voxels);
    tool->voxels = NULL;
}

int64_t ost_tool_volume_count(const ost_tool_volume *tool, uint8_t tool_class)
{
    int64_t count = ost_dims_count(tool->geometry.dims);
    int64_t found = 0;
    for (int64_t i = 0; i < count; i++)
        found += tool->voxels[i] == tool_class;
    return found;
}

/* dims * voxel <= 2^12 * 10^11 < 2^49, so the sum for the far corner does not overflow before the comparison. */
ost_status ost_tool_geometry_check(const ost_tool_geometry *geometry, ost_error *err)
{
    const int32_t dims[3] = {geometry->dims.x, geometry->dims.y, geometry->dims.z};
    const int64_t corner[3] = {geometry->corner.x, geometry->corner.y, geometry->corner.z};
    if (geometry->voxel < OST_TOOL_VOXEL_MIN || geometry->voxel > OST_SPACING_MAX)
        return ost_fail(err, OST_ERR_RANGE, "tool voxel of %.9g mm; expected 0.001 to 100 mm",
                        ost_pm_to_mm(geometry->voxel));
    for (int a = 0; a < 3; a++) {
        if (dims[a] < 1 || dims[a] > OST_TOOL_DIM_MAX)
            return ost_fail(err, OST_ERR_RANGE, "a tool grid of %d x %d x %d voxels; expected 1 to %d along %c",
                            (int)dims[0], (int)dims[1], (int)dims[2], OST_TOOL_DIM_MAX, "xyz"[a]);
        if (corner[a] < -OST_LENGTH_MAX || corner[a] > OST_LENGTH_MAX ||
            corner[a] + dims[a] * geometry->voxel > OST_LENGTH_MAX)
            return ost_fail(err, OST_ERR_RANGE,
                            "a tool grid that begins at %.6g mm along %c; supported is within 8000 mm of 0",
                            ost_pm_to_mm(corner[a]), "xyz"[a]);
    }
    if (ost_dims_count(geometry->dims) > OST_TOOL_VOXELS_MAX)
        return ost_fail(err, OST_ERR_RANGE, "a tool grid of %d x %d x %d voxels; expected at most 2^33", (int)dims[0],
                        (int)dims[1], (int)dims[2]);
    return OST_OK;
}
