/* SPDX-License-Identifier: Apache-2.0 */
/*
 * How a surface voxel looks: which way its surface faces, how open it lies,
 * what it is painted with.
 *
 *   bits, densities --> how much bone a voxel is --smoothed by 9^3--------> field ------.
 *                          '--> means of 2^3 voxels --smoothed by 9^3 cells--> wide field --slopes.h--> normal,
 *   bits now, bits before, densities (ground.h) --> paint                                               openness
 *
 * The weights of the smoothing are 1 2 3 4 5 4 3 2 1 along each axis: on a
 * plane through a voxel's upper side the field there is 0.6 of all.  The wide
 * field sees what is smooth under the steps of voxels and slices, the other one
 * where an edge is.  Integers all the way, but for the last step (slopes.h).
 */
#ifndef OST_RENDER_DRESS_H
#define OST_RENDER_DRESS_H

#include "render/points/extract.h"
#include "render/points/smooth.h"

/* What a block is made anew with. */
typedef struct ost_dress_scratch {
    ost_row_kernels rows;
    ost_smooth_kernels smooth;
    ost_faces faces;             /* of the block's voxels that are shown */
    uint32_t stale[OST_BLOCK];   /* [z], bits y: rows whose looks are to be made */
    uint32_t points[OST_BLOCK_POINTS + OST_POINT_ROOM], looks[OST_BLOCK_POINTS + OST_LOOKS_ROOM];
    uint32_t cap[OST_BLOCK_ROWS], bared[OST_BLOCK_ROWS], contact[OST_BLOCK_ROWS]; /* voxels that are painted for it */
    ost_rim rim;
    ost_rows whole, near, other; /* what is there; what is near to what went */
    uint16_t bone[OST_FIELD_BONE + 2][OST_FIELD_LINE]; /* a slice; or two, of a block alone */
    ost_field_slice y[9], field[3];                    /* slices z at z modulo nine, or three */
    uint16_t cells[OST_CELLS + 10 + 2][OST_FIELD_LINE];  /* a slice */
    ost_field_slice cells_y[9], cells_field[3], wide[3];
} ost_dress_scratch;

/* Makes the block's cells anew where it changed, or what went is near. Before any block is dressed. */
void ost_surface_measure(const ost_surface *surface, ost_surface_block *block, ost_dress_scratch *scratch);

/* Of a block whose faces and points the scratch has: the looks of all points in stale rows. */
ost_status ost_surface_dress(ost_surface *surface, ost_surface_block *block, const uint32_t *points, ost_dress_scratch *scratch, ost_error *err);
/* Makes the scratch's cap and contact, of all the block's rows. */
void ost_surface_find_marked(const ost_surface *surface, const ost_surface_block *block, ost_dress_scratch *scratch);

#endif
