/* SPDX-License-Identifier: Apache-2.0 */
/* Dense grids: one buffer, x fastest, slices up and down. */
#include "cl/objects.h"

#include <stdlib.h>

ost_status ost_cl_alive(const ost_backend *backend, bool lost, const char *what, ost_error *err)
{
    if (!lost)
        return OST_OK;
    return ost_fail(err, OST_ERR_UNAVAILABLE,
                    "the %s on OpenCL device '%.120s' is lost: the device failed while it was changed; make it again from its last known "
                    "state, here or on another backend",
                    what, ((const cl_backend *)backend)->device.name);
}

static size_t grid_bytes(const ost_geometry *geometry)
{
    return (size_t)ost_dims_count(geometry->dims) * sizeof(int16_t);
}

ost_status ost_cl_grid_create_raw(ost_backend *backend, const ost_geometry *geometry, ost_grid **out, ost_error *err)
{
    cl_grid *grid = calloc(1, sizeof *grid);
    if (!grid)
        return ost_fail(err, OST_ERR_MEMORY, "no memory for a grid");
    grid->base = (ost_grid){.backend = backend, .geometry = *geometry};
    ost_status status = ost_cl_buffer((cl_backend *)backend, grid_bytes(geometry), NULL, "grid", &grid->voxels, err);
    if (status != OST_OK) {
        free(grid);
        return status;
    }
    *out = &grid->base;
    return OST_OK;
}

ost_status ost_cl_grid_create(ost_backend *backend, const ost_geometry *geometry, ost_grid **out, ost_error *err)
{
    ost_grid *grid;
    ost_status status = ost_cl_grid_create_raw(backend, geometry, &grid, err);
    if (status == OST_OK)
        status = ost_cl_zero((cl_backend *)backend, ((cl_grid *)grid)->voxels, 0, grid_bytes(geometry), err);
    else
        return status;
    if (status != OST_OK)
        ost_cl_grid_free(grid);
    else
        *out = grid;
    return status;
}

void ost_cl_grid_free(ost_grid *base)
{
    cl_grid *grid = (cl_grid *)base;
    cl_backend *b = (cl_backend *)base->backend;
    ost_cl_buffer_free(b, &grid->voxels);
    ost_cl_buffer_free(b, &grid->seen);
    ost_cl_buffer_free(b, &grid->owner);
    free(grid);
}

static size_t slice_bytes(const ost_geometry *geometry)
{
    return (size_t)geometry->dims.x * (size_t)geometry->dims.y * sizeof(int16_t);
}

ost_status ost_cl_grid_upload(ost_grid *base, int32_t z0, int32_t count, const int16_t *voxels, ost_error *err)
{
    cl_grid *grid = (cl_grid *)base;
    const size_t slice = slice_bytes(&base->geometry);
    ost_status status = ost_cl_alive(base->backend, grid->lost, "grid", err);
    if (status != OST_OK)
        return status;
    status = ost_cl_write((cl_backend *)base->backend, grid->voxels, slice * (size_t)z0, slice * (size_t)count, voxels, err);
    grid->lost = status != OST_OK; /* a part may be there */
    return status;
}

ost_status ost_cl_grid_download(const ost_grid *base, int32_t z0, int32_t count, int16_t *voxels, ost_error *err)
{
    const cl_grid *grid = (const cl_grid *)base;
    const size_t slice = slice_bytes(&base->geometry);
    ost_status status = ost_cl_alive(base->backend, grid->lost, "grid", err);
    return status == OST_OK ? ost_cl_read((cl_backend *)base->backend, grid->voxels, slice * (size_t)z0, slice * (size_t)count, voxels, err)
                            : status;
}
