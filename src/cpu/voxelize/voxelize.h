/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The voxelizer of the CPU backend: AR-VOX by tiles of rows.
 *
 * A row is a line of voxels along x.  The grid is divided in (y, z) into tiles of
 * rows that fit a core's cache; a thread processes complete tiles.
 *
 *        z  +-----+-----+       a tile's planes have one bit per voxel, with the
 *           |     |  T  |       words of a row together and rows ordered by (k, j):
 *           +-----+-----+         plus   a crossing enters before this centre
 *           |     |     |         minus  a crossing leaves before it
 *           +-----+-----+ y
 *
 *   mark    every crossing sets one bit                 mark.c, ../x86/, embree.c
 *   fill    centres between crossings become solid bits fill.c, ../x86/
 *   expand  bits become classes, 0, 1 or 2              fill.c, ../x86/
 *
 * Exact counts from single bits.  A bit means one crossing, so the bit of a second
 * crossing of the same sign at the same centre is already set.  Such crossings, and
 * those after the last centre of a row, are spilled: added to the row's own array
 * of int32 steps.  Planes and steps together always contain every crossing with its
 * sign, so no crossing is lost and no count saturates.
 *
 * A row whose crossings enter and leave alternately, which the result itself
 * proves, is filled by a subtraction, minus - plus (fill.c); the other rows, and
 * those that have spilled, are summed crossing by crossing.
 */
#ifndef OST_CPU_VOXELIZE_H
#define OST_CPU_VOXELIZE_H

#include "cpu/cpu.h"

/* The rows and planes of one tile. The number of a row is (k - k0) * (j1 - j0) + (j - j0). */
struct ost_vox_tile {
    const ost_snapped_mesh *mesh;
    int f;              /* fraction bits, 1..10 */
    int32_t nx;         /* voxels per row */
    int32_t j0, j1;     /* rows j0 <= j < j1 */
    int32_t k0, k1;     /* slices k0 <= k < k1 */
    uint32_t row_bits;  /* 64 * words of a row, >= nx */
    uint32_t minus;     /* bit offset of the minus plane in planes; both planes have < 2^31 bits */
    uint64_t *planes;   /* plus rows, padding to complete blocks, minus rows, padding */
    uint8_t *row_state; /* flags per row: OST_VOX_SPILLED, OST_VOX_UNPROVEN */
    int32_t *spill;     /* nx + 1 steps per row, valid for rows that are OST_VOX_SPILLED; NULL before the first spill */
    bool any_unproven;
    bool no_memory; /* there was no memory for spill: the result is invalid */
};

enum {
    OST_VOX_SPILLED = 1,   /* the row has steps in spill */
    OST_VOX_UNPROVEN = 2,  /* the row is not proven to enter and leave alternately */
    OST_VOX_BLOCK = 8      /* words per block; planes and bits can be read and written up to the end of a block */
};

/*
 * A triangle is marked in lanes (lanes.h) if its extents ex, ey, ez on the axes, in
 * lattice units, have (ex + w) ey ez <= OST_VOX_SMALL, w = 2^f: about 80 voxels on
 * each axis at f = 10, or 1,024 by 160 by 2.
 */
#define OST_VOX_SMALL (INT64_C(1) << 49)

/*
 * Returns the number of words of a row of n voxels: 1, 2, 4 or a multiple of a block, so that a block
 * holds complete rows or a row holds complete blocks.
 */
static inline int ost_vox_words(int32_t n)
{
    int words = (n + 63) / 64;
    return words <= 2 ? words : words <= 4 ? 4 : (words + OST_VOX_BLOCK - 1) / OST_VOX_BLOCK * OST_VOX_BLOCK;
}

/* Adds a crossing to the row's steps because it has no bit: the bit is already set, or i = nx. */
void ost_vox_spill(ost_vox_tile *tile, uint32_t row, int32_t i, int step);

/* Marks a crossing at the centre of this bit of planes; spills it if the bit is already set. */
static inline void ost_vox_mark_bit(ost_vox_tile *tile, uint32_t bit)
{
    uint64_t *word = tile->planes + (bit >> 6);
    const uint64_t mask = UINT64_C(1) << (bit & 63);
    if (*word & mask) {
        const bool minus = bit >= tile->minus;
        const uint32_t b = minus ? bit - tile->minus : bit;
        ost_vox_spill(tile, b / tile->row_bits, (int32_t)(b % tile->row_bits), minus ? -1 : 1);
    } else {
        *word |= mask;
    }
}

/* Marks one triangle of any size and position in the rows of this tile. */
void ost_vox_mark_triangle(ost_vox_tile *tile, uint32_t triangle);

/*
 * Sums the unproven rows among `rows` rows of a tile, starting with first_row, crossing by
 * crossing. bits holds the kernel's output for these rows; those of unproven rows are
 * replaced. Adds the number of leaking rows to *leaking_rows. Returns the correction
 * to the kernel's count of solid voxels.
 */
int64_t ost_vox_fill_unproven(const ost_vox_tile *tile, size_t first_row, size_t rows, ost_fill_rule rule,
                              uint64_t *bits, uint64_t *leaking_rows);

/* Returns the number of rows of a tile. */
static inline size_t ost_vox_rows(const ost_vox_tile *tile)
{
    return (size_t)(tile->j1 - tile->j0) * (size_t)(tile->k1 - tile->k0);
}

/* The division of the grid into tiles; tile (ty, tz) has the number ty + tiles_y * tz. */
struct ost_vox_plan {
    ost_dims dims;
    int f;
    int words;                /* per row */
    int32_t shift_y, shift_z; /* a tile has 2^shift rows along that axis, the last one possibly fewer */
    int32_t tiles_y, tiles_z;
};

/* Lists of the triangles that can cross the rows of each tile. */
typedef struct ost_vox_bins {
    size_t *start;   /* tiles + 1 elements; NULL if there is one tile, which has all triangles */
    uint32_t *list;  /* triangles of tile t: list[i], start[t] <= i < start[t + 1] */
    uint32_t *large; /* triangles in many tiles, which every tile processes */
    size_t large_count;
} ost_vox_bins;

ost_status ost_vox_bins_make(ost_vox_bins *bins, const ost_vox_plan *plan, const ost_snapped_mesh *mesh,
                             const cpu_backend *backend, int threads, ost_error *err);
void ost_vox_bins_free(ost_vox_bins *bins);

/* Keys that the keys kernel writes for a triangle that is not in exactly one tile. */
#define OST_VOX_KEY_NONE UINT32_MAX        /* the triangle's bounds contain no row centre */
#define OST_VOX_KEY_MANY (UINT32_MAX - 1u) /* the bounds overlap several tiles */

/* The output buffers; a NULL one is not written. Bits have ost_vox_words words per row, rows ordered by (k, j). */
typedef struct ost_vox_result {
    uint8_t *voxels;      /* classes, as the reference writes them */
    uint64_t *cutting;    /* bits of voxels that are solid in the cutting mesh */
    uint64_t *noncutting; /* bits of voxels that are solid only in the other mesh */
} ost_vox_result;

/* Voxelizes both meshes on one grid, with the same results as ost_ref_voxelize. */
ost_status ost_cpu_voxelize(const cpu_backend *backend, const ost_snapped_mesh *cutting,
                            const ost_snapped_mesh *noncutting, ost_fill_rule rule, ost_voxelize_report *report,
                            const ost_vox_result *result, ost_error *err);

/* Implements the slot voxelize of the backend's table. */
ost_status ost_cpu_voxelize_tool(ost_backend *backend, const ost_snapped_mesh *cutting,
                                 const ost_snapped_mesh *noncutting, ost_fill_rule rule, ost_voxelize_report *report,
                                 ost_tool **out, ost_error *err);

/* The scalar kernels (kernels.h has their contracts). */
void ost_vox_mark_scalar(ost_vox_tile *tile, const uint32_t *list, size_t count);
void ost_vox_keys_scalar(const ost_vox_plan *plan, const ost_snapped_mesh *mesh, size_t first, size_t count,
                         uint32_t *keys);
uint64_t ost_vox_fill_scalar(ost_vox_tile *tile, size_t first_row, size_t rows, uint64_t *bits);
void ost_vox_expand_scalar(const uint64_t *cutting, const uint64_t *noncutting, size_t rows, int words, int32_t nx,
                           bool stream, uint8_t *voxels);

#endif
