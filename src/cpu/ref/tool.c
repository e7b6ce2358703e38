/* SPDX-License-Identifier: Apache-2.0 */
/* Implements the tools of the reference: one uint8 per voxel, x fastest (include/osteon/tool.h). */
#include "cpu/ref/ref.h"

#include <stdlib.h>
#include <string.h>

#include "cpu/ref/voxelize.h"

/* Creates a tool with this geometry. All voxels of the tool are empty; the caller then sets them. */
static ost_status tool_create(ost_backend *backend, const ost_tool_geometry *geometry, ref_tool **out, ost_error *err)
{
    int64_t count = ost_dims_count(geometry->dims);
    ref_tool *tool = malloc(sizeof *tool);
    uint8_t *voxels = calloc((size_t)count, 1);
    if (!tool || !voxels) {
        free(voxels);
        free(tool);
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a tool of %d x %d x %d voxels (%lld bytes)",
                        geometry->dims.x, geometry->dims.y, geometry->dims.z, (long long)count);
    }
    *tool = (ref_tool){.base = {.backend = backend, .geometry = *geometry}, .voxels = voxels};
    *out = tool;
    return OST_OK;
}

ost_status ost_ref_tool_upload(ost_backend *backend, const ost_tool_volume *volume, ost_tool **out, ost_error *err)
{
    ref_tool *tool;
    ost_status status = tool_create(backend, &volume->geometry, &tool, err);
    if (status != OST_OK)
        return status;
    memcpy(tool->voxels, volume->voxels, (size_t)ost_dims_count(volume->geometry.dims));
    *out = &tool->base;
    return OST_OK;
}

ost_status ost_ref_tool_download(const ost_tool *base, ost_tool_volume *volume, ost_error *err)
{
    (void)err;
    const ref_tool *tool = (const ref_tool *)base;
    memcpy(volume->voxels, tool->voxels, (size_t)ost_dims_count(base->geometry.dims));
    return OST_OK;
}

void ost_ref_tool_free(ost_tool *base)
{
    ref_tool *tool = (ref_tool *)base;
    free(tool->voxels);
    free(tool);
}

ost_status ost_ref_voxelize_tool(ost_backend *backend, const ost_snapped_mesh *cutting,
                                 const ost_snapped_mesh *noncutting, ost_fill_rule rule, ost_voxelize_report *report,
                                 ost_tool **out, ost_error *err)
{
    ref_tool *tool;
    ost_status status = tool_create(backend, &cutting->grid, &tool, err);
    if (status != OST_OK)
        return status;
    status = ost_ref_voxelize(cutting, noncutting, rule, report, tool->voxels, err);
    if (status != OST_OK) {
        ost_ref_tool_free(&tool->base);
        return status;
    }
    *out = &tool->base;
    return OST_OK;
}
