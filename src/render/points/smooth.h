/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The arithmetic of a field (dress.c), a line of words at a time.
 *
 * All in 16 bits: sums are below 2^16, and what overflows on the way to them
 * cannot be told from what does not.  So every variant gives the same words.
 */
#ifndef OST_RENDER_SMOOTH_H
#define OST_RENDER_SMOOTH_H

#include <stdbool.h>

#include "core/isa.h"

enum {
    OST_FIELD_LINE = 48,  /* voxels of a row */
    OST_FIELD_ALL = 63,   /* a voxel that is all bone */
    OST_FIELD_LEAST = 15, /* one that is hardly */
    OST_FIELD_DENSE = 768, /* HU from which on a voxel is all bone: LEAST + 768 / 16 = ALL */
    OST_FIELD_LANES = 32,
};

typedef struct ost_smooth_kernels {
    /*
     * out[i] = 1 in[i] + 2 in[i + step] + ... + 5 in[i + 4 step] + ... + 1 in[i + 8 step],
     * of which a sixteenth, rounded, if that is asked for; count is a multiple of OST_FIELD_LANES.
     */
    void (*nine)(const uint16_t *in, uint16_t *out, int count, int step, bool sixteenth);
    /* Of each bit of a row OST_FIELD_ALL or nothing. */
    void (*bits)(uint64_t row, uint16_t out[OST_FIELD_LINE]);
    /* Of each bit by its density; those that are near what was cut are all bone. */
    void (*densities)(uint64_t row, uint64_t near, const int16_t density[OST_FIELD_LINE], uint16_t out[OST_FIELD_LINE]);
} ost_smooth_kernels;

ost_smooth_kernels ost_smooth_kernels_of(ost_isa isa);

#define OST_SMOOTH_DECLARE(SET)                                                                                                     \
    void ost_nine_##SET(const uint16_t *in, uint16_t *out, int count, int step, bool sixteenth);                                    \
    void ost_field_bits_##SET(uint64_t row, uint16_t out[OST_FIELD_LINE]);                                                          \
    void ost_field_densities_##SET(uint64_t row, uint64_t near, const int16_t density[OST_FIELD_LINE], uint16_t out[OST_FIELD_LINE]);
OST_SMOOTH_DECLARE(scalar)
OST_SMOOTH_DECLARE(avx2)
OST_SMOOTH_DECLARE(avx512)

#endif
