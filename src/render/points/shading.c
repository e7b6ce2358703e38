/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The smoothing is a weighted sum over nine neighbours on each axis (smooth.h). It is computed slice by slice, so that
 * all data stay in the first-level cache:
 *
 *            z, y: -5 .. 36      x: -8 .. 39; the outermost entries are used only as neighbours
 *   bone    [42][42][48]   0 .. 63
 *     y     [42][34][48]   0 .. 63 * 25
 *     z     [34][34][48]   0 .. 63 * 625 = 39375, then a sixteenth of it, rounded
 *     x     [34][34][34]   0 .. 2461 * 25 = 61525
 *
 * Only the rows on which stale points depend are computed. The wide field is computed in the same way for cells of 2^3
 * voxels, from -5 to 20, and then interpolated to voxels with the weights 3 : 1 (smooth.c). A block keeps its cells for
 * the shading of its neighbours.
 *
 * The wide field at a point depends on voxels at most 11 voxels away: 1 for the slope, 2 for the interpolation between
 * cells, and 8 for the sum, which reaches over four cells.
 *
 * Without a CT, a voxel contains either 0 % or 100 % bone. With a CT, a bone voxel contains 25 % to 100 % bone,
 * depending on its density, because a border voxel that is half filled with bone has half the density. Within three
 * voxels of a cut, a bone voxel always counts as 100 % bone, because inside the bone, the density does not indicate the
 * amount of bone.
 */
#include "render/points/shading.h"

#include <stdlib.h>
#include <string.h>

#include "core/conditions.h"
#include "render/points/uncut.h"

enum {
    SIDE = OST_BLOCK,
    REACH = OST_FIELD_REACH,
    NEAR = OST_NEAR_REACH,
    INNER = OST_FIELD_ROWS,     /* number of rows of the field */
    LINE = OST_FIELD_LINE, LEFT = 8, /* the first entry of a line is at x = -LEFT */
    NINE = 9, THREE = 3,
    CELLS = OST_CELLS,
    ROWS_BEFORE = OST_SHADING_REACH, /* index in ost_rows of row 0 of the block */
};

_Static_assert((int)OST_WIDE_REACH + (int)NEAR == (int)OST_SHADING_REACH, "blocks so far from a change are made anew");

static const uint32_t *before_of(const ost_surface_block *b) { return b->before; }
static const uint32_t *occupied_of(const ost_surface_block *b) { return b->occupied; }
static const uint32_t *fresh_of(const ost_surface_block *b) { return b->fresh; }
static const uint32_t *recent_of(const ost_surface_block *b) { return b->recent; }

/* ------------------------------------------------------------------- field */

/* Computes k->near, the voxels near removed voxels. Returns false, with k->near undefined, if no voxel was removed. */
static bool find_near(const ost_surface *s, const ost_surface_block *b, ost_shading_scratch *k)
{
    uint64_t any = 0;
    if (!ost_surface_rows(s, b, before_of, &k->rows, &k->near))
        return false;
    for (int z = 0; z < OST_SEEN; z++)
        for (int y = 0; y < OST_SEEN; y++)
            any |= k->near.row[z][y] &= ~k->occupied.row[z][y];
    if (any)
        k->rows.spread(&k->near, &k->other, NEAR);
    return any != 0;
}

/* Returns a line of a row: the LINE voxels from index `first` on. The row has `size` voxels. Elements outside the row
   are OST_FIELD_DENSE, which is never used because there is no bone outside the row. */
static const int16_t *line_of(const int16_t *voxels, int first, int size, int16_t copy[LINE])
{
    if (first >= 0 && first + LINE <= size)
        return voxels + first;
    for (int i = 0; i < LINE; i++)
        copy[i] = first + i >= 0 && first + i < size ? voxels[first + i] : OST_FIELD_DENSE;
    return copy;
}

/*
 * Computes the amounts of bone in slice z, from row `first` to row `last`; slices and rows are counted from -REACH.
 * Densities are read only where they are needed, because their rows are far apart in memory.
 */
static void measure(const ost_surface *s, const ost_surface_block *b, ost_shading_scratch *k, bool cut, int z,
                    int first, int last, uint16_t (*out)[LINE])
{
    enum { MORE = ROWS_BEFORE - REACH };
    const uint64_t line = ((UINT64_C(1) << LINE) - 1) << LEFT;
    const ost_uncut *g = s->reference;
    const ost_dims d = s->geometry.dims;
    const uint64_t *occupied = k->occupied.row[z + MORE] + MORE;
    const int32_t at_z = SIDE * b->at[2] + z - REACH;
    k->smooth.bits(occupied + first, last - first + 1, out);
    for (int y = first; y <= last && g && at_z >= 0 && at_z < d.z; y++) {
        const int32_t at_y = SIDE * b->at[1] + y - REACH;
        const uint64_t near = cut ? k->near.row[z + MORE][y + MORE] : 0;
        int16_t copy[LINE];
        if (occupied[y] & ~near & line && at_y >= 0 && at_y < d.y)
            k->smooth.densities(occupied[y], near,
                                line_of(g->volume.voxels + (size_t)d.x * ((size_t)at_y + (size_t)d.y * (size_t)at_z),
                                        SIDE * b->at[0] - LEFT, d.x, copy),
                                out[y - first]);
    }
}

/* ------------------------------------------------------------------- cells */

/* Finds the rows of cells that may have changed. Row y of slice z is bit y of rows[z]. */
static void find_unmeasured(const ost_surface *s, const ost_surface_block *b, uint32_t rows[CELLS])
{
    uint64_t changes[OST_SEEN];
    const bool changed = !b->remade && ost_surface_changes(s, b, NEAR, changes);
    memset(rows, b->remade ? 0xff : 0, CELLS * sizeof *rows);
    for (int z = 0; z < SIDE && changed; z++)
        for (int y = 0; y < SIDE; y++)
            rows[z / 2] |= (uint32_t)(changes[z + ROWS_BEFORE] >> (y + ROWS_BEFORE) & 1) << y / 2;
}

void ost_surface_measure(const ost_surface *s, ost_surface_block *b, ost_shading_scratch *k)
{
    enum { PAIR = 2 };
    uint32_t rows[CELLS];
    uint16_t(*below)[LINE] = k->bone, (*above)[LINE] = k->y[0];
    find_unmeasured(s, b, rows);
    ost_surface_rows(s, b, occupied_of, &k->rows, &k->occupied);
    const bool cut = s->reference && find_near(s, b, k);
    for (int z = 0; z < CELLS; z++)
        for (int y = 0; y < CELLS; y++) {
            if (!(rows[z] >> y & 1))
                continue;
            const int first = REACH + PAIR * y;
            measure(s, b, k, cut, REACH + PAIR * z, first, first + 1, below);
            measure(s, b, k, cut, REACH + PAIR * z + 1, first, first + 1, above);
            k->smooth.cells((const uint16_t(*)[LINE])below, (const uint16_t(*)[LINE])above,
                            b->cells + CELLS * (y + CELLS * z));
        }
    b->unmeasured = false;
}

/* The cells of the block and its 26 neighbours, indexed by [z][y][x]. */
typedef const uint8_t *cells_about[3][3][3];

static void find_cells(const ost_surface *s, const ost_surface_block *b, cells_about out)
{
    static const uint8_t none[sizeof b->cells];
    for (int i = 0; i < 27; i++) {
        const ost_surface_block *n = ost_surface_block_at(s, b->at[0] + i % 3 - 1, b->at[1] + i / 3 % 3 - 1,
                                                          b->at[2] + i / 9 - 1);
        out[i / 9][i / 3 % 3][i % 3] = n ? n->cells : none;
    }
}

/* Finds the rows of cells from which the needed rows of the wide field are interpolated. On each axis, a row of the
   field needs the two nearest rows of cells. */
static void find_needed_cells(const uint64_t needed[INNER], uint64_t cells[INNER])
{
    memset(cells, 0, INNER * sizeof *cells);
    for (int z = 0; z < INNER; z++)
        for (uint64_t left = needed[z]; left; left &= left - 1) {
            const uint64_t both = UINT64_C(3) << __builtin_ctzll(left) / 2;
            cells[z / 2] |= both;
            cells[z / 2 + 1] |= both;
        }
}

/* Finds the rows of the field on which the stale rows of the block depend. Row y of slice z is bit y + 1 of needed[z
   + 1]. */
static void find_needed(const uint32_t stale[SIDE], uint64_t needed[INNER])
{
    memset(needed, 0, INNER * sizeof *needed);
    for (int z = 0; z < SIDE; z++) {
        const uint64_t rows = (uint64_t)stale[z] << 1;
        needed[z] |= rows;
        needed[z + 1] |= rows | rows << 1 | rows >> 1;
        needed[z + 2] |= rows;
    }
}

/*
 * Finds the first and the last sum along y that are needed in slice z of the bone. Sum i covers the nine rows from row
 * i on. Slices and rows of the bone are counted from -REACH.
 */
static void rows_needed(int z, const uint64_t needed[INNER], int *first, int *last)
{
    uint64_t rows = 0;
    for (int i = z - (NINE - 1) < 0 ? 0 : z - (NINE - 1); i <= z && i < INNER; i++)
        rows |= needed[i];
    *first = __builtin_ctzll(rows);
    *last = 63 - __builtin_clzll(rows);
}

static void add_slice(const ost_surface *s, const ost_surface_block *b, ost_shading_scratch *k, bool cut, int z,
                      const uint64_t needed[INNER])
{
    int first, last;
    rows_needed(z, needed, &first, &last);
    measure(s, b, k, cut, z, first, last + NINE - 1, k->bone + first);
    k->smooth.down((const uint16_t(*)[LINE])k->bone + first, k->y[z % NINE] + first, last - first + 1);
}

/* Computes slice z of the sums along y for cells, as add_slice does for voxels. */
static void add_cells(cells_about about, ost_shading_scratch *k, int z, const uint64_t needed[INNER])
{
    int first, last;
    const int at = z - REACH, slice = CELLS * CELLS * (at & (CELLS - 1));
    const uint8_t *const(*n)[3] = about[(at >= 0) + (at >= CELLS)];
    rows_needed(z, needed, &first, &last);
    for (int y = first; y < last + NINE;) {
        const int row = y - REACH,
                  end = row < 0       ? REACH
                        : row < CELLS ? REACH + CELLS
                                      : CELLS + 2 * REACH,
                  stop = end < last + NINE ? end : last + NINE;
        const int from = slice + CELLS * (row & (CELLS - 1)), which = (row >= 0) + (row >= CELLS);
        k->smooth.lines(n[which][0] + from, n[which][1] + from, n[which][2] + from, stop - y, k->cells + y);
        y = stop;
    }
    k->smooth.down((const uint16_t(*)[LINE])k->cells + first, k->cells_y[z % NINE] + first, last - first + 1);
}

/*
 * Computes slice z of the wide field. *made is the number of slices of cells whose sums along y have been computed, and
 * *smoothed is the number of completely smoothed slices of cells. Both numbers include slices that were skipped because
 * they are not needed.
 */
static void widen(cells_about about, ost_shading_scratch *k, int z, const uint64_t needed[INNER],
                  const uint64_t cells[INNER], int *made, int *smoothed)
{
    for (int c = *smoothed > z / 2 ? *smoothed : z / 2; c <= z / 2 + 1; c++) {
        const ost_field_slice *y[NINE];
        for (*made = *made > c ? *made : c; *made < c + NINE; ++*made)
            add_cells(about, k, *made, cells);
        for (int i = 0; i < NINE; i++)
            y[i] = &k->cells_y[(c + i) % NINE];
        k->smooth.slice(y, cells[c], &k->cells_field[c % THREE]);
        *smoothed = c + 1;
    }
    const ost_field_slice *const both[2] = {&k->cells_field[z / 2 % THREE], &k->cells_field[(z / 2 + 1) % THREE]};
    k->smooth.finer(both, z % 2, needed[z], &k->wide[z % THREE]);
}

/* Computes the shades of the points of slice z that are in stale rows. */
static void select_slices(const uint32_t *points, ost_shading_scratch *k, int z)
{
    const ost_field_slice *const fine[3] = {&k->field[z % THREE], &k->field[(z + 1) % THREE],
                                            &k->field[(z + 2) % THREE]};
    const ost_field_slice *const wide[3] = {&k->wide[z % THREE], &k->wide[(z + 1) % THREE], &k->wide[(z + 2) % THREE]};
    const uint16_t *begin = k->faces.begin + SIDE * z;
    for (uint64_t left = k->stale[z]; left;) {
        const int from = __builtin_ctzll(left), to = from + __builtin_ctzll(~(left >> from));
        k->smooth.shades(points + begin[from], begin[to] - begin[from], fine, wide, k->shades + begin[from]);
        left = to < SIDE ? left >> to << to : 0;
    }
}

static void shade_points(const ost_surface *s, const ost_surface_block *b, const uint32_t *points,
                         ost_shading_scratch *k)
{
    uint64_t needed[INNER], cells[INNER];
    cells_about about;
    /*
     * made: number of slices of sums along y that have been computed or skipped so far. The other two variables are
     * described at widen()
     */
    int made = 0, cells_made = 0, cells_smoothed = 0;
    ost_surface_rows(s, b, occupied_of, &k->rows, &k->occupied);
    const bool cut = s->reference && find_near(s, b, k);
    find_needed(k->stale, needed);
    find_needed_cells(needed, cells);
    find_cells(s, b, about);
    for (int z = 0; z < INNER; z++) {
        if (!needed[z])
            continue;
        const ost_field_slice *y[NINE];
        for (made = made > z ? made : z; made < z + NINE; made++)
            add_slice(s, b, k, cut, made, needed);
        for (int i = 0; i < NINE; i++)
            y[i] = &k->y[(z + i) % NINE];
        k->smooth.slice(y, needed[z], &k->field[z % THREE]);
        widen(about, k, z, needed, cells, &cells_made, &cells_smoothed);
        if (z >= 2 && k->stale[z - 2])
            select_slices(points, k, z - 2);
    }
}

/* ------------------------------------------------------------------- paint */

/* Finds the voxels that have an exposed face at which the neighbour is in a set of bits. `which` selects the set. */
static bool find_beyond(const ost_surface *s, const ost_surface_block *b, ost_words_of *which, ost_shading_scratch *k,
                        uint32_t out[OST_BLOCK_ROWS])
{
    const bool any = ost_surface_rim(s, b, which, &k->rim);
    if (any)
        k->rows.behind(&k->rim, &k->faces, out);
    else
        memset(out, 0, OST_BLOCK_ROWS * sizeof *out);
    return any;
}

static uint32_t any_of(const uint32_t words[OST_BLOCK_ROWS])
{
    uint32_t any = 0;
    for (int row = 0; row < OST_BLOCK_ROWS; row++)
        any |= words[row];
    return any;
}

void ost_surface_find_marked(const ost_surface *s, const ost_surface_block *b, ost_shading_scratch *k)
{
    uint32_t recent[OST_BLOCK_ROWS];
    memset(k->cap, 0, sizeof k->cap);
    memset(k->contact, 0, sizeof k->contact);
    if (s->clipped)
        find_beyond(s, b, occupied_of, k, k->cap);
    if (s->any_fresh)
        find_beyond(s, b, fresh_of, k, k->contact);
    if (s->any_recent && find_beyond(s, b, recent_of, k, recent))
        for (int row = 0; row < OST_BLOCK_ROWS; row++)
            k->contact[row] |= recent[row];
    if (s->clipped) /* the clip plane removes no bone, so voxels that it exposes are not in contact */
        for (int row = 0; row < OST_BLOCK_ROWS; row++)
            k->contact[row] &= ~k->cap[row];
}

/* Computes k->bared, the voxels exposed by a tool. If a removed voxel is adjacent to a point of the block, also
   computes the depths of the block. */
static ost_status find_bared(ost_surface *s, ost_surface_block *b, ost_shading_scratch *k, ost_error *err)
{
    if (!s->reference || s->colouring == OST_COLOUR_BONE) {
        memset(k->bared, 0, sizeof k->bared);
        return OST_OK;
    }
    find_beyond(s, b, before_of, k, k->bared);
    ost_status status = OST_OK;
    if (s->colouring == OST_COLOUR_DEPTH && !b->depth && any_of(k->bared))
        status = ost_uncut_depth(s, b, err);
    if (s->reference->uncut)
        memcpy(k->bared, k->faces.any, sizeof k->bared);
    return status;
}

static void paint_row(const ost_surface *s, const ost_surface_block *b, const uint32_t *points, ost_shading_scratch *k,
                      int row)
{
    for (uint32_t i = k->faces.begin[row]; i < k->faces.begin[row + 1]; i++) {
        const uint32_t x = points[i] & (SIDE - 1), cell = x | (uint32_t)row << 5;
        const int32_t at[3] = {SIDE * b->at[0] + (int32_t)x, SIDE * b->at[1] + row % SIDE,
                               SIDE * b->at[2] + row / SIDE};
        if (k->cap[row] >> x & 1)
            k->shades[i] |= ost_uncut_cap(s->reference, (ost_colouring)s->colouring, at) << OST_PAINT_SHIFT;
        else if (k->bared[row] >> x & 1)
            k->shades[i] |= ost_uncut_paint(s->reference, (ost_colouring)s->colouring, at,
                                            b->depth ? b->depth[cell] : 0)
                            << OST_PAINT_SHIFT;
    }
}

/* ------------------------------------------------------------------- block */

ost_status ost_surface_shade(ost_surface *surface, ost_surface_block *block, const uint32_t *points,
                             ost_shading_scratch *scratch, ost_error *err)
{
    ost_status status = find_bared(surface, block, scratch, err);
    if (status != OST_OK)
        return status;
    shade_points(surface, block, points, scratch);
    for (int row = 0; row < OST_BLOCK_ROWS; row++)
        if (scratch->stale[row / SIDE] >> row % SIDE & 1 && (scratch->cap[row] | scratch->bared[row]))
            paint_row(surface, block, points, scratch, row);
    return OST_OK;
}
