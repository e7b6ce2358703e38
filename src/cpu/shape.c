/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Making the tables of shape.h.
 *
 * Distances are those between boxes on a lattice, so they separate by axis:
 * with gap(c, g) the distance in granules between cell c and granule g along
 * an axis (0 when they meet or touch),
 *
 *   D^2(cx, cy, cz) = min over gz, gy, gx of gap(cx, gx)^2 + gap(cy, gy)^2 + gap(cz, gz)^2
 *
 * over the granules of the other kind, taken one axis at a time and only as
 * far as OST_CELL_REACH.  All of it is integer; v = isqrt(64 D^2).
 */
#include "cpu/shape.h"

#include <stdlib.h>
#include <string.h>

#include "core/conditions.h"

enum { VOID, SOLID, BOTH };
enum { REACH = OST_CELL_REACH, FAR = REACH * REACH };

/* Granule edge 2^granule voxels, cells of `per` granules; a bone voxel is at most one granule. */
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
    int32_t margin; /* granules around the tool's */
    int32_t dims[3], cells[3];
    uint8_t *state;
} lattice;

static size_t product(const int32_t d[3])
{
    return (size_t)d[0] * (size_t)d[1] * (size_t)d[2];
}

/* Marks each granule by what its voxels are. */
static void mark_granules(const ost_shape *shape, lattice *l)
{
    const int g = l->grain.granule;
    const int32_t edge = 1 << g;
    for (int32_t z = 0; z < l->dims[2]; z++)
        for (int32_t y = 0; y < l->dims[1]; y++)
            for (int32_t x = 0; x < l->dims[0]; x++) {
                const int32_t from[3] = {(x - l->margin) * edge, (y - l->margin) * edge, (z - l->margin) * edge};
                int32_t solid = 0;
                for (int32_t k = from[2]; k < from[2] + edge; k++)
                    for (int32_t j = from[1]; j < from[1] + edge; j++)
                        for (int32_t i = from[0]; i < from[0] + edge; i++)
                            if (i >= 0 && i < shape->dims[0] && j >= 0 && j < shape->dims[1] && k >= 0 && k < shape->dims[2])
                                solid += shape->voxels[i + shape->dims[0] * (j + (int64_t)shape->dims[1] * k)] == shape->kind;
                l->state[x + l->dims[0] * (y + (size_t)l->dims[1] * (size_t)z)] =
                    solid == 0 ? VOID : solid == edge * edge * edge ? SOLID : BOTH;
            }
}

/* Squared gaps along x from every cell of a row to the nearest granule that is not of the kind; FAR when none is near. */
static void row_gaps(const uint8_t *state, int32_t granules, int32_t cells, int per, uint8_t kind, uint8_t *out)
{
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

/* out[c][i] = min over granules g of in[g][i] + gap(c, g)^2, not above FAR; lines of `width`. */
static void fold_axis(const uint8_t *in, int32_t granules, int32_t cells, int per, size_t width, uint8_t *out)
{
    for (int32_t c = 0; c < cells; c++) {
        uint8_t *to = out + (size_t)c * width;
        memset(to, FAR, width);
        for (int32_t g = c * per - REACH; g < (c + 1) * per + REACH; g++) {
            if (g < 0 || g >= granules)
                continue;
            const int32_t gap = g < c * per ? c * per - 1 - g : g >= (c + 1) * per ? g - (c + 1) * per : 0;
            const uint8_t *from = in + (size_t)g * width;
            const uint8_t add = (uint8_t)(gap * gap);
            for (size_t i = 0; i < width; i++) {
                uint8_t sum = (uint8_t)(from[i] + add); /* <= 64 + 49 */
                to[i] = sum < to[i] ? sum : to[i];
            }
        }
    }
}

/* Writes the cells of one kind into value; a and b are scratch of dims[0..2] and cells[0] * cells[1] * dims[2] bytes or more. */
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
                const size_t g = (size_t)(x * per) + (size_t)l->dims[0] * ((size_t)(y * per) + (size_t)l->dims[1] * (size_t)(z * per));
                if (l->state[g] == kind)
                    value[c] = (int8_t)(kind == SOLID ? root[a[c]] : -root[a[c]]);
            }
}

/*
 * A gap of 0 says that the cell holds or touches the other kind, and then v is 0: kept as "mixed".
 * margin: a whole number of cells, so that cell 0 is OST_CELL_REACH granules away from granule 0 of the tool.
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
    if (a && b && value && l.state) {
        mark_granules(shape, &l);
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
        return ost_fail(err, status, "no memory for the distances of a tool (%zu cells)", cells);
    return OST_OK;
}

/* --------------------------------------------------------------- windows */

enum { EDGE = 8 };

/* Bits x..x+7 of the tool's rows that a window covers. */
static void read_window(const ost_shape *shape, const int32_t from[3], uint8_t line[64])
{
    memset(line, 0, 64);
    const int32_t x0 = from[0] < 0 ? -from[0] : 0, x1 = shape->dims[0] - from[0] < EDGE ? shape->dims[0] - from[0] : EDGE;
    for (int32_t y = 0; y < EDGE; y++)
        for (int32_t z = 0; z < EDGE; z++) {
            const int32_t j = from[1] + y, k = from[2] + z;
            if (j < 0 || j >= shape->dims[1] || k < 0 || k >= shape->dims[2])
                continue;
            const uint8_t *row = shape->voxels + shape->dims[0] * (j + (int64_t)shape->dims[1] * k);
            unsigned byte = 0;
            for (int32_t x = x0; x < x1; x++)
                byte |= (unsigned)(row[from[0] + x] == shape->kind) << x;
            line[8 * y + z] = (uint8_t)byte;
        }
}

static bool line_is(const uint8_t line[64], uint8_t byte)
{
    for (int i = 0; i < 64; i++)
        if (line[i] != byte)
            return false;
    return true;
}

typedef struct line_store {
    uint8_t (*line)[64];
    size_t count, capacity;
} line_store;

static bool add_line(line_store *store, const uint8_t line[64], uint32_t *number)
{
    if (line_is(line, 0) || line_is(line, 0xff)) {
        *number = line[0] != 0;
        return true;
    }
    if (store->count == store->capacity) {
        size_t capacity = store->capacity * 2;
        uint8_t(*grown)[64] = aligned_alloc(64, capacity * 64);
        if (!grown)
            return false;
        memcpy(grown, store->line, store->count * 64);
        free(store->line);
        store->line = grown;
        store->capacity = capacity;
    }
    memcpy(store->line[store->count], line, 64);
    *number = (uint32_t)store->count++;
    return true;
}

/*
 * A brick's coordinates span at most 3 * sqrt(3) * ratio + 9/2 units along an
 * axis (AR-MAP-5's bound on the sum of a column's steps), and must stay below
 * 8 - step voxels: then they touch at most 9 - step of them.
 */
static int32_t window_step(int32_t ratio)
{
    const int64_t span = ((int64_t)ratio * 519616 + 99999) / 100000 + 5;
    for (int32_t step = 3; step > 0; step--)
        if (span < (int64_t)(8 - step) << OST_MAP_FRACTION)
            return step;
    return 0;
}

/* Windows begin at -OST_WINDOW_MARGIN; the last one begins beyond dims + 8 - step: remove.h says why no brick asks farther. */
static ost_status make_windows(ost_shape *shape, int32_t step, ost_error *err)
{
    int32_t n[3];
    for (int a = 0; a < 3; a++)
        n[a] = (shape->dims[a] + 8 + OST_WINDOW_MARGIN) / step + 1;
    uint32_t *index = malloc((product(n) + 16) * sizeof *index);
    line_store store = {.line = aligned_alloc(64, 1024 * 64), .capacity = 1024, .count = 2};
    bool enough = index && store.line;
    if (enough) {
        memset(store.line[0], 0, 64);
        memset(store.line[1], 0xff, 64);
    }
    size_t i = 0;
    for (int32_t z = 0; z < n[2] && enough; z++)
        for (int32_t y = 0; y < n[1] && enough; y++)
            for (int32_t x = 0; x < n[0] && enough; x++, i++) {
                const int32_t from[3] = {x * step - OST_WINDOW_MARGIN, y * step - OST_WINDOW_MARGIN, z * step - OST_WINDOW_MARGIN};
                uint8_t line[64];
                read_window(shape, from, line);
                enough = add_line(&store, line, &index[i]);
            }
    shape->memory[1] = index;
    shape->memory[2] = store.line;
    if (!enough)
        return ost_fail(err, OST_ERR_MEMORY, "no memory for the windows of a tool of %d x %d x %d voxels", shape->dims[0], shape->dims[1],
                        shape->dims[2]);
    shape->windows = (ost_windows){.index = index, .line = (const uint8_t(*)[64])store.line, .dims = {n[0], n[1], n[2]}, .step = step};
    return OST_OK;
}

ost_status ost_shape_make(const uint8_t *voxels, ost_dims dims, uint8_t kind, int32_t ratio, ost_shape *out, ost_error *err)
{
    *out = (ost_shape){.voxels = voxels, .dims = {dims.x, dims.y, dims.z}, .kind = kind};
    ost_status status = make_cells(out, grain_for(ratio), err);
    const int32_t step = window_step(ratio);
    if (status == OST_OK && step > 0)
        status = make_windows(out, step, err);
    return status;
}

void ost_shape_free(ost_shape *shape)
{
    for (int i = 0; i < 3; i++)
        free(shape->memory[i]);
    *shape = (ost_shape){0};
}

bool ost_shape_serves(const ost_shape *shape, int32_t ratio)
{
    const grain g = grain_for(ratio);
    return shape->cells.value && shape->windows.step == window_step(ratio) && shape->cells.shift == OST_MAP_FRACTION + g.granule + (g.per == 2) &&
           shape->cells.unit == 1 << (OST_MAP_FRACTION + g.granule - 3);
}
