/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The chunk grid on the host (thesis, chapter 3): a bone divided into cubes (chunks) of n^3 voxels,
 * n = 16, 32 or 64. Memory is allocated only for chunks with an active voxel.
 *
 *     chunk grid          a chunk                     one row of occupancy, n = 32
 *   +----+----+----+      densities  int16[n^3]         bit  0             31
 *   |    | ## | ## |      occupancy  uint32[n^3/32]         00000011111111000
 *   +----+----+----+      active     number of bits     voxel v = x + n (y + n z):
 *   |    |    | ## |                 that are set       word v / 32, bit v % 32
 *   +----+----+----+
 *
 * Invariants, which may be broken only within the functions of this file:
 *   - a voxel is active iff its density >= threshold; every other voxel is 0;
 *   - an occupancy bit is set iff its voxel is active;
 *   - a chunk has memory iff active > 0, so a chunk without memory is all zeros;
 *   - voxels of the padding, outside dims, are 0.
 *
 * The content of the grid therefore depends only on its voxels: a download or a
 * digest depends neither on n nor on the order of events (AR-CHK-3).
 *
 * Ranges: dims <= 2^14 on each axis and n >= 16, so there are at most 2^30 chunks,
 * and the index of a chunk fits in an int32.
 */
#ifndef OST_CORE_CHUNK_GRID_H
#define OST_CORE_CHUNK_GRID_H

#include <osteon/digest.h>
#include <osteon/grid.h>

typedef struct ost_chunk {
    /*
     * start of the owned, 64-byte aligned memory block that contains the densities and the occupancy; NULL if `active`
     * is 0
     */
    int16_t *density;
    uint32_t *occupancy; /* occupancy words; they follow the densities in the block at `density` */
    int32_t active;
} ost_chunk;

typedef struct ost_chunk_grid {
    ost_dims dims; /* size of the grid in voxels, without padding */
    int size;      /* edge length of a chunk in voxels, called n in the comment at the top of this file */
    int32_t threshold;
    ost_dims chunk_dims;
    int64_t count;
    ost_chunk *chunks; /* owned array, x fastest */
} ost_chunk_grid;

/* Initialises a grid without active voxels. After a failure, *grid may be passed to ost_chunk_grid_free. */
ost_status ost_chunk_grid_init(ost_chunk_grid *grid, ost_dims dims, int size, int32_t threshold, ost_error *err);
void ost_chunk_grid_free(ost_chunk_grid *grid);

/* Returns the number of chunks along each axis: dims / size, rounded up. */
ost_dims ost_chunk_dims(ost_dims dims, int size);
/* Returns the memory of an active chunk, in bytes: densities and occupancy. */
size_t ost_chunk_bytes(int size);

/* Frees the memory of a chunk whose `active` count is 0. */
void ost_chunk_release(ost_chunk *chunk);

/*
 * Removes the voxels whose bits in `occupancy` are 0. `occupancy` has the n^3/32 words of the chunk. A bit that is 1
 * for a voxel that is not active has no effect. If no voxel remains active, the chunk's memory is freed.
 */
void ost_chunk_keep(const ost_chunk_grid *grid, ost_chunk *chunk, const uint32_t *occupancy);

/*
 * Reads the densities of single voxels. Voxel i has the indices (at[0][i], at[1][i], at[2][i]). Outside the grid, the
 * density is 0.
 */
void ost_chunk_grid_sample(const ost_chunk_grid *grid, size_t count, const int32_t *const at[3], int16_t *densities);

/*
 * ost_chunk_grid_upload and ost_chunk_grid_download copy the slices z0 <= k < z0 + count between `voxels` and the grid.
 * The array `voxels` is in x-fastest order, without padding. The upload sets densities below the threshold to 0; if the
 * upload fails, the grid is unchanged.
 */
ost_status ost_chunk_grid_upload(ost_chunk_grid *grid, int32_t z0, int32_t count, const int16_t *voxels,
                                 ost_error *err);
void ost_chunk_grid_download(const ost_chunk_grid *grid, int32_t z0, int32_t count, int16_t *voxels);

/*
 * Reads the 32^3 voxels of a leaf (AR-DIG-2), for any n. Voxels outside the grid are zero. Returns
 * false if no chunk in the leaf has memory; all voxels of the leaf are then zero, and `voxels` is
 * unchanged.
 */
bool ost_chunk_grid_leaf(const ost_chunk_grid *grid, ost_dims leaf, int16_t voxels[OST_LEAF * OST_LEAF * OST_LEAF]);

/* Counts the active chunks and the active voxels. */
void ost_chunk_grid_count(const ost_chunk_grid *grid, int64_t *active_chunks, int64_t *active_voxels);

#endif
