/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Uploads and downloads slices of a bone whose voxels are stored as bricks. A layer of
 * bricks is four slices high, but the uploaded slices (a slab) may contain only some of
 * these four. Rows of the layer that are not in the slab are therefore read from the bone,
 * or are zero if they lie outside the grid. One kernel then converts sixteen rows into a
 * row of bricks:
 *
 *     rows (y, z), y and z in 0..3          bricks of the row
 *     ----- ----- ----- -----               [ 0 ][ 1 ][ 2 ] ...
 *
 * Upload, download and the computation of leaves for the digest copy four voxels at a time.
 */
#include "cpu/bone/bone.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "core/chunk_grid.h"
#include "core/conditions.h"
#include "cpu/cpu.h"

enum { CHUNK_MAX = 64 };

static int32_t min32(int32_t a, int32_t b)
{
    return a < b ? a : b;
}

static int32_t max32(int32_t a, int32_t b)
{
    return a > b ? a : b;
}

ost_status ost_cpu_bone_create(ost_backend *backend, const ost_geometry *geometry, int chunk_size, int32_t threshold,
                               ost_bone **out, ost_error *err)
{
    const ost_dims dims = ost_chunk_dims(geometry->dims, chunk_size);
    cpu_bone *bone = malloc(sizeof *bone);
    cpu_chunk *chunks = calloc((size_t)ost_dims_count(dims), sizeof *chunks);
    if (!bone || !chunks) {
        free(chunks);
        free(bone);
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a table of %lld chunks",
                        (long long)ost_dims_count(dims));
    }
    *bone = (cpu_bone){
        .base = {.backend = backend, .geometry = *geometry, .chunk_size = chunk_size, .threshold = threshold},
        .chunk_dims = dims,
        .count = ost_dims_count(dims),
        .chunks = chunks,
    };
    *out = &bone->base;
    return OST_OK;
}

static void give_back(cpu_chunk *chunk)
{
    if (chunk->pool)
        ost_chunk_pool_give(chunk->pool, chunk->density);
    else
        free(chunk->density);
}

void ost_cpu_bone_free(ost_bone *base)
{
    cpu_bone *bone = (cpu_bone *)base;
    ost_chunk_pool *pool = NULL;
    for (int64_t i = 0; i < bone->count; i++) {
        pool = bone->chunks[i].pool ? bone->chunks[i].pool : pool;
        give_back(&bone->chunks[i]);
    }
    if (pool)
        ost_chunk_pool_trim(pool);
    free(bone->chunks);
    free(bone);
}

bool ost_cpu_chunk_take(const cpu_bone *bone, ost_chunk_pool *pool, cpu_chunk *chunk)
{
    const size_t bytes = ost_chunk_bytes(bone->base.chunk_size);
    /* Each voxel has 2 bytes of density and 1/8 byte of occupancy. In the block, densities precede occupancy. */
    const size_t densities = bytes / 17 * 16;
    unsigned char *block = pool ? ost_chunk_pool_take(pool) : NULL;
    if (!block) {
        pool = NULL;
        block = aligned_alloc(64, bytes);
    }
    if (!block)
        return false;
    *chunk = (cpu_chunk){
        .density = (int16_t *)(void *)block, .occupancy = (uint64_t *)(void *)(block + densities), .pool = pool};
    return true;
}

static bool fill(const cpu_bone *bone, cpu_chunk *chunk)
{
    if (!ost_cpu_chunk_take(bone, NULL, chunk))
        return false;
    memset(chunk->density, 0, ost_chunk_bytes(bone->base.chunk_size));
    return true;
}

void ost_cpu_chunk_release(cpu_chunk *chunk)
{
    assert(chunk->active == 0);
    give_back(chunk);
    *chunk = (cpu_chunk){0};
}

ost_status ost_cpu_bone_stats(const ost_bone *base, ost_bone_info *info, ost_error *err)
{
    (void)err;
    const cpu_bone *bone = (const cpu_bone *)base;
    const ost_chunk_pool *pool = NULL;
    info->active_chunks = info->active_voxels = 0;
    for (int64_t i = 0; i < bone->count; i++) {
        pool = bone->chunks[i].pool ? bone->chunks[i].pool : pool;
        info->active_chunks += bone->chunks[i].active > 0;
        info->active_voxels += bone->chunks[i].active;
    }
    info->chunk_bytes = info->active_chunks * (int64_t)ost_chunk_bytes(base->chunk_size);
    info->resident_bytes = info->chunk_bytes + bone->count * (int64_t)sizeof *bone->chunks + (int64_t)sizeof *bone +
                           (pool ? (int64_t)ost_chunk_pool_overhead(pool) : 0);
    return OST_OK;
}

/* ---------------------------------------------------------------- upload */

/* A slab of a grid: the slices z0 <= z < z1. `voxels` points to the first voxel of slice z0. */
typedef struct slab {
    ost_dims dims;
    int32_t z0, z1;
    const int16_t *voxels;
} slab;

static const int16_t *slab_row(const slab *s, int32_t y, int32_t z)
{
    return s->voxels + ((size_t)(z - s->z0) * (size_t)s->dims.y + (size_t)y) * (size_t)s->dims.x;
}

typedef struct chunk_position {
    int32_t first[3]; /* grid coordinates of the chunk's first voxel */
    int32_t end[3];   /* grid coordinates at which the chunk ends (exclusive), clipped to the grid */
} chunk_position;

static chunk_position chunk_position_of(const cpu_bone *bone, int64_t index)
{
    const ost_dims d = bone->chunk_dims, g = bone->base.geometry.dims;
    const int32_t n = bone->base.chunk_size;
    const int32_t x = (int32_t)(index % d.x) * n, y = (int32_t)(index / d.x % d.y) * n,
                  z = (int32_t)(index / d.x / d.y) * n;
    return (chunk_position){{x, y, z}, {min32(x + n, g.x), min32(y + n, g.y), min32(z + n, g.z)}};
}

static bool any_active(const cpu_bone *bone, const chunk_position *at, const slab *s)
{
    for (int32_t z = max32(at->first[2], s->z0); z < min32(at->end[2], s->z1); z++)
        for (int32_t y = at->first[1]; y < at->end[1]; y++) {
            const int16_t *row = slab_row(s, y, z);
            int16_t highest = INT16_MIN;
            for (int32_t x = at->first[0]; x < at->end[0]; x++)
                highest = row[x] > highest ? row[x] : highest;
            if (highest >= bone->base.threshold)
                return true;
        }
    return false;
}

/*
 * Copies a row of n voxels from the bricks of a chunk to `row`. The coordinates y and z are relative to the chunk's
 * first voxel.
 */
static void read_row(const cpu_chunk *chunk, int32_t n, int32_t y, int32_t z, int16_t *row)
{
    /* spread[x] is ost_brick_spread(x), for the 16 bricks of a row of 64 voxels. */
    static const uint16_t spread[CHUNK_MAX / 4] = {0, 1, 8, 9, 64, 65, 72, 73, 512, 513, 520, 521, 576, 577, 584, 585};
    const int16_t *bricks = chunk->density + (size_t)ost_brick_number(0, y / 4, z / 4) * OST_BRICK_VOXELS +
                            (y % 4) * 4 + (z % 4) * 16;
    for (int32_t x = 0; x < n / 4; x++)
        memcpy(row + 4 * x, bricks + (size_t)spread[x] * OST_BRICK_VOXELS, 4 * sizeof *row);
}

/*
 * Collects the sixteen rows of voxels that form the row of bricks at (y, z). A row that lies entirely in the slab is
 * used without a copy; any other row is assembled in `spare`.
 */
static void collect_rows(const cpu_bone *bone, const cpu_chunk *chunk, const chunk_position *at, const slab *s,
                         int32_t y, int32_t z, int16_t spare[16][CHUNK_MAX], const int16_t *rows[16])
{
    const int32_t n = bone->base.chunk_size, width = at->end[0] - at->first[0];
    for (int32_t r = 0; r < 16; r++) {
        const int32_t gy = at->first[1] + y + r % 4, gz = at->first[2] + z + r / 4;
        const bool in_grid = gy < at->end[1] && gz < at->end[2];
        rows[r] = spare[r];
        if (in_grid && gz >= s->z0 && gz < s->z1) {
            const int16_t *from = slab_row(s, gy, gz) + at->first[0];
            if (width == n) {
                rows[r] = from;
            } else {
                memcpy(spare[r], from, (size_t)width * sizeof *from);
                memset(spare[r] + width, 0, (size_t)(n - width) * sizeof *from);
            }
        } else if (in_grid) {
            read_row(chunk, n, y + r % 4, z + r / 4, spare[r]);
        } else {
            memset(spare[r], 0, (size_t)n * sizeof(int16_t));
        }
    }
}

static int32_t active_in(const uint64_t *occupancy, size_t words)
{
    int32_t active = 0;
    for (size_t i = 0; i < words; i++)
        active += __builtin_popcountll(occupancy[i]);
    return active;
}

static void store_chunk(const cpu_bone *bone, cpu_chunk *chunk, const chunk_position *at, const slab *s)
{
    const ost_cpu_kernels *kernels = &((const cpu_backend *)bone->base.backend)->kernels;
    const int32_t n = bone->base.chunk_size;
    const int32_t lo = (max32(at->first[2], s->z0) - at->first[2]) & ~3, hi = min32(at->end[2], s->z1) - at->first[2];
    _Alignas(64) int16_t spare[16][CHUNK_MAX];
    for (int32_t z = lo; z < hi; z += 4)
        for (int32_t y = 0; y < n; y += 4) {
            const int16_t *rows[16];
            collect_rows(bone, chunk, at, s, y, z, spare, rows);
            const size_t brick = (size_t)ost_brick_number(0, y / 4, z / 4);
            ost_brick_sums sums = kernels->brick_row(rows, (size_t)n / 4, (int16_t)bone->base.threshold, false,
                                                 chunk->density + brick * OST_BRICK_VOXELS, chunk->occupancy + brick);
            chunk->highest = max32(chunk->highest, sums.highest);
        }
    chunk->active = active_in(chunk->occupancy, (size_t)(n / 4) * (size_t)(n / 4) * (size_t)(n / 4));
}

ost_status ost_cpu_bone_upload(ost_bone *base, int32_t z0, int32_t count, const int16_t *voxels, ost_error *err)
{
    cpu_bone *bone = (cpu_bone *)base;
    if (count == 0)
        return OST_OK;
    const slab s = {.dims = base->geometry.dims, .z0 = z0, .z1 = z0 + count, .voxels = voxels};
    const int64_t layer = (int64_t)bone->chunk_dims.x * bone->chunk_dims.y;
    const int64_t from = z0 / base->chunk_size * layer, to = ((z0 + count - 1) / base->chunk_size + 1) * layer;
    const cpu_backend *backend = (const cpu_backend *)base->backend;

    /* All memory is allocated before the first voxel changes, so that a failed allocation can be undone. */
    bool enough = true;
    ost_team filling = ost_team_of(backend->sharing, backend->threads, OST_PATH_BONE_UPLOAD, count, to - from, 4),
             storing = filling;
#pragma omp parallel num_threads(filling.threads) if (filling.threads > 1) reduction(&& : enough)
    {
        ost_member me = ost_team_join(&filling);
        for (int64_t n; (n = ost_team_next(&filling, &me)) >= 0;) {
            const int64_t i = from + n;
            chunk_position at = chunk_position_of(bone, i);
            if (!bone->chunks[i].density && any_active(bone, &at, &s))
                enough = fill(bone, &bone->chunks[i]) && enough;
        }
    }
#pragma omp parallel num_threads(storing.threads) if (storing.threads > 1)
    {
        ost_member me = ost_team_join(&storing);
        for (int64_t n; (n = ost_team_next(&storing, &me)) >= 0;) {
            cpu_chunk *chunk = &bone->chunks[from + n];
            chunk_position at = chunk_position_of(bone, from + n);
            if (chunk->density && enough)
                store_chunk(bone, chunk, &at, &s);
            if (chunk->density && chunk->active == 0)
                ost_cpu_chunk_release(chunk);
        }
    }
    ost_team_end(backend->sharing, &storing);
    if (!enough)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for the chunks of slices %d to %d (%zu bytes each)", z0,
                        z0 + count - 1, ost_chunk_bytes(base->chunk_size));
    return OST_OK;
}

/* -------------------------------------------------------------- download */

ost_status ost_cpu_bone_download(const ost_bone *base, int32_t z0, int32_t count, int16_t *voxels, ost_error *err)
{
    (void)err;
    const cpu_bone *bone = (const cpu_bone *)base;
    const ost_dims dims = base->geometry.dims;
    const int32_t n = base->chunk_size;
    for (int32_t z = z0; z < z0 + count; z++)
        for (int32_t y = 0; y < dims.y; y++)
            for (int32_t cx = 0; cx < bone->chunk_dims.x; cx++) {
                const cpu_chunk *chunk =
                    &bone->chunks[cx + (int64_t)bone->chunk_dims.x * (y / n + (int64_t)bone->chunk_dims.y * (z / n))];
                int16_t row[CHUNK_MAX];
                const size_t bytes = (size_t)min32(n, dims.x - cx * n) * sizeof *row;
                int16_t *to = voxels + ((size_t)(z - z0) * (size_t)dims.y + (size_t)y) * (size_t)dims.x +
                              (size_t)(cx * n);
                if (chunk->density && bytes == (size_t)n * sizeof *row) {
                    read_row(chunk, n, y % n, z % n, to);
                } else if (chunk->density) {
                    read_row(chunk, n, y % n, z % n, row);
                    memcpy(to, row, bytes);
                } else {
                    memset(to, 0, bytes);
                }
            }
    return OST_OK;
}

/*
 * Reads the 32^3 voxels of a leaf. Voxels outside the grid are zero. Returns false and leaves `voxels` unchanged if no
 * chunk in the leaf has memory. The leaf is read in parts: complete chunks of 16 or 32 voxels per side, or an eighth of
 * a chunk of 64 voxels per side.
 */
static bool read_leaf(const cpu_bone *bone, ost_dims leaf, int16_t *voxels)
{
    const int32_t n = bone->base.chunk_size, part = min32(n, OST_LEAF);
    bool found = false;
    for (int32_t z = 0; z < OST_LEAF; z += part)
        for (int32_t y = 0; y < OST_LEAF; y += part)
            for (int32_t x = 0; x < OST_LEAF; x += part) {
                const int32_t gx = leaf.x * OST_LEAF + x, gy = leaf.y * OST_LEAF + y, gz = leaf.z * OST_LEAF + z;
                if (gx / n >= bone->chunk_dims.x || gy / n >= bone->chunk_dims.y || gz / n >= bone->chunk_dims.z)
                    continue;
                const cpu_chunk *chunk = &bone->chunks[gx / n + (int64_t)bone->chunk_dims.x *
                                                                    (gy / n + (int64_t)bone->chunk_dims.y * (gz / n))];
                if (!chunk->density)
                    continue;
                if (!found)
                    memset(voxels, 0, OST_LEAF * OST_LEAF * OST_LEAF * sizeof *voxels);
                found = true;
                for (int32_t k = 0; k < part; k++)
                    for (int32_t j = 0; j < part; j++) {
                        int16_t row[CHUNK_MAX];
                        read_row(chunk, n, gy % n + j, gz % n + k, row);
                        memcpy(voxels + x + OST_LEAF * (y + j + OST_LEAF * (z + k)), row + gx % n,
                               (size_t)part * sizeof *row);
                    }
            }
    return found;
}

/*
 * Converts the occupancy words of eight adjacent bricks to sixteen rows of 32 voxels. In the word of brick b, the bits
 * 4 (y + 4 z) to 4 (y + 4 z) + 3 are row (y, z). These four bits become the bits 4b to 4b + 3 of row (y, z).
 * Neighbouring nibbles are merged into bytes, bytes into 16-bit halves, and halves into words of 32 bits:
 *
 *   byte k of pair[p][odd]       row 2k + odd of the bricks 2p and 2p + 1
 *   half k of four[p][odd][l]    row 4k + 2l + odd of the bricks 4p to 4p + 3
 *   word k of low                row 8k + 2l + odd of all bricks
 *   word k of high               row 8k + 4 + 2l + odd of all bricks
 */
static void rows_of_bricks(const uint64_t brick[8], uint32_t row[16])
{
    const uint64_t nibbles = UINT64_C(0x0f0f0f0f0f0f0f0f), bytes = UINT64_C(0x00ff00ff00ff00ff),
                   halves = UINT64_C(0x0000ffff0000ffff);
    uint64_t pair[4][2], four[2][2][2];
    for (int p = 0; p < 4; p++) {
        const uint64_t a = brick[2 * p], b = brick[2 * p + 1];
        pair[p][0] = (a & nibbles) | (b & nibbles) << 4;
        pair[p][1] = (a >> 4 & nibbles) | (b & ~nibbles);
    }
    for (int p = 0; p < 2; p++)
        for (int odd = 0; odd < 2; odd++) {
            const uint64_t a = pair[2 * p][odd], b = pair[2 * p + 1][odd];
            four[p][odd][0] = (a & bytes) | (b & bytes) << 8;
            four[p][odd][1] = (a >> 8 & bytes) | (b & ~bytes);
        }
    for (int odd = 0; odd < 2; odd++)
        for (int l = 0; l < 2; l++) {
            const uint64_t a = four[0][odd][l], b = four[1][odd][l];
            const uint64_t low = (a & halves) | (b & halves) << 16, high = (a >> 16 & halves) | (b & ~halves);
            row[2 * l + odd] = (uint32_t)low;
            row[2 * l + odd + 4] = (uint32_t)high;
            row[2 * l + odd + 8] = (uint32_t)(low >> 32);
            row[2 * l + odd + 12] = (uint32_t)(high >> 32);
        }
}

/* Converts a chunk's occupancy to words of 32 voxels along x. For a chunk of 16^3 voxels, a word contains two rows. */
static void occupancy_rows(const uint64_t *occupancy, int32_t n, uint32_t *words)
{
    const int32_t bricks = min32(n / 4, 8);
    for (int32_t z = 0; z < n; z += 4)
        for (int32_t y = 0; y < n; y += 4)
            for (int32_t x = 0; x < n; x += 32) {
                uint64_t brick[8] = {0};
                uint32_t row[16];
                for (int32_t b = 0; b < bricks; b++)
                    brick[b] = occupancy[ost_brick_number(x / 4 + b, y / 4, z / 4)];
                rows_of_bricks(brick, row);
                for (int32_t r = 0; r < 16; r++) {
                    const int32_t at = n * (y + r % 4 + n * (z + r / 4)) + x;
                    if (n >= 32)
                        words[at / 32] = row[r];
                    else if (r % 2 == 0)
                        words[at / 32] = row[r] | row[r + 1] << 16;
                }
            }
}

ost_status ost_cpu_bone_occupancy(const ost_bone *base, size_t count, const int32_t *chunks, uint32_t *words,
                                  ost_error *err)
{
    (void)err;
    const cpu_bone *bone = (const cpu_bone *)base;
    const int32_t n = base->chunk_size;
    const size_t size = (size_t)n * (size_t)n * (size_t)n / 32;
    for (size_t i = 0; i < count; i++, words += size) {
        const cpu_chunk *chunk = &bone->chunks[chunks[i]];
        if (chunk->density)
            occupancy_rows(chunk->occupancy, n, words);
        else
            memset(words, 0, size * sizeof *words);
    }
    return OST_OK;
}

ost_status ost_cpu_bone_leaves(const ost_bone *base, ost_digest *leaves, ost_error *err)
{
    const cpu_bone *bone = (const cpu_bone *)base;
    const cpu_backend *backend = (const cpu_backend *)base->backend;
    const ost_dims dims = ost_leaf_dims(base->geometry.dims);
    const int64_t count = ost_dims_count(dims);
    int failed = OST_OK;
    ost_team team = ost_team_of(backend->sharing, backend->threads, OST_PATH_LEAVES, count, count, 8);
#pragma omp parallel num_threads(team.threads) if (team.threads > 1) reduction(max : failed)
    {
        ost_member me = ost_team_join(&team);
        for (int64_t i; (i = ost_team_next(&team, &me)) >= 0;) {
            int16_t voxels[OST_LEAF * OST_LEAF * OST_LEAF];
            const ost_dims leaf = {(int32_t)(i % dims.x), (int32_t)(i / dims.x % dims.y),
                                   (int32_t)(i / dims.x / dims.y)};
            ost_status status = OST_OK;
            if (read_leaf(bone, leaf, voxels))
                status = ost_digest_leaf16(voxels, &leaves[i], NULL);
            else
                leaves[i] = backend->ref.empty_leaf;
            failed = (int)status > failed ? (int)status : failed;
        }
    }
    ost_team_end(backend->sharing, &team);
    return failed == OST_OK ? OST_OK : ost_fail(err, (ost_status)failed, "a leaf's digest could not be computed");
}
