/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Draws a band of a frame: skips hidden blocks, draws the other blocks into planes, and merges the planes of the
 * layers.
 */
#include "core/bits_run.h"
#include "core/conditions.h"
#include "render/points/frame_parts.h"

#include <string.h>

/* The band of rows y0 <= y < y1, and the scratch of the thread that draws it. */
typedef struct band {
    int y0, y1;
    ost_frame_bench *bench;
} band;

/* The half-open range of tiles that a block may cover in a band. Tile rows are counted from the top of the band. */
typedef struct tile_range {
    int x0, x1, y0, y1;
} tile_range;

static tile_range tiles_of(const ost_frame_block *b, const band *at)
{
    const ost_extent *e = &b->pixels;
    const int top = e->y0 > at->y0 ? e->y0 : at->y0, end = e->y1 < at->y1 ? e->y1 : at->y1;
    return (tile_range){e->x0 / OST_TILE, (e->x1 + OST_TILE - 1) / OST_TILE, (top - at->y0) / OST_TILE,
                        (end - at->y0 + OST_TILE - 1) / OST_TILE};
}

/* Returns true if all tiles of the range are completely covered by voxels nearer than `key`. */
static bool hidden(const ost_frame *f, const band *at, const ost_planes *planes, tile_range r, uint64_t key)
{
    for (int y = r.y0; y < r.y1; y++)
        for (int x = r.x0; x < r.x1; x++) {
            ost_frame_tile *t = &at->bench->tiles[y * f->tiles_across + x];
            const int top = at->y0 + y * OST_TILE, rows = at->y1 - top < OST_TILE ? at->y1 - top : OST_TILE;
            if (t->farthest < key)
                continue;
            if (!t->stale)
                return false;
            *t = (ost_frame_tile){f->kernels.farthest(planes, x * OST_TILE, top, rows), false};
            if (t->farthest >= key)
                return false;
        }
    return true;
}

static void drawn(const ost_frame *f, const band *at, tile_range r)
{
    for (int y = r.y0; y < r.y1; y++)
        for (int x = r.x0; x < r.x1; x++) {
            ost_frame_tile *t = &at->bench->tiles[y * f->tiles_across + x];
            t->stale = t->farthest > 0;
        }
}

/* One row of cells in a band. */
typedef struct cell_row {
    uint64_t bit[OST_CELL_WORDS];
    int words, y0, y1; /* the row of cells contains the pixel rows y0 <= y < y1 */
} cell_row;

/*
 * Returns a row of cells: those that are in both sets a and b or, if `without` is true, those that are in a but not in
 * b.
 */
static cell_row row_of(const ost_cells *a, const ost_cells *b, bool without, const band *at, int y)
{
    const uint64_t *x = ost_cells_row(a, y / OST_CELL_HEIGHT), *z = ost_cells_row(b, y / OST_CELL_HEIGHT);
    cell_row row = {.words = a->words, .y0 = y, .y1 = y + OST_CELL_HEIGHT < at->y1 ? y + OST_CELL_HEIGHT : at->y1};
    for (int i = 0; i < a->words; i++)
        row.bit[i] = x[i] & (without ? ~z[i] : z[i]);
    return row;
}

/* Finds the next run of cells in a row, and sets *from and *to to its half-open range of pixel columns. Returns
   false if there is none. On entry, *to must be 0 or the end of the previous run. */
static bool next_run(const cell_row *row, int *from, int *to)
{
    int a, b = *to / OST_CELL_WIDTH;
    const bool found = ost_bits_run(row->bit, row->words, &a, &b);
    *from = a * OST_CELL_WIDTH;
    *to = b * OST_CELL_WIDTH;
    return found;
}

/*
 * Clears the keys in the cells to be redrawn. Marks the tiles outside these cells as completely covered, so that blocks
 * there are skipped. Returns the extent to draw.
 */
static ost_extent begin(const ost_frame *f, const ost_frame_layer *layer, const ost_cells *part, const band *at,
                        const ost_planes *planes)
{
    ost_extent e = {f->width, 0, at->y1, at->y0};
    for (int y = at->y0; y < at->y1; y += OST_CELL_HEIGHT) {
        const cell_row row = row_of(&layer->cells, part, false, at, y);
        ost_frame_tile *tiles = &at->bench->tiles[(y - at->y0) / OST_TILE * f->tiles_across];
        for (int i = 0; i < f->tiles_across; i++)
            tiles[i] = (ost_frame_tile){0, false};
        for (int from, to = 0; next_run(&row, &from, &to);) {
            for (int j = row.y0; j < row.y1; j++)
                memset(ost_key_row(planes, j) + from, OST_EMPTY_BYTE, (size_t)(to - from) * sizeof *planes->key);
            for (int i = from / OST_TILE; i < to / OST_TILE; i++)
                tiles[i].farthest = OST_EMPTY_KEY;
            e.x0 = from < e.x0 ? from : e.x0;
            e.x1 = to > e.x1 ? to : e.x1;
            e.y0 = row.y0 < e.y0 ? row.y0 : e.y0;
            e.y1 = row.y1;
        }
    }
    return e;
}

/* Draws a layer in the cells of the set `part`. */
static void draw_layer(const ost_frame *f, const ost_frame_layer *layer, const ost_cells *part, const band *at,
                       const ost_planes *planes)
{
    const ost_extent e = begin(f, layer, part, at, planes);
    for (int32_t i = 0; i < layer->count && e.y0 < e.y1; i++) {
        const ost_frame_block *b = &layer->blocks[i];
        if (b->pixels.y0 >= e.y1 || b->pixels.y1 <= e.y0 || b->pixels.x0 >= e.x1 || b->pixels.x1 <= e.x0)
            continue;
        const tile_range r = tiles_of(b, at);
        if (hidden(f, at, planes, r, b->nearest))
            continue;
        if (!layer->list[b->slot].listed)
            ost_layer_make_list(f, layer, b->slot, at->bench->lists);
        f->kernels.splat(&layer->eye, &layer->visible, (uint32_t)b->slot, layer->list[b->slot].count, planes, &e);
        drawn(f, at, r);
    }
    for (int y = at->y0; y < at->y1; y += OST_CELL_HEIGHT) {
        const cell_row row = row_of(&layer->cells, part, false, at, y);
        for (int from, to = 0; next_run(&row, &from, &to);)
            for (int j = row.y0; j < row.y1; j++)
                f->kernels.resolve(&layer->eye, &layer->visible, planes, j, from, to);
    }
}

/* Fills the cells that the first layer cannot cover with the background. */
static void blank(const ost_frame *f, const band *at, const ost_planes *planes)
{
    for (int y = at->y0; y < at->y1; y += OST_CELL_HEIGHT) {
        const cell_row row = row_of(&f->part, &f->layer[0].cells, true, at, y);
        for (int from, to = 0; next_run(&row, &from, &to);)
            for (int j = row.y0; j < row.y1; j++) {
                const size_t i = ost_row(planes, j) + (size_t)from, count = (size_t)(to - from);
                memset(planes->face + i, OST_NO_FACE, count);
                memcpy(planes->colour + i, f->blank, count * sizeof *planes->colour);
            }
    }
}

static void put_back(const ost_frame *f, const band *at)
{
    const ost_planes *to = &f->drawn, *stored = &f->stored;
    for (int y = at->y0; y < at->y1; y += OST_CELL_HEIGHT) {
        const cell_row row = row_of(&f->stale, &f->stale, false, at, y);
        for (int x, end = 0; next_run(&row, &x, &end);)
            for (int j = row.y0; j < row.y1; j++) {
                const size_t i = ost_row(to, j) + (size_t)x, count = (size_t)(end - x);
                memcpy(to->depth + i, stored->depth + i, count * sizeof *to->depth);
                memcpy(to->face + i, stored->face + i, count);
                memcpy(to->colour + i, stored->colour + i, count * sizeof *to->colour);
            }
    }
}

static uint32_t mixed(uint32_t under, uint32_t over, uint32_t share)
{
    const uint32_t complement = 256 - share;
    return (((under & 0xff00ff) * complement + (over & 0xff00ff) * share) >> 8 & 0xff00ff) |
           (((under & 0xff00) * complement + (over & 0xff00) * share) >> 8 & 0xff00);
}

/* Returns true if the ghost's planes show the ghost at the pixel (x, y). */
static bool is_there(const ost_frame *f, const ost_frame_layer *layer, int x, int y)
{
    return ost_cells_has(&layer->cells, x, y) && f->ghost.face[ost_row(&f->ghost, y) + (size_t)x] != OST_NO_FACE;
}

/* Blends a ghost with its outline into the pixels first <= x < end of row y. Only colours change. */
static void merge_ghost(const ost_frame *f, const ost_frame_layer *layer, unsigned ghost, int y, int first, int end)
{
    enum { LINE = 100 };
    const ost_planes *to = &f->planes, *from = &f->ghost;
    for (int x = first; x < end && x < f->width; x++) {
        const size_t i = ost_row(to, y) + (size_t)x;
        if (from->face[i] == OST_NO_FACE)
            continue;
        const bool before = to->face[i] == OST_NO_FACE || from->depth[i] * layer->scale < to->depth[i];
        const bool edge = (x > 0 && !is_there(f, layer, x - 1, y)) ||
                          (x + 1 < f->width && !is_there(f, layer, x + 1, y)) ||
                          (y > 0 && !is_there(f, layer, x, y - 1)) ||
                          (y + 1 < f->height && !is_there(f, layer, x, y + 1));
        const uint32_t share = (before ? ghost : ghost / 2) + (edge ? LINE : 0);
        to->colour[i] = mixed(to->colour[i], edge ? layer->light.colour[0] : from->colour[i],
                              share < 256 ? share : 256);
    }
}

void ost_frame_merge_ghost_row(const ost_frame *f, const ost_frame_layer *layer, unsigned ghost, int y)
{
    const band at = {.y1 = f->height};
    const cell_row row = row_of(&layer->cells, &layer->cells, false, &at, y / OST_CELL_HEIGHT * OST_CELL_HEIGHT);
    for (int from, to = 0; next_run(&row, &from, &to);)
        merge_ghost(f, layer, ghost, y, from, to);
}

/* Returns the band with the given number. If `planes` has no keys, the keys of the thread's scratch are used. */
static band band_of(const ost_frame *f, int number, ost_planes *planes)
{
    const int y0 = number * f->band;
    const band at = {y0, y0 + f->band < f->height ? y0 + f->band : f->height, &f->bench[ost_frame_thread()]};
    if (!planes->key) {
        planes->key = at.bench->over.key;
        planes->key_top = y0;
    }
    return at;
}

void ost_frame_draw_band(const ost_frame *f, int number, const ost_planes *base)
{
    ost_planes planes = *base;
    planes.key = f->planes.key;
    const band at = band_of(f, number, &planes);
    ost_planes over = at.bench->over;
    over.top = over.key_top = at.y0;
    draw_layer(f, &f->layer[0], &f->part, &at, &planes);
    blank(f, &at, &planes);
    if (base != &f->drawn)
        put_back(f, &at);
    for (int i = 1; i < f->layers; i++) {
        const ost_frame_layer *layer = &f->layer[i];
        if (layer->y0 >= at.y1 || layer->y1 <= at.y0)
            continue;
        draw_layer(f, layer, &layer->cells, &at, &over);
        for (int y = at.y0; y < at.y1; y += OST_CELL_HEIGHT) {
            const cell_row row = row_of(&layer->cells, &layer->cells, false, &at, y);
            for (int from, to = 0; next_run(&row, &from, &to);)
                for (int j = row.y0; j < row.y1; j++)
                    f->kernels.merge(&f->drawn, &over, layer->scale, j, from, to,
                                     f->over.bit + (ptrdiff_t)(y / OST_CELL_HEIGHT) * f->over.words);
        }
    }
    for (int i = 0; i < f->smooth_count; i++)
        ost_triangles_draw(&f->smooth[i], f->rows, &f->drawn, at.y0, at.y1, &f->over);
}

void ost_frame_draw_ghost_band(const ost_frame *f, const ost_frame_layer *layer, int number)
{
    ost_planes planes = f->ghost;
    const band at = band_of(f, number, &planes);
    draw_layer(f, layer, &layer->cells, &at, &planes);
}
