/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The arithmetic of a field and of what is seen of it (dress.c).
 *
 *   rows of bits, densities --bits, densities--> slice of bone, [42][48]
 *   slice of bone --down--> sums along y, [34][48]
 *   nine of these --slice--> sums along z, a sixteenth of them, sums along x: slice of the field, [34][48]
 *
 *   slices of bone --cells--> a mean of each 2^3 voxels --lines, down, slice--> a field of cells
 *       --finer--> slice of the wide field, a quarter of it, [34][48]
 *
 *   three slices of the field, three of the wide one, points --looks--> normal, openness
 *
 * A sum has the weights 1 2 3 4 5 4 3 2 1.  All in 16 bits: sums are below
 * 2^16, and what overflows on the way to them cannot be told from what does
 * not.  So every variant gives the same words: the scalar one adds weighted
 * words; others add to a sum the slope to the next, and to the slope
 * in[i + 10] - 2 in[i + 5] + in[i].
 */
#ifndef OST_RENDER_SMOOTH_H
#define OST_RENDER_SMOOTH_H

#include "core/isa.h"
#include "render/points/surface.h"

enum {
    OST_FIELD_REACH = 5,   /* of a sum, and one more for a gradient */
    OST_WIDE_REACH = 11,   /* of the wide field's, in voxels */
    OST_NEAR_REACH = 3,    /* what is so near to a cut counts as bone, whatever its density */
    OST_FIELD_LINE = 48,   /* voxels of a row, from x = -8 */
    OST_FIELD_BONE = OST_BLOCK + 2 * OST_FIELD_REACH, /* rows of a slice of bone, and slices */
    OST_FIELD_ROWS = OST_BLOCK + 2, /* after a sum: the block and one about it */
    OST_FIELD_ALL = 63,    /* a voxel that is all bone */
    OST_FIELD_LEAST = 15,  /* one that is hardly */
    OST_FIELD_DENSE = 768, /* HU from which on a voxel is all bone: LEAST + 768 / 16 = ALL */
    OST_FIELD_FULL = 61525, /* about the field where all is bone */
    OST_FIELD_FLAT = OST_FIELD_FULL / 5 * 3, /* of a plane */
    OST_FIELD_BY_FACES = 160, /* what a face to the air adds to a slope */
    OST_CELLS = OST_BLOCK / 2, /* on a side of a block */
    OST_LOOKS_ROOM = 16,   /* words behind the last look that may be written */
};

typedef uint16_t ost_field_slice[OST_FIELD_ROWS][OST_FIELD_LINE];

typedef struct ost_smooth_kernels {
    /* Of each of bits x = -8 .. 39 of count rows (rows.h) OST_FIELD_ALL or nothing. */
    void (*bits)(const uint64_t *rows, int count, uint16_t (*out)[OST_FIELD_LINE]);
    /* Of a row's by their density; those that are near what was cut are all bone. */
    void (*densities)(uint64_t row, uint64_t near, const int16_t density[OST_FIELD_LINE], uint16_t out[OST_FIELD_LINE]);
    /* out[i] = 1 in[i] + 2 in[i + 1] + ... + 1 in[i + 8], count rows of them. */
    void (*down)(const uint16_t (*in)[OST_FIELD_LINE], uint16_t (*out)[OST_FIELD_LINE], int count);
    /* Rows whose bit is set. Place i of a row of the field is x = i - 1; behind the last of OST_FIELD_ROWS is anything. */
    void (*slice)(const ost_field_slice *const y[9], uint64_t rows, ost_field_slice *out);
    /* A row of cells, of two rows of two slices. */
    void (*cells)(const uint16_t (*below)[OST_FIELD_LINE], const uint16_t (*above)[OST_FIELD_LINE], uint8_t out[OST_CELLS]);
    /* Lines of cells, as those of bone: from -8 on; of three blocks' rows, which lie one behind the other. */
    void (*lines)(const uint8_t *left, const uint8_t *own, const uint8_t *right, int count, uint16_t (*out)[OST_FIELD_LINE]);
    /* Rows whose bit is set, which is one at least, of the slice between two of cells: nearer to the second if odd. */
    void (*finer)(const ost_field_slice *const cells[2], bool odd, uint64_t rows, ost_field_slice *out);
    /* Points of one slice, whose field is fine[1]. */
    void (*looks)(const uint32_t *points, int count, const ost_field_slice *const fine[3], const ost_field_slice *const wide[3], uint32_t *looks);
} ost_smooth_kernels;

ost_smooth_kernels ost_smooth_kernels_of(ost_isa isa);

#define OST_SMOOTH_DECLARE(SET)                                                                                                     \
    void ost_field_bits_##SET(const uint64_t *rows, int count, uint16_t (*out)[OST_FIELD_LINE]);                                    \
    void ost_field_densities_##SET(uint64_t row, uint64_t near, const int16_t density[OST_FIELD_LINE], uint16_t out[OST_FIELD_LINE]); \
    void ost_field_down_##SET(const uint16_t (*in)[OST_FIELD_LINE], uint16_t (*out)[OST_FIELD_LINE], int count);                    \
    void ost_field_slice_##SET(const ost_field_slice *const y[9], uint64_t rows, ost_field_slice *out);                             \
    void ost_field_cells_##SET(const uint16_t (*below)[OST_FIELD_LINE], const uint16_t (*above)[OST_FIELD_LINE], uint8_t *out);      \
    void ost_field_lines_##SET(const uint8_t *left, const uint8_t *own, const uint8_t *right, int count, uint16_t (*out)[OST_FIELD_LINE]); \
    void ost_field_looks_##SET(const uint32_t *points, int count, const ost_field_slice *const fine[3], const ost_field_slice *const wide[3], uint32_t *looks);
OST_SMOOTH_DECLARE(scalar)
OST_SMOOTH_DECLARE(avx2)
OST_SMOOTH_DECLARE(avx512)
void ost_field_finer_scalar(const ost_field_slice *const cells[2], bool odd, uint64_t rows, ost_field_slice *out);
void ost_field_finer_avx2(const ost_field_slice *const cells[2], bool odd, uint64_t rows, ost_field_slice *out); /* AVX-512's too */

#endif
