/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The arithmetic of the field (the smoothed amount of bone) and of the shades that are computed from it (shading.c).
 *
 *   rows of bits, densities --bits, densities--> slice of bone, [42][48]
 *   slice of bone --down--> sums along y, [34][48]
 *   nine of these sums --slice--> sums along z, divided by 16, summed along x: slice of the field, [34][48]
 *
 *   slices of bone --cells--> means of 2^3 voxels each --lines, down, slice--> field of cells
 *       --finer--> slice of the wide field, divided by 4, [34][48]
 *
 *   three slices of the field, three of the wide one, points --shades-> normal, openness
 *
 * A sum has the weights 1 2 3 4 5 4 3 2 1. All arithmetic is modulo 2^16: final sums are below 2^16, so intermediate
 * overflow is harmless, and all variants compute the same words. The scalar variant adds weighted words. The other
 * variants add a difference to obtain the next sum, and in[i + 10] - 2 in[i + 5] + in[i] to obtain the next difference.
 */
#ifndef OST_RENDER_SMOOTH_H
#define OST_RENDER_SMOOTH_H

#include "core/isa.h"
#include "render/points/surface.h"

enum {
    /* distance, in voxels, up to which voxels affect the field's gradient: 4 for the sum and 1 for the gradient */
    OST_FIELD_REACH = 5,
    OST_WIDE_REACH = 11,   /* the same distance for the wide field's gradient */
    /* bone voxels at most this number of voxels away from a cut count as 100 % bone, regardless of their density */
    OST_NEAR_REACH = 3,
    OST_FIELD_LINE = 48,   /* number of voxels in a line, which begins at x = -8 */
    /* number of slices of bone, and of rows in each slice */
    OST_FIELD_BONE = OST_BLOCK + 2 * OST_FIELD_REACH,
    /* number of rows of sums: those of the block and one more on each side */
    OST_FIELD_ROWS = OST_BLOCK + 2,
    OST_FIELD_ALL = 63,    /* value of a voxel that is 100 % bone */
    OST_FIELD_LEAST = 15,  /* minimum value of a bone voxel */
    /* minimum density at which every bone voxel counts as 100 % bone */
    OST_FIELD_DENSE = 768,
    OST_FIELD_FULL = 61525, /* approximate value of the field inside bone */
    OST_FIELD_FLAT = OST_FIELD_FULL / 5 * 3, /* value of the field at a plane surface */
    OST_FIELD_BY_FACES = 160, /* amount by which an exposed face increases a slope */
    OST_CELLS = OST_BLOCK / 2, /* number of cells per side of a block */
    OST_SHADING_SLACK = 16, /* number of words that a kernel may overwrite after the last shade */
};

typedef uint16_t ost_field_slice[OST_FIELD_ROWS][OST_FIELD_LINE];

typedef struct ost_smooth_kernels {
    /* Writes OST_FIELD_ALL for each set bit and 0 for each clear bit, for x = -8 .. 39 of `count` rows (rows.h). */
    void (*bits)(const uint64_t *rows, int count, uint16_t (*out)[OST_FIELD_LINE]);
    /* Computes the values of one row from the densities. A bone voxel near a cut counts as 100 % bone. */
    void (*densities)(uint64_t row, uint64_t near, const int16_t density[OST_FIELD_LINE], uint16_t out[OST_FIELD_LINE]);
    /* Computes sums along y for `count` rows i: out[i] = 1 * in[i] + 2 * in[i + 1] + ... + 1 * in[i + 8]. */
    void (*down)(const uint16_t (*in)[OST_FIELD_LINE], uint16_t (*out)[OST_FIELD_LINE], int count);
    /* Computes sums along z and then along x, for the rows whose bit in `rows` is set. Entry i of a row is the sum at x
       = i - 1. Entries from OST_FIELD_ROWS on are undefined. */
    void (*slice)(const ost_field_slice *const y[9], uint64_t rows, ost_field_slice *out);
    /* Computes a row of cells from four rows of voxels: two rows in each of two slices. */
    void (*cells)(const uint16_t (*below)[OST_FIELD_LINE], const uint16_t (*above)[OST_FIELD_LINE],
                  uint8_t out[OST_CELLS]);
    /* Joins the rows of cells of three adjacent blocks into lines. The lines begin at x = -8, as lines of voxels do.
     * `count` is the number of lines. */
    void (*lines)(const uint8_t *left, const uint8_t *own, const uint8_t *right, int count,
                  uint16_t (*out)[OST_FIELD_LINE]);
    /* Interpolates between two slices of cells. The result is nearer to the second slice if `odd` is true, otherwise
     * nearer to the first. Only the rows whose bit in `rows` is set are computed; at least one bit must be set. */
    void (*finer)(const ost_field_slice *const cells[2], bool odd, uint64_t rows, ost_field_slice *out);
    /* Computes the shades of the points of one slice. fine[1] and wide[1] are the fields in this slice. */
    void (*shades)(const uint32_t *points, int count, const ost_field_slice *const fine[3],
                   const ost_field_slice *const wide[3], uint32_t *shades);
} ost_smooth_kernels;

ost_smooth_kernels ost_smooth_kernels_of(ost_isa isa);

#define OST_SMOOTH_DECLARE(SET)                                                                                        \
    void ost_field_bits_##SET(const uint64_t *rows, int count, uint16_t(*out)[OST_FIELD_LINE]);                        \
    void ost_field_densities_##SET(uint64_t row, uint64_t near, const int16_t density[OST_FIELD_LINE],                 \
                                   uint16_t out[OST_FIELD_LINE]);                                                      \
    void ost_field_down_##SET(const uint16_t(*in)[OST_FIELD_LINE], uint16_t(*out)[OST_FIELD_LINE], int count);         \
    void ost_field_slice_##SET(const ost_field_slice *const y[9], uint64_t rows, ost_field_slice *out);                \
    void ost_field_cells_##SET(const uint16_t(*below)[OST_FIELD_LINE], const uint16_t(*above)[OST_FIELD_LINE],         \
                               uint8_t *out);                                                                          \
    void ost_field_lines_##SET(const uint8_t *left, const uint8_t *own, const uint8_t *right, int count,               \
                               uint16_t(*out)[OST_FIELD_LINE]);                                                        \
    void ost_field_shades_##SET(const uint32_t *points, int count, const ost_field_slice *const fine[3],               \
                                const ost_field_slice *const wide[3], uint32_t *shades);
OST_SMOOTH_DECLARE(scalar)
OST_SMOOTH_DECLARE(avx2)
OST_SMOOTH_DECLARE(avx512)
void ost_field_finer_scalar(const ost_field_slice *const cells[2], bool odd, uint64_t rows, ost_field_slice *out);
/* The function for AVX2, which is also used for AVX-512. */
void ost_field_finer_avx2(const ost_field_slice *const cells[2], bool odd, uint64_t rows, ost_field_slice *out);

#endif
