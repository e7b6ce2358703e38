/* SPDX-License-Identifier: Apache-2.0 */
#include "io/import_digest.h"

#include <stdlib.h>
#include <string.h>

/* Copies one leaf from a slab. Voxels of the leaf beyond the grid are set to 0. */
static void copy_leaf(const int16_t *slab, ost_dims dims, int32_t depth, int32_t x0, int32_t y0, int16_t *leaf)
{
    int32_t width = dims.x - x0 < OST_LEAF ? dims.x - x0 : OST_LEAF;
    int32_t height = dims.y - y0 < OST_LEAF ? dims.y - y0 : OST_LEAF;
    memset(leaf, 0, sizeof *leaf * OST_LEAF * OST_LEAF * OST_LEAF);
    for (int32_t z = 0; z < depth; z++)
        for (int32_t y = 0; y < height; y++)
            memcpy(leaf + (size_t)OST_LEAF * (size_t)(y + OST_LEAF * z),
                   slab + (size_t)x0 + (size_t)dims.x * ((size_t)(y0 + y) + (size_t)dims.y * (size_t)z),
                   (size_t)width * sizeof *leaf);
}

ost_status ost_import_digest(const char *path, ost_grid_kind kind, const ost_grid *grid, ost_digest *out,
                             ost_error *err)
{
    const ost_geometry *g = ost_grid_geometry(grid);
    ost_dims leaf_dims = ost_leaf_dims(g->dims);
    size_t count = (size_t)ost_dims_count(leaf_dims), filled = 0;
    size_t slab_voxels = (size_t)g->dims.x * (size_t)g->dims.y * (size_t)(g->dims.z < OST_LEAF ? g->dims.z : OST_LEAF);
    ost_digest *leaves = malloc(count * sizeof *leaves);
    int16_t *slab = malloc(slab_voxels * sizeof *slab);
    int16_t *leaf = malloc(sizeof *leaf * OST_LEAF * OST_LEAF * OST_LEAF);
    ost_status status = OST_OK;
    if (!leaves || !slab || !leaf)
        status = ost_fail(err, OST_ERR_MEMORY, "%s: out of memory for the digests of %zu leaves", path, count);
    for (int32_t z0 = 0; z0 < g->dims.z && status == OST_OK; z0 += OST_LEAF) {
        int32_t depth = g->dims.z - z0 < OST_LEAF ? g->dims.z - z0 : OST_LEAF;
        status = ost_grid_download(grid, z0, depth, slab, err);
        for (int32_t y0 = 0; y0 < g->dims.y; y0 += OST_LEAF)
            for (int32_t x0 = 0; x0 < g->dims.x && status == OST_OK; x0 += OST_LEAF) {
                copy_leaf(slab, g->dims, depth, x0, y0, leaf);
                status = ost_digest_leaf16(leaf, &leaves[filled++], err);
            }
    }
    if (status == OST_OK)
        status = ost_digest_root(kind, g, 0, leaves, count, out, err);
    free(leaves);
    free(slab);
    free(leaf);
    return status;
}
