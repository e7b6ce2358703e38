/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What removal needs to know about a tool's solid (its voxels of one class),
 * derived once from the voxels for a range of bone voxel sizes.
 *
 *   cells     how far is it from here to the surface, at least?
 *             decides whole cubes of bone voxels: inside, outside, mixed
 *   windows   8^3 tool voxels as 64 bytes, one at every third voxel of each axis:
 *             decides the 64 voxels of a mixed brick by one look-up each
 *
 * Cells.  Space is cut into granules of 2^g tool voxels; a granule is void,
 * solid or of both kinds (outside the tool's grid all is void), and a cell is
 * a cube of 1 or 2 granules.  A cell of one kind has value +v (solid) or -v
 * (void), else 0:
 *
 *   (C1)  every point nearer than v / 8 granules to some point of the cell is
 *         of the cell's kind
 *
 * as v = floor(8 * least distance between the cell and a granule that is not
 * wholly of its kind), and v <= 8 OST_CELL_REACH.  The table goes so far beyond the
 * tool's grid that its outermost cells are void and have the greatest v.  For a point beyond the
 * table the cell nearest to it may be asked: going there is a projection onto
 * a convex box that holds the tool, so it brings the point no farther from
 * any part of the tool, and (C1) holds with the cell's v all the more.
 *
 * Windows.  Window (i, j, k) begins at voxel step * (i, j, k) - OST_WINDOW_MARGIN.
 * The byte of its row (y, z) is number 8 y + z, the bit of voxel x is bit x.
 * The 9 - step voxels from any voxel on lie within one window.  Windows of
 * void (line 0) and of solid (line 1) are kept once.  The coarsest step that
 * holds every brick of bone voxels is taken: 3 up to 0.962 tool voxels a bone
 * voxel, 2 up to 1.154, 1 up to 1.347, beyond there are none (remove.h).
 */
#ifndef OST_CPU_SHAPE_H
#define OST_CPU_SHAPE_H

#include <stddef.h>
#include <stdint.h>

#include <osteon/event.h>

enum {
    OST_CELL_REACH = 8, /* granules */
    OST_WINDOW_MARGIN = 12,
};

typedef struct ost_cells {
    const int8_t *value; /* x fastest; 64 bytes before it and behind the last one may be read */
    int32_t dims[3];
    int32_t margin; /* cells before the tool's voxel (0, 0, 0), on every axis */
    int32_t shift;  /* log2 of a cell's edge in units of 2^-20 tool voxels */
    int32_t unit;   /* an eighth of a granule in the same units */
} ost_cells;

typedef struct ost_windows {
    const uint32_t *index; /* line of each window, x fastest */
    const uint8_t (*line)[64]; /* 64-byte aligned */
    int32_t dims[3];
    int32_t step; /* 3, 2, 1; 0 when there are none */
} ost_windows;

typedef struct ost_shape {
    ost_cells cells;
    ost_windows windows;
    const uint8_t *voxels; /* the tool's; one byte each, x fastest */
    int32_t dims[3];
    uint8_t kind; /* the class that is solid here */
    void *memory[3]; /* owned */
} ost_shape;

/*
 * ratio: a bone voxel in tool voxels, times 2^20, rounded up; at most
 * OST_MAP_RATIO_MAX * 2^20 + 2.  Sets *out wholly, also on failure (free is then safe).
 */
ost_status ost_shape_make(const uint8_t *voxels, ost_dims dims, uint8_t kind, int32_t ratio, ost_shape *out, ost_error *err);
void ost_shape_free(ost_shape *shape);
/* Whether a shape made for one ratio serves another: the same cells come out. */
bool ost_shape_serves(const ost_shape *shape, int32_t ratio);

#endif
