/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The loops of rows.h over complete rows, in plain C. The source is compiled once for each instruction set, and the
 * compiler vectorizes it over rows.
 */
#ifndef OST_RENDER_ROW_LOOPS_H
#define OST_RENDER_ROW_LOOPS_H

#include "render/points/rows.h"

static inline void join_rows(const uint32_t *restrict left, const uint32_t *restrict own,
                             const uint32_t *restrict right, uint64_t *restrict out, int count)
{
    for (int i = 0; i < count; i++)
        out[i] = left[i] >> 16 | (uint64_t)own[i] << 16 | (uint64_t)right[i] << 48;
}

/*
 * Returns the next shift when bits are spread to the distance `reach` in steps. In each step, a word is combined by OR
 * with shifted copies of itself. The bits are already spread to the distance `covered`, so a shift by at most 2 covered
 * + 1 leaves no gap between the copies.
 */
static inline int next_step(int covered, int reach)
{
    const int most = 2 * covered + 1;
    return reach - covered < most ? reach - covered : most;
}

static inline void spread_slice(const uint64_t *restrict in, uint64_t *restrict out, int reach)
{
    uint64_t a[OST_SEEN], b[OST_SEEN];
    for (int y = 0; y < OST_SEEN; y++)
        a[y] = in[y];
    for (int c = 0, step; c < reach; c += step) {
        step = next_step(c, reach);
        for (int y = 0; y < OST_SEEN; y++)
            a[y] |= a[y] << step | a[y] >> step;
    }
    for (int c = 0, step; c < reach; c += step) {
        step = next_step(c, reach);
        for (int y = 0; y < OST_SEEN; y++)
            b[y] = a[y];
        for (int y = step; y < OST_SEEN - step; y++)
            a[y] = b[y] | b[y - step] | b[y + step];
    }
    for (int y = 0; y < OST_SEEN; y++)
        out[y] = a[y];
}

static inline void spread_rows(ost_rows *restrict rows, ost_rows *restrict other, int reach)
{
    int steps = 0;
    for (int c = 0; c < reach; c += next_step(c, reach))
        steps++;
    ost_rows *from = steps % 2 ? other : rows, *to = steps % 2 ? rows : other;
    for (int z = 0; z < OST_SEEN; z++) {
        uint64_t slice[OST_SEEN];
        spread_slice(rows->row[z], slice, reach);
        for (int y = 0; y < OST_SEEN; y++)
            from->row[z][y] = slice[y];
    }
    for (int c = 0, step; c < reach; c += step) {
        step = next_step(c, reach);
        for (int z = c + step; z < OST_SEEN - c - step; z++) {
            const uint64_t *restrict before = from->row[z - step], *restrict at = from->row[z],
                                     *restrict behind = from->row[z + step];
            uint64_t *restrict out = to->row[z];
            for (int y = 0; y < OST_SEEN; y++)
                out[y] = at[y] | before[y] | behind[y];
        }
        ost_rows *swap = from;
        from = to;
        to = swap;
    }
}

/* Sets each out[f] to those voxels of a row whose neighbours at face f are set. */
static inline void behind_row(const ost_rim *rim, int y, int z, uint32_t out[6])
{
    const int row = y + OST_BLOCK * z;
    ost_visible_behind(rim->row[z + 1][y + 1], rim->left[row], rim->right[row], rim->row[z + 1][y],
                       rim->row[z + 1][y + 2], rim->row[z][y + 1], rim->row[z + 2][y + 1], out);
}

static inline void faces_of_rows(const ost_rim *restrict rim, ost_faces *restrict out)
{
    for (int z = 0; z < OST_BLOCK; z++)
        for (int y = 0; y < OST_BLOCK; y++) {
            const uint32_t own = rim->row[z + 1][y + 1];
            const int row = y + OST_BLOCK * z;
            uint32_t behind[6], any = 0;
            behind_row(rim, y, z, behind);
            for (int f = 0; f < 6; f++)
                any |= out->face[f][row] = own & ~behind[f];
            out->any[row] = any;
        }
    uint32_t count = 0;
    for (int row = 0; row < OST_BLOCK_ROWS; row++) {
        out->begin[row] = (uint16_t)count;
        count += (uint32_t)__builtin_popcount(out->any[row]);
    }
    out->begin[OST_BLOCK_ROWS] = (uint16_t)count;
}

static inline void behind_rows(const ost_rim *restrict rim, const ost_faces *restrict faces, uint32_t *restrict out)
{
    for (int z = 0; z < OST_BLOCK; z++)
        for (int y = 0; y < OST_BLOCK; y++) {
            const int row = y + OST_BLOCK * z;
            uint32_t behind[6], any = 0;
            behind_row(rim, y, z, behind);
            for (int f = 0; f < 6; f++)
                any |= faces->face[f][row] & behind[f];
            out[row] = any;
        }
}

/* Defines the loops of this file as functions for one instruction set. */
#define OST_ROWS_DEFINE(SET)                                                                                           \
    void ost_rows_join_##SET(const uint32_t *left, const uint32_t *own, const uint32_t *right, uint64_t *out,          \
                             int count)                                                                                \
    {                                                                                                                  \
        join_rows(left, own, right, out, count);                                                                       \
    }                                                                                                                  \
    void ost_rows_spread_##SET(ost_rows *rows, ost_rows *other, int reach)                                             \
    {                                                                                                                  \
        spread_rows(rows, other, reach);                                                                               \
    }                                                                                                                  \
    void ost_rows_faces_##SET(const ost_rim *rim, ost_faces *out)                                                      \
    {                                                                                                                  \
        faces_of_rows(rim, out);                                                                                       \
    }                                                                                                                  \
    void ost_rows_behind_##SET(const ost_rim *rim, const ost_faces *faces, uint32_t out[OST_BLOCK_ROWS])               \
    {                                                                                                                  \
        behind_rows(rim, faces, out);                                                                                  \
    }

#endif
