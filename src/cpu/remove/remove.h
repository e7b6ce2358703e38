/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What the inner loops of removal work on (kernels.h has their contracts).
 *
 *   16^3 block --split--> 8^3 cubes --split--> 4^3 bricks --match--> hits --take--> densities, tally
 *                  |                   |
 *                  '- inside, outside -'
 *
 * Coordinates are those of AR-MAP-4: units of 2^-20 tool voxels, int32, the
 * coordinate of a cube being that of its first voxel.  A cube's voxels have
 * coordinates u + i step[0] + j step[1] + k step[2], 0 <= i, j, k < edge, all
 * in the same 16^3 block, so that no rounding happens between.
 *
 * Split.  The centre of a cube of edge e is u + (e-1)/2 (step[0] + step[1] +
 * step[2]); it is rounded down to a unit (less than 1 off, an axis).  No voxel is
 * farther from it than R, the greatest of the cube's half diagonals
 * (e-1)/2 |step[0] +- step[1] +- step[2]|.  With `least` the first v for which
 * v * unit > R + 2 > R + sqrt(3): a centre in a cell of value <= -least has
 * only voxels of void around it by (C1), and one of >= least only solid ones.
 *
 * Match.  Where windows may be used (ost_match.windows): a brick's least
 * coordinate on an axis is u + lowest, and its voxels are within
 * 0 <= offset < (8 - step) voxels of it: at most 9 - step voxels wide, so it lies
 * in the window number floor((voxel + margin) / step), and
 *     c + offset < step + 8 - step = 8 voxels = 2^23 units
 * with c the least coordinate from the window's begin on.
 * No brick that a split calls mixed asks for a window beyond the table: its
 * centre lies in a cell with |v| < least, so a granule that is not void, hence
 * the tool's grid, is nearer to the cell than least units of 1/8 granule,
 * <= (R + 2) / unit + 1 of them.  With R <= 3.6 voxels and granules of up
 * to 2 voxels, cells of up to 4, that is
 *     3.6 + 2/2^20 + 1/4 + 4 < 7.9 voxels an axis between the grid and the centre.
 * The least coordinate is at most 3.5 voxels and a unit below the centre, and
 * not above it: > -12, < dims + 8.
 *
 * Sixteen bits a lane.  c >> 7 and offset >> 7 are 3 bits of voxel and 13 of
 * fraction. (c >> 7) + (offset >> 7) is (c + offset) >> 7 or one less, as the low
 * seven bits may carry; the voxel is wrong only if the carry runs through 13
 * set bits.  `tie` marks the values of (c >> 7) mod 2^13 for which some offset
 * has a sum with 13 set bits: such a brick (2.3 % of them) is matched with the
 * carries.  `near_tie` has eight such values a bit, few enough for registers:
 * what is not near a tie (five bricks of six) is none.
 */
#ifndef OST_CPU_REMOVE_H
#define OST_CPU_REMOVE_H

#include "cpu/remove/shape.h"

enum {
    OST_UNIT = 32,         /* voxels an axis that are worked on at once: a chunk, or an eighth of one of 64^3 */
    OST_UNIT_BRICKS = 512,
    OST_CUBES_SLACK = 16,  /* elements behind the last one that a kernel may overwrite */
    OST_TIE_BITS = 13,
    OST_NEAR_TIES = 1024,
};

/* Cubes of one edge. number counts Morton-wise within the unit: cube n holds the cubes 8n..8n+7 of half the edge. */
typedef struct ost_cubes {
    _Alignas(64) int32_t u[3][OST_UNIT_BRICKS + OST_CUBES_SLACK];
    int32_t number[OST_UNIT_BRICKS + OST_CUBES_SLACK];
    size_t count;
} ost_cubes;

typedef struct ost_numbers {
    _Alignas(64) int32_t number[OST_UNIT_BRICKS + OST_CUBES_SLACK];
    size_t count;
} ost_numbers;

/* A pose on cubes that are cut into eight. */
typedef struct ost_split {
    _Alignas(32) int32_t first[3][8];  /* from the cube's u to the u of part x + 2y + 4z */
    _Alignas(32) int32_t centre[3][8]; /* to the part's centre, rounded down */
    int32_t least;                     /* 1..128; over 127: no part is known to be inside or outside */
} ost_split;

/* A pose on bricks; voxel x + 4y + 16z. */
typedef struct ost_match {
    _Alignas(64) uint16_t high[3][64]; /* (offset - lowest) >> 7 */
    _Alignas(64) uint16_t low[3][64];  /* and its low 7 bits */
    int32_t offset[3][64];             /* from the brick's u */
    int32_t lowest[3];
    bool windows;
    uint8_t tie[1 << OST_TIE_BITS]; /* bit a: on axis a */
    _Alignas(64) uint32_t near_tie[3][OST_NEAR_TIES / 32]; /* bit n: one of tie's values from 8 n to 8 n + 7 is set on this axis */
    const ost_shape *shape;
} ost_match;

/* What is taken, and the limits that hold for all of it. */
typedef struct ost_take {
    int borders;        /* 0..OST_CLASS_MAX - 1 */
    int16_t border[OST_CLASS_MAX]; /* ascending */
    int32_t highest;    /* no density is above it; 1..32767 */
    bool apply;         /* write 0 where hit */
} ost_take;

/* Sums over hits: [0] all, [b] those of density >= border[b - 1]. */
typedef struct ost_tally {
    uint64_t voxels[OST_CLASS_MAX];
    uint64_t density[OST_CLASS_MAX];
} ost_tally;

void ost_split_make(const int32_t step[3][3], int32_t edge, const ost_cells *cells, ost_split *out);
void ost_match_make(const int32_t step[3][3], const ost_shape *shape, ost_match *out);

#endif
