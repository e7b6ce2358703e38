/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Computes the appearance of a surface voxel: the direction of the surface normal, the openness and the paint.
 *
 *   bits, densities --> amount of bone in a voxel -smoothed by 9^3--------> field ------.
 *                          '--> means of 2^3 voxels --smoothed by 9^3 cells--> wide field --slopes.h--> normal,
 *   bits now, bits before, densities (uncut.h) --> paint                                               openness
 *
 * The weights of the smoothing are 1 2 3 4 5 4 3 2 1 along each axis, so the field at a surface voxel of a plane has
 * 0.6 of its maximum value. The wide field yields the smooth surface, without the steps of voxels and slices; the fine
 * field yields the edges. All computations use integers, except for the last step (slopes.h).
 */
#ifndef OST_RENDER_SHADING_H
#define OST_RENDER_SHADING_H

#include "render/points/extract.h"
#include "render/points/smooth.h"

/* The scratch for updating a block. */
typedef struct ost_shading_scratch {
    ost_row_kernels rows;
    ost_smooth_kernels smooth;
    ost_faces faces;             /* exposed faces of the block's shown voxels */
    uint32_t stale[OST_BLOCK];   /* rows whose shades must be computed; row (y, z) is bit y of stale[z] */
    uint32_t points[OST_BLOCK_POINTS + OST_POINT_SLACK], shades[OST_BLOCK_POINTS + OST_SHADING_SLACK];
    /* sets of voxels. cap: exposed by the clip plane; bared: exposed by a tool; contact: next to a voxel that was just
       removed */
    uint32_t cap[OST_BLOCK_ROWS], bared[OST_BLOCK_ROWS], contact[OST_BLOCK_ROWS];
    ost_rim rim;
    /* occupied: active voxels; near: voxels near removed voxels; other: scratch */
    ost_rows occupied, near, other;
    /* scratch for the amounts of bone in one slice, including the voxels of neighbouring blocks */
    uint16_t bone[OST_FIELD_BONE + 2][OST_FIELD_LINE];
    /* ring buffers of slices: slice z is stored in y[z % 9] and field[z % 3] */
    ost_field_slice y[9], field[3];
    uint16_t cells[OST_CELLS + 10 + 2][OST_FIELD_LINE];  /* a slice */
    ost_field_slice cells_y[9], cells_field[3], wide[3];
} ost_shading_scratch;

/* Recomputes the block's cells near changed voxels. Must be called for all blocks before the first one is shaded. */
void ost_surface_measure(const ost_surface *surface, ost_surface_block *block, ost_shading_scratch *scratch);

/* Computes the shades of all points in stale rows, and stores them in the scratch. The scratch must already contain the
   faces of the block. */
ost_status ost_surface_shade(ost_surface *surface, ost_surface_block *block, const uint32_t *points,
                             ost_shading_scratch *scratch, ost_error *err);
/* Computes scratch->cap and scratch->contact for all rows of the block. */
void ost_surface_find_marked(const ost_surface *surface, const ost_surface_block *block, ost_shading_scratch *scratch);

#endif
