/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Processes rows of voxels of a block and its neighbours, one bit per voxel and one integer per row. Lists (extract.c)
 * and shades (shading.c) are computed from the results.
 *
 *   words of a block, of six neighbours --faces--> six words for each row: exposed faces
 *                                       --points--> surface points
 *   words of 27 blocks --join--> rows of 64 voxels --spread--> voxels near a set voxel
 */
#ifndef OST_RENDER_ROWS_H
#define OST_RENDER_ROWS_H

#include "core/isa.h"
#include "render/points/surface.h"

enum {
    /* number of rows along y, and of slices along z, on which the shades of a block may depend */
    OST_SEEN = OST_BLOCK + 2 * OST_SHADING_REACH,
    OST_RIM = OST_BLOCK + 2,
    /* number of words that a kernel may overwrite after the last point */
    OST_POINT_SLACK = 16,
};

/* Rows of voxels, one word per row, indexed by [z][y] with both indices counted from -OST_SHADING_REACH. The bits of
   a word are the voxels x = -16 .. 47. */
typedef struct ost_rows {
    uint64_t row[OST_SEEN][OST_SEEN];
} ost_rows;

/* The words of a block and of one row on each side of it, indexed by [z + 1][y + 1]. `left` and `right` are the
   words of the two neighbours along x. */
typedef struct ost_rim {
    uint32_t row[OST_RIM][OST_RIM];
    const uint32_t *left, *right;
} ost_rim;

typedef struct ost_faces {
    /* face[f]: one bit per voxel, 1 if its face f (ost_face) is exposed */
    uint32_t face[6][OST_BLOCK_ROWS];
    uint32_t any[OST_BLOCK_ROWS];
    uint16_t begin[OST_BLOCK_ROWS + 1]; /* index of each row's first point */
} ost_faces;

typedef struct ost_row_kernels {
    /* Computes out[i]: bits 16 .. 31 of left[i], then all bits of own[i], then bits 0 .. 15 of right[i]. */
    void (*join)(const uint32_t *left, const uint32_t *own, const uint32_t *right, uint64_t *out, int count);
    /* Sets all voxels that are at most `reach` voxels away, along each axis, from a set voxel. Uses `other` as scratch.
       Afterwards, the outermost `reach` rows, slices and bits are undefined. */
    void (*spread)(ost_rows *rows, ost_rows *other, int reach);
    void (*faces)(const ost_rim *rim, ost_faces *out);
    /* For each row, finds the voxels that have an exposed face at which the neighbour is set in `rim`. */
    void (*behind)(const ost_rim *rim, const ost_faces *faces, uint32_t out[OST_BLOCK_ROWS]);
    /* Writes the points in ascending order of rows. There are faces->begin[OST_BLOCK_ROWS] points. */
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
