/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The shape of a tool consists of tables that removal uses. They describe the voxels of one class of the tool,
 * which this file calls solid. The tables are derived once from the tool's voxels, for a range of bone voxel sizes.
 *
 *   cells     lower bounds on the distance to the solid's surface,
 *             which classify cubes of bone voxels as inside, outside or mixed
 *   windows   8^3 tool voxels as 64 bytes; adjacent windows overlap, so that each mixed brick lies in one;
 *             a window classifies the 64 voxels of a mixed brick by one look-up each
 *
 * Cells.  Space is divided into granules of 2^g tool voxels per side.  A granule is empty, solid or
 * mixed; all space outside the tool's grid is empty.  A cell is a cube of 1 or 2 granules per side.
 * A solid cell has the value +v, an empty cell has the value -v, and a mixed cell has the value 0:
 *
 *   (C1)  every point nearer than v / 8 granules to some point of the cell is
 *         solid or empty, like the cell
 *
 * where v = floor(8 * least distance between the cell and a granule that differs from the cell),
 * and v <= 8 OST_CELL_REACH.  The table extends far enough beyond the tool's grid that its outermost
 * cells are empty and have the greatest v.  For a point outside the table, the nearest cell may be used. Moving the
 * point to this cell projects it onto a convex box that contains the tool. The projection does not increase the
 * distance to any part of the tool. Therefore (C1) with the cell's v is true for the original point too.
 *
 * Windows.  Window (i, j, k) begins at voxel step * (i, j, k) - OST_WINDOW_MARGIN.
 * Row (y, z) of a window is byte number 8 y + z, and voxel x of the row is bit x of this byte.  On
 * each axis, any 9 - step adjacent voxels lie in one window.  The 64 bytes of a window are a line;
 * all empty windows share line 0, and all windows that are entirely solid share line 1.  The step
 * is the coarsest for which every brick of bone voxels lies in one window.  It is 3 for bone voxels
 * of up to 0.962 tool voxels per side, 2 up to 1.154 and 1 up to 1.347.  For larger bone voxels
 * there are no windows (remove.h).
 *
 * Wide windows.  For bone voxels of 1.347 to 2.886 tool voxels, there are windows of 16^3 tool voxels with a margin of
 * OST_WIDE_MARGIN instead. A wide window has eight lines, that is, 512 bytes. The voxels x < 8 of row (y, z) are byte
 * 16 y + z, and the other voxels of this row are byte 256 + 16 y + z. Any 17 - step adjacent voxels lie in one wide
 * window; the step is 6 up to 1.924 tool voxels per bone voxel, 3 up to 2.501, 2 up to 2.694 and 1 up to 2.886. Only
 * the kernel for AVX-512 VBMI reads wide windows.
 */
#ifndef OST_CPU_SHAPE_H
#define OST_CPU_SHAPE_H

#include <stddef.h>
#include <stdint.h>

#include <osteon/event.h>

enum {
    OST_CELL_REACH = 8, /* granules */
    OST_WINDOW_MARGIN = 12,
    OST_WIDE_MARGIN = 24,
    OST_WIDE_LINES = 8, /* number of 64-byte lines per wide window */
};

typedef struct ost_cells {
    /* value of each cell, x fastest; 64 bytes before the first value and after the last value may be read */
    const int8_t *value;
    int32_t dims[3];
    int32_t margin; /* number of cells that precede the tool's voxel (0, 0, 0) on each axis */
    int32_t shift;  /* log2 of the edge length of a cell, in units of 2^-20 tool voxels */
    int32_t unit;   /* one eighth of the edge length of a granule, in units of 2^-20 tool voxels */
} ost_cells;

typedef struct ost_windows {
    const uint32_t *index; /* for each window, the index of its first line in line[]; windows are ordered x fastest */
    const uint8_t (*line)[64]; /* 64-byte aligned */
    int32_t dims[3];
    int32_t step; /* distance between adjacent windows in tool voxels: 6, 3, 2 or 1; 0 if there are no windows */
} ost_windows;

typedef struct ost_shape {
    ost_cells cells;
    ost_windows windows, wide; /* windows of 8^3 and of 16^3 tool voxels; at most one of the two is filled */
    const uint64_t *bits; /* one bit per tool voxel, 1 if the voxel is solid; x fastest; not owned */
    size_t words;         /* number of words per row of `bits`; the bits after a row's last voxel are 0 */
    int32_t dims[3];
    void *memory[3]; /* owned */
} ost_shape;

/*
 * Computes the tables for the solid voxels in `bits`, which must remain valid until the shape is freed. A row has
 * `words` words. `ratio` is the edge of a bone voxel in tool voxels, times 2^20, rounded up. It is at most
 * OST_MAP_RATIO_MAX * 2^20 + 2. All of *out is initialised even if the function fails, and the caller must call
 * ost_shape_free in either case.
 */
ost_status ost_shape_make(const uint64_t *bits, size_t words, ost_dims dims, int32_t ratio, ost_shape *out,
                          ost_error *err);
void ost_shape_free(ost_shape *shape);
/* Returns true if the tables of *shape are also valid for this ratio of bone voxels to tool voxels. */
bool ost_shape_covers_ratio(const ost_shape *shape, int32_t ratio);

#endif
