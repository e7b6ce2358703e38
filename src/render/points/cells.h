/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A part of a picture, as a bit for each cell of 16 x 8 pixels.
 *
 * Such parts describe the pixels to be drawn again, the pixels to be restored
 * and the pixels that a layer may cover.  They are processed run by run.
 */
#ifndef OST_RENDER_CELLS_H
#define OST_RENDER_CELLS_H

#include <stdbool.h>
#include <stdint.h>

enum { OST_CELL_WIDTH = 16, OST_CELL_HEIGHT = 8, OST_CELL_WORDS = 8 }; /* words: the most of a row, for 8192 pixels */

typedef struct ost_cells {
    uint64_t *bit; /* owned; `words` for each row of cells */
    int words, across, rows;
    int width, height; /* of the picture */
} ost_cells;

/* Makes an empty part of a picture of up to 8192 pixels a side. Returns false if there is no memory. */
bool ost_cells_init(ost_cells *cells, int width, int height);
/* Frees the memory; zeroed cells are valid. */
void ost_cells_free(ost_cells *cells);

void ost_cells_clear(const ost_cells *cells);
void ost_cells_fill(const ost_cells *cells);
/* Adds all cells with a pixel x0 <= x < x1, y0 <= y < y1; pixels outside the picture are ignored. */
void ost_cells_add(const ost_cells *cells, int x0, int x1, int y0, int y1);
/* Adds the cells of another part of a picture of the same size. */
void ost_cells_join(const ost_cells *cells, const ost_cells *other);

static inline const uint64_t *ost_cells_row(const ost_cells *cells, int row)
{
    return cells->bit + (int64_t)row * cells->words;
}

/* Returns true if the part contains the pixel (x, y), which must be in the picture. */
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
