/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Smooths the edges of a picture by morphological antialiasing (Reshetov 2009). Edges are found by colour, and the
 * search along an edge is limited (Jimenez et al. 2012).
 *
 *   colours --differences of neighbours--> one bit for each side between two pixels
 *           --runs of bits, bends at both ends--> share of the neighbour in a pixel --> smooth colours
 *
 * A side is the border between two neighbouring pixels. Between two rows, an edge is a run of adjacent sides at which
 * the upper and the lower pixel differ. If the edge continues into the upper or the lower row at an end of the run, the
 * run is one step of a slanted line, and this end of the step is half a pixel away from the line:
 *
 *   . . . . . . # # #
 *   . . . . # # # # #
 *   # # # # # # # # #
 *
 * For example, the run between the lower two rows has its right end where the edge continues into the upper of these
 * rows. The line falls from half a pixel above this end to the middle of the run. Each pixel `.` that the line cuts is
 * mixed with the pixel below. The weight of the pixel below is the share of the cut pixel's area that lies below the
 * line.
 *
 * Sides between two columns are processed in the same way. All values are integers, so the result is bit-identical for
 * every instruction set and number of threads. A pixel depends only on pixels at most OST_ANTIALIAS_REACH away, in its
 * own and the adjacent rows and columns. If part of a picture changes, only this part and its surroundings are
 * recomputed.
 */
#ifndef OST_RENDER_ANTIALIAS_H
#define OST_RENDER_ANTIALIAS_H

#include "core/isa.h"
#include "render/points/cells.h"

enum {
    OST_ANTIALIAS_RUN = 15,    /* number of sides that are searched in each direction from a pixel */
    OST_ANTIALIAS_REACH = 16,
    /* minimum difference, in one colour channel, between two pixels that form an edge */
    OST_ANTIALIAS_LEAST = 24,
    /* a pixel depends only on cells that are at most this number of cell columns and cell rows away */
    OST_ANTIALIAS_CELLS_ACROSS = 1,
    OST_ANTIALIAS_CELLS_DOWN = 2,
};
_Static_assert(OST_ANTIALIAS_CELLS_ACROSS * OST_CELL_WIDTH >= OST_ANTIALIAS_REACH &&
               OST_ANTIALIAS_CELLS_DOWN * OST_CELL_HEIGHT >= OST_ANTIALIAS_REACH, "a changed pixel is in reach");

/*
 * Compares each pixel in the first `cells` cells of `row` with the pixel below it and with its right neighbour. Sets
 * bit i of below[c] or right[c] if pixel OST_CELL_WIDTH * c + i and this neighbour form an edge. Also reads the pixel
 * after the last cell.
 */
typedef void ost_antialias_find(const uint32_t *row, const uint32_t *next, int cells, uint16_t *below, uint16_t *right);
ost_antialias_find ost_antialias_find_scalar, ost_antialias_find_avx2;

/* The sides between the pixels of a picture. */
typedef struct ost_antialias {
    /* owned; one word per row of a cell; zero words precede and follow each row of the picture, and zero rows
       precede and follow the picture */
    uint16_t *below, *right;
    uint8_t share[OST_ANTIALIAS_RUN + 1][OST_ANTIALIAS_RUN + 1]; /* the results of share_of */
    int words, width, height;
    ost_antialias_find *find;
} ost_antialias;

/* Allocates memory for pictures of width x height pixels. Returns false if memory is exhausted. */
bool ost_antialias_init(ost_antialias *a, int width, int height, ost_isa isa);
void ost_antialias_free(ost_antialias *a); /* accepts zero-initialized memory */

/*
 * Finds the edges in the given cells of row `row` of cells. Rows of pixels are `stride` pixels apart; `stride` is a
 * multiple of OST_CELL_WIDTH. The function also reads the pixel that follows the last row of pixels. Different threads
 * may process different rows of cells.
 */
void ost_antialias_edges(const ost_antialias *a, const uint32_t *colour, int stride, const ost_cells *cells, int row);
/* Removes all edges in the given cells of row `row`. */
void ost_antialias_none(const ost_antialias *a, const ost_cells *cells, int row);
/*
 * Writes the smoothed colours of the given cells of row `row` to `to`. All edges in reach of these cells must have been
 * found before, from the same colours.
 */
void ost_antialias_smooth(const ost_antialias *a, const uint32_t *colour, uint32_t *to, int stride,
                          const ost_cells *cells, int row);

#endif
