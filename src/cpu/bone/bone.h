/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The bone of the CPU backend. The same chunks have memory and the same voxels are active as in the reference's bone.
 * Inside a chunk, the voxels are stored as bricks of 4^3 voxels, in Morton order.
 *
 *     a brick: 64 densities, 128 bytes      2^3 bricks = 8^3 voxels
 *     and one occupancy word of 64 bits       6 ---- 7
 *                                            /|     /|     brick number: bits of
 *     voxel (x, y, z) of the brick is       4 ---- 5 |     x, y, z interleaved,
 *     number x + 4 y + 16 z                 | 2 ---|-3     x lowest
 *                                           0 ---- 1
 *
 * Bricks make removal faster, because the 64 voxels of a brick are processed at once, as one word, and occupy two cache
 * lines instead of sixteen. The occupancy words of 8^3 voxels fill one cache line. The bricks of a cube of 8, 16 or
 * 32 voxels per side are contiguous for every chunk size.
 *
 * The invariants of core/chunk_grid.h apply. A voxel is active iff its density is at least the
 * threshold; all other voxels are 0. A voxel's occupancy bit is set iff the voxel is active.
 * Memory is allocated for a chunk iff its `active` field is above 0. The padding, that is, the
 * voxels of a chunk outside the grid, is 0. In addition, no density of a chunk is above the
 * chunk's `highest` field, which never decreases.
 */
#ifndef OST_CPU_BONE_H
#define OST_CPU_BONE_H

#include "core/backend.h"
#include "cpu/bone/chunk_pool.h"

typedef struct cpu_chunk {
    /* start of the owned, 64-byte aligned block that contains densities and occupancy; NULL if `active` is 0 */
    int16_t *density;
    uint64_t *occupancy; /* occupancy words; they follow the densities in the block at `density` */
    ost_chunk_pool *pool; /* pool that owns the block; NULL if the block was allocated with malloc */
    int32_t active;
    int32_t highest;
} cpu_chunk;

typedef struct cpu_bone {
    ost_bone base;
    ost_dims chunk_dims;
    int64_t count;
    cpu_chunk *chunks; /* owned array, x fastest */
} cpu_bone;

enum { OST_BRICK = 4, OST_BRICK_VOXELS = 64 };

/* Returns v with its bits 0, 1, 2, 3 moved to the bits 0, 3, 6, 9. */
static inline int32_t ost_brick_spread(int32_t v)
{
    return (v & 1) | (v & 2) << 2 | (v & 4) << 4 | (v & 8) << 6;
}

/* Returns the Morton number of brick (x, y, z) within its chunk. Each coordinate must be below 16. */
static inline int32_t ost_brick_number(int32_t x, int32_t y, int32_t z)
{
    return ost_brick_spread(x) | ost_brick_spread(y) << 1 | ost_brick_spread(z) << 2;
}

/*
 * Returns the x coordinate of the brick with the given Morton number, by moving the bits 0, 3, 6, 9 to the bits 0..3.
 * To compute y or z, the caller shifts the number right by 1 or 2 first.
 */
static inline int32_t ost_brick_gather(int32_t number)
{
    return (number & 1) | (number >> 2 & 2) | (number >> 4 & 4) | (number >> 6 & 8);
}

/*
 * Allocates memory for a chunk that has none. The content of the memory is undefined. If `pool` is not NULL and has a
 * free block, the memory is a block of `pool`. Otherwise, malloc allocates the memory. Returns false if memory is
 * exhausted.
 */
bool ost_cpu_chunk_take(const cpu_bone *bone, ost_chunk_pool *pool, cpu_chunk *chunk);
/* Frees the memory of a chunk whose `active` count has become 0. */
void ost_cpu_chunk_release(cpu_chunk *chunk);

ost_status ost_cpu_bone_create(ost_backend *backend, const ost_geometry *geometry, int chunk_size, int32_t threshold,
                               ost_bone **out, ost_error *err);
void ost_cpu_bone_free(ost_bone *bone);
ost_status ost_cpu_bone_stats(const ost_bone *bone, ost_bone_info *info, ost_error *err);
ost_status ost_cpu_bone_upload(ost_bone *bone, int32_t z0, int32_t count, const int16_t *voxels, ost_error *err);
ost_status ost_cpu_bone_download(const ost_bone *bone, int32_t z0, int32_t count, int16_t *voxels, ost_error *err);
ost_status ost_cpu_bone_sample(const ost_bone *bone, size_t count, const int32_t *const at[3], int16_t *densities,
                               ost_error *err);
ost_status ost_cpu_bone_occupancy(const ost_bone *bone, size_t count, const int32_t *chunks, uint32_t *words,
                                  ost_error *err);
ost_status ost_cpu_bone_leaves(const ost_bone *bone, ost_digest *leaves, ost_error *err);

#endif
