/* SPDX-License-Identifier: Apache-2.0 */
/* The dense grids of the `cl` backend: creation, upload and download. The voxels are in a store, x fastest. */
#include "cl/objects.h"

#include <stdlib.h>

ost_status ost_cl_alive(const ost_backend *backend, bool lost, const char *what, ost_error *err)
{
    if (!lost)
        return OST_OK;
    return ost_fail(err, OST_ERR_UNAVAILABLE,
                    "the %s on OpenCL device '%.120s' is lost: the device failed while it was changed; create it "
                    "again from its last stored state", what, ((const cl_backend *)backend)->device.name);
}

static size_t grid_bytes(const ost_geometry *geometry)
{
    return (size_t)ost_dims_count(geometry->dims) * sizeof(int16_t);
}

static ost_status store_create(cl_backend *b, const ost_geometry *geometry, cl_store **out, ost_error *err)
{
    cl_store *store = calloc(1, sizeof *store);
    if (!store)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a grid");
    ost_status status = ost_cl_spare_take(b, grid_bytes(geometry), "grid", &store->voxels, &store->reserved, err);
    if (status != OST_OK) {
        free(store);
        return status;
    }
    store->holders = 1;
    *out = store;
    return OST_OK;
}

static void store_release(cl_backend *b, cl_store *store)
{
    if (--store->holders > 0)
        return;
    ost_cl_spare_return(b, &store->voxels, store->reserved);
    free(store);
}

ost_status ost_cl_grid_create_raw(ost_backend *backend, const ost_geometry *geometry, cl_store *store, ost_grid **out,
                                  ost_error *err)
{
    cl_grid *grid = calloc(1, sizeof *grid);
    if (!grid)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a grid");
    grid->base = (ost_grid){.backend = backend, .geometry = *geometry};
    grid->store = store;
    ost_status status = OST_OK;
    if (store)
        store->holders++;
    else
        status = store_create((cl_backend *)backend, geometry, &grid->store, err);
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
    ost_status status = ost_cl_grid_create_raw(backend, geometry, NULL, &grid, err);
    if (status == OST_OK)
        status = ost_cl_zero((cl_backend *)backend, ((cl_grid *)grid)->store->voxels, 0, grid_bytes(geometry), err);
    else
        return status;
    if (status != OST_OK)
        ost_cl_grid_free(grid);
    else
        *out = grid;
    return status;
}

ost_status ost_cl_grid_own(cl_grid *grid, ost_error *err)
{
    cl_backend *b = (cl_backend *)grid->base.backend;
    cl_store *own;
    if (!grid->sources && grid->store->holders == 1)
        return OST_OK;
    ost_status status = store_create(b, &grid->base.geometry, &own, err);
    if (status != OST_OK)
        return status;
    b->entered[grid->sources ? OST_CL_PATH_GRID_OF_LIST : OST_CL_PATH_GRID_COPIED]++;
    if (grid->sources)
        status = ost_cl_resample(b, grid->base.geometry.dims, grid->linear, grid->cubic, grid->sources,
                                 grid->store->voxels, own->voxels, err);
    else
        status = ost_cl_copy(b, grid->store->voxels, own->voxels, grid_bytes(&grid->base.geometry), err);
    if (status == OST_OK)
        /* the old store is the source of the kernel, so the kernel must end before the store is released */
        status = ost_cl_finish(b, err);
    if (status != OST_OK) {
        store_release(b, own);
        return status;
    }
    store_release(b, grid->store);
    ost_cl_buffer_free(b, &grid->cubic);
    ost_cl_buffer_free(b, &grid->sources);
    grid->store = own;
    return OST_OK;
}

void ost_cl_grid_free(ost_grid *base)
{
    cl_grid *grid = (cl_grid *)base;
    cl_backend *b = (cl_backend *)base->backend;
    store_release(b, grid->store);
    ost_cl_buffer_free(b, &grid->cubic);
    ost_cl_buffer_free(b, &grid->sources);
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
    if (status == OST_OK)
        status = ost_cl_grid_own(grid, err);
    if (status != OST_OK)
        return status;
    status = ost_cl_write((cl_backend *)base->backend, grid->store->voxels, slice * (size_t)z0, slice * (size_t)count,
                          voxels, err);
    grid->lost = status != OST_OK; /* A failed upload may have written some of the slices. */
    return status;
}

ost_status ost_cl_grid_download(const ost_grid *base, int32_t z0, int32_t count, int16_t *voxels, ost_error *err)
{
    /* The function casts away const, because a grid that is computed from a shared store first gets a store of its
       own. The values of the voxels do not change. */
    cl_grid *grid = (cl_grid *)(uintptr_t)base;
    const size_t slice = slice_bytes(&base->geometry);
    ost_status status = ost_cl_alive(base->backend, grid->lost, "grid", err);
    if (status == OST_OK && grid->sources)
        status = ost_cl_grid_own(grid, err);
    if (status != OST_OK)
        return status;
    return ost_cl_read((cl_backend *)base->backend, grid->store->voxels, slice * (size_t)z0, slice * (size_t)count,
                       voxels, err);
}
