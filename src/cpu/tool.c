/* SPDX-License-Identifier: Apache-2.0 */
#include "cpu/tool.h"

#include <stdlib.h>
#include <string.h>

#include "core/conditions.h"
#include "core/huge_pages.h"
#include "cpu/cpu.h"
#include "cpu/voxelize/voxelize.h"

static size_t rows_of(ost_dims dims)
{
    return (size_t)dims.y * (size_t)dims.z;
}

/*
 * Allocates the bits of one class without clearing them, because every word is written later. A page is
 * then first written by a thread that computes words of this page. Requests huge pages for large tools.
 */
static uint64_t *new_bits(ost_dims dims)
{
    void *p;
    const size_t size = rows_of(dims) * (size_t)ost_vox_words(dims.x) * sizeof(uint64_t);
    if (posix_memalign(&p, size >= OST_HUGE_PAGE ? OST_HUGE_PAGE : 64, size) != 0)
        return NULL;
    ost_request_huge_pages(p, size);
    return p;
}

ost_status ost_cpu_tool_create(ost_backend *backend, const ost_tool_geometry *geometry, bool both, cpu_tool **out,
                               ost_error *err)
{
    const ost_dims dims = geometry->dims;
    cpu_tool *tool = malloc(sizeof *tool);
    cpu_shapes *shapes = calloc(1, sizeof *shapes);
    uint64_t *cutting = new_bits(dims), *noncutting = both ? new_bits(dims) : NULL;
    if (!tool || !shapes || !cutting || (both && !noncutting)) {
        free(noncutting);
        free(cutting);
        free(shapes);
        free(tool);
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a tool of %d x %d x %d voxels", dims.x, dims.y,
                        dims.z);
    }
    *tool = (cpu_tool){.base = {.backend = backend, .geometry = *geometry},
                       .cutting = cutting,
                       .noncutting = noncutting,
                       .shapes = shapes};
    *out = tool;
    return OST_OK;
}

/* Sets the bits of the voxels of class `kind`, and clears all other bits of the rows. */
static void pack(const uint8_t *voxels, ost_dims dims, uint8_t kind, uint64_t *bits)
{
    const size_t words = (size_t)ost_vox_words(dims.x);
    memset(bits, 0, rows_of(dims) * words * sizeof *bits);
    for (size_t r = 0; r < rows_of(dims); r++, voxels += dims.x, bits += words)
        for (int32_t x = 0; x < dims.x; x++)
            bits[x / 64] |= (uint64_t)(voxels[x] == kind) << (x % 64);
}

ost_status ost_cpu_tool_upload(ost_backend *backend, const ost_tool_volume *volume, ost_tool **out, ost_error *err)
{
    const ost_dims dims = volume->geometry.dims;
    const bool both = memchr(volume->voxels, OST_TOOL_NONCUTTING, (size_t)ost_dims_count(dims)) != NULL;
    cpu_tool *tool;
    ost_status status = ost_cpu_tool_create(backend, &volume->geometry, both, &tool, err);
    if (status != OST_OK)
        return status;
    pack(volume->voxels, dims, OST_TOOL_CUTTING, tool->cutting);
    if (both)
        pack(volume->voxels, dims, OST_TOOL_NONCUTTING, tool->noncutting);
    *out = &tool->base;
    return OST_OK;
}

ost_status ost_cpu_tool_download(const ost_tool *base, ost_tool_volume *volume, ost_error *err)
{
    (void)err;
    const cpu_tool *tool = (const cpu_tool *)base;
    const cpu_backend *backend = (const cpu_backend *)base->backend;
    const ost_dims dims = base->geometry.dims;
    const int64_t count = ost_dims_count(dims);
    const size_t words = (size_t)ost_vox_words(dims.x) * (size_t)dims.y, voxels = (size_t)dims.x * (size_t)dims.y;
    const bool stream = ost_cpu_enters(backend->sharing, OST_PATH_TOOL_STREAM, count);
    ost_team team = ost_team_of(backend->sharing, backend->threads, OST_PATH_TOOL_DOWNLOAD, count, dims.z, 0);
#pragma omp parallel num_threads(team.threads) if (team.threads > 1)
    {
        ost_member me = ost_team_join(&team);
        for (int64_t z; (z = ost_team_next(&team, &me)) >= 0;)
            backend->kernels.vox_expand(tool->cutting + words * (size_t)z,
                                        tool->noncutting ? tool->noncutting + words * (size_t)z : NULL, (size_t)dims.y,
                                        ost_vox_words(dims.x), dims.x, stream, volume->voxels + voxels * (size_t)z);
    }
    ost_team_end(backend->sharing, &team);
    return OST_OK;
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
    free(tool->noncutting);
    free(tool->cutting);
    free(tool);
}

ost_status ost_cpu_tool_prepare(const cpu_tool *tool, ost_pm bone_voxel, ost_error *err)
{
    cpu_shapes *shapes = tool->shapes;
    const ost_tool_geometry *g = &tool->base.geometry;
    /* bone_voxel is at most 16 times the tool's voxel (AR-MAP-2), which is at most 10^11 pm, so the product is
       below 2^61. */
    const int32_t ratio = (int32_t)(((bone_voxel << OST_MAP_FRACTION) + g->voxel - 1) / g->voxel);
    if (ost_shape_covers_ratio(&shapes->cutting, ratio))
        return OST_OK;
    drop(shapes);
    const size_t words = (size_t)ost_vox_words(g->dims.x);
    ost_status status = ost_shape_make(tool->cutting, words, g->dims, ratio, &shapes->cutting, err);
    if (status == OST_OK && tool->noncutting)
        status = ost_shape_make(tool->noncutting, words, g->dims, ratio, &shapes->touching, err);
    if (status != OST_OK)
        drop(shapes);
    return status;
}
