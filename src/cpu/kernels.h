/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The inner loops of the CPU backend.  Every slot is filled with its scalar
 * function first and then overwritten as far as the instruction set allows,
 * so no slot is ever NULL and every variant has the scalar one to be held to
 * (tests/simd).  A kernel checks nothing: its contract stands beside its slot.
 *
 * Unless a contract says more: nothing is read or written but the elements it
 * speaks of; pointers are aligned as their elements are; what is const does
 * not overlap what is written; and the processor's state is left as a C
 * function leaves it, with upper halves of vectors cleared.
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
 * to[i] = from[map[i]], 0 <= i < count, 0 <= count <= 64; map ascends (equal
 * neighbours allowed) from 0 or more.  All of from[map[0]] to from[map[count - 1]]
 * may be read.
 */
typedef void ost_gather_row_fn(const int16_t *from, const int32_t *map, int count, int16_t *to);

/*
 * Linear interpolation (AR-CUB-2).  The upper of two neighbours has a weight w
 * of 0 to 2^15, the lower one 2^15 - w.  Rows of results lie OST_ROW_STRIDE
 * elements apart.
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
 * Computes the sums of a row along x:
 * to[i] = from[at[i]] minus[2 i] + from[at[i] + 1] minus[2 i + 1] for
 * 0 <= i < width (1 to 64).  minus holds the negated weights, -2^15 to 0, so
 * that both ends of their range fit 16 bits; the two of a pair sum to -2^15.
 * at ascends (equal neighbours allowed) from 0 or more.  All of from[at[0]] to
 * from[at[width - 1] + 1] may be read.  at, minus (pairs) and to have room up to
 * a multiple of 16; what lies there may be read, and in `to` be overwritten.
 */
typedef void ost_stretch_row_fn(const int16_t *from, const int32_t *at, const int16_t *minus, int width, int32_t *to);

/*
 * Computes weighted sums of rows: to[i] = RHE(sum of rows[r][i] weight[r] / 2^45)
 * over 0 <= r < count (1, 2 or 4) for 0 <= i < width (1 to 64).
 * |rows[r][i]| <= 2^30; the weights have one sign and sum to 2^30 or -2^30; the
 * results fit 16 bits.  rows[r] and to have room up to a multiple of 16; what
 * lies there may be read, and in `to` be overwritten.
 */
typedef void ost_weigh_rows_fn(const int32_t *const rows[4], const int32_t weight[4], int count, int width, int16_t *to);

/* ------------------------------------------------------ bones (cpu/bone/bone.h) */

/*
 * Sixteen rows of 4 * bricks voxels, row y + 4 z, some of which may be the same,
 * into a row of bricks: voxels below threshold (>= 1) become 0.  bricks is 4, 8 or 16; brick x is written
 * to density + 64 * spread(x) and occupancy[spread(x)], spread(x) being the bits
 * of x at 0, 3, 6, 9 (ost_brick_spread).  density is 64-byte aligned.  What lies
 * between those bricks is not written.  Returns how many voxels are active and the highest density (0 when none is).
 * stream asks for stores past the caches; drain must follow before another thread reads.
 */
struct cpu_bone;
typedef struct ost_brick_sums {
    int32_t active, highest;
} ost_brick_sums;
typedef ost_brick_sums ost_brick_row_fn(const int16_t *const rows[16], size_t bricks, int16_t threshold, bool stream, int16_t *density,
                                        uint64_t *occupancy);

/* Whether one of the first `width` elements (1 to 64) of the `count` (>= 1) rows base + row[i] is at least threshold (>= 1). */
typedef bool ost_any_active_fn(const int16_t *base, const size_t *row, int count, int width, int16_t threshold);

/*
 * densities[i] of voxel (at[0][i], at[1][i], at[2][i]), any numbers: 0 beyond the grid and for what is not active.  Of the
 * voxels in the grid the chunks' entries are read, of those in chunks with memory the words of occupancy, of the active ones the density
 * and the two bytes behind it, which lie in the chunk's block.  Only pointers, dims and chunk_size of bone are looked at.
 */
typedef void ost_sample_fn(const struct cpu_bone *bone, size_t count, const int32_t *const at[3], int16_t *densities);

/* Orders streamed stores of this thread before what it stores next. */
typedef void ost_drain_fn(void);

/* --------------------------------------------------- removal (cpu/remove/remove.h) */

/*
 * Of the blocks from <= block < to (from < to, in the range that bases was made
 * for, and within first <= block < first + 2) those that have a base
 * (ost_block_base) in reach: their bases as u, and as number
 * x + 2y + 4z from first on; ascending, the first one as blocks' first. blocks->count is set; up
 * to eight elements may be written.
 */
typedef void ost_blocks_fn(const ost_block_bases *bases, const ost_block_reach *reach, const int32_t first[3], const int32_t from[3],
                           const int32_t to[3], ost_cubes *blocks);

/*
 * Cuts cubes into eight and sorts the parts by the cell of their centre,
 * v = cells->value[clamp((u + centre) >> shift) + margin ...]:
 *     v <= -least   outside: dropped
 *     v >=  least   inside: number appended to `inside`
 *     else          mixed: u and number appended to `mixed`
 * in any order (it differs among instruction sets; the sets are equal).
 * occupancy, when not NULL, has one word a part; parts with a word of 0 are dropped first.
 * The cubes' numbers differ from each other; of occupancy the words of their
 * parts are read.  mixed and inside are not cubes; their counts are added to,
 * and room is there for 8 parts a cube and OST_CUBES_SLACK more, which may be
 * overwritten.  u + centre and u + first of every part fit int32.  Up to
 * OST_CUBES_SLACK elements behind cubes->count may be read, and whatever they
 * hold, table entries that exist are looked at for them.  Values of cells are
 * in [-64, 64].
 */
typedef void ost_split_fn(const ost_split *split, const ost_cells *cells, const ost_cubes *cubes, const uint64_t *occupancy,
                          ost_cubes *mixed, ost_numbers *inside);

/*
 * hits[i] bit x + 4y + 16z: whether the tool voxel that holds voxel (x, y, z)
 * of brick i is solid in match->shape (void outside the tool's grid).  Bricks are mixed ones of a split by
 * the same shape (remove.h: "Match") when match->windows is set, any otherwise.
 * u + offset of every voxel fits int32.  hits has room for OST_CUBES_SLACK more,
 * which may be overwritten; up to that many elements of bricks behind its count
 * may be read, and are anything.
 */
typedef void ost_match_fn(const ost_match *match, const ost_cubes *bricks, uint64_t *hits);

/*
 * For each i < count the voxels hits[i] (not 0) of the brick at density + 64 *
 * number[i]: adds them to the tally, and when take->apply, writes 0 to them.
 * density is 64-byte aligned; densities at hits are 1..take->highest, others are
 * anything; numbers differ from each other.  Only voxels that are hit change.
 * Of the tally only [0] to [take->borders] change.
 */
typedef void ost_take_fn(const ost_take *take, int16_t *density, const int32_t *number, const uint64_t *hits, size_t count,
                         ost_tally *tally);

/* ---------------------------------------------- voxelization (voxelize.h) */

typedef struct ost_vox_tile ost_vox_tile;
typedef struct ost_vox_plan ost_vox_plan;

/*
 * Marks the crossings of count triangles with the rows of a tile that are to be
 * marked in its planes (and its spill); list NULL: of the triangles 0 to count - 1.
 * A triangle may be listed more than once and then counts as often.  Planes and
 * spill may hold earlier crossings.  Which of several crossings at one centre
 * has the bit is of no account: all of them are then the same.
 */
typedef void ost_vox_mark_fn(ost_vox_tile *tile, const uint32_t *list, size_t count);

/*
 * The tile of each of the triangles first to first + count - 1, by its bounds:
 * the tile's number, or OST_VOX_KEY_NONE, or OST_VOX_KEY_MANY.  keys[0] is the
 * first one's.
 */
typedef void ost_vox_keys_fn(const ost_vox_plan *plan, const ost_snapped_mesh *mesh, size_t first, size_t count, uint32_t *keys);

/*
 * Fills some rows of a tile, from a whole block on and to the end of one or of
 * the tile (a block: OST_VOX_BLOCK words of planes): writes the bits (whole
 * blocks; 64-byte aligned) of the rows whose crossings enter and leave in turn,
 * beginning with either and ending with the other (fill.c), and returns how many
 * bits it set in them.  Sets OST_VOX_UNPROVEN and any_odd for the others, whose
 * bits are of no account; with one row of a block, or when some of them enter
 * first and others leave first, all of the same block may be called unproven.  Other flags of odd stay.  Clears the planes of the proven
 * rows, unless any_odd was set before: a row may be odd for its spill; then planes
 * do not change.  Planes hold nothing behind a row's last voxel.
 */
typedef uint64_t ost_vox_fill_fn(ost_vox_tile *tile, size_t first_row, size_t rows, uint64_t *bits);

/*
 * rows * nx classes from rows of `words` (ost_vox_words(nx)) words; no voxel is
 * in both, bits behind a row's last voxel are anything. noncutting may be NULL.
 * Reads rows * words words of each, writes rows * nx bytes, whatever their
 * alignment. `stream` asks for stores past the caches, where the shape allows
 * them; they are ordered before the return.
 */
typedef void ost_vox_expand_fn(const uint64_t *cutting, const uint64_t *noncutting, size_t rows, int words, int32_t nx, bool stream,
                               uint8_t *voxels);

typedef struct ost_cpu_kernels {
    ost_isa isa; /* the level they were filled for */
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
    ost_match_fn *match;
    ost_take_fn *take;
    ost_vox_mark_fn *vox_mark;
    ost_vox_keys_fn *vox_keys;
    ost_vox_fill_fn *vox_fill;
    ost_vox_expand_fn *vox_expand;
} ost_cpu_kernels;

void ost_cpu_kernels_fill(ost_cpu_kernels *kernels, ost_isa isa);

/* NAME_scalar, NAME_avx2, ... of every slot. */
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
ost_match_fn ost_match_scalar, ost_match_avx2, ost_match_avx512, ost_match_neon;
ost_take_fn ost_take_scalar, ost_take_avx2, ost_take_avx512, ost_take_neon;
ost_vox_mark_fn ost_vox_mark_neon;
ost_vox_keys_fn ost_vox_keys_neon;
ost_vox_expand_fn ost_vox_expand_neon;

#endif
