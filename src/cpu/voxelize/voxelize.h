/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The voxelizer of the CPU backend: AR-VOX by tiles of rows.
 *
 * A row is a line of voxels along x.  The grid is cut in (y, z) into tiles of
 * rows that fit a core's cache; threads take whole tiles.
 *
 *        z  +-----+-----+       a tile's planes, one bit a voxel and a row's
 *           |     |  T  |       words together, rows in the order (k, j):
 *           +-----+-----+         plus   something enters before this centre
 *           |     |     |         minus  something leaves before it
 *           +-----+-----+ y
 *
 *   mark    every crossing sets one bit                 mark.c, ../x86/, embree.c
 *   fill    what lies between makes solid bits          fill.c, ../x86/
 *   expand  bits become classes, 0, 1 or 2              fill.c, ../x86/
 *
 * Exact counts from single bits.  A bit says "one crossing here", so a second
 * crossing of the same sign at the same centre finds its bit taken.  Such
 * crossings, and those behind the last centre of a row, are spilled: added to
 * the row's own array of int32 steps.  Planes and steps together always hold
 * every crossing with its sign, so nothing is ever lost or saturated.
 *
 * A row whose crossings enter and leave in turn, which the result itself
 * proves, is filled by a subtraction, minus - plus (fill.c); the others, and
 * those that have spilled, are summed crossing by crossing.
 */
#ifndef OST_CPU_VOXELIZE_H
#define OST_CPU_VOXELIZE_H

#include "cpu/cpu.h"

/* Rows and planes of one tile. Rows are numbered (k - k0) * (j1 - j0) + (j - j0). */
struct ost_vox_tile {
    const ost_snapped_mesh *mesh;
    int f;              /* fraction bits, 1..10 */
    int32_t nx;         /* voxels a row */
    int32_t j0, j1;     /* rows j0 <= j < j1 */
    int32_t k0, k1;     /* of slices k0 <= k < k1 */
    uint32_t row_bits;  /* 64 * words of a row, >= nx */
    uint32_t minus;     /* where minus begins in planes, in bits; < 2^31 together */
    uint64_t *planes;   /* plus rows, padding to whole blocks, minus rows, padding */
    uint8_t *odd;       /* a row: OST_VOX_... below */
    int32_t *spill;     /* nx + 1 steps a row; valid for rows that are OST_VOX_SPILLED; NULL before the first */
    bool any_odd;
    bool no_memory; /* for spill: the result is of no use */
};

enum {
    OST_VOX_SPILLED = 1,   /* has steps in spill */
    OST_VOX_UNPROVEN = 2,  /* not proven to enter and leave in turn */
    OST_VOX_BLOCK = 8      /* words: planes and bits are readable and writable to a whole block */
};

/*
 * A triangle is marked in lanes (lanes.h) when its extents on x, y and z, in
 * lattice units, have (ex + w) ey ez <= this, w = 2^f: some 80 voxels each way
 * at f = 10, or 1,024 by 160 by 2.
 */
#define OST_VOX_SMALL (INT64_C(1) << 49)

/* Words of a row of n voxels: 1, 2, 4, or whole blocks, so that a block holds whole rows or the reverse. */
static inline int ost_vox_words(int32_t n)
{
    int words = (n + 63) / 64;
    return words <= 2 ? words : words <= 4 ? 4 : (words + OST_VOX_BLOCK - 1) / OST_VOX_BLOCK * OST_VOX_BLOCK;
}

/* A crossing that has no bit: the bit is taken, or i = nx. */
void ost_vox_spill(ost_vox_tile *tile, uint32_t row, int32_t i, int step);

/* A crossing at the centre of this bit of planes. */
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

/* Marks one triangle of any size, anywhere, in the rows of this tile. */
void ost_vox_mark_triangle(ost_vox_tile *tile, uint32_t triangle);

/*
 * Sums those of some rows of a tile that are odd: bits holds them as the kernel
 * left them; returns what is to be added to the kernel's count of solid voxels.
 */
int64_t ost_vox_fill_odd(const ost_vox_tile *tile, size_t first_row, size_t rows, ost_fill_rule rule, uint64_t *bits,
                         uint64_t *leaking_rows);

/* Number of rows of a tile. */
static inline size_t ost_vox_rows(const ost_vox_tile *tile)
{
    return (size_t)(tile->j1 - tile->j0) * (size_t)(tile->k1 - tile->k0);
}

/* How the grid is cut into tiles; tile (ty, tz) has the number ty + tiles_y * tz. */
struct ost_vox_plan {
    ost_dims dims;
    int f;
    int words;                /* a row */
    int32_t shift_y, shift_z; /* a tile has 2^shift rows that way, the last one fewer */
    int32_t tiles_y, tiles_z;
};

/* Which triangles a tile has to look at. */
typedef struct ost_vox_bins {
    size_t *start;   /* tiles + 1; NULL with one tile only: all triangles */
    uint32_t *list;  /* tile t: list[start[t]] to list[start[t + 1]] */
    uint32_t *large; /* in more tiles than a few: every tile looks at them */
    size_t large_count;
} ost_vox_bins;

ost_status ost_vox_bins_make(ost_vox_bins *bins, const ost_vox_plan *plan, const ost_snapped_mesh *mesh,
                             const cpu_backend *backend, int threads, ost_error *err);
void ost_vox_bins_free(ost_vox_bins *bins);

/* What the keys kernel writes for a triangle that is in no single tile. */
#define OST_VOX_KEY_NONE UINT32_MAX        /* no row centre in its bounds */
#define OST_VOX_KEY_MANY (UINT32_MAX - 1u) /* bounds in several tiles */

/* Where a result goes; NULL is not written. Bits have plan.words words a row, in the order (k, j). */
typedef struct ost_vox_result {
    uint8_t *voxels;      /* classes, as the reference */
    uint64_t *cutting;    /* solid in the cutting mesh */
    uint64_t *noncutting; /* solid in the other alone */
} ost_vox_result;

/* Both meshes on one grid, as ost_ref_voxelize. */
ost_status ost_cpu_voxelize(const cpu_backend *backend, const ost_snapped_mesh *cutting, const ost_snapped_mesh *noncutting,
                            ost_fill_rule rule, ost_voxelize_report *report, const ost_vox_result *result, ost_error *err);

/* The table's function. */
ost_status ost_cpu_voxelize_tool(ost_backend *backend, const ost_snapped_mesh *cutting, const ost_snapped_mesh *noncutting,
                                 ost_fill_rule rule, ost_voxelize_report *report, ost_tool **out, ost_error *err);

/* Scalar kernels (contracts: kernels.h). */
void ost_vox_mark_scalar(ost_vox_tile *tile, const uint32_t *list, size_t count);
void ost_vox_keys_scalar(const ost_vox_plan *plan, const ost_snapped_mesh *mesh, size_t first, size_t count, uint32_t *keys);
uint64_t ost_vox_fill_scalar(ost_vox_tile *tile, size_t first_row, size_t rows, uint64_t *bits);
void ost_vox_expand_scalar(const uint64_t *cutting, const uint64_t *noncutting, size_t rows, int words, int32_t nx, bool stream,
                           uint8_t *voxels);

#endif
