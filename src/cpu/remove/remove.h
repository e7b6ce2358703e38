/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The data of the inner loops of removal. kernels.h has the contracts of these loops.
 *
 *   16^3 block --split--> 8^3 cubes --split--> 4^3 bricks --match--> hits --take--> densities, tally
 *                  |                   |
 *                  '- inside, outside -'
 *
 * Coordinates are defined by AR-MAP-4: int32 in units of 2^-20 tool voxels.  The
 * coordinate u of a cube is the coordinate of its first voxel.  The voxels of the cube have
 * the coordinates u + i step[0] + j step[1] + k step[2], 0 <= i, j, k < edge.  All voxels
 * of a cube are in the same 16^3 block, so these sums are exact.
 *
 * Split.  The centre of a cube of edge e is u + (e-1)/2 (step[0] + step[1] + step[2]); it is rounded
 * down to an integer (an error below 1 on each axis).  No voxel is farther from the centre than R, the
 * length of the longest half diagonal of the cube, (e-1)/2 |step[0] +- step[1] +- step[2]|. Let
 * `unit` be 1/8 of a granule's edge (ost_cells), and `least` the first v for which
 * v * unit > R + 2 > R + sqrt(3).  If the centre lies in a cell of
 * value <= -least, all voxels of the cube are empty by (C1); if the value is >= least, all are
 * solid.
 *
 * Match.  On each axis, the least coordinate of a brick is u + lowest, and the distance between adjacent windows is s
 * tool voxels (ost_windows.step). If windows may be used (ost_match.windows), the offset of every voxel of the brick
 * from the least coordinate is 0 <= offset < 8 - s tool voxels. The brick then overlaps at most 9 - s tool voxels and
 * lies in the window number floor((voxel + margin) / s), where `voxel` is the index of the tool voxel that contains the
 * least coordinate. Therefore
 *     c + offset < s + 8 - s = 8 tool voxels = 2^23 units
 * where c is the least coordinate relative to the window's first voxel. No mixed brick of a split needs a window beyond
 * the table. The centre of such a brick lies in a cell with |v| < least. Therefore a granule that is not empty is
 * nearer to the cell than least * unit. This granule overlaps the tool's grid, and `least` is at most
 * (R + 2) / unit + 1. With R <= 3.6 voxels, granules of up to 2 voxels and cells of up to 4 voxels, the distance
 * between the grid and the centre on an axis is less than
 *     3.6 + 2/2^20 + 1/4 + 4 < 7.9 voxels.
 * The least coordinate of the brick is not above the centre, and at most 3.5 + 1/2^20 voxels below it. The least
 * coordinate is therefore > -12 and < dims + 8 voxels.
 * For wide windows (ost_match.wide), the proof is the same with 16 in place of 8. Then R <= 7.5 voxels, granules have
 * up to 4 voxels and cells up to 8, and 7.5 + 2/2^20 + 1/2 + 8 < 16.1. The least coordinate is at most 7.5 + 1/2^20
 * voxels below the centre, and therefore > -24 and < dims + 16.
 *
 * Sixteen bits per lane. c >> 7 and offset >> 7 have 3 bits of voxel and 13 of fraction. (c >> 7) +
 * (offset >> 7) is (c + offset) >> 7 or one less, because the low seven bits may carry; the voxel is
 * wrong only if the carry passes through 13 set bits. A value of (c >> 7) mod 2^13 is a tie if its sum with some offset
 * has 13 set fraction bits; `tie` marks the ties. A brick whose c is a tie on an axis is tied (2.3 % of all bricks) and
 * is matched with the carries. `near_tie` has one bit for eight values, so that its bits fit in registers. If the bits
 * for a brick's values are clear (five bricks of six), the brick is not tied.
 *
 * Carries.  The kernel for AVX-512 VBMI adds complete voxels and fractions separately. Voxel v of a brick has the
 * voxel coordinate floor(c) + floor(offset[v]) + carry in its window. The threshold of v is 1 minus the fraction of
 * offset[v]; the carry is 1 if the fraction of c is at least this threshold. The thresholds of the 64 voxels are
 * sorted. The number of thresholds that a fraction reaches, its rank, then determines the carries of all voxels. On
 * each axis, at least one voxel has the offset 0, and no fraction reaches its threshold 1, so a rank is at most 63.
 */
#ifndef OST_CPU_REMOVE_H
#define OST_CPU_REMOVE_H

#include "cpu/remove/shape.h"

enum {
    /*
     * maximum edge length of a unit in voxels; a unit is a chunk or, if chunks have 64^3 voxels, an eighth of a chunk
     */
    OST_UNIT = 32,
    OST_UNIT_BRICKS = 512,
    OST_CUBES_SLACK = 16,  /* number of elements that a kernel may overwrite after the last cube */
    OST_TIE_BITS = 13,
    OST_NEAR_TIES = 1024,
};

/*
 * A list of cubes that all have the same edge. number[i] is the Morton index of cube i within the unit. If the cube
 * with the Morton index n is divided into eight, these smaller cubes have the Morton indices 8n to 8n+7.
 */
typedef struct ost_cubes {
    _Alignas(64) int32_t u[3][OST_UNIT_BRICKS + OST_CUBES_SLACK];
    int32_t number[OST_UNIT_BRICKS + OST_CUBES_SLACK];
    size_t count;
} ost_cubes;

typedef struct ost_numbers {
    _Alignas(64) int32_t number[OST_UNIT_BRICKS + OST_CUBES_SLACK];
    size_t count;
} ost_numbers;

/* Constants with which the `split` kernel divides cubes of a given size into eight parts, for one pose. */
typedef struct ost_split {
    /* coordinate u of each of the eight parts, relative to the cube's u; part (x, y, z) has the number x + 2y + 4z */
    _Alignas(32) int32_t first[3][8];
    /* centre of each of the eight parts, relative to the cube's u, rounded down */
    _Alignas(32) int32_t centre[3][8];
    /* least absolute value of a cell for which a part is not mixed, 1..127; 128 if every part is mixed */
    int32_t least;
} ost_split;

/*
 * The tables that only the `match` kernel for AVX-512 VBMI reads ("Carries"), in units of 2^-20 tool voxels. The voxels
 * of a brick are numbered as in ost_match.
 */
typedef struct ost_carries {
    /* The thresholds of each axis in ascending order, 1..2^20: element [a][k][g] is threshold 4 g + k of axis a. */
    _Alignas(64) uint32_t threshold[3][4][16];
    /* row[3 z + y][v] is the number of the window's byte for voxel v if there are no carries and floor(c) has the
       coordinates y and z */
    uint8_t row[9][64];
    uint8_t bit[4][64];    /* bit[x][v] is the bit of voxel v in its byte if floor(c) plus carry is x on the x axis */
    uint64_t mask[3][64];  /* mask[a][r] is the set of the voxels with a carry along axis a for a fraction of rank r */
    /* If there are no carries and floor(c) is (0, 0, 0), voxel v has the coordinates (x, y, z) in the wide window, with
       wide[0][v] = 16 y + z and wide[1][v] = x. The kernel adds floor(c), which has up to six values on each axis. */
    uint8_t wide[2][64];
} ost_carries;

/*
 * Constants with which the `match` kernel tests the voxels of bricks, for one pose. In an array of 64 elements, voxel
 * (x, y, z) of a brick has the index x + 4y + 16z. ost_match_make computes `offset`, `lowest`, `windows`, `wide` and
 * `shape`. If `windows` or `wide` is true, the `match_tables` kernel then computes the tables that the `match` kernel
 * of the same instruction set reads: either `high`, `low`, `tie` and `near_tie`, or `carries`.
 */
typedef struct ost_match {
    _Alignas(64) uint16_t high[3][64]; /* (offset[a][i] - lowest[a]) >> 7 */
    _Alignas(64) uint16_t low[3][64];  /* (offset[a][i] - lowest[a]) mod 2^7 */
    int32_t offset[3][64];             /* offset from the coordinate u of a brick to the u of each voxel of the brick */
    int32_t lowest[3];                 /* the lowest offset[a][i] of each axis a */
    bool windows;                      /* true if the `match` kernel may use windows of 8^3 tool voxels */
    bool wide;                         /* true if the `match` kernel may use wide windows, of 16^3 tool voxels */
    /* bit a of tie[v] is set if the value v is a tie on axis a ("Sixteen bits per lane") */
    uint8_t tie[1 << OST_TIE_BITS];
    /* bit n of near_tie[a] is set if at least one of the elements tie[8 n] to tie[8 n + 7] has bit a set */
    _Alignas(64) uint32_t near_tie[3][OST_NEAR_TIES / 32];
    ost_carries carries;
    const ost_shape *shape;
} ost_match;

/* The parameters of the `take` kernel, which removes or counts the voxels that are hit. */
typedef struct ost_take {
    int borders;        /* number of borders between density classes, 0..OST_CLASS_MAX - 1 */
    int16_t border[OST_CLASS_MAX]; /* ascending */
    int32_t highest;    /* upper bound on all densities in the chunk, 1..32767 */
    /* true to remove the voxels that are hit, that is, to set them to 0; false to count them only */
    bool apply;
} ost_take;

/*
 * The number of hits and the sum of their densities. Element 0 counts all hits. Element b > 0 counts the hits whose
 * density is at least border[b - 1].
 */
typedef struct ost_tally {
    uint64_t voxels[OST_CLASS_MAX];
    uint64_t density[OST_CLASS_MAX];
} ost_tally;

void ost_split_make(const int32_t step[3][3], int32_t edge, const ost_cells *cells, ost_split *out);
void ost_match_make(const int32_t step[3][3], const ost_shape *shape, ost_match *out);

#endif
