/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The inner loops of the CPU backend. Every slot is first set to its scalar function. Variants for
 * the available instruction sets then replace scalar functions, so no slot is ever NULL. tests/simd
 * compares every variant with the scalar function. A kernel does not check its arguments: the
 * comment of its function type is a contract that the caller must fulfil.
 *
 * Unless a contract states otherwise:
 *   - A kernel reads and writes only the elements that its contract mentions.
 *   - Pointers have the alignment of their elements.
 *   - Const arguments do not overlap the output.
 *   - A kernel returns with the upper halves of vector registers cleared, and with the
 *     processor in the state that the C calling convention requires.
 *
 *   ost_cpu_kernels_fill(k, isa):   scalar -> avx2 -> avx512 -> avx512vbmi
 *                                   scalar -> neon
 */
#ifndef OST_CPU_KERNELS_H
#define OST_CPU_KERNELS_H

#include <osteon/mesh.h>

#include "core/isa.h"
#include "cpu/remove/block_base.h"
#include "cpu/remove/remove.h"

/* ------------------------------------------------------ grids (cpu/import/grid.h) */

/*
 * Gathers elements: to[i] = from[map[i]] for 0 <= i < count, 0 <= count <= 64. The elements of `map` are >= 0 and
 * ascending; neighbours may be equal. Every element of `from` with an index from map[0] to map[count - 1] may be read.
 */
typedef void ost_gather_row_fn(const int16_t *from, const int32_t *map, int count, int16_t *to);

/*
 * Linear interpolation (AR-CUB-2).  The upper of two neighbours has a weight w
 * with 0 <= w <= 2^15, and the lower neighbour has the weight 2^15 - w.  The rows of
 * the results are OST_ROW_STRIDE elements apart.
 */
enum { OST_WEIGHT_BITS = 15, OST_WEIGHT_ONE = 1 << OST_WEIGHT_BITS, OST_ROW_STRIDE = 64 };

/*
 * Interpolates rows between two slices:
 * to[64 r + i] = RHE((a[row[r] + i] (2^15 - weight) + b[row[r] + i] weight) / 2^15)
 * for 0 <= i < width (1 to 64) and 0 <= r < count; 0 < weight < 2^15.
 */
typedef void ost_blend_rows_fn(const int16_t *a, const int16_t *b, const size_t *row, int count, int width, int weight,
                               int16_t *to);

/*
 * Computes weighted sums of neighbours in a row:
 *   to[i] = from[at[i]] minus[2 i] + from[at[i] + 1] minus[2 i + 1] for 0 <= i < width (1 to 64).
 * `minus` contains pairs of negated weights; each pair sums to -2^15. The weights are negated, because the
 * range -2^15 to 0 fits in 16 bits. The elements of `at` are >= 0 and ascending; neighbours may be equal. Every element
 * of `from` with an index from at[0] to at[width - 1] + 1 may be read. Let n be width rounded up to a multiple of 16.
 * `at` and `to` have a capacity of n elements, and `minus` has a capacity of n pairs. The elements beyond width may be
 * read, and those of `to` may be overwritten.
 */
typedef void ost_stretch_row_fn(const int16_t *from, const int32_t *at, const int16_t *minus, int width, int32_t *to);

/*
 * Computes weighted sums of `count` (1, 2 or 4) rows: for 0 <= i < width (1 to 64),
 * to[i] = RHE(sum of rows[r][i] weight[r] / 2^45), where the sum is over 0 <= r < count.
 * |rows[r][i]| <= 2^30.  All weights have the same sign and sum to 2^30 or -2^30.  The
 * results fit in 16 bits.  rows[r] and `to` have a capacity of width rounded up to a
 * multiple of 16.  The elements beyond width may be read, and those of `to` may be
 * overwritten.
 */
typedef void ost_weigh_rows_fn(const int32_t *const rows[4], const int32_t weight[4], int count, int width,
                               int16_t *to);

/* ------------------------------------------------------ bones (cpu/bone/bone.h) */

/*
 * Converts sixteen rows of 4 * bricks voxels into a row of bricks. rows[y + 4 z] is the row (y, z); several rows may be
 * the same. `bricks` is 4, 8 or 16. Voxels below `threshold` (>= 1) become 0. Brick x is written to density + 64 *
 * spread(x) and occupancy[spread(x)], where spread(x) moves the bits 0 to 3 of x to the bits 0, 3, 6 and 9
 * (ost_brick_spread). The array `density` is 64-byte aligned. The memory between these bricks is not written. Returns
 * the number of active voxels and the highest density (0 if no voxel is active). If `stream` is true, stores bypass the
 * caches. The thread must then call the `drain` kernel before another thread reads the bricks.
 */
struct cpu_bone;
typedef struct ost_brick_sums {
    int32_t active, highest;
} ost_brick_sums;
typedef ost_brick_sums ost_brick_row_fn(const int16_t *const rows[16], size_t bricks, int16_t threshold, bool stream,
                                        int16_t *density, uint64_t *occupancy);

/*
 * Returns true if at least one of `count` (>= 1) rows has a voxel whose density is at least threshold (>= 1). Row i
 * begins at base + row[i] and has `width` elements (1 to 64).
 */
typedef bool ost_any_active_fn(const int16_t *base, const size_t *row, int count, int width, int16_t threshold);

/*
 * Writes the density of voxel (at[0][i], at[1][i], at[2][i]) to densities[i] for each i < count.  The
 * coordinates can have any value.  The density is 0 outside the grid and for voxels that are not
 * active.  Entries of the chunk table are read only for voxels in the grid. Occupancy words are read only for voxels in
 * chunks that have memory. For active voxels, the density and the two bytes after it are read; these bytes are part of
 * the chunk's allocation. Of *bone, the kernel reads only pointers, `dims` and `chunk_size`.
 */
typedef void ost_sample_fn(const struct cpu_bone *bone, size_t count, const int32_t *const at[3], int16_t *densities);

/* A barrier: the calling thread's earlier stores that bypass the caches become visible before its later stores. */
typedef void ost_drain_fn(void);

/* --------------------------------------------------- removal (cpu/remove/remove.h) */

/*
 * Selects the blocks with from <= block < to whose base (ost_block_base) is within *reach. On each axis,
 * first <= from < to <= first + 2, and the blocks must be among those for which `bases` was computed.
 * Overwrites *blocks with the selected blocks in ascending order of their numbers, and sets blocks->count.
 * In *blocks, the `u` of block first + (x, y, z) is the block's base, and its `number` is x + 2y + 4z.
 * Up to eight elements may be written.
 */
typedef void ost_blocks_fn(const ost_block_bases *bases, const ost_block_reach *reach, const int32_t first[3],
                           const int32_t from[3], const int32_t to[3], ost_cubes *blocks);

/*
 * Splits each cube into eight parts and classifies each part by the cell that contains
 * the part's centre, v = cells->value[clamp((u + centre) >> shift) + margin ...]:
 *     v <= -least   outside: the part is dropped
 *     v >=  least   inside: the part's number is appended to `inside`
 *     else          mixed: the part's u and number are appended to `mixed`
 * The set of appended parts is the same for all instruction sets, but their order may differ. If `occupancy` is not
 * NULL, it has one word per part, and parts whose word is 0 are dropped. The cubes' numbers are distinct, and only the
 * words of their parts are read from `occupancy`. The lists `mixed` and `inside` must not overlap `cubes`. The count
 * of each list is increased by the number of appended parts. Each list has capacity for 8 parts per cube and
 * OST_CUBES_SLACK more elements, which may be overwritten. u + centre and u + first of every part fit in int32. Up to
 * OST_CUBES_SLACK elements beyond cubes->count may be read. These elements may have any value: the indices computed
 * from them are clamped to the table. The values of cells are in [-64, 64].
 */
typedef void ost_split_fn(const ost_split *split, const ost_cells *cells, const ost_cubes *cubes,
                          const uint64_t *occupancy, ost_cubes *mixed, ost_numbers *inside);

/*
 * Computes the tables of *match that the `match` kernel of the same instruction set reads. Requires that
 * match->windows or match->wide is true, and that ost_match_make has computed the other members.
 */
typedef void ost_match_tables_fn(ost_match *match);

/*
 * Computes the hits of each brick: bit x + 4y + 16z of hits[i] is set if voxel (x, y, z) of brick i lies in a tool
 * voxel that is solid in match->shape. All space outside the tool's grid is empty. If match->windows or match->wide is
 * set, the `split` kernel must have used the cells of match->shape and found every brick mixed (remove.h, "Match").
 * u + offset of every voxel fits in int32. The array `hits` has capacity for OST_CUBES_SLACK more elements than there
 * are bricks, and these elements may be overwritten. Up to OST_CUBES_SLACK elements beyond bricks->count may be read
 * and can have any value.
 */
typedef void ost_match_fn(const ost_match *match, const ost_cubes *bricks, uint64_t *hits);

/*
 * Processes the bricks at density + 64 * number[i] for each i < count. Adds the voxels whose bits are set in hits[i] to
 * the tally and, if take->apply is true, sets them to 0. Every hits[i] has at least one bit set. The numbers are
 * distinct. The array `density` is 64-byte aligned. The densities of voxels that are hit are 1..take->highest; other
 * densities can have any value. The kernel changes only the voxels that are hit and the tally's elements 0 to
 * take->borders.
 */
typedef void ost_take_fn(const ost_take *take, int16_t *density, const int32_t *number, const uint64_t *hits,
                         size_t count, ost_tally *tally);

/* ---------------------------------------------- voxelization (voxelize.h) */

typedef struct ost_vox_tile ost_vox_tile;
typedef struct ost_vox_plan ost_vox_plan;

/*
 * Marks the crossings of count triangles with the rows of a tile in the tile's planes and spill. `list` contains the
 * triangles' numbers; if `list` is NULL, the numbers are 0 to count - 1. A triangle that is listed several times is
 * counted that many times. Planes and spill may contain earlier crossings. Crossings of the same sign at the same
 * centre are equivalent: any one of them may set the bit in the plane.
 */
typedef void ost_vox_mark_fn(ost_vox_tile *tile, const uint32_t *list, size_t count);

/*
 * Computes the keys of the triangles first to first + count - 1 from their bounds;
 * keys[i] is the key of triangle first + i. If the bounds of a triangle overlap
 * exactly one tile, its key is the number of this tile; otherwise the key is
 * OST_VOX_KEY_NONE or OST_VOX_KEY_MANY.
 */
typedef void ost_vox_keys_fn(const ost_vox_plan *plan, const ost_snapped_mesh *mesh, size_t first, size_t count,
                             uint32_t *keys);

/*
 * Fills the proven rows of a tile and returns the number of bits that are set in these rows.  In a
 * proven row, crossings that enter the mesh and crossings that leave the mesh alternate, and the
 * first and the last crossing are of opposite sign (fill.c).
 *
 * A block is OST_VOX_BLOCK words of planes. The rows begin at the start of a block and end at the end of a block or of
 * the tile. The array `bits` is 64-byte aligned and is written in complete blocks. Planes have no bits after a row's
 * last voxel.
 *
 * All other rows are unproven: the kernel sets their flag OST_VOX_UNPROVEN and the tile's `any_unproven`,
 * and their bits are undefined.  A kernel may mark all rows of a block unproven in two cases: one of the
 * rows is unproven, or the first crossing enters the mesh in some rows and leaves it in others.  The other
 * flags of row_state do not change.  If any_unproven was set before the call (spilled crossings set it
 * too), the planes do not change.  Otherwise the planes of the proven rows are cleared.
 */
typedef uint64_t ost_vox_fill_fn(ost_vox_tile *tile, size_t first_row, size_t rows, uint64_t *bits);

/*
 * Expands the bits of rows of nx voxels to classes, one byte per voxel. A row of the inputs has `words` =
 * ost_vox_words(nx) words. No voxel is set in both inputs; bits after a row's last voxel can have any value. The array
 * `noncutting` may be NULL. Reads rows * words words of each input and writes rows * nx bytes, at any alignment. If
 * `stream` is true, stores bypass the caches where the dimensions allow it; the function orders these stores before it
 * returns.
 */
typedef void ost_vox_expand_fn(const uint64_t *cutting, const uint64_t *noncutting, size_t rows, int words, int32_t nx,
                               bool stream, uint8_t *voxels);

typedef struct ost_cpu_kernels {
    ost_isa isa; /* the instruction set whose variants fill the slots */
    ost_gather_row_fn *gather_row;
    ost_blend_rows_fn *blend_rows;
    ost_stretch_row_fn *stretch_row;
    ost_weigh_rows_fn *weigh_rows;
    ost_brick_row_fn *brick_row;
    ost_any_active_fn *any_active;
    ost_drain_fn *drain;
    ost_sample_fn *sample;
    ost_blocks_fn *blocks;
    ost_split_fn *split;
    ost_match_tables_fn *match_tables;
    ost_match_fn *match;
    ost_take_fn *take;
    ost_vox_mark_fn *vox_mark;
    ost_vox_keys_fn *vox_keys;
    ost_vox_fill_fn *vox_fill;
    ost_vox_expand_fn *vox_expand;
} ost_cpu_kernels;

void ost_cpu_kernels_fill(ost_cpu_kernels *kernels, ost_isa isa);

/* The variants of each kernel for the instruction sets: NAME_scalar, NAME_avx2, ... */
ost_gather_row_fn ost_gather_row_scalar, ost_gather_row_avx512;
ost_blend_rows_fn ost_blend_rows_scalar, ost_blend_rows_avx2, ost_blend_rows_avx512, ost_blend_rows_neon;
ost_stretch_row_fn ost_stretch_row_scalar, ost_stretch_row_avx2, ost_stretch_row_avx512;
ost_weigh_rows_fn ost_weigh_rows_scalar, ost_weigh_rows_avx2, ost_weigh_rows_avx512, ost_weigh_rows_neon;
ost_brick_row_fn ost_brick_row_scalar, ost_brick_row_avx2, ost_brick_row_avx512, ost_brick_row_neon;
ost_any_active_fn ost_any_active_scalar, ost_any_active_avx2, ost_any_active_avx512, ost_any_active_neon;
ost_drain_fn ost_drain_scalar, ost_drain_avx2;
ost_sample_fn ost_sample_scalar, ost_sample_avx512;
ost_blocks_fn ost_blocks_scalar, ost_blocks_avx512;
ost_split_fn ost_split_scalar, ost_split_avx2, ost_split_avx512, ost_split_neon;
ost_match_tables_fn ost_match_ties, ost_match_carries_avx512vbmi;
ost_match_fn ost_match_scalar, ost_match_avx2, ost_match_avx512, ost_match_avx512vbmi, ost_match_neon;
ost_take_fn ost_take_scalar, ost_take_avx2, ost_take_avx512, ost_take_neon;
ost_vox_mark_fn ost_vox_mark_neon;
ost_vox_keys_fn ost_vox_keys_neon;
ost_vox_expand_fn ost_vox_expand_neon;

#endif
