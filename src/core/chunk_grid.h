/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The chunk grid on the host (thesis, chapter 3): a bone as cubes of n^3
 * voxels, n = 16, 32 or 64, of which only those with an active voxel hold
 * memory.
 *
 *     chunk grid          a chunk                     one row of occupancy, n = 32
 *   +----+----+----+      densities  int16[n^3]         bit  0             31
 *   |    | ## | ## |      occupancy  uint32[n^3/32]         00000011111111000
 *   +----+----+----+      active     how many bits      voxel v = x + n (y + n z):
 *   |    |    | ## |                 are set            word v / 32, bit v % 32
 *   +----+----+----+
 *
 * Invariants, outside the functions of this file:
 *   - a voxel is active iff its density >= threshold; every other one is 0;
 *   - an occupancy bit is set iff its voxel is active;
 *   - a chunk holds memory iff active > 0, so a freed chunk is one of zeros;
 *   - voxels of the padding, beyond dims, are 0.
 *
 * So the grid's content is a function of its voxels alone: neither n nor the
 * order of events shows in a download or a digest (AR-CHK-3).
 *
 * Ranges: dims <= 2^14 an axis and n >= 16, so there are at most 2^30 chunks
 * and an index fits int32.
 */
#ifndef OST_CORE_CHUNK_GRID_H
#define OST_CORE_CHUNK_GRID_H

#include <osteon/digest.h>
#include <osteon/grid.h>

typedef struct ost_chunk {
    int16_t *density;    /* owned with occupancy behind it, one 64-byte aligned block; NULL when active is 0 */
    uint32_t *occupancy; /* in the same block */
    int32_t active;
} ost_chunk;

typedef struct ost_chunk_grid {
    ost_dims dims; /* voxels, without the padding */
    int size;      /* n */
    int32_t threshold;
    ost_dims chunk_dims;
    int64_t count;
    ost_chunk *chunks; /* owned; x fastest */
} ost_chunk_grid;

/* Every chunk empty. On failure free is still safe. */
ost_status ost_chunk_grid_init(ost_chunk_grid *grid, ost_dims dims, int size, int32_t threshold, ost_error *err);
void ost_chunk_grid_free(ost_chunk_grid *grid);

/* Chunks along each axis: ceil(dims / size). */
ost_dims ost_chunk_dims(ost_dims dims, int size);
/* Bytes that one chunk with an active voxel holds: densities and occupancy. */
size_t ost_chunk_bytes(int size);

/* Gives an empty chunk its zero-filled memory; false when there is none. */
bool ost_chunk_fill(const ost_chunk_grid *grid, ost_chunk *chunk);
/* Takes it back; active must be 0. */
void ost_chunk_release(ost_chunk *chunk);

/* Slices z0 <= k < z0 + count without the padding, x fastest. Upload applies the threshold; on failure nothing has changed. */
ost_status ost_chunk_grid_upload(ost_chunk_grid *grid, int32_t z0, int32_t count, const int16_t *voxels, ost_error *err);
void ost_chunk_grid_download(const ost_chunk_grid *grid, int32_t z0, int32_t count, int16_t *voxels);

/*
 * The 32^3 voxels of a leaf (AR-DIG-2), zero beyond the grid, whatever n is.
 * False when no chunk in it holds memory: then voxels is left alone and the
 * leaf is that of zeros.
 */
bool ost_chunk_grid_leaf(const ost_chunk_grid *grid, ost_dims leaf, int16_t voxels[OST_LEAF * OST_LEAF * OST_LEAF]);

/* Sums over all chunks. */
void ost_chunk_grid_count(const ost_chunk_grid *grid, int64_t *active_chunks, int64_t *active_voxels);

#endif
