/* SPDX-License-Identifier: Apache-2.0 */
#include "render/points/uncut.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/conditions.h"
#include "render/marks.h"
#include "render/points/block_words.h"

enum { SIDE = OST_BLOCK, ROWS = OST_BLOCK_ROWS };
/* docs/reference/metrics.md defines PLATE_MM. */
static const double PLATE_MM = 4.5, PLATE_CLEAR_MM = 7.5, PLATE_RADIUS_MM = 20;

static double voxel_mm(const ost_uncut *g)
{
    return 1e-9 * (double)g->volume.geometry.spacing.x;
}

static void make_levels(ost_uncut *g)
{
    g->scale_mm = ost_round_down((OST_DEPTH_REACH - 0.5) * voxel_mm(g));
    for (int i = 0; i <= OST_DEPTH_FAR; i++) {
        const int step = (int)((sqrt(i) - 0.5) * voxel_mm(g) / g->scale_mm * (OST_SCALE - 1) + 0.5);
        g->level[i] = (uint8_t)(OST_PAINT_LIT + (step < 0 ? 0 : step > OST_SCALE - 1 ? OST_SCALE - 1 : step));
    }
}

ost_status ost_uncut_init(ost_uncut *reference, ost_volume *volume, int32_t threshold,
                          const ost_density_classes *classes, const ost_pm3 *at, const double *axis, ost_error *err)
{
    *reference = (ost_uncut){.threshold = threshold};
    const ost_geometry *g = &volume->geometry;
    if (g->spacing.x != g->spacing.y || g->spacing.x != g->spacing.z)
        return ost_fail(err, OST_ERR_RANGE, "the uncut bone needs cubic voxels");
    reference->volume = *volume;
    *volume = (ost_volume){.voxels = NULL};
    g = &reference->volume.geometry;
    reference->classes = classes->count;
    for (int c = 0; c < classes->count; c++)
        reference->border[c] = classes->border[c];
    if (at && axis) {
        const double s = (double)g->spacing.x, length = sqrt(axis[0] * axis[0] + axis[1] * axis[1] + axis[2] * axis[2]);
        const ost_pm p[3] = {at->x - g->origin.x, at->y - g->origin.y, at->z - g->origin.z};
        reference->has_face = length > 0;
        for (int a = 0; a < 3 && reference->has_face; a++) {
            reference->face[a] = (double)p[a] / s;
            reference->inward[a] = axis[a] / length;
        }
    }
    make_levels(reference);
    return OST_OK;
}

void ost_uncut_free(ost_uncut *reference)
{
    ost_volume_free(&reference->volume);
    free(reference->outside);
    memset(reference, 0, sizeof *reference);
}

/* ------------------------------------------------------------------- paint */

static bool inside(const ost_uncut *g, const int32_t at[3])
{
    const ost_dims d = g->volume.geometry.dims;
    return at[0] >= 0 && at[1] >= 0 && at[2] >= 0 && at[0] < d.x && at[1] < d.y && at[2] < d.z;
}

static int density_at(const ost_uncut *g, const int32_t at[3])
{
    const ost_dims d = g->volume.geometry.dims;
    return inside(g, at) ? g->volume.voxels[at[0] + (size_t)d.x * ((size_t)at[1] + (size_t)d.y * (size_t)at[2])]
                         : INT16_MIN;
}

/*
 * Returns true if a voxel is in the subchondral plate, that is, if the voxel is close to the face, and there is no bone
 * PLATE_MM to PLATE_CLEAR_MM outward of the voxel.
 */
static bool in_plate(const ost_uncut *g, const int32_t at[3])
{
    if (!g->has_face)
        return false;
    double off[3], along = 0, square = 0;
    const double mm = voxel_mm(g);
    for (int a = 0; a < 3; a++) {
        off[a] = at[a] - g->face[a];
        along += off[a] * g->inward[a];
        square += off[a] * off[a];
    }
    if ((square - along * along) * mm * mm > PLATE_RADIUS_MM * PLATE_RADIUS_MM || fabs(along * mm) > 2 * PLATE_CLEAR_MM)
        return false;
    for (double out = PLATE_MM / mm; out <= PLATE_CLEAR_MM / mm; out += 1) {
        int32_t p[3];
        for (int a = 0; a < 3; a++)
            p[a] = (int32_t)floor(at[a] - out * g->inward[a] + 0.5);
        if (density_at(g, p) >= g->threshold)
            return false;
    }
    return true;
}

/* Returns true if a voxel with a density in [from, to) is one or two voxels away from at[] along one of the axes. */
static bool near(const ost_uncut *g, const int32_t at[3], int from, int to)
{
    for (int i = 0; i < 12; i++) {
        int32_t p[3] = {at[0], at[1], at[2]};
        p[i % 3] += (i / 6 + 1) * (i / 3 % 2 ? 1 : -1);
        const int density = density_at(g, p);
        if (density >= from && density < to)
            return true;
    }
    return false;
}

/*
 * Returns the tissue of a voxel by its density class, with two corrections for the partial volume effect. First, a
 * voxel of medium density between hard bone and a soft voxel or air is treated as the edge of hard bone, not as
 * cancellous bone. Second, if the position of the face is known, a voxel with the density of cartilage counts as
 * cartilage only at the face.
 */
static uint32_t tissue_at(const ost_uncut *g, const int32_t at[3], int density)
{
    const int hard = g->border[g->classes - 1], soft = g->classes > 1 ? g->border[1] : hard;
    const uint32_t shell = in_plate(g, at) ? OST_TISSUE_PLATE : OST_TISSUE_CORTICAL;
    if (density >= hard)
        return shell;
    if (density < soft && (!g->has_face || shell == OST_TISSUE_PLATE))
        return OST_TISSUE_CARTILAGE;
    return near(g, at, hard, INT16_MAX) && near(g, at, INT16_MIN, soft) ? shell : OST_TISSUE_CANCELLOUS;
}

uint32_t ost_uncut_paint(const ost_uncut *reference, ost_colouring colouring, const int32_t at[3], uint32_t depth)
{
    const int density = density_at(reference, at);
    switch (colouring) {
    case OST_COLOUR_CLASS: return OST_PAINT_LIT + tissue_at(reference, at, density);
    case OST_COLOUR_DEPTH: return reference->level[depth];
    /* the scale runs from light to dark, so it is reversed to make dense voxels light */
    case OST_COLOUR_DENSITY: return (uint32_t)(OST_PAINT_LIT + OST_SCALE - 1 - ost_window_step(density));
    case OST_COLOUR_LABEL:
        return OST_PAINT_LIT + (uint32_t)(density < OST_LABEL_DENSITY + OST_LABELS ? density - OST_LABEL_DENSITY
                                                                                    : OST_LABELS - 1);
    case OST_COLOUR_BONE: break;
    }
    return 0;
}

uint32_t ost_uncut_cap(const ost_uncut *reference, ost_colouring colouring, const int32_t at[3])
{
    if (!reference)
        return OST_PAINT_FLAT + OST_SCALE * 3 / 4;
    const int density = density_at(reference, at);
    return OST_PAINT_FLAT +
           (colouring == OST_COLOUR_CLASS ? tissue_at(reference, at, density) : (uint32_t)ost_window_step(density));
}

/* ----------------------------------------------------------------- outside */

typedef struct cells {
    int32_t x, y, z;
} cells;

static cells cells_of(const ost_uncut *g)
{
    const ost_dims d = g->volume.geometry.dims;
    return (cells){(d.x + 1) / 2, (d.y + 1) / 2, (d.z + 1) / 2};
}

enum { OPEN = 1, BONE = 2 }; /* bits of a cell's mark */

/* Marks the cells that contain bone, in the order of the voxels in memory. */
static void mark_bone(const ost_uncut *g, uint8_t *mark)
{
    const ost_dims d = g->volume.geometry.dims;
    const cells c = cells_of(g);
    const int16_t *voxels = g->volume.voxels;
    for (int32_t z = 0; z < d.z; z++)
        for (int32_t y = 0; y < d.y; y++, voxels += d.x) {
            uint8_t *row = mark + (int64_t)c.x * (y / 2 + (int64_t)c.y * (z / 2));
            for (int32_t x = 0; x + 1 < d.x; x += 2)
                row[x / 2] |= (uint8_t)(((voxels[x] >= g->threshold) | (voxels[x + 1] >= g->threshold)) * BONE);
            if (d.x % 2 && voxels[d.x - 1] >= g->threshold)
                row[c.x - 1] |= BONE;
        }
}

/* Cells x0 <= x < x1 of a row, all without bone and all marked as outside. */
typedef struct run {
    int32_t x0, x1, y, z;
} run;

typedef struct flooding {
    cells c;
    uint8_t *mark;
    run *stack; /* owned; runs whose neighbouring rows have not been searched */
    size_t count, capacity;
} flooding;

/*
 * Marks all runs in row (y, z) that contain at least one of the cells x0 <= x < x1, and pushes them on the stack.
 * Returns false if memory is exhausted.
 */
static bool flood_row(flooding *f, int32_t x0, int32_t x1, int32_t y, int32_t z)
{
    if (y < 0 || z < 0 || y >= f->c.y || z >= f->c.z)
        return true;
    uint8_t *row = f->mark + (int64_t)f->c.x * (y + (int64_t)f->c.y * z);
    for (int32_t x = x0; x < x1; x++) {
        if (row[x])
            continue;
        run r = {x, x + 1, y, z};
        while (r.x0 > 0 && !row[r.x0 - 1])
            r.x0--;
        while (r.x1 < f->c.x && !row[r.x1])
            r.x1++;
        memset(row + r.x0, OPEN, (size_t)(r.x1 - r.x0));
        if (f->count == f->capacity) {
            run *grown = realloc(f->stack, 2 * f->capacity * sizeof *grown);
            if (!grown)
                return false;
            f->stack = grown;
            f->capacity *= 2;
        }
        f->stack[f->count++] = r;
        x = r.x1;
    }
    return true;
}

/*
 * Marks as outside all cells without bone that are connected to the border of the grid through such cells. On entry,
 * only the cells with bone are marked. Returns false if memory is exhausted.
 */
static bool flood(const ost_uncut *g, uint8_t *mark)
{
    const cells c = cells_of(g);
    flooding f = {.c = c, .mark = mark, .capacity = 4096};
    f.stack = malloc(f.capacity * sizeof *f.stack);
    bool enough = f.stack != NULL;
    for (int32_t z = 0; z < c.z && enough; z++)
        for (int32_t y = 0; y < c.y && enough; y++) {
            if (y == 0 || z == 0 || y == c.y - 1 || z == c.z - 1)
                enough = flood_row(&f, 0, c.x, y, z);
            else /* only the two ends of the row are at the border */
                enough = flood_row(&f, 0, 1, y, z) && flood_row(&f, c.x - 1, c.x, y, z);
            while (enough && f.count > 0) {
                const run r = f.stack[--f.count];
                enough = flood_row(&f, r.x0, r.x1, r.y - 1, r.z) && flood_row(&f, r.x0, r.x1, r.y + 1, r.z) &&
                         flood_row(&f, r.x0, r.x1, r.y, r.z - 1) && flood_row(&f, r.x0, r.x1, r.y, r.z + 1);
            }
        }
    free(f.stack);
    return enough;
}

/* Marks the neighbours of marked cells in a line of `size` cells, which are `step` elements apart in memory. */
static void widen(uint8_t *mark, int64_t begin, int64_t step, int32_t size)
{
    uint8_t before = 0;
    for (int32_t i = 0; i < size; i++) {
        uint8_t *at = &mark[begin + i * step];
        const uint8_t here = *at & 1;
        if (before | here | (i + 1 < size ? at[step] & 1 : 0))
            *at |= 2;
        before = here;
    }
    for (int32_t i = 0; i < size; i++)
        mark[begin + i * step] = mark[begin + i * step] ? 1 : 0;
}

static ost_status find_outside(ost_uncut *g, ost_error *err)
{
    const cells c = cells_of(g);
    const size_t count = (size_t)c.x * (size_t)c.y * (size_t)c.z;
    uint8_t *mark = calloc(count, 1);
    if (mark)
        mark_bone(g, mark);
    if (!mark || !flood(g, mark)) {
        free(mark);
        return ost_fail(err, OST_ERR_MEMORY, "out of memory to find the outside of the bone");
    }
    for (size_t i = 0; i < count; i++)
        mark[i] &= OPEN;
    for (int64_t i = 0; i < (int64_t)c.y * c.z; i++)
        widen(mark, i * c.x, 1, c.x);
    for (int32_t z = 0; z < c.z; z++)
        for (int32_t x = 0; x < c.x; x++)
            widen(mark, x + (int64_t)c.x * c.y * z, c.x, c.y);
    for (int64_t i = 0; i < (int64_t)c.x * c.y; i++)
        widen(mark, i, (int64_t)c.x * c.y, c.z);
    g->outside = mark;
    return OST_OK;
}

/* ------------------------------------------------------------------- depth */

enum { WIDE = 3 * SIDE, FAR = OST_DEPTH_FAR };

typedef struct distances {
    uint32_t outside[3][3][3][ROWS]; /* words of the block and its 26 neighbours, indexed by [z][y][x] */
    int16_t x[WIDE][WIDE][SIDE], y[WIDE][SIDE][SIDE];
} distances;

static void outside_words(const ost_uncut *g, const int32_t block[3], uint32_t words[ROWS])
{
    const ost_dims d = g->volume.geometry.dims;
    const cells c = cells_of(g);
    memset(words, 0, ROWS * sizeof *words);
    for (int a = 0; a < 3; a++)
        if (block[a] < 0 || SIDE * block[a] >= (a == 0 ? d.x : a == 1 ? d.y : d.z))
            return;
    ost_block_words(&g->volume, block, g->threshold, words);
    for (int z = 0; z < SIDE; z++)
        for (int y = 0; y < SIDE; y++) {
            const int32_t row[2] = {SIDE * block[1] + y, SIDE * block[2] + z};
            uint32_t open = 0;
            for (int x = 0; x < SIDE && row[0] < d.y && row[1] < d.z && SIDE * block[0] + x < d.x; x++)
                open |=
                    (uint32_t)g->outside[(SIDE * block[0] + x) / 2 + c.x * (row[0] / 2 + (int64_t)c.y * (row[1] / 2))]
                    << x;
            words[y + SIDE * z] = ~words[y + SIDE * z] & open;
        }
}

/* Computes, for each voxel of a row, the squared distance along the row to the nearest set bit, at most FAR. The row
   continues in the words `left` and `right`. */
static void along_row(uint32_t left, uint32_t own, uint32_t right, int16_t out[SIDE])
{
    int since = left ? __builtin_clz(left) : SIDE;
    for (int x = 0; x < SIDE; x++) {
        since = own >> x & 1 ? 0 : since + 1;
        out[x] = (int16_t)(since < SIDE ? since * since : FAR);
    }
    since = right ? __builtin_ctz(right) : SIDE;
    for (int x = SIDE - 1; x >= 0; x--) {
        since = own >> x & 1 ? 0 : since + 1;
        const int square = since < SIDE ? since * since : FAR;
        out[x] = (int16_t)(square < out[x] ? square : out[x]);
    }
}

/* Computes out[i], the minimum of line[i + k * count] + k^2 over all |k| < 32. Lines have `count` elements and are
   adjacent in memory. */
static inline void least(const int16_t *restrict line, int16_t *restrict out, int count)
{
    for (int i = 0; i < count; i++)
        out[i] = FAR;
    for (int k = 1 - SIDE; k < SIDE; k++) {
        const int16_t *restrict from = line + (ptrdiff_t)k * count;
        const int16_t square = (int16_t)(k * k);
        for (int i = 0; i < count; i++) {
            const int16_t far = (int16_t)(from[i] + square);
            out[i] = far < out[i] ? far : out[i];
        }
    }
}

ost_status ost_uncut_depth(ost_surface *surface, ost_surface_block *block, ost_error *err)
{
    ost_uncut *g = surface->reference;
    ost_status status = g->outside ? OST_OK : find_outside(g, err);
    if (status != OST_OK)
        return status;
    distances *d = malloc(sizeof *d);
    block->depth = malloc((size_t)SIDE * ROWS * sizeof *block->depth);
    if (!d || !block->depth) {
        free(d);
        free(block->depth);
        block->depth = NULL;
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for depths");
    }
    for (int i = 0; i < 27; i++) {
        const int32_t at[3] = {block->at[0] + i % 3 - 1, block->at[1] + i / 3 % 3 - 1, block->at[2] + i / 9 - 1};
        outside_words(g, at, d->outside[i / 9][i / 3 % 3][i % 3]);
    }
    for (int z = 0; z < WIDE; z++)
        for (int y = 0; y < WIDE; y++) {
            const uint32_t(*const w)[ROWS] = d->outside[z / SIDE][y / SIDE];
            const int row = y % SIDE + SIDE * (z % SIDE);
            along_row(w[0][row], w[1][row], w[2][row], d->x[z][y]);
        }
    for (int z = 0; z < WIDE; z++)
        for (int y = 0; y < SIDE; y++)
            least(d->x[z][y + SIDE], d->y[z][y], SIDE);
    for (int z = 0; z < SIDE; z++) {
        int16_t out[SIDE * SIDE];
        least(d->y[z + SIDE][0], out, SIDE * SIDE);
        for (int i = 0; i < SIDE * SIDE; i++)
            block->depth[i + SIDE * SIDE * z] = (uint16_t)out[i];
    }
    free(d);
    return OST_OK;
}
