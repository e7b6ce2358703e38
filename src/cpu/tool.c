/* SPDX-License-Identifier: Apache-2.0 */
#include "cpu/tool.h"

#include <stdlib.h>
#include <string.h>

ost_status ost_cpu_tool_adopt(ost_tool **tool, ost_error *err)
{
    cpu_shapes *shapes = calloc(1, sizeof *shapes);
    cpu_tool *grown = shapes ? realloc(*tool, sizeof *grown) : NULL;
    if (!grown) {
        free(shapes);
        ost_ref_tool_free(*tool);
        *tool = NULL;
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a tool");
    }
    grown->shapes = shapes;
    *tool = &grown->ref.base;
    return OST_OK;
}

ost_status ost_cpu_tool_upload(ost_backend *backend, const ost_tool_volume *volume, ost_tool **out, ost_error *err)
{
    ost_status status = ost_ref_tool_upload(backend, volume, out, err);
    return status == OST_OK ? ost_cpu_tool_adopt(out, err) : status;
}

static void drop(cpu_shapes *shapes)
{
    ost_shape_free(&shapes->cutting);
    ost_shape_free(&shapes->touching);
}

void ost_cpu_tool_free(ost_tool *base)
{
    cpu_tool *tool = (cpu_tool *)base;
    drop(tool->shapes);
    free(tool->shapes);
    ost_ref_tool_free(base);
}

ost_status ost_cpu_tool_prepare(const cpu_tool *tool, ost_pm bone_voxel, ost_error *err)
{
    cpu_shapes *shapes = tool->shapes;
    const ost_tool_geometry *g = &tool->ref.base.geometry;
    /* bone_voxel is at most 16 times the tool's voxel (AR-MAP-2), which is at most 10^11 pm, so the product is
       below 2^61. */
    const int32_t ratio = (int32_t)(((bone_voxel << OST_MAP_FRACTION) + g->voxel - 1) / g->voxel);
    if (ost_shape_covers_ratio(&shapes->cutting, ratio))
        return OST_OK;
    drop(shapes);
    shapes->touches = memchr(tool->ref.voxels, OST_TOOL_NONCUTTING, (size_t)ost_dims_count(g->dims)) != NULL;
    ost_status status = ost_shape_make(tool->ref.voxels, g->dims, OST_TOOL_CUTTING, ratio, &shapes->cutting, err);
    if (status == OST_OK && shapes->touches)
        status = ost_shape_make(tool->ref.voxels, g->dims, OST_TOOL_NONCUTTING, ratio, &shapes->touching, err);
    if (status != OST_OK)
        drop(shapes);
    return status;
}
