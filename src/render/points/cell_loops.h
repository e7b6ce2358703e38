/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The loops that compute cells of 2^3 voxels from voxels, in plain C. The source is compiled once for each instruction
 * set, and the compiler vectorizes it.
 */
#ifndef OST_RENDER_CELL_LOOPS_H
#define OST_RENDER_CELL_LOOPS_H

#include "render/points/smooth.h"

static inline void cell_row(const uint16_t (*restrict below)[OST_FIELD_LINE],
                            const uint16_t (*restrict above)[OST_FIELD_LINE], uint8_t *restrict out)
{
    enum { FIRST = 8 };
    uint16_t sum[OST_BLOCK];
    for (int i = 0; i < OST_BLOCK; i++)
        sum[i] = (uint16_t)(below[0][FIRST + i] + below[1][FIRST + i] + above[0][FIRST + i] + above[1][FIRST + i]);
    for (int i = 0; i < OST_CELLS; i++)
        out[i] = (uint8_t)((sum[2 * i] + sum[2 * i + 1] + 4) >> 3);
}

static inline void cell_lines(const uint8_t *restrict left, const uint8_t *restrict own, const uint8_t *restrict right,
                              int count, uint16_t (*restrict out)[OST_FIELD_LINE])
{
    enum { FIRST = 8 };
    for (int row = 0; row < count; row++) {
        for (int i = 0; i < FIRST; i++)
            out[row][i] = left[OST_CELLS * row + OST_CELLS - FIRST + i];
        for (int i = 0; i < OST_CELLS; i++)
            out[row][FIRST + i] = own[OST_CELLS * row + i];
        for (int i = 0; i < OST_CELLS; i++)
            out[row][FIRST + OST_CELLS + i] = right[OST_CELLS * row + i];
    }
}

/* Defines the loops of this file as functions for one instruction set. */
#define OST_CELLS_DEFINE(SET)                                                                                          \
    void ost_field_cells_##SET(const uint16_t(*below)[OST_FIELD_LINE], const uint16_t(*above)[OST_FIELD_LINE],         \
                               uint8_t *out)                                                                           \
    {                                                                                                                  \
        cell_row(below, above, out);                                                                                   \
    }                                                                                                                  \
    void ost_field_lines_##SET(const uint8_t *left, const uint8_t *own, const uint8_t *right, int count,               \
                               uint16_t(*out)[OST_FIELD_LINE])                                                         \
    {                                                                                                                  \
        cell_lines(left, own, right, count, out);                                                                      \
    }

#endif
