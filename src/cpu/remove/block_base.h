/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Computes the bases of many blocks at one pose (AR-MAP-4) without a division for each block.
 *
 *   exact coordinate of block (x, y, z)  =  X[x] + Y[y] + Z[z],  each a multiple of 1 / divisor
 *
 * Tables contain the three parts in units of 2^-16, each rounded down with an error below 2. Their
 * sum V satisfies V <= exact * 2^16 < V + 6. Let W = V + 2^15. If the low 16 bits of W are
 * 1..2^16 - 7, the base is floor(W / 2^16), because exact + 1/2 then lies strictly between this
 * integer and the next. About one in ten thousand bases does not satisfy this condition;
 * ost_map_block_base then computes the base with a division.
 *
 * Ranges: |exact| < 2^45.2, and |Y|, |Z| < 2^44.1 (16 m of bone in tool voxels of
 * at least 1 um), so the sums stay below 2^63.
 */
#ifndef OST_CPU_BLOCK_BASE_H
#define OST_CPU_BLOCK_BASE_H

#include <osteon/event.h>

typedef struct ost_block_bases {
    const ost_map *map;
    /* first block and number of blocks along each axis, as set by the last call of ost_block_bases_make */
    int32_t lo[3], count[3];
    /* owned; part[b] is the table for bone axis b, with element 3 * (block - lo[b]) + a for tool axis a */
    int64_t *part[3];
    size_t capacity[3];
} ost_block_bases;

/*
 * Reserves memory for up to count[axis] blocks along each axis. *bases must be zero-initialised before
 * the first call. *bases can be used for several poses, one after the other, and is freed by
 * ost_block_bases_free.
 */
ost_status ost_block_bases_reserve(ost_block_bases *bases, const int32_t count[3], ost_error *err);
/* Computes the tables for the blocks lo <= block < hi. Memory for these blocks must have been reserved. */
void ost_block_bases_make(ost_block_bases *bases, const ost_map *map, const int32_t lo[3], const int32_t hi[3]);
void ost_block_bases_free(ost_block_bases *bases);

/* Computes the base of a block, with the same result as ost_map_block_base. The block must be in the range of the last
   call of ost_block_bases_make. */
static inline bool ost_block_base(const ost_block_bases *bases, const int32_t block[3], int32_t base[3])
{
    const int64_t low = -(INT64_C(1) << 29);
    /* A base is valid if low <= base < low + span, where low + span = 2^30 + 2^29. */
    const uint64_t span = UINT64_C(1) << 31;
    const int64_t *x = bases->part[0] + 3 * (size_t)(block[0] - bases->lo[0]),
                  *y = bases->part[1] + 3 * (size_t)(block[1] - bases->lo[1]),
                  *z = bases->part[2] + 3 * (size_t)(block[2] - bases->lo[2]);
    const int64_t u = x[0] + y[0] + z[0] + (1 << 15), v = x[1] + y[1] + z[1] + (1 << 15),
                  w = x[2] + y[2] + z[2] + (1 << 15);
    base[0] = (int32_t)(u >> 16);
    base[1] = (int32_t)(v >> 16);
    base[2] = (int32_t)(w >> 16);
    /* the least value of (low 16 bits of W) - 1 for which the base is computed with a division */
    const uint16_t unsure = 0xffff - 6;
    if ((uint16_t)(u - 1) >= unsure || (uint16_t)(v - 1) >= unsure || (uint16_t)(w - 1) >= unsure)
        return ost_map_block_base(bases->map, (ost_dims){block[0], block[1], block[2]}, base);
    return (uint64_t)((u >> 16) - low) < span && (uint64_t)((v >> 16) - low) < span &&
           (uint64_t)((w >> 16) - low) < span;
}

/* The range of bases for which at least one voxel of a block can lie in the tool's grid: from <= base < from + width
   on each axis. */
typedef struct ost_block_reach {
    int32_t from[3];
    uint32_t width[3];
} ost_block_reach;

/* Computes the range of bases for a tool of `dims` voxels and the steps of a map. */
ost_block_reach ost_block_reach_of(const int32_t step[3][3], const int32_t dims[3]);

static inline bool ost_block_in_reach(const ost_block_reach *r, const int32_t base[3])
{
    return ((uint32_t)base[0] - (uint32_t)r->from[0] < r->width[0]) &
           ((uint32_t)base[1] - (uint32_t)r->from[1] < r->width[1]) &
           ((uint32_t)base[2] - (uint32_t)r->from[2] < r->width[2]);
}

#endif
