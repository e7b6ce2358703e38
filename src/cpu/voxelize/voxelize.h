/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The voxelizer of the CPU backend, which implements AR-VOX by tiles of rows.
 *
 * A row is a line of voxels along x.  The grid is divided along y and z into tiles of rows.  A tile
 * fits in a core's cache, and a thread processes complete tiles.
 *
 *        z  +-----+-----+       a tile has two planes with one bit per voxel;
 *           |     |  T  |       rows are ordered by (k, j):
 *           +-----+-----+         plus   a crossing enters before this centre
 *           |     |     |         minus  a crossing leaves before this centre
 *           +-----+-----+ y
 *
 *   mark    every crossing sets one bit                 mark.c, ../x86/, embree.c
 *   fill    centres between crossings become solid bits fill.c, ../x86/
 *   expand  bits become classes, 0, 1 or 2, when a tool is downloaded    fill.c, ../x86/
 *
 * Exact counts from single bits.  A bit can represent only one crossing.  If a second crossing has
 * the same sign and the same centre, its bit is already set.  The crossing is then spilled: it is
 * added to the row's own array of int32 steps.  Crossings after the last centre of a row are
 * spilled too.  The planes and the steps together always contain every crossing with its sign, so
 * no crossing is lost and no count saturates.
 *
 * Let P and M be a row's bits in the planes `plus` and `minus` as binary numbers. If the crossings of the
 * row enter and leave alternately, M - P has the row's solid bits; the difference also shows whether the
 * crossings alternate (fill.c). All other rows, and rows with spilled crossings, are summed crossing by
 * crossing.
 */
#ifndef OST_CPU_VOXELIZE_H
#define OST_CPU_VOXELIZE_H

#include "cpu/cpu.h"

/* The rows and planes of one tile. The number of a row is (k - k0) * (j1 - j0) + (j - j0). */
struct ost_vox_tile {
    const ost_snapped_mesh *mesh;
    int f;              /* fraction bits, 1..10 */
    int32_t nx;         /* voxels per row */
    int32_t j0, j1;     /* first row, and end of the rows (exclusive) */
    int32_t k0, k1;     /* first slice, and end of the slices (exclusive) */
    uint32_t row_bits;  /* number of bits per row of a plane: a multiple of 64, at least nx */
    uint32_t minus;     /* offset of the minus plane in `planes`, in bits; `planes` has fewer than 2^31 bits */
    uint64_t *planes;   /* the plus plane, padding to complete blocks, the minus plane, and padding */
    uint8_t *row_state; /* flags of each row, OST_VOX_SPILLED and OST_VOX_UNPROVEN */
    /* array of nx + 1 steps per row, valid for rows with the flag OST_VOX_SPILLED; NULL before the first spill */
    int32_t *spill;
    bool any_unproven;
    bool no_memory; /* true if memory for `spill` could not be allocated; the result is then invalid */
};

enum {
    OST_VOX_SPILLED = 1,   /* crossings of the row are in `spill` */
    OST_VOX_UNPROVEN = 2,  /* the kernel has not proved that the crossings of the row enter and leave alternately */
    OST_VOX_BLOCK = 8      /* number of words per block; planes and bit buffers consist of complete blocks */
};

/*
 * A triangle is small, and is marked in lanes (lanes.h), if its extents ex, ey, ez along
 * the axes, in lattice units, satisfy (ex + w) ey ez <= OST_VOX_SMALL with w = 2^f. For
 * f = 10, for example, a triangle is small if its extents are about 80 voxels on each axis,
 * or 1,024 by 160 by 2 voxels.
 */
#define OST_VOX_SMALL (INT64_C(1) << 49)

/*
 * Returns the number of words of a row of n voxels. It is 1, 2, 4 or a multiple of OST_VOX_BLOCK, so that
 * either a block consists of complete rows, or a row consists of complete blocks.
 */
static inline int ost_vox_words(int32_t n)
{
    int words = (n + 63) / 64;
    return words <= 2 ? words : words <= 4 ? 4 : (words + OST_VOX_BLOCK - 1) / OST_VOX_BLOCK * OST_VOX_BLOCK;
}

/*
 * Adds a crossing to the steps of its row. Used if no bit can represent the crossing, because the bit is already set or
 * i = nx.
 */
void ost_vox_spill(ost_vox_tile *tile, uint32_t row, int32_t i, int step);

/* Marks a crossing by setting bit number `bit` of the planes. If the bit is already set, spills the crossing. */
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

/* Marks the crossings of one triangle with the rows of a tile. The triangle can have any size and position. */
void ost_vox_mark_triangle(ost_vox_tile *tile, uint32_t triangle);

/*
 * Completes rows of a tile after the `vox_fill` kernel: sums the crossings of unproven rows, and of rows with
 * spilled crossings, one by one. On entry, `bits` contains the kernel's output for all rows; the bits of the
 * summed rows are replaced. Adds the number of leaking rows to *leaking_rows. Returns the number of solid
 * voxels minus the kernel's count.
 */
int64_t ost_vox_fill_unproven(const ost_vox_tile *tile, size_t first_row, size_t rows, ost_fill_rule rule,
                              uint64_t *bits, uint64_t *leaking_rows);

/* Returns the number of rows of a tile, in all of its slices. */
static inline size_t ost_vox_rows(const ost_vox_tile *tile)
{
    return (size_t)(tile->j1 - tile->j0) * (size_t)(tile->k1 - tile->k0);
}

/* The division of the grid into tiles. Tile (ty, tz) has the number ty + tiles_y * tz. */
struct ost_vox_plan {
    ost_dims dims;
    int f;
    int words;                /* per row */
    /* log2 of the number of rows and slices per tile; the last tile of an axis may be smaller */
    int32_t shift_y, shift_z;
    int32_t tiles_y, tiles_z;
};

/* For each tile, lists the triangles that can cross rows of the tile. */
typedef struct ost_vox_bins {
    size_t *start;   /* tiles + 1 indices of elements of `list`; NULL if there is only one tile */
    uint32_t *list;  /* numbers of triangles; those of tile t are list[start[t]] to list[start[t + 1] - 1] */
    uint32_t *large; /* numbers of the triangles that overlap many tiles; each tile processes all of them */
    size_t large_count;
} ost_vox_bins;

ost_status ost_vox_bins_make(ost_vox_bins *bins, const ost_vox_plan *plan, const ost_snapped_mesh *mesh,
                             const cpu_backend *backend, int threads, ost_error *err);
void ost_vox_bins_free(ost_vox_bins *bins);

/* The keys that the `vox_keys` kernel writes for triangles that are in no tile or in several tiles. */
#define OST_VOX_KEY_NONE UINT32_MAX        /* key of a triangle whose bounds contain no row centre */
#define OST_VOX_KEY_MANY (UINT32_MAX - 1u) /* key of a triangle whose bounds overlap several tiles */

/* The output buffers, with one bit per voxel and ost_vox_words words per row. Rows are ordered by (k, j). */
typedef struct ost_vox_result {
    uint64_t *cutting;    /* 1 if the voxel is solid in the cutting mesh */
    uint64_t *noncutting; /* 1 if the voxel is solid in the non-cutting mesh only; NULL if not requested */
} ost_vox_result;

/* Voxelizes one or two meshes on the same grid. Computes the same results as ost_ref_voxelize. */
ost_status ost_cpu_voxelize(const cpu_backend *backend, const ost_snapped_mesh *cutting,
                            const ost_snapped_mesh *noncutting, ost_fill_rule rule, ost_voxelize_report *report,
                            const ost_vox_result *result, ost_error *err);

/* The `voxelize` slot of the backend's function table. */
ost_status ost_cpu_voxelize_tool(ost_backend *backend, const ost_snapped_mesh *cutting,
                                 const ost_snapped_mesh *noncutting, ost_fill_rule rule, ost_voxelize_report *report,
                                 ost_tool **out, ost_error *err);

/* The scalar kernels of the voxelizer; kernels.h contains their contracts. */
void ost_vox_mark_scalar(ost_vox_tile *tile, const uint32_t *list, size_t count);
void ost_vox_keys_scalar(const ost_vox_plan *plan, const ost_snapped_mesh *mesh, size_t first, size_t count,
                         uint32_t *keys);
uint64_t ost_vox_fill_scalar(ost_vox_tile *tile, size_t first_row, size_t rows, uint64_t *bits);
void ost_vox_expand_scalar(const uint64_t *cutting, const uint64_t *noncutting, size_t rows, int words, int32_t nx,
                           bool stream, uint8_t *voxels);

#endif
