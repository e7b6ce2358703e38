/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A set of cells of a picture, with one bit for each cell of 16 x 8 pixels.
 *
 * Such sets describe the pixels to be redrawn, the pixels to be restored and the pixels that a
 * layer may cover. A set is processed run by run, where a run is a sequence of consecutive cells in
 * a row.
 */
#ifndef OST_RENDER_CELLS_H
#define OST_RENDER_CELLS_H

#include <stdbool.h>
#include <stdint.h>

#include "core/bits_run.h"

/* OST_CELL_WORDS is the maximum number of words per row, sufficient for 8192 pixels. */
enum { OST_CELL_WIDTH = 16, OST_CELL_HEIGHT = 8, OST_CELL_WORDS = 8 };

typedef struct ost_cells {
    uint64_t *bit; /* owned; bits of the cells; `words` words for each row of cells */
    int words, across, rows;
    int width, height; /* size of the picture in pixels */
} ost_cells;

/* Creates an empty set for a picture of up to 8192 x 8192 pixels. Returns false if memory is exhausted. */
bool ost_cells_init(ost_cells *cells, int width, int height);
/* Frees the memory. Accepts a zero-initialized set. */
void ost_cells_free(ost_cells *cells);

void ost_cells_clear(const ost_cells *cells);
void ost_cells_fill(const ost_cells *cells);
/* Adds all cells that contain a pixel with x0 <= x < x1 and y0 <= y < y1. Pixels outside the picture are ignored. */
void ost_cells_add(const ost_cells *cells, int x0, int x1, int y0, int y1);
/* Adds the cells of another set, which must be for a picture of the same size. */
void ost_cells_join(const ost_cells *cells, const ost_cells *other);
/* Extends the set on every side, by `across` columns and `down` rows of cells. */
void ost_cells_grow(const ost_cells *cells, int across, int down);

static inline const uint64_t *ost_cells_row(const ost_cells *cells, int row)
{
    return cells->bit + (int64_t)row * cells->words;
}

/*
 * Finds the next run of cells in a row, and sets *from and *to to its half-open range. Returns false if there is none.
 * On entry, *to must be 0 or the end of the previous run.
 */
static inline bool ost_cells_run(const ost_cells *cells, int row, int *from, int *to)
{
    return ost_bits_run(ost_cells_row(cells, row), cells->words, from, to);
}

/* A rectangle of pixels with x0 <= x < x1 and y0 <= y < y1. */
typedef struct ost_cells_box {
    int x0, x1, y0, y1;
} ost_cells_box;

/* Returns the rectangle of the cells from <= c < to of a row, clipped to the picture. */
static inline ost_cells_box ost_cells_box_of(const ost_cells *cells, int row, int from, int to)
{
    ost_cells_box b = {from * OST_CELL_WIDTH, to * OST_CELL_WIDTH, row * OST_CELL_HEIGHT, (row + 1) * OST_CELL_HEIGHT};
    b.x1 = b.x1 < cells->width ? b.x1 : cells->width;
    b.y1 = b.y1 < cells->height ? b.y1 : cells->height;
    return b;
}

/* Returns true if the set contains the cell of the pixel (x, y). The pixel must be in the picture. */
static inline bool ost_cells_has(const ost_cells *cells, int x, int y)
{
    const int column = x / OST_CELL_WIDTH;
    return ost_cells_row(cells, y / OST_CELL_HEIGHT)[column / 64] >> (column % 64) & 1;
}

static inline void ost_cells_dot(const ost_cells *cells, int x, int y)
{
    const int column = x / OST_CELL_WIDTH;
    cells->bit[(int64_t)(y / OST_CELL_HEIGHT) * cells->words + column / 64] |= UINT64_C(1) << (column % 64);
}

#endif
