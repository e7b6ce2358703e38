/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Computes the look of a surface voxel: the direction of the surface's normal,
 * its openness and its paint.
 *
 *   bits, densities --> amount of bone in a voxel -smoothed by 9^3--------> field ------.
 *                          '--> means of 2^3 voxels --smoothed by 9^3 cells--> wide field --slopes.h--> normal,
 *   bits now, bits before, densities (uncut.h) --> paint                                               openness
 *
 * The weights of the smoothing are 1 2 3 4 5 4 3 2 1 along each axis: on a
 * plane through a voxel's upper side the field there is 0.6 of its maximum.  The
 * wide field gives the smooth surface without the steps of voxels and slices,
 * the other one the edges.  All is in integers but for the last step (slopes.h).
 */
#ifndef OST_RENDER_SHADING_H
#define OST_RENDER_SHADING_H

#include "render/points/extract.h"
#include "render/points/smooth.h"

/* The scratch for updating a block. */
typedef struct ost_shading_scratch {
    ost_row_kernels rows;
    ost_smooth_kernels smooth;
    ost_faces faces;             /* faces of the block's shown voxels */
    uint32_t stale[OST_BLOCK];   /* [z], bits y: rows whose shades have to be computed */
    uint32_t points[OST_BLOCK_POINTS + OST_POINT_SLACK], shades[OST_BLOCK_POINTS + OST_SHADING_SLACK];
    /* voxels bared by the clip plane, bared by a tool, in contact just now */
    uint32_t cap[OST_BLOCK_ROWS], bared[OST_BLOCK_ROWS], contact[OST_BLOCK_ROWS];
    ost_rim rim;
    ost_rows occupied, near, other; /* active voxels; voxels near removed ones; scratch of spread */
    uint16_t bone[OST_FIELD_BONE + 2][OST_FIELD_LINE]; /* a slice; or two slices of the block without its neighbours */
    ost_field_slice y[9], field[3];                    /* slices z at z modulo nine, or three */
    uint16_t cells[OST_CELLS + 10 + 2][OST_FIELD_LINE];  /* a slice */
    ost_field_slice cells_y[9], cells_field[3], wide[3];
} ost_shading_scratch;

/* Recomputes the block's cells near changes. Must be called for all blocks before the first is dressed. */
void ost_surface_measure(const ost_surface *surface, ost_surface_block *block, ost_shading_scratch *scratch);

/* Computes the shades of all points in stale rows. The scratch must hold the block's faces; the
   shades are written to it. */
ost_status ost_surface_shade(ost_surface *surface, ost_surface_block *block, const uint32_t *points,
                             ost_shading_scratch *scratch, ost_error *err);
/* Computes the scratch's cap and contact for all rows of the block. */
void ost_surface_find_marked(const ost_surface *surface, const ost_surface_block *block, ost_shading_scratch *scratch);

#endif
