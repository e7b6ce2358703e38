/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Smooths the edges of a picture: morphological antialiasing (Reshetov 2009), with edges found by colour and a limited
 * search along an edge (Jimenez et al. 2012).
 *
 *   colours --differences of neighbours--> one bit for each side between two pixels
 *           --runs of bits, bends at both ends--> share of the neighbour in a pixel --> smooth colours
 *
 * Between two rows, an edge is a run of sides in which the upper and the lower pixel differ. At an end where the edge
 * goes on in the upper or lower row, the drawn stair is half a pixel away from the line that it approximates:
 *
 *   . . . . . . # # #          `line`: from half a pixel above the run's left end to its middle. The pixels # that the
 *   . . . . # # # # #          line cuts get the share of the colour below that lies below the line.
 *   # # # # # # # # #
 *
 * The same is done for the sides between two columns. All values are integers, and a pixel depends only on the pixels
 * within OST_ANTIALIAS_REACH of it in its row and column and in the neighbouring ones. The result is therefore
 * bit-identical for every instruction set and number of threads, and if a part of a picture changes, only this part and
 * its surroundings must be computed again.
 */
#ifndef OST_RENDER_ANTIALIAS_H
#define OST_RENDER_ANTIALIAS_H

#include "core/isa.h"
#include "render/points/cells.h"

enum {
    OST_ANTIALIAS_RUN = 15,    /* sides that are searched on either side of a pixel */
    OST_ANTIALIAS_REACH = 16,
    OST_ANTIALIAS_LEAST = 24,  /* difference of two pixels in one channel that makes an edge */
    /* cells around a changed cell that may depend on it */
    OST_ANTIALIAS_CELLS_ACROSS = 1,
    OST_ANTIALIAS_CELLS_DOWN = 2,
};
_Static_assert(OST_ANTIALIAS_CELLS_ACROSS * OST_CELL_WIDTH >= OST_ANTIALIAS_REACH &&
               OST_ANTIALIAS_CELLS_DOWN * OST_CELL_HEIGHT >= OST_ANTIALIAS_REACH, "a changed pixel is in reach");

/*
 * Compares the pixels of `row` with those of the next row and with their right neighbours, for `cells` cells. Bit i of
 * below[c] and right[c] is set if pixel OST_CELL_WIDTH * c + i differs in one of the three channels. One more pixel of
 * `row` is read.
 */
typedef void ost_antialias_find(const uint32_t *row, const uint32_t *next, int cells, uint16_t *below, uint16_t *right);
ost_antialias_find ost_antialias_find_scalar, ost_antialias_find_avx2;

/* The sides between the pixels of a picture. */
typedef struct ost_antialias {
    /* owned; one word for each row of a cell, with a word of zeros before and after each row, and such rows before and
       after the picture */
    uint16_t *below, *right;
    uint8_t share[OST_ANTIALIAS_RUN + 1][OST_ANTIALIAS_RUN + 1]; /* see share_of */
    int words, width, height;
    ost_antialias_find *find;
} ost_antialias;

/* Allocates memory for pictures of a size. Returns false if memory is exhausted. */
bool ost_antialias_init(ost_antialias *a, int width, int height, ost_isa isa);
void ost_antialias_free(ost_antialias *a); /* accepts zero-initialized memory */

/*
 * Finds the edges in the cells of a row of cells. Rows of colours begin at multiples of `stride`, which is a multiple
 * of OST_CELL_WIDTH; one pixel after the last row is read. Rows of cells may be processed by different threads.
 */
void ost_antialias_edges(const ost_antialias *a, const uint32_t *colour, int stride, const ost_cells *cells, int row);
/* Sets the cells of a row of cells to have no edges. */
void ost_antialias_none(const ost_antialias *a, const ost_cells *cells, int row);
/*
 * Writes the colours of the cells of a row of cells to `to`. The edges in reach of these cells must have been found
 * for the same colours.
 */
void ost_antialias_smooth(const ost_antialias *a, const uint32_t *colour, uint32_t *to, int stride,
                          const ost_cells *cells, int row);

#endif
