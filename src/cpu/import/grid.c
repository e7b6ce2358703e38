/* SPDX-License-Identifier: Apache-2.0 */
#include "cpu/import/grid.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

#include "core/conditions.h"
#include "core/huge_pages.h"
#include "cpu/import/import.h"

/* ---------------------------------------------------------------- stores */

static cpu_store *store_open(const cpu_backend *backend, ost_dims dims)
{
    cpu_store *store = malloc(sizeof *store);
    if (!store)
        return NULL;
    *store = (cpu_store){.holders = 1, .dims = dims, .bytes = (size_t)ost_dims_count(dims) * sizeof *store->voxels};
    store->mapped = ost_cpu_enters(backend->sharing, OST_PATH_MAPPED, (int64_t)store->bytes);
    if (store->mapped) {
        void *map = mmap(NULL, store->bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
        store->voxels = map == MAP_FAILED ? NULL : map;
        ost_request_huge_pages(store->voxels, store->bytes);
    } else {
        store->voxels = calloc(store->bytes, 1);
    }
    if (!store->voxels) {
        free(store);
        return NULL;
    }
    return store;
}

static void store_drop(cpu_store *store)
{
    if (--store->holders > 0)
        return;
    if (store->mapped)
        munmap(store->voxels, store->bytes);
    else
        free(store->voxels);
    free(store);
}

static ost_status no_memory(ost_dims dims, ost_error *err)
{
    return ost_fail(err, OST_ERR_MEMORY, "out of memory for a grid of %d x %d x %d voxels (%lld bytes)", dims.x,
                    dims.y, dims.z, (long long)ost_dims_count(dims) * 2);
}

/* ----------------------------------------------------------------- views */

cpu_view ost_cpu_grid_view(const cpu_grid *grid)
{
    const cpu_store *store = grid->store;
    return (cpu_view){
        .voxels = store->voxels,
        .row = (size_t)store->dims.x,
        .slice = (size_t)store->dims.x * (size_t)store->dims.y,
        .map = {grid->map[0], grid->map[1], grid->map[2]},
        .minus = {grid->minus[0], grid->minus[1], grid->minus[2]},
    };
}

static void interpolated_row(const cpu_view *view, const ost_cpu_kernels *kernels, int32_t width, int32_t y, int32_t z,
                             int16_t *to)
{
    int16_t part[1][OST_ROW_STRIDE];
    const cpu_tap ty = ost_cpu_view_tap(view, 1, y), tz = ost_cpu_view_tap(view, 2, z);
    for (int32_t i = 0; i < width; i += OST_ROW_STRIDE) {
        const int32_t count = width - i < OST_ROW_STRIDE ? width - i : OST_ROW_STRIDE;
        ost_cpu_linear_rows(view, kernels, i, count, &ty, 1, &tz, 1, part);
        memcpy(to + i, part[0], (size_t)count * sizeof *to);
    }
}

/* Writes the first `width` voxels of row (y, z) of the view to `to`. */
static void view_row(const cpu_view *view, const ost_cpu_kernels *kernels, int32_t width, int32_t y, int32_t z,
                     int16_t *to)
{
    if (ost_cpu_view_linear(view)) {
        interpolated_row(view, kernels, width, y, z, to);
        return;
    }
    const int16_t *row = view->voxels + ost_cpu_view_tap(view, 1, y).from[0] + ost_cpu_view_tap(view, 2, z).from[0];
    const int32_t *map = view->map[0];
    if (!map) {
        memcpy(to, row, (size_t)width * sizeof *to);
        return;
    }
    for (int32_t i = 0; i < width; i += 64)
        kernels->gather_row(row, map + i, width - i < 64 ? width - i : 64, to + i);
}

static void copy_slices(const cpu_grid *grid, int32_t z0, int32_t count, int16_t *to)
{
    const cpu_backend *backend = (const cpu_backend *)grid->base.backend;
    const ost_dims dims = grid->base.geometry.dims;
    const cpu_view view = ost_cpu_grid_view(grid);
    int64_t rows = (int64_t)count * dims.y;
    ost_team team = ost_team_of(backend->sharing, backend->threads, OST_PATH_GRID_COPY, rows * dims.x, rows, 0);
#pragma omp parallel num_threads(team.threads)
    {
        ost_member me = ost_team_join(&team);
        for (int64_t r; (r = ost_team_next(&team, &me)) >= 0;)
            view_row(&view, &backend->kernels, dims.x, (int32_t)(r % dims.y), z0 + (int32_t)(r / dims.y),
                     to + r * dims.x);
    }
    ost_team_end(backend->sharing, &team);
}

/* ----------------------------------------------------------------- grids */

static ost_status grid_new(ost_backend *backend, const ost_geometry *geometry, cpu_store *store, cpu_grid **out,
                           ost_error *err)
{
    cpu_grid *grid = store ? malloc(sizeof *grid) : NULL;
    if (!grid)
        return no_memory(geometry->dims, err);
    *grid = (cpu_grid){.base = {.backend = backend, .geometry = *geometry}, .store = store};
    *out = grid;
    return OST_OK;
}

ost_status ost_cpu_grid_create(ost_backend *backend, const ost_geometry *geometry, ost_grid **out, ost_error *err)
{
    cpu_grid *grid;
    cpu_store *store = store_open((const cpu_backend *)backend, geometry->dims);
    ost_status status = grid_new(backend, geometry, store, &grid, err);
    if (status == OST_OK)
        *out = &grid->base;
    else if (store)
        store_drop(store);
    return status;
}

ost_status ost_cpu_grid_select(const cpu_grid *from, const ost_geometry *geometry, int32_t *map[3], int16_t *minus[3],
                               ost_grid **out, ost_error *err)
{
    cpu_grid *grid;
    ost_status status = grid_new(from->base.backend, geometry, from->store, &grid, err);
    for (int a = 0; a < 3; a++) {
        if (status == OST_OK) {
            grid->map[a] = map[a];
            grid->minus[a] = minus[a];
        } else {
            free(map[a]);
            free(minus[a]);
        }
    }
    if (status != OST_OK)
        return status;
    from->store->holders++;
    *out = &grid->base;
    return OST_OK;
}

ost_status ost_cpu_grid_own(cpu_grid *grid, ost_error *err)
{
    if (!grid->map[0] && grid->store->holders == 1)
        return OST_OK;
    cpu_store *store = store_open((const cpu_backend *)grid->base.backend, grid->base.geometry.dims);
    if (!store)
        return no_memory(grid->base.geometry.dims, err);
    copy_slices(grid, 0, grid->base.geometry.dims.z, store->voxels);
    store_drop(grid->store);
    grid->store = store;
    for (int a = 0; a < 3; a++) {
        free(grid->map[a]);
        free(grid->minus[a]);
        grid->map[a] = NULL;
        grid->minus[a] = NULL;
    }
    return OST_OK;
}

void ost_cpu_grid_free(ost_grid *base)
{
    cpu_grid *grid = (cpu_grid *)base;
    store_drop(grid->store);
    for (int a = 0; a < 3; a++) {
        free(grid->map[a]);
        free(grid->minus[a]);
    }
    free(grid->seen);
    free(grid);
}

ost_status ost_cpu_grid_upload(ost_grid *base, int32_t z0, int32_t count, const int16_t *voxels, ost_error *err)
{
    cpu_grid *grid = (cpu_grid *)base;
    const cpu_backend *backend = (const cpu_backend *)base->backend;
    ost_status status = ost_cpu_grid_own(grid, err);
    if (status != OST_OK)
        return status;
    size_t slice = (size_t)base->geometry.dims.x * (size_t)base->geometry.dims.y;
    int16_t *to = grid->store->voxels + slice * (size_t)z0;
    ost_team team = ost_team_of(backend->sharing, backend->threads, OST_PATH_GRID_UPLOAD, (int64_t)slice * count, count,
                                0);
#pragma omp parallel num_threads(team.threads)
    {
        ost_member me = ost_team_join(&team);
        for (int64_t z; (z = ost_team_next(&team, &me)) >= 0;)
            memcpy(to + slice * (size_t)z, voxels + slice * (size_t)z, slice * sizeof *to);
    }
    ost_team_end(backend->sharing, &team);
    return OST_OK;
}

ost_status ost_cpu_grid_download(const ost_grid *base, int32_t z0, int32_t count, int16_t *voxels, ost_error *err)
{
    (void)err;
    copy_slices((const cpu_grid *)base, z0, count, voxels);
    return OST_OK;
}
