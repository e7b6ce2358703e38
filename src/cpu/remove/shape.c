/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Computes the tables of shape.h.
 *
 * All distances are distances between boxes on a lattice, so each axis can be processed
 * separately.  Let gap(c, g) be the distance in granules between cell c and granule g
 * along an axis (0 if they overlap or touch).  The distance D of a cell is
 *
 *   D^2(cx, cy, cz) = min over gz, gy, gx of gap(cx, gx)^2 + gap(cy, gy)^2 + gap(cz, gz)^2
 *
 * over the granules (gx, gy, gz) that differ from the cell, that is, granules that are not solid if
 * the cell is solid, or not empty if the cell is empty.  D^2 is computed one axis at a time and
 * only up to OST_CELL_REACH.  All arithmetic is in integers; v = isqrt(64 D^2).
 */
#include "cpu/remove/shape.h"

#include <stdlib.h>
#include <string.h>

#include "core/conditions.h"

enum { VOID, SOLID, BOTH };
enum { REACH = OST_CELL_REACH, FAR = REACH * REACH };

/*
 * The edge of a granule is 2^granule tool voxels, and the edge of a cell is `per` granules. The edge of a
 * bone voxel is at most the edge of a granule.
 */
typedef struct grain {
    int granule, per;
} grain;

static grain grain_for(int32_t ratio)
{
    grain g = {.granule = 0, .per = ratio <= 1 << (OST_MAP_FRACTION - 1) ? 1 : 2};
    while (ratio > 1 << (OST_MAP_FRACTION + g.granule) && g.granule < 4)
        g.granule++;
    return g;
}

typedef struct lattice {
    grain grain;
    int32_t margin; /* number of granules before the first and after the last granule of the tool, on each axis */
    int32_t dims[3], cells[3];
    uint8_t *state;
} lattice;

static size_t product(const int32_t d[3])
{
    return (size_t)d[0] * (size_t)d[1] * (size_t)d[2];
}

static const uint64_t *row_of(const ost_shape *shape, int32_t y, int32_t z)
{
    return shape->bits + shape->words * ((size_t)y + (size_t)shape->dims[1] * (size_t)z);
}

/* Counts the set bits among the bits x to x + edge - 1. `edge` is at most 16, and x is a multiple of `edge`. */
static int count_edge(const uint64_t *row, int32_t x, int32_t edge)
{
    const uint64_t bits = row[x / 64] >> (x % 64) & ((UINT64_C(1) << edge) - 1);
    return bits ? __builtin_popcountll(bits) : 0;
}

/*
 * Sets the state of each granule. The solid voxels of each granule (at most 16^3 = 4096) are counted for one line of
 * granules at a time. Returns false if memory is exhausted.
 */
static bool mark_granules(const ost_shape *shape, lattice *l)
{
    const int g = l->grain.granule;
    const int32_t edge = 1 << g;
    uint16_t *solid = malloc((size_t)l->dims[0] * sizeof *solid);
    if (!solid)
        return false;
    memset(l->state, VOID, product(l->dims));
    for (int32_t z = 0; z << g < shape->dims[2]; z++)
        for (int32_t y = 0; y << g < shape->dims[1]; y++) {
            uint8_t *state = l->state + l->margin +
                             (size_t)l->dims[0] *
                                 ((size_t)(y + l->margin) + (size_t)l->dims[1] * (size_t)(z + l->margin));
            memset(solid, 0, (size_t)l->dims[0] * sizeof *solid);
            for (int32_t k = z << g; k < (z + 1) << g && k < shape->dims[2]; k++)
                for (int32_t j = y << g; j < (y + 1) << g && j < shape->dims[1]; j++) {
                    const uint64_t *row = row_of(shape, j, k);
                    for (int32_t x = 0; x << g < shape->dims[0]; x++)
                        solid[x] = (uint16_t)(solid[x] + count_edge(row, x << g, edge));
                }
            for (int32_t x = 0; x << g < shape->dims[0]; x++)
                state[x] = solid[x] == 0 ? VOID : solid[x] == edge * edge * edge ? SOLID : BOTH;
        }
    free(solid);
    return true;
}

/*
 * For every cell of a row, computes the squared gap along x to the nearest granule whose state is not `kind` (solid or
 * empty). The gap is FAR if no such granule is nearer than REACH.
 */
static void row_gaps(const uint8_t *state, int32_t granules, int32_t cells, int per, uint8_t kind, uint8_t *out)
{
    /* In most rows, all granules have the same state. */
    if (state[0] == state[granules - 1] && memcmp(state, state + 1, (size_t)granules - 1) == 0) {
        memset(out, state[0] == kind ? FAR : 0, (size_t)cells);
        return;
    }
    int32_t last = -2 * REACH;
    for (int32_t c = 0, g = 0; c < cells; c++) {
        for (; g < (c + 1) * per && g < granules; g++)
            last = state[g] != kind ? g : last;
        int32_t gap = c * per - 1 - last;
        out[c] = (uint8_t)(gap <= 0 ? 0 : gap >= REACH ? FAR : gap * gap);
    }
    last = granules + 2 * REACH;
    for (int32_t c = cells - 1, g = granules - 1; c >= 0; c--) {
        for (; g >= c * per; g--)
            last = state[g] != kind ? g : last;
        int32_t gap = last - (c + 1) * per;
        uint8_t squared = (uint8_t)(gap <= 0 ? 0 : gap >= REACH ? FAR : gap * gap);
        out[c] = squared < out[c] ? squared : out[c];
    }
}

/*
 * Computes out[c][i] = min(FAR, min over granules g of in[g][i] + gap(c, g)^2) for 0 <= i < width. The loop
 * processes all granules near a cell for STRIP values of i, so that the STRIP minima remain in registers.
 */
static void fold_axis(const uint8_t *in, int32_t granules, int32_t cells, int per, size_t width, uint8_t *out)
{
    enum { STRIP = 64 };
    for (int32_t c = 0; c < cells; c++) {
        const int32_t first = c * per, next = first + per;
        const int32_t lo = first > REACH ? first - REACH : 0, hi = next + REACH < granules ? next + REACH : granules;
        for (size_t i = 0; i < width; i += STRIP) {
            const size_t n = width - i < STRIP ? width - i : STRIP;
            uint8_t best[STRIP];
            memset(best, FAR, sizeof best);
            for (int32_t g = lo; g < hi; g++) {
                const int32_t gap = g < first ? first - 1 - g : g >= next ? g - next : 0;
                const uint8_t *from = in + (size_t)g * width + i;
                const uint8_t add = (uint8_t)(gap * gap);
                if (n == STRIP) {
                    for (size_t k = 0; k < STRIP; k++) {
                        const uint8_t sum = (uint8_t)(from[k] + add); /* <= 64 + 49 */
                        best[k] = sum < best[k] ? sum : best[k];
                    }
                } else {
                    for (size_t k = 0; k < n; k++) {
                        const uint8_t sum = (uint8_t)(from[k] + add);
                        best[k] = sum < best[k] ? sum : best[k];
                    }
                }
            }
            memcpy(out + (size_t)c * width + i, best, n);
        }
    }
}

/*
 * Writes the values of all cells whose state is `kind` (solid or empty). The scratch arrays a and b must each have at
 * least one byte per granule.
 */
static void distances_of(const lattice *l, uint8_t kind, uint8_t *a, uint8_t *b, int8_t *value)
{
    const int per = l->grain.per;
    const size_t cx = (size_t)l->cells[0], cy = (size_t)l->cells[1];
    for (int32_t r = 0; r < l->dims[1] * l->dims[2]; r++)
        row_gaps(l->state + (size_t)r * (size_t)l->dims[0], l->dims[0], l->cells[0], per, kind, a + (size_t)r * cx);
    for (int32_t z = 0; z < l->dims[2]; z++)
        fold_axis(a + (size_t)z * (size_t)l->dims[1] * cx, l->dims[1], l->cells[1], per, cx, b + (size_t)z * cx * cy);
    fold_axis(b, l->dims[2], l->cells[2], per, cx * cy, a);
    int8_t root[FAR + 1];
    for (int d = 0, r = 0; d <= FAR; d++) {
        while ((r + 1) * (r + 1) <= 64 * d)
            r++;
        root[d] = (int8_t)r;
    }
    for (int32_t z = 0; z < l->cells[2]; z++)
        for (int32_t y = 0; y < l->cells[1]; y++)
            for (int32_t x = 0; x < l->cells[0]; x++) {
                const size_t c = (size_t)x + cx * ((size_t)y + cy * (size_t)z);
                const size_t g = (size_t)(x * per) +
                                 (size_t)l->dims[0] * ((size_t)(y * per) + (size_t)l->dims[1] * (size_t)(z * per));
                if (l->state[g] == kind)
                    value[c] = (int8_t)(kind == SOLID ? root[a[c]] : -root[a[c]]);
            }
}

/*
 * Computes the table of cells. A solid or empty cell that touches a granule of a different state has the value 0, like
 * a mixed cell. The margin is a multiple of a cell's edge, and is large enough that cell 0 is at least
 * OST_CELL_REACH granules away from the tool's granule 0.
 */
static ost_status make_cells(ost_shape *shape, grain size, ost_error *err)
{
    lattice l = {.grain = size, .margin = REACH + 2 * size.per};
    ost_status status = OST_ERR_MEMORY;
    for (int a = 0; a < 3; a++) {
        int32_t granules = (shape->dims[a] + (1 << size.granule) - 1) >> size.granule;
        l.cells[a] = (granules + 2 * l.margin + size.per - 1) / size.per;
        l.dims[a] = l.cells[a] * size.per;
    }
    const size_t granules = product(l.dims), cells = product(l.cells);
    uint8_t *a = malloc(granules), *b = malloc(granules);
    int8_t *value = calloc(cells + 128, 1);
    l.state = malloc(granules);
    if (a && b && value && l.state && mark_granules(shape, &l)) {
        distances_of(&l, VOID, a, b, value + 64);
        distances_of(&l, SOLID, a, b, value + 64);
        shape->memory[0] = value;
        shape->cells = (ost_cells){
            .value = value + 64,
            .dims = {l.cells[0], l.cells[1], l.cells[2]},
            .margin = l.margin / size.per,
            .shift = OST_MAP_FRACTION + size.granule + (size.per == 2),
            .unit = 1 << (OST_MAP_FRACTION + size.granule - 3),
        };
        status = OST_OK;
    } else {
        free(value);
    }
    free(l.state);
    free(b);
    free(a);
    if (status != OST_OK)
        return ost_fail(err, status, "out of memory for the distances of a tool (%zu cells)", cells);
    return OST_OK;
}

/* --------------------------------------------------------------- windows */

/*
 * A size of windows: `edge` is the number of voxels along an edge, and `lines` is the number of lines of a window.
 * On each axis, the first window begins `margin` voxels before the tool, and the last window ends more than `behind`
 * voxels after the tool.
 */
typedef struct window_size {
    int32_t edge, margin, behind;
    size_t lines;
} window_size;
static const window_size NARROW = {8, OST_WINDOW_MARGIN, 8, 1}, WIDE = {16, OST_WIDE_MARGIN, 16, OST_WIDE_LINES};

/*
 * The bytes of all windows, in columns. A window with x index i has edge / 8 columns of eight voxels along x; the first
 * of these is column i edge / 8. A column contains one byte for every row (y, z) of the tool and of the empty space
 * around the tool. The index z is fastest, so the bytes of a window that have the same y are adjacent.
 *
 *   column i edge / 8 + p, row (y, z): bit x is voxel (step i + 8 p - margin + x, y - margin, z - margin)
 */
typedef struct columns {
    uint8_t *byte;
    size_t width[2]; /* numbers of rows along z and along y */
} columns;

/* Returns the bits x to x + 7 of a row of words. */
static uint8_t eight_bits(const uint64_t *row, int32_t x)
{
    const int32_t shift = x % 64;
    return (uint8_t)(row[x / 64] >> shift | (shift > 56 ? row[x / 64 + 1] << (64 - shift) : 0));
}

static bool make_columns(const ost_shape *shape, window_size size, int32_t step, const int32_t n[3], columns *c)
{
    c->width[0] = (size_t)((n[2] - 1) * step + size.edge);
    c->width[1] = (size_t)((n[1] - 1) * step + size.edge);
    const size_t plane = c->width[0] * c->width[1], bits = (size_t)((n[0] - 1) * step + size.edge);
    const int32_t parts = size.edge / 8;
    c->byte = calloc((size_t)(n[0] * parts) * plane, 1);
    /* a row of the tool between empty words, so that every byte of a window can be read */
    uint64_t *row = calloc(shape->words + bits / 64 + 4, sizeof *row);
    const bool enough = c->byte && row;
    for (int32_t z = 0; z < shape->dims[2] && enough; z++)
        for (int32_t y = 0; y < shape->dims[1]; y++) {
            memcpy(row + 1, row_of(shape, y, z), shape->words * sizeof *row);
            uint8_t *to = c->byte + (size_t)(y + size.margin) * c->width[0] + (size_t)(z + size.margin);
            for (int32_t i = 0; i < n[0] * parts; i++)
                to[(size_t)i * plane] = eight_bits(row, 64 + i / parts * step + 8 * (i % parts) - size.margin);
        }
    free(row);
    return enough;
}

enum { WORDS = 8 * OST_WIDE_LINES }; /* maximum number of 64-bit words per window */

static void read_window(const columns *c, window_size size, int32_t step, int32_t i, int32_t j, int32_t k,
                        uint64_t word[WORDS])
{
    const int32_t parts = size.edge / 8;
    uint8_t *to = (uint8_t *)word;
    for (int32_t p = i * parts; p < (i + 1) * parts; p++) {
        const uint8_t *from = c->byte + ((size_t)p * c->width[1] + (size_t)(j * step)) * c->width[0] +
                              (size_t)(k * step);
        for (int y = 0; y < size.edge; y++, to += size.edge)
            memcpy(to, from + (size_t)y * c->width[0], (size_t)size.edge);
    }
}

static bool all_are(const uint64_t *word, size_t count, uint64_t value)
{
    uint64_t other = 0;
    for (size_t i = 0; i < count; i++)
        other |= word[i] ^ value;
    return other == 0;
}

typedef struct line_store {
    uint8_t (*line)[64];
    size_t count, capacity;
} line_store;

/* Stores a window, which consists of `lines` lines, and sets *number to the index of the window's first line. */
static bool add_window(line_store *store, const uint64_t word[WORDS], size_t lines, uint32_t *number)
{
    if (all_are(word, 8 * lines, 0) || all_are(word, 8 * lines, ~UINT64_C(0))) {
        *number = word[0] ? (uint32_t)lines : 0;
        return true;
    }
    if (store->count + lines > store->capacity) {
        size_t capacity = store->capacity * 2;
        uint8_t(*grown)[64] = aligned_alloc(64, capacity * 64);
        if (!grown)
            return false;
        memcpy(grown, store->line, store->count * 64);
        free(store->line);
        store->line = grown;
        store->capacity = capacity;
    }
    memcpy(store->line[store->count], word, 64 * lines);
    *number = (uint32_t)store->count;
    store->count += lines;
    return true;
}

/*
 * Returns the coarsest possible step of windows with the given edge, or 0 if no step is possible. `ratio` is the size
 * of a bone voxel in tool voxels, times 2^20 (ost_shape_make). AR-MAP-5 bounds the sum of the steps along a tool axis;
 * the coordinates of a brick therefore span at most 3 * sqrt(3) * ratio + 9/2 units along an axis. This span must be
 * below edge - step voxels, so that a brick overlaps at most edge + 1 - step voxels. Only steps by which the kernels
 * divide exactly (x86/window_avx512.h) are used.
 */
static int32_t window_step(int32_t ratio, int32_t edge)
{
    static const int32_t steps[] = {6, 3, 2, 1};
    const int64_t span = ((int64_t)ratio * 519616 + 99999) / 100000 + 5;
    for (size_t i = edge == 8; i < sizeof steps / sizeof *steps; i++)
        if (span < (int64_t)(edge - steps[i]) << OST_MAP_FRACTION)
            return steps[i];
    return 0;
}

/*
 * Computes a table of windows. On each axis, the first window begins at voxel -margin, and the last window begins
 * beyond voxel dims + behind - step. remove.h explains why no brick needs further windows.
 */
static ost_status make_windows(ost_shape *shape, window_size size, int32_t step, ost_windows *out, ost_error *err)
{
    int32_t n[3];
    for (int a = 0; a < 3; a++)
        n[a] = (shape->dims[a] + size.behind + size.margin) / step + 1;
    uint32_t *index = malloc((product(n) + 16) * sizeof *index);
    line_store store = {.line = aligned_alloc(64, 1024 * 64), .capacity = 1024, .count = 2 * size.lines};
    columns c = {0};
    bool enough = index && store.line && make_columns(shape, size, step, n, &c);
    if (enough) {
        memset(store.line[0], 0, 64 * size.lines);
        memset(store.line[size.lines], 0xff, 64 * size.lines);
    }
    size_t i = 0;
    for (int32_t z = 0; z < n[2] && enough; z++)
        for (int32_t y = 0; y < n[1] && enough; y++)
            for (int32_t x = 0; x < n[0] && enough; x++, i++) {
                uint64_t word[WORDS];
                read_window(&c, size, step, x, y, z, word);
                enough = add_window(&store, word, size.lines, &index[i]);
            }
    free(c.byte);
    shape->memory[1] = index;
    shape->memory[2] = store.line;
    if (!enough)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for the windows of a tool of %d x %d x %d voxels",
                        shape->dims[0], shape->dims[1], shape->dims[2]);
    *out = (ost_windows){
        .index = index, .line = (const uint8_t(*)[64])store.line, .dims = {n[0], n[1], n[2]}, .step = step};
    return OST_OK;
}

ost_status ost_shape_make(const uint64_t *bits, size_t words, ost_dims dims, int32_t ratio, ost_shape *out,
                          ost_error *err)
{
    *out = (ost_shape){.bits = bits, .words = words, .dims = {dims.x, dims.y, dims.z}};
    ost_status status = make_cells(out, grain_for(ratio), err);
    const int32_t step = window_step(ratio, NARROW.edge), wide = window_step(ratio, WIDE.edge);
    if (status == OST_OK && step > 0)
        status = make_windows(out, NARROW, step, &out->windows, err);
    else if (status == OST_OK && wide > 0)
        status = make_windows(out, WIDE, wide, &out->wide, err);
    return status;
}

void ost_shape_free(ost_shape *shape)
{
    for (int i = 0; i < 3; i++)
        free(shape->memory[i]);
    *shape = (ost_shape){0};
}

bool ost_shape_covers_ratio(const ost_shape *shape, int32_t ratio)
{
    const grain g = grain_for(ratio);
    const int32_t step = window_step(ratio, NARROW.edge);
    return shape->cells.value && shape->windows.step == step &&
           shape->wide.step == (step > 0 ? 0 : window_step(ratio, WIDE.edge)) &&
           shape->cells.shift == OST_MAP_FRACTION + g.granule + (g.per == 2) &&
           shape->cells.unit == 1 << (OST_MAP_FRACTION + g.granule - 3);
}
