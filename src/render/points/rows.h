/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Processes rows of bits of a block and of its neighbours, from which lists (extract.c) and shades
 * (shading.c) are computed. All rows are integers, one word per row.
 *
 *   words of a block, of six neighbours --faces--> six words for each row: faces to the air
 *                                       --points--> surface points
 *   words of 27 blocks --join--> rows of 64 voxels --spread--> voxels near one of them
 */
#ifndef OST_RENDER_ROWS_H
#define OST_RENDER_ROWS_H

#include "core/isa.h"
#include "render/points/surface.h"

enum {
    OST_SEEN = OST_BLOCK + 2 * OST_SHADING_REACH, /* number of rows and slices on which a shade may depend */
    OST_RIM = OST_BLOCK + 2,
    OST_POINT_SLACK = 16,                      /* number of words after the last point that may be overwritten */
};

/* Rows indexed by [z][y], both counted from -OST_SHADING_REACH. The bits of a word are x = -16 .. 47. */
typedef struct ost_rows {
    uint64_t row[OST_SEEN][OST_SEEN];
} ost_rows;

/* A block's words with a margin of one row, [z + 1][y + 1], and the words of the two neighbours along x. */
typedef struct ost_rim {
    uint32_t row[OST_RIM][OST_RIM];
    const uint32_t *left, *right;
} ost_rim;

typedef struct ost_faces {
    uint32_t face[6][OST_BLOCK_ROWS]; /* indexed by ost_face: voxels with air at this face */
    uint32_t any[OST_BLOCK_ROWS];
    uint16_t begin[OST_BLOCK_ROWS + 1]; /* index of each row's first point */
} ost_faces;

typedef struct ost_row_kernels {
    /* Computes out[i] from bits 16 .. 31 of left[i], all of own[i], and bits 0 .. 15 of right[i]. */
    void (*join)(const uint32_t *left, const uint32_t *own, const uint32_t *right, uint64_t *out, int count);
    /*
     * Sets all voxels that are at most `reach` away, along each axis, from a set voxel. Afterwards
     * the outer `reach` rows, slices and bits are undefined.
     */
    void (*spread)(ost_rows *rows, ost_rows *other, int reach);
    void (*faces)(const ost_rim *rim, ost_faces *out);
    /* Finds, in each row, the voxels that have a face to the air and behind that face a set bit of the rim. */
    void (*behind)(const ost_rim *rim, const ost_faces *faces, uint32_t out[OST_BLOCK_ROWS]);
    /* Writes faces->begin[OST_BLOCK_ROWS] points, in ascending order of rows. */
    void (*points)(const ost_faces *faces, uint32_t *points);
} ost_row_kernels;

ost_row_kernels ost_row_kernels_of(ost_isa isa);

#define OST_ROWS_DECLARE(SET)                                                                                          \
    void ost_rows_join_##SET(const uint32_t *left, const uint32_t *own, const uint32_t *right, uint64_t *out,          \
                             int count);                                                                               \
    void ost_rows_spread_##SET(ost_rows *rows, ost_rows *other, int reach);                                            \
    void ost_rows_faces_##SET(const ost_rim *rim, ost_faces *out);                                                     \
    void ost_rows_behind_##SET(const ost_rim *rim, const ost_faces *faces, uint32_t out[OST_BLOCK_ROWS]);              \
    void ost_rows_points_##SET(const ost_faces *faces, uint32_t *points);
OST_ROWS_DECLARE(scalar)
OST_ROWS_DECLARE(avx2)
OST_ROWS_DECLARE(avx512)

#endif
