/* SPDX-License-Identifier: Apache-2.0 */
#include "bench/inputs.h"

#include <math.h>

/* ------------------------------------------------------------- tools, grids */

ost_status bench_tool_make(ost_backend *backend, ost_tool_kind kind, const ost_tool_options *options, ost_pm voxel,
                           ost_tool **out, ost_error *err)
{
    ost_mesh mesh = {0};
    ost_snapped_mesh snapped = {0};
    ost_tool_geometry grid;
    ost_pm3 lo, hi;
    ost_status status = ost_tool_make(kind, options, &mesh, err);
    if (status == OST_OK)
        status = ost_mesh_bounds(&mesh, &lo, &hi, err);
    if (status == OST_OK)
        status = ost_tool_geometry_from_bounds(lo, hi, voxel, &grid, err);
    if (status == OST_OK)
        status = ost_mesh_snap(&mesh, &grid, &snapped, err);
    if (status == OST_OK)
        status = ost_voxelize(backend, &snapped, NULL, OST_FILL_WINDING, NULL, out, err);
    ost_snapped_mesh_free(&snapped);
    ost_mesh_free(&mesh);
    return status;
}

ost_status bench_tool_volume(const char *spec, ost_tool_kind kind, ost_pm voxel, ost_tool_volume *out, ost_error *err)
{
    ost_backend *backend = NULL;
    ost_tool *tool = NULL;
    ost_status status = ost_backend_open(spec, &backend, err);
    if (status == OST_OK)
        status = bench_tool_make(backend, kind, NULL, voxel, &tool, err);
    if (status == OST_OK)
        status = ost_tool_download(tool, out, err);
    ost_tool_free(tool);
    ost_backend_close(backend);
    return status;
}

ost_status bench_cubic_make(ost_backend *backend, const ost_volume *rect, ost_volume *out, ost_error *err)
{
    const ost_geometry *g = &rect->geometry;
    ost_grid *grid = NULL, *cubic = NULL;
    ost_status status = ost_grid_create(backend, g, &grid, err);
    if (status == OST_OK)
        status = ost_grid_upload(grid, 0, g->dims.z, rect->voxels, err);
    if (status == OST_OK)
        status = ost_rect_to_cubic(grid, g->spacing.x, OST_RESAMPLE_LINEAR, &cubic, err);
    if (status == OST_OK)
        status = ost_volume_init(out, ost_grid_geometry(cubic), err);
    if (status == OST_OK)
        status = ost_grid_download(cubic, 0, out->geometry.dims.z, out->voxels, err);
    ost_grid_free(cubic);
    ost_grid_free(grid);
    return status;
}

/* -------------------------------------------------------------------- cuts */

/* Stores in `words` the voxels of a block that remain outside a ball. Returns true if any voxel is removed. */
static bool carve_block(const ost_surface_block *b, const double at[3], double radius, uint32_t words[OST_BLOCK_ROWS])
{
    bool any = false;
    for (int row = 0; row < OST_BLOCK_ROWS; row++) {
        const double y = OST_BLOCK * b->at[1] + row % OST_BLOCK - at[1],
                     z = OST_BLOCK * b->at[2] + row / OST_BLOCK - at[2], first = OST_BLOCK * b->at[0] - at[0];
        const double left = radius * radius - y * y - z * z;
        uint32_t gone = 0;
        for (int x = 0; x < OST_BLOCK && left >= 0 && b->occupied[row]; x++)
            gone |= (uint32_t)((first + x) * (first + x) <= left) << x;
        words[row] = b->occupied[row] & ~gone;
        any |= words[row] != b->occupied[row];
    }
    return any;
}

ost_status bench_carve(ost_surface *surface, const double at[3], double radius, int32_t *changed, ost_error *err)
{
    ost_status status = OST_OK;
    uint32_t words[OST_BLOCK_ROWS];
    *changed = 0;
    for (int32_t i = 0; i < surface->used && status == OST_OK; i++) {
        const ost_surface_block *b = surface->slot[i];
        double away = 0;
        for (int a = 0; a < 3; a++)
            away += pow(fmax(fabs(OST_BLOCK * b->at[a] + 15.5 - at[a]) - 16, 0), 2);
        if (away > radius * radius || !carve_block(b, at, radius, words))
            continue;
        status = ost_surface_set(surface, b->at, words, err);
        ++*changed;
    }
    return status;
}
