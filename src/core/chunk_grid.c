/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A simple serial implementation of the chunk grid.  A slab of slices z0 <= k < z1 is copied in rows of up to n voxels;
 * the struct chunk_part describes the intersection of a slab with one chunk.
 */
#include "core/chunk_grid.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "core/conditions.h"

static int32_t min32(int32_t a, int32_t b)
{
    return a < b ? a : b;
}

static int32_t max32(int32_t a, int32_t b)
{
    return a > b ? a : b;
}

ost_dims ost_chunk_dims(ost_dims dims, int size)
{
    return (ost_dims){(dims.x + size - 1) / size, (dims.y + size - 1) / size, (dims.z + size - 1) / size};
}

size_t ost_chunk_bytes(int size)
{
    size_t voxels = (size_t)size * (size_t)size * (size_t)size;
    return voxels * sizeof(int16_t) + voxels / 8;
}

ost_status ost_chunk_grid_init(ost_chunk_grid *grid, ost_dims dims, int size, int32_t threshold, ost_error *err)
{
    assert(size == 16 || size == 32 || size == 64);
    assert(threshold >= 1 && threshold <= INT16_MAX);
    ost_dims chunk_dims = ost_chunk_dims(dims, size);
    *grid = (ost_chunk_grid){.dims = dims,
                             .size = size,
                             .threshold = threshold,
                             .chunk_dims = chunk_dims,
                             .count = ost_dims_count(chunk_dims)};
    grid->chunks = calloc((size_t)grid->count, sizeof *grid->chunks);
    if (!grid->chunks)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a table of %lld chunks", (long long)grid->count);
    return OST_OK;
}

void ost_chunk_grid_free(ost_chunk_grid *grid)
{
    if (grid->chunks)
        for (int64_t i = 0; i < grid->count; i++)
            free(grid->chunks[i].density);
    free(grid->chunks);
    *grid = (ost_chunk_grid){0};
}

/* Allocates memory filled with zeros for a chunk that has none. Returns false if memory is exhausted. */
static bool chunk_fill(const ost_chunk_grid *grid, ost_chunk *chunk)
{
    assert(!chunk->density && chunk->active == 0);
    size_t bytes = ost_chunk_bytes(grid->size);
    /*
     * A voxel has 2 bytes of density and 1/8 byte of occupancy, so the densities take 16/17 of the memory block. The
     * occupancy words follow them.
     */
    size_t densities = bytes / 17 * 16;
    unsigned char *block = aligned_alloc(64, bytes);
    if (!block)
        return false;
    memset(block, 0, bytes);
    chunk->density = (int16_t *)(void *)block;
    chunk->occupancy = (uint32_t *)(void *)(block + densities);
    return true;
}

void ost_chunk_release(ost_chunk *chunk)
{
    assert(chunk->active == 0);
    free(chunk->density);
    *chunk = (ost_chunk){0};
}

void ost_chunk_keep(const ost_chunk_grid *grid, ost_chunk *chunk, const uint32_t *occupancy)
{
    if (chunk->active == 0)
        return;
    const size_t words = (size_t)grid->size * (size_t)grid->size * (size_t)grid->size / 32;
    for (size_t w = 0; w < words; w++) {
        uint32_t removed = chunk->occupancy[w] & ~occupancy[w];
        chunk->occupancy[w] ^= removed;
        for (; removed; removed &= removed - 1) {
            chunk->density[w * 32 + (size_t)__builtin_ctz(removed)] = 0;
            chunk->active--;
        }
    }
    if (chunk->active == 0)
        ost_chunk_release(chunk);
}

void ost_chunk_grid_sample(const ost_chunk_grid *grid, size_t count, const int32_t *const at[3], int16_t *densities)
{
    const int n = grid->size;
    for (size_t i = 0; i < count; i++) {
        const ost_dims v = {at[0][i], at[1][i], at[2][i]};
        densities[i] = 0;
        if (v.x < 0 || v.y < 0 || v.z < 0 || v.x >= grid->dims.x || v.y >= grid->dims.y || v.z >= grid->dims.z)
            continue;
        const int64_t row = v.y / n + (int64_t)grid->chunk_dims.y * (v.z / n);
        const ost_chunk *chunk = &grid->chunks[v.x / n + grid->chunk_dims.x * row];
        if (chunk->density)
            densities[i] = chunk->density[v.x % n + n * (v.y % n + n * (v.z % n))];
    }
}

/*
 * The intersection of a slab and a chunk: voxels [x0, x1) x [y0, y1) x [z0, z1) of the grid. `first` is
 * the first voxel of the chunk.
 */
typedef struct chunk_part {
    int32_t first[3];
    int32_t x0, x1, y0, y1, z0, z1;
} chunk_part;

static chunk_part part_of(const ost_chunk_grid *grid, int32_t cx, int32_t cy, int32_t cz, int32_t z0, int32_t z1)
{
    int32_t n = grid->size;
    return (chunk_part){
        .first = {cx * n, cy * n, cz * n},
        .x0 = cx * n,
        .x1 = min32(cx * n + n, grid->dims.x),
        .y0 = cy * n,
        .y1 = min32(cy * n + n, grid->dims.y),
        .z0 = max32(cz * n, z0),
        .z1 = min32(cz * n + n, z1),
    };
}

static ost_chunk *chunk_at(const ost_chunk_grid *grid, int32_t cx, int32_t cy, int32_t cz)
{
    return &grid->chunks[cx + (int64_t)grid->chunk_dims.x * (cy + (int64_t)grid->chunk_dims.y * cz)];
}

/* Returns the offset of the grid's row (y, z) in a slab that begins at slice z0. */
static size_t slab_row(const ost_chunk_grid *grid, int32_t y, int32_t z, int32_t z0)
{
    return ((size_t)(z - z0) * (size_t)grid->dims.y + (size_t)y) * (size_t)grid->dims.x;
}

static size_t chunk_row(const ost_chunk_grid *grid, const chunk_part *part, int32_t y, int32_t z)
{
    size_t n = (size_t)grid->size;
    return ((size_t)(z - part->first[2]) * n + (size_t)(y - part->first[1])) * n;
}

static bool part_has_active(const ost_chunk_grid *grid, const chunk_part *part, const int16_t *slab, int32_t z0)
{
    for (int32_t z = part->z0; z < part->z1; z++)
        for (int32_t y = part->y0; y < part->y1; y++) {
            const int16_t *row = slab + slab_row(grid, y, z, z0);
            for (int32_t x = part->x0; x < part->x1; x++)
                if (row[x] >= grid->threshold)
                    return true;
        }
    return false;
}

static void store_part(const ost_chunk_grid *grid, ost_chunk *chunk, const chunk_part *part, const int16_t *slab,
                       int32_t z0)
{
    for (int32_t z = part->z0; z < part->z1; z++)
        for (int32_t y = part->y0; y < part->y1; y++) {
            const int16_t *row = slab + slab_row(grid, y, z, z0);
            size_t v = chunk_row(grid, part, y, z);
            for (int32_t x = part->x0; x < part->x1; x++, v++) {
                uint32_t bit = UINT32_C(1) << (v % 32);
                uint32_t *word = &chunk->occupancy[v / 32];
                bool was = (*word & bit) != 0;
                bool is = row[x] >= grid->threshold;
                chunk->density[v] = is ? row[x] : 0;
                *word = is ? *word | bit : *word & ~bit;
                chunk->active += is - was;
            }
        }
}

ost_status ost_chunk_grid_upload(ost_chunk_grid *grid, int32_t z0, int32_t count, const int16_t *voxels, ost_error *err)
{
    assert(z0 >= 0 && count >= 0 && count <= grid->dims.z - z0);
    if (count == 0)
        return OST_OK;
    int32_t z1 = z0 + count;
    int32_t c0 = z0 / grid->size, c1 = (z1 - 1) / grid->size + 1;

    /*
     * All memory is allocated before any voxel changes, so that the function can restore the grid if an allocation
     * fails.
     */
    bool enough = true;
    for (int32_t cz = c0; cz < c1 && enough; cz++)
        for (int32_t cy = 0; cy < grid->chunk_dims.y && enough; cy++)
            for (int32_t cx = 0; cx < grid->chunk_dims.x && enough; cx++) {
                ost_chunk *chunk = chunk_at(grid, cx, cy, cz);
                chunk_part part = part_of(grid, cx, cy, cz, z0, z1);
                if (!chunk->density && part_has_active(grid, &part, voxels, z0))
                    enough = chunk_fill(grid, chunk);
            }

    for (int32_t cz = c0; cz < c1; cz++)
        for (int32_t cy = 0; cy < grid->chunk_dims.y; cy++)
            for (int32_t cx = 0; cx < grid->chunk_dims.x; cx++) {
                ost_chunk *chunk = chunk_at(grid, cx, cy, cz);
                chunk_part part = part_of(grid, cx, cy, cz, z0, z1);
                if (chunk->density && enough)
                    store_part(grid, chunk, &part, voxels, z0);
                if (chunk->density && chunk->active == 0)
                    ost_chunk_release(chunk);
            }
    if (!enough)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for the chunks of slices %d to %d (%zu bytes each)", z0,
                        z1 - 1, ost_chunk_bytes(grid->size));
    return OST_OK;
}

void ost_chunk_grid_download(const ost_chunk_grid *grid, int32_t z0, int32_t count, int16_t *voxels)
{
    assert(z0 >= 0 && count >= 0 && count <= grid->dims.z - z0);
    if (count == 0)
        return;
    int32_t z1 = z0 + count;
    for (int32_t cz = z0 / grid->size; cz <= (z1 - 1) / grid->size; cz++)
        for (int32_t cy = 0; cy < grid->chunk_dims.y; cy++)
            for (int32_t cx = 0; cx < grid->chunk_dims.x; cx++) {
                const ost_chunk *chunk = chunk_at(grid, cx, cy, cz);
                chunk_part part = part_of(grid, cx, cy, cz, z0, z1);
                size_t bytes = (size_t)(part.x1 - part.x0) * sizeof *voxels;
                for (int32_t z = part.z0; z < part.z1; z++)
                    for (int32_t y = part.y0; y < part.y1; y++) {
                        int16_t *row = voxels + slab_row(grid, y, z, z0) + part.x0;
                        if (chunk->density)
                            memcpy(row, chunk->density + chunk_row(grid, &part, y, z), bytes);
                        else
                            memset(row, 0, bytes);
                    }
            }
}

bool ost_chunk_grid_leaf(const ost_chunk_grid *grid, ost_dims leaf, int16_t voxels[OST_LEAF * OST_LEAF * OST_LEAF])
{
    int32_t n = grid->size;
    int32_t first[3] = {leaf.x * OST_LEAF, leaf.y * OST_LEAF, leaf.z * OST_LEAF};
    /*
     * A leaf consists of (32/n)^3 complete chunks or, if n is 64, of an eighth of a chunk. The variable `part` is the
     * edge length of the intersection of a leaf and a chunk.
     */
    int32_t part = min32(n, OST_LEAF);
    bool found = false;
    for (int32_t z = 0; z < OST_LEAF; z += part)
        for (int32_t y = 0; y < OST_LEAF; y += part)
            for (int32_t x = 0; x < OST_LEAF; x += part) {
                int32_t cx = (first[0] + x) / n, cy = (first[1] + y) / n, cz = (first[2] + z) / n;
                if (cx >= grid->chunk_dims.x || cy >= grid->chunk_dims.y || cz >= grid->chunk_dims.z)
                    continue;
                const ost_chunk *chunk = chunk_at(grid, cx, cy, cz);
                if (!chunk->density)
                    continue;
                if (!found)
                    memset(voxels, 0, OST_LEAF * OST_LEAF * OST_LEAF * sizeof *voxels);
                found = true;
                for (int32_t k = 0; k < part; k++)
                    for (int32_t j = 0; j < part; j++) {
                        size_t from = (size_t)((first[0] + x) % n +
                                               n * ((first[1] + y) % n + j + n * ((first[2] + z) % n + k)));
                        size_t to = (size_t)(x + OST_LEAF * (y + j + OST_LEAF * (z + k)));
                        memcpy(voxels + to, chunk->density + from, (size_t)part * sizeof *voxels);
                    }
            }
    return found;
}

void ost_chunk_grid_count(const ost_chunk_grid *grid, int64_t *active_chunks, int64_t *active_voxels)
{
    int64_t chunks = 0, voxels = 0;
    for (int64_t i = 0; i < grid->count; i++) {
        chunks += grid->chunks[i].active > 0;
        voxels += grid->chunks[i].active;
    }
    *active_chunks = chunks;
    *active_voxels = voxels;
}
