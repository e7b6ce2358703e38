/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The tools of the `cl` backend. For each voxel, a tool has a class (one uint8) and a cell, which
 * removal reads. A cell is the class together with the voxel's reach (kernels/shared.h).
 */
#include "cl/objects.h"

#include <stdlib.h>
#include <string.h>

static size_t voxels_of(const ost_tool_geometry *geometry)
{
    return (size_t)ost_dims_count(geometry->dims);
}

ost_status ost_cl_tool_create(ost_backend *backend, const ost_tool_geometry *geometry, cl_tool **out, ost_error *err)
{
    cl_tool *tool = calloc(1, sizeof *tool);
    if (!tool)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a tool");
    tool->base = (ost_tool){.backend = backend, .geometry = *geometry};
    ost_status status = ost_cl_spare_take((cl_backend *)backend, voxels_of(geometry), "tool", &tool->classes,
                                          &tool->reserved, err);
    if (status != OST_OK) {
        free(tool);
        return status;
    }
    *out = tool;
    return OST_OK;
}

ost_status ost_cl_tool_upload(ost_backend *backend, const ost_tool_volume *volume, ost_tool **out, ost_error *err)
{
    cl_tool *tool;
    ost_status status = ost_cl_tool_create(backend, &volume->geometry, &tool, err);
    if (status != OST_OK)
        return status;
    tool->touches = memchr(volume->voxels, OST_TOOL_NONCUTTING, voxels_of(&volume->geometry)) != NULL;
    status = ost_cl_write((cl_backend *)backend, tool->classes, 0, voxels_of(&volume->geometry), volume->voxels, err);
    if (status == OST_OK)
        *out = &tool->base;
    else
        ost_cl_tool_free(&tool->base);
    return status;
}

ost_status ost_cl_tool_download(const ost_tool *base, ost_tool_volume *volume, ost_error *err)
{
    const cl_tool *tool = (const cl_tool *)base;
    return ost_cl_read((cl_backend *)base->backend, tool->classes, 0, voxels_of(&base->geometry), volume->voxels, err);
}

void ost_cl_tool_free(ost_tool *base)
{
    cl_tool *tool = (cl_tool *)base;
    ost_cl_spare_return((cl_backend *)base->backend, &tool->classes, tool->reserved);
    ost_cl_buffer_free((cl_backend *)base->backend, &tool->cells);
    ost_cl_buffer_free((cl_backend *)base->backend, &tool->windows);
    free(tool);
}

static ost_status make_windows(cl_tool *tool, cl_mem *out, ost_error *err)
{
    cl_backend *b = (cl_backend *)tool->base.backend;
    const ost_dims dims = tool->base.geometry.dims;
    const ost_cl_tool shape = {.dims = {dims.x, dims.y, dims.z}, .axis = tool->touches ? 2 : 1};
    const size_t y = (size_t)OST_CL_WINDOWS_Y(dims.y), z = (size_t)OST_CL_WINDOWS_Z(dims.z);
    const size_t x = (size_t)OST_CL_WINDOWS_X(dims.x) * (tool->touches ? 2 : 1);
    cl_mem shape_buffer = NULL;
    ost_status status = ost_cl_buffer(b, x * y * z, NULL, "windows of a tool", out, err);
    if (status == OST_OK)
        status = ost_cl_buffer(b, sizeof shape, &shape, "tool", &shape_buffer, err);
    if (status == OST_OK)
        status = OST_CL_LAUNCH(b, ost_tool_windows, y, z, x, err, OST_CL_ARG(shape_buffer), OST_CL_ARG(tool->classes),
                               OST_CL_ARG(*out));
    ost_cl_buffer_free(b, &shape_buffer);
    if (status != OST_OK)
        ost_cl_buffer_free(b, out);
    return status;
}

/*
 * Computes the cells by three launches, one per axis. The launches use two buffers in turn: classes -> first -> second
 * -> first.
 */
ost_status ost_cl_tool_prepare(cl_tool *tool, ost_error *err)
{
    cl_backend *b = (cl_backend *)tool->base.backend;
    const ost_dims dims = tool->base.geometry.dims;
    const size_t bytes = voxels_of(&tool->base.geometry);
    if (tool->cells)
        return OST_OK;
    cl_mem first = NULL, second = NULL;
    ost_status status = ost_cl_buffer(b, bytes, NULL, "cells of a tool", &first, err);
    if (status == OST_OK)
        status = ost_cl_buffer(b, bytes, NULL, "cells of a tool", &second, err);
    for (int32_t axis = 0; axis < 3 && status == OST_OK; axis++) {
        const ost_cl_tool shape = {.dims = {dims.x, dims.y, dims.z}, .axis = axis};
        cl_mem shape_buffer = NULL,
               from = axis == 0   ? tool->classes
                      : axis == 1 ? first
                                  : second,
               to = axis == 1 ? second : first;
        status = ost_cl_buffer(b, sizeof shape, &shape, "tool", &shape_buffer, err);
        if (status == OST_OK)
            status = OST_CL_LAUNCH(b, ost_tool_reach, (size_t)dims.x, (size_t)dims.y, (size_t)dims.z, err,
                                   OST_CL_ARG(shape_buffer), OST_CL_ARG(from), OST_CL_ARG(to));
        ost_cl_buffer_free(b, &shape_buffer);
    }
    ost_cl_buffer_free(b, &second);
    if (status == OST_OK && b->cpu_set)
        status = make_windows(tool, &tool->windows, err);
    if (status != OST_OK)
        ost_cl_buffer_free(b, &first);
    tool->cells = first;
    return status;
}

void ost_cl_tool_finish(cl_tool *tool, bool done)
{
    cl_backend *b = (cl_backend *)tool->base.backend;
    tool->made = tool->made || done;
    if (tool->made)
        return;
    ost_cl_buffer_free(b, &tool->cells);
    ost_cl_buffer_free(b, &tool->windows);
}
