/* SPDX-License-Identifier: Apache-2.0 */
#include "render/points/cells.h"

#include <stddef.h>
#include <stdlib.h>
#include <string.h>

bool ost_cells_init(ost_cells *c, int width, int height)
{
    *c = (ost_cells){.width = width, .height = height};
    c->across = (width + OST_CELL_WIDTH - 1) / OST_CELL_WIDTH;
    c->rows = (height + OST_CELL_HEIGHT - 1) / OST_CELL_HEIGHT;
    c->words = (c->across + 63) / 64;
    c->bit = calloc((size_t)c->words * (size_t)c->rows, sizeof *c->bit);
    return c->bit != NULL;
}

void ost_cells_free(ost_cells *c)
{
    free(c->bit);
    *c = (ost_cells){0};
}

void ost_cells_clear(const ost_cells *c)
{
    memset(c->bit, 0, (size_t)c->words * (size_t)c->rows * sizeof *c->bit);
}

void ost_cells_fill(const ost_cells *c)
{
    ost_cells_add(c, 0, c->width, 0, c->height);
}

void ost_cells_add(const ost_cells *c, int x0, int x1, int y0, int y1)
{
    x0 = x0 > 0 ? x0 : 0;
    y0 = y0 > 0 ? y0 : 0;
    x1 = x1 < c->width ? x1 : c->width;
    y1 = y1 < c->height ? y1 : c->height;
    if (x0 >= x1 || y0 >= y1)
        return;
    const int first = x0 / OST_CELL_WIDTH, last = (x1 - 1) / OST_CELL_WIDTH;
    for (int w = first / 64; w <= last / 64; w++) {
        const uint64_t from = w == first / 64 ? UINT64_MAX << (first % 64) : UINT64_MAX;
        const uint64_t mask = w == last / 64 ? from & UINT64_MAX >> (63 - last % 64) : from;
        for (int row = y0 / OST_CELL_HEIGHT; row <= (y1 - 1) / OST_CELL_HEIGHT; row++)
            c->bit[(size_t)row * (size_t)c->words + (size_t)w] |= mask;
    }
}

void ost_cells_join(const ost_cells *c, const ost_cells *other)
{
    for (size_t i = 0; i < (size_t)c->words * (size_t)c->rows; i++)
        c->bit[i] |= other->bit[i];
}

/* Adds the left and right neighbours of the cells in a row. */
static void grow_row(const ost_cells *c, uint64_t *row)
{
    uint64_t before = 0;
    for (int w = 0; w < c->words; w++) {
        const uint64_t was = row[w], after = w + 1 < c->words ? row[w + 1] : 0;
        row[w] = was | was << 1 | before >> 63 | was >> 1 | after << 63;
        before = was;
    }
    if (c->across % 64)
        row[c->words - 1] &= UINT64_MAX >> (64 - c->across % 64);
}

void ost_cells_grow(const ost_cells *c, int across, int down)
{
    for (int i = 0; i < across; i++)
        for (int row = 0; row < c->rows; row++)
            grow_row(c, c->bit + (ptrdiff_t)row * c->words);
    for (int i = 0; i < down; i++) {
        uint64_t above[OST_CELL_WORDS] = {0};
        for (int row = 0; row < c->rows; row++)
            for (int w = 0; w < c->words; w++) {
                uint64_t *word = c->bit + (ptrdiff_t)row * c->words + w;
                const uint64_t was = *word;
                *word |= above[w] | (row + 1 < c->rows ? word[c->words] : 0);
                above[w] = was;
            }
    }
}
