/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Checks of the kernels `blocks`, `split`, `match_tables`, `match` and `take`.
 *
 * `blocks` computes the base of a block as the sum of three parts. The parts are random, but their sums lie near one
 * of three kinds of limits: the fraction above which the base is computed by a division, the least and greatest base
 * that a block can have, and the least and greatest base at which the tool reaches the block.
 *
 * `split` may write its lists in any order, so the lists are compared as sets. For this, both lists are sorted by
 * the numbers of the parts, which are all different. The previous content of the lists must not change, and nothing
 * beyond the OST_CUBES_SLACK elements after a list may be written.
 *
 * `match` is tested with bricks that a split classifies as mixed. The bricks lie anywhere in the cells, also at the
 * edges. Half of the bricks are moved so that a voxel lies on a border between tool voxels or a few units from such
 * a border, where the 16-bit sums have ties.
 */
#include <stdlib.h>
#include <string.h>

#include "core/int128.h"
#include "cpu/kernels.h"
#include "simd/check.h"
#include "simd/solids.h"

static const int32_t extremes[] = {INT32_MIN, INT32_MAX, 0, -1};

/* Fills the unused elements after the end of a list with random data. The content of these elements is unspecified. */
static void garbage(check *c, ost_cubes *cubes)
{
    for (size_t i = cubes->count; i < OST_UNIT_BRICKS + OST_CUBES_SLACK; i++) {
        for (int a = 0; a < 3; a++)
            cubes->u[a][i] = check_chance(c, 2) ? extremes[check_range(c, 0, 3)] : (int32_t)rng_next(&c->rng);
        cubes->number[i] = (int32_t)rng_next(&c->rng);
    }
}

/* Chooses `count` different numbers below `limit`, in random or in ascending order. */
static void some_numbers(check *c, int32_t *number, size_t count, int32_t limit)
{
    enum { LIMIT_MAX = 4096 };
    int32_t all[LIMIT_MAX];
    for (int32_t i = 0; i < limit; i++)
        all[i] = i;
    const bool shuffled = check_chance(c, 2);
    for (size_t i = 0; i < count; i++) {
        const size_t j = shuffled ? (size_t)check_range(c, (int64_t)i, limit - 1) : i;
        number[i] = all[j];
        all[j] = all[i];
    }
}

/* ------------------------------------------------------------------- blocks */

typedef struct blocks_arguments {
    const ost_block_bases *bases;
    const ost_block_reach *reach;
    const int32_t *first, *from, *to;
    ost_cubes *blocks;
} blocks_arguments;

static void call_blocks(check_fn *kernel, void *with)
{
    const blocks_arguments *a = with;
    ((ost_blocks_fn *)kernel)(a->bases, a->reach, a->first, a->from, a->to, a->blocks);
}

/*
 * Returns a sum for the three parts of a block's base. A kernel adds a half to it for rounding. The sum may
 * have any value in the ranges of block_base.h and is usually near the border of a range.
 */
static int64_t some_sum(check *c, const ost_block_reach *reach, int a)
{
    const int64_t exists[2] = {-(INT64_C(1) << 29), (INT64_C(1) << 30) + (INT64_C(1) << 29)};
    int64_t base = check_range(c, -(INT64_C(1) << 30), (INT64_C(1) << 31) + 2);
    switch (check_range(c, 0, 4)) {
    case 0:
        base = exists[check_range(c, 0, 1)] + check_range(c, -1, 1);
        break;
    case 1:
        base = reach->from[a] + (check_chance(c, 2) ? 0 : (int64_t)reach->width[a]) + check_range(c, -1, 1);
        break;
    case 2:
        base = check_range(c, reach->from[a], reach->from[a] + (int64_t)reach->width[a] - 1);
        break;
    case 3:
        if (check_chance(c, 4))
            base = check_range(c, -(INT64_C(1) << 44), INT64_C(1) << 44);
        break;
    default:
        break;
    }
    const int64_t fraction = check_chance(c, 8) ? check_range(c, -7, 1) & 0xffff : check_range(c, 0, 0xffff);
    return base * (1 << 16) + fraction - (1 << 15);
}

static void test_blocks(check *c)
{
    enum { MOST = 5 };
    solid s;
    solid_make(c, &s);
    ost_block_bases *bases = check_input(c, "bases", 1, sizeof *bases, _Alignof(ost_block_bases));
    ost_block_reach *reach = check_input(c, "reach", 1, sizeof *reach, _Alignof(ost_block_reach));
    ost_map *map = check_input(c, "map", 1, sizeof *map, _Alignof(ost_map));
    int32_t *first = check_input(c, "first", 3, sizeof *first, sizeof *first),
            *from = check_input(c, "from", 3, sizeof *from, sizeof *from);
    int32_t *to = check_input(c, "to", 3, sizeof *to, sizeof *to);
    *bases = (ost_block_bases){.map = map};
    *reach = ost_block_reach_of(s.step, s.shape.dims);
    for (int b = 0; b < 3; b++) {
        first[b] = 2 * (int32_t)check_range(c, 0, 9);
        from[b] = first[b] + check_chance(c, 4);
        to[b] = first[b] + 2 - (from[b] == first[b] && check_chance(c, 4));
        bases->lo[b] = from[b] - (from[b] > 0 ? (int32_t)check_range(c, 0, 1) : 0);
        bases->count[b] = to[b] - bases->lo[b] + (int32_t)check_range(c, 0, MOST - 3);
        bases->part[b] = check_input(c, "part", 3 * (size_t)bases->count[b], sizeof(int64_t), sizeof(int64_t));
    }
    /*
     * The kernel computes a base from the map if the parts are not exact enough. The map has the same steps
     * as the parts. Its origin is chosen so that the tool reaches the first block.
     */
    const ost_i128 divisor = (ost_i128)1 << 80;
    *map = (ost_map){.divisor = ost_int128_of(divisor)};
    for (int a = 0; a < 3; a++) {
        int64_t base = check_range(c, reach->from[a], reach->from[a] + (int64_t)reach->width[a] - 1);
        for (int b = 0; b < 3; b++) {
            map->step[b][a] = s.step[b][a];
            map->column[b][a] = ost_int128_of(s.step[b][a] * divisor);
            base -= (int64_t)OST_MAP_BLOCK * first[b] * s.step[b][a];
        }
        map->origin[a] = ost_int128_of(base * divisor + check_range(c, -9, 9));
    }
    /*
     * On each axis, some_sum chooses the sum of the first block. A part of another block equals the part of the first
     * block, or differs from it by about 16 steps of the map.
     */
    for (int a = 0; a < 3; a++) {
        const int64_t far = INT64_C(1) << 46, sum = some_sum(c, reach, a), y = check_range(c, -far, far),
                      z = check_range(c, -far, far);
        const int64_t begin[3] = {sum - y - z, y, z};
        for (int b = 0; b < 3; b++)
            for (int32_t i = 0; i < bases->count[b]; i++)
                bases->part[b][3 * i + a] = begin[b] +
                                            (i == from[b] - bases->lo[b] || check_chance(c, 4)
                                                 ? 0
                                                 : (INT64_C(16) << 16) * s.step[b][a] + check_range(c, -3, 3));
    }
    void *blocks[2];
    check_outputs(c, "blocks", 1, sizeof(ost_cubes), _Alignof(ost_cubes), blocks);
    check_note(c, "%s, blocks from %d %d %d to %d %d %d of %d %d %d", s.text, from[0], from[1], from[2], to[0], to[1],
               to[2], first[0], first[1], first[2]);
    blocks_arguments a = {bases, reach, first, from, to, blocks[0]}, b = {bases, reach, first, from, to, blocks[1]};
    if (!check_both(c, call_blocks, &a, &b))
        return;
    const ost_cubes *p = blocks[0], *q = blocks[1];
    if (!check_that(c, p->count == q->count, "the kernel finds %zu blocks, expected %zu", q->count, p->count))
        return;
    for (int i = 0; i < 3; i++) {
        check_same(c, "blocks->u", CHECK_I32, p->u[i], q->u[i], p->count);
        check_same(c, "blocks->u from element 8 on", CHECK_I32, p->u[i] + 8, q->u[i] + 8,
                   OST_UNIT_BRICKS + OST_CUBES_SLACK - 8);
    }
    check_same(c, "blocks->number", CHECK_I32, p->number, q->number, p->count);
    check_same(c, "blocks->number from element 8 on", CHECK_I32, p->number + 8, q->number + 8,
               OST_UNIT_BRICKS + OST_CUBES_SLACK - 8);
}

/* -------------------------------------------------------------------- split */

typedef struct split_arguments {
    const ost_split *split;
    const ost_cells *cells;
    const ost_cubes *cubes;
    const uint64_t *occupancy;
    ost_cubes *mixed;
    ost_numbers *inside;
} split_arguments;

static void call_split(check_fn *kernel, void *with)
{
    const split_arguments *a = with;
    ((ost_split_fn *)kernel)(a->split, a->cells, a->cubes, a->occupancy, a->mixed, a->inside);
}

typedef struct part {
    int32_t number, u[3];
} part;

static int by_number(const void *a, const void *b)
{
    const int32_t x = ((const part *)a)->number, y = ((const part *)b)->number;
    return (x > y) - (x < y);
}

/* Copies the cubes of `mixed` to `out`, and sorts by number the cubes whose index is at least `from`. */
static void listed(const ost_cubes *mixed, size_t from, part *out)
{
    for (size_t i = 0; i < mixed->count; i++)
        out[i] = (part){mixed->number[i], {mixed->u[0][i], mixed->u[1][i], mixed->u[2][i]}};
    qsort(out + from, mixed->count - from, sizeof *out, by_number);
}

static int by_value(const void *a, const void *b)
{
    const int32_t x = *(const int32_t *)a, y = *(const int32_t *)b;
    return (x > y) - (x < y);
}

/* If `near` is true, places cubes around the tool. If not, places them at any positions for which the centres of their
   parts fit in int32. */
static void place_cubes(check *c, const ost_cells *cells, const ost_split *split, bool near, ost_cubes *cubes)
{
    for (int a = 0; a < 3; a++) {
        int64_t least = 0, most = 0; /* least and greatest offset that is added to u */
        for (int p = 0; p < 8; p++) {
            const int64_t lo = split->centre[a][p] < split->first[a][p] ? split->centre[a][p] : split->first[a][p];
            const int64_t hi = split->centre[a][p] > split->first[a][p] ? split->centre[a][p] : split->first[a][p];
            least = lo < least ? lo : least;
            most = hi > most ? hi : most;
        }
        const int64_t lo = INT32_MIN - least, hi = INT32_MAX - most;
        const int64_t from = -((int64_t)cells->margin << cells->shift),
                      to = from + ((int64_t)cells->dims[a] << cells->shift);
        for (size_t i = 0; i < cubes->count; i++) {
            int64_t u = near ? check_range(c, from, to) - split->centre[a][check_range(c, 0, 7)]
                             : check_range(c, lo, hi);
            if (check_chance(c, 8)) /* places a part's centre on the border of a cell, or one unit away */
                u = (check_range(c, -1, cells->dims[a]) - cells->margin) * (INT64_C(1) << cells->shift) -
                    split->centre[a][check_range(c, 0, 7)] + check_range(c, -1, 1);
            else if (check_chance(c, 16))
                u = check_chance(c, 2) ? lo : hi;
            cubes->u[a][i] = (int32_t)(u < lo ? lo : u > hi ? hi : u);
        }
    }
}

static void test_split(check *c)
{
    ost_cells *cells = check_input(c, "cells", 1, sizeof *cells, _Alignof(ost_cells));
    ost_split *split = check_input(c, "split", 1, sizeof *split, _Alignof(ost_split));
    ost_cubes *cubes = check_input(c, "cubes", 1, sizeof *cubes, _Alignof(ost_cubes));
    const bool real = check_chance(c, 2), near = real || check_chance(c, 2);
    const int32_t edge = check_chance(c, 2) ? 16 : 8;
    solid s = {.text = "made up"};
    if (real) {
        solid_make(c, &s);
        *cells = s.shape.cells;
        ost_split_make(s.step, edge, cells, split);
    } else {
        solid_cells(c, cells);
        int32_t step[3][3];
        for (int i = 0; i < 9; i++)
            step[i / 3][i % 3] = (int32_t)check_range(c, -(1 << 24) - 1, (1 << 24) + 1);
        ost_split_make(step, edge, cells, split);
        if (check_chance(c, 2))
            split->least = (int32_t)check_range(c, 1, check_chance(c, 2) ? 128 : 66);
    }
    const int most = edge == 16 ? 8 : 64;
    cubes->count = (size_t)(c->number < 130 ? c->number % (most + 1) : check_range(c, 0, most));
    some_numbers(c, cubes->number, cubes->count, most);
    place_cubes(c, cells, split, near, cubes);
    garbage(c, cubes);

    uint64_t *occupancy = NULL;
    if (check_chance(c, 2)) {
        int32_t last = -1;
        for (size_t i = 0; i < cubes->count; i++)
            last = cubes->number[i] > last ? cubes->number[i] : last;
        const size_t words = 8 * (size_t)(last + 1);
        const int64_t full_in_8 = check_range(c, 0, 8);
        occupancy = check_input(c, "occupancy", words, sizeof *occupancy, sizeof *occupancy);
        for (size_t w = 0; w < words; w++)
            occupancy[w] = check_range(c, 0, 7) >= full_in_8 ? 0
                           : check_chance(c, 2)              ? UINT64_C(1) << check_range(c, 0, 63)
                                                             : rng_next(&c->rng);
    }
    void *mixed[2], *inside[2];
    check_outputs(c, "mixed", 1, sizeof(ost_cubes), _Alignof(ost_cubes), mixed);
    check_outputs(c, "inside", 1, sizeof(ost_numbers), _Alignof(ost_numbers), inside);
    const size_t capacity = OST_UNIT_BRICKS - 8 * cubes->count;
    const size_t mixed_before = check_chance(c, 2) ? 0 : (size_t)check_range(c, 0, (int64_t)capacity);
    const size_t inside_before = check_chance(c, 2) ? 0 : (size_t)check_range(c, 0, (int64_t)capacity);
    split_arguments a[2];
    for (int i = 0; i < 2; i++) {
        ((ost_cubes *)mixed[i])->count = mixed_before;
        ((ost_numbers *)inside[i])->count = inside_before;
        a[i] = (split_arguments){split, cells, cubes, occupancy, mixed[i], inside[i]};
    }
    check_note(c, "%s, %zu cubes of %d, %zu mixed and %zu inside before, least %d", s.text, cubes->count, edge,
               mixed_before, inside_before, split->least);
    if (!check_both(c, call_split, &a[0], &a[1]))
        return;
    ost_cubes *m[2] = {mixed[0], mixed[1]};
    ost_numbers *n[2] = {inside[0], inside[1]};
    if (!check_that(c, m[1]->count == m[0]->count && n[1]->count == n[0]->count,
                    "the kernel finds %zu mixed and %zu inside cubes, expected %zu and %zu", m[1]->count - mixed_before,
                    n[1]->count - inside_before, m[0]->count - mixed_before, n[0]->count - inside_before))
        return;
    static part list[2][OST_UNIT_BRICKS + OST_CUBES_SLACK];
    for (int i = 0; i < 2; i++) {
        listed(m[i], mixed_before, list[i]);
        qsort(n[i]->number + inside_before, n[i]->count - inside_before, sizeof(int32_t), by_value);
    }
    check_same(c, "mixed cubes, each as number, u[0], u[1], u[2]", CHECK_I32, list[0], list[1], 4 * m[0]->count);
    check_same(c, "inside->number", CHECK_I32, n[0]->number, n[1]->number, n[0]->count);
    /* A kernel may write up to the capacity that the contract requires. Beyond it, both buffers must contain poison. */
    const size_t mixed_capacity = mixed_before + 8 * cubes->count + OST_CUBES_SLACK,
                 inside_capacity = inside_before + 8 * cubes->count + OST_CUBES_SLACK;
    const size_t all = OST_UNIT_BRICKS + OST_CUBES_SLACK;
    for (int b = 0; b < 3; b++)
        check_same(c, "mixed->u beyond the capacity", CHECK_I32, m[0]->u[b] + mixed_capacity,
                   m[1]->u[b] + mixed_capacity, all - mixed_capacity);
    check_same(c, "mixed->number beyond the capacity", CHECK_I32, m[0]->number + mixed_capacity,
               m[1]->number + mixed_capacity, all - mixed_capacity);
    check_same(c, "inside->number beyond the capacity", CHECK_I32, n[0]->number + inside_capacity,
               n[1]->number + inside_capacity, all - inside_capacity);
}

/* -------------------------------------------------------------------- match */

typedef struct match_arguments {
    const ost_match *match;
    const ost_cubes *bricks;
    uint64_t *hits;
} match_arguments;

static void call_match(check_fn *kernel, void *with)
{
    const match_arguments *a = with;
    ((ost_match_fn *)kernel)(a->match, a->bricks, a->hits);
}

/*
 * Chooses at most MIXED_MAX random cells, by reservoir sampling, from the cells that a split with this value
 * of `least` (ost_split) classifies as mixed. Returns the number of chosen cells.
 */
enum { MIXED_MAX = 512 };
static size_t mixed_cells(check *c, const ost_cells *cells, int32_t least, int32_t chosen[MIXED_MAX])
{
    const int32_t count = cells->dims[0] * cells->dims[1] * cells->dims[2];
    int32_t found = 0;
    for (int32_t i = 0; i < count; i++) {
        if (cells->value[i] <= -least || cells->value[i] >= least)
            continue;
        const int64_t index = found++ < MIXED_MAX ? found - 1 : check_range(c, 0, found - 1);
        if (index < MIXED_MAX)
            chosen[index] = i;
    }
    return (size_t)(found < MIXED_MAX ? found : MIXED_MAX);
}

/*
 * Reduces the coordinate u of a brick along axis a by less than one tool voxel, so that a voxel of the brick
 * lies on a border between two tool voxels, or at most 200 units from such a border. Returns the new
 * coordinate.
 */
static int32_t on_border(check *c, const ost_match *match, int a, int32_t u)
{
    static const int32_t near_byte[] = {0, -1, 1, 127, -128, 128, -129};
    const int32_t border = check_chance(c, 2) ? near_byte[check_range(c, 0, 6)] : (int32_t)check_range(c, -200, 200);
    const uint32_t sum = (uint32_t)u + (uint32_t)match->offset[a][check_range(c, 0, 63)] - (uint32_t)border;
    return u - (int32_t)(sum & ((1u << OST_MAP_FRACTION) - 1));
}

/*
 * Places bricks so that their centres lie in mixed cells. The distance of a brick's centre from its
 * first voxel is that of part 0 of the split, because the first voxel of part 0 is the first voxel
 * of the cube that is split.
 */
static size_t place_mixed(check *c, const ost_match *match, const ost_split *split, ost_cubes *bricks, size_t count)
{
    const ost_cells *cells = &match->shape->cells;
    const int64_t edge = INT64_C(1) << cells->shift;
    int32_t cell[MIXED_MAX];
    const size_t mixed = mixed_cells(c, cells, split->least, cell);
    for (size_t i = 0; i < count && mixed > 0; i++) {
        const int32_t n = cell[check_range(c, 0, (int64_t)mixed - 1)];
        const int32_t at[3] = {n % cells->dims[0], n / cells->dims[0] % cells->dims[1],
                               n / cells->dims[0] / cells->dims[1]};
        for (int a = 0; a < 3; a++) {
            const int64_t within = check_chance(c, 4) ? 0 : check_chance(c, 4) ? edge - 1 : check_range(c, 0, edge - 1);
            const int64_t begin = (at[a] - cells->margin) * edge - split->centre[a][0];
            int64_t u = begin + within;
            if (check_chance(c, 2)) {
                u = on_border(c, match, a, (int32_t)u);
                u = u < begin ? u + (1 << OST_MAP_FRACTION) : u;
            }
            bricks->u[a][i] = (int32_t)u;
        }
    }
    return mixed > 0 ? count : 0;
}

/* Places bricks at positions for which the coordinates of their voxels fit in int32. Most bricks are near the tool. */
static void place_anywhere(check *c, const ost_match *match, ost_cubes *bricks, size_t count)
{
    for (int a = 0; a < 3; a++) {
        int64_t least = 0, most = 0;
        for (int v = 0; v < 64; v++) {
            least = match->offset[a][v] < least ? match->offset[a][v] : least;
            most = match->offset[a][v] > most ? match->offset[a][v] : most;
        }
        const int64_t lo = INT32_MIN - least, hi = INT32_MAX - most,
                      size = (int64_t)match->shape->dims[a] << OST_MAP_FRACTION;
        for (size_t i = 0; i < count; i++) {
            int64_t u = check_range(c, -most - 2, size - least + 1);
            if (check_chance(c, 3))
                u = on_border(c, match, a, (int32_t)u);
            if (check_chance(c, 16))
                u = check_chance(c, 2) ? lo : hi;
            bricks->u[a][i] = (int32_t)(u < lo ? lo : u > hi ? hi : u);
        }
    }
}

static void call_match_tables(check_fn *kernel, void *with)
{
    ((ost_match_tables_fn *)kernel)(with);
}

/* Returns the set of voxels with a carry along axis a. A voxel has a carry if the sum of `fraction` and the fraction of
   the voxel's offset is at least one tool voxel. */
static uint64_t carries_of(const ost_match *match, int a, uint32_t fraction)
{
    const uint32_t mask = (1 << OST_MAP_FRACTION) - 1;
    uint64_t carries = 0;
    for (int v = 0; v < 64; v++)
        carries |= (uint64_t)((((uint32_t)(match->offset[a][v] - match->lowest[a]) & mask) + fraction) > mask) << v;
    return carries;
}

/* The scalar kernel does not compute the tables in `carries`. Therefore the tables of the other variants are compared
   with their definition (remove.h, "Carries"). */
static void test_match_tables(check *c)
{
    solid s;
    solid_make(c, &s);
    void *both[2];
    check_outputs(c, "match", 1, sizeof(ost_match), _Alignof(ost_match), both);
    for (int i = 0; i < 2; i++)
        ost_match_make(s.step, &s.shape, both[i]);
    const ost_match *match = both[1];
    const ost_carries *carries = &match->carries;
    check_note(c, "%s", s.text);
    if (!(match->windows || match->wide) || !check_both(c, call_match_tables, both[0], both[1]) ||
        c->other == c->scalar)
        return;
    uint8_t whole[3][64];
    for (int a = 0; a < 3; a++) {
        const uint32_t *threshold = carries->threshold[a][0];
        for (int v = 0; v < 64; v++)
            whole[a][v] = (uint8_t)((match->offset[a][v] - match->lowest[a]) >> OST_MAP_FRACTION);
        for (int i = 0; i < 128; i++) {
            uint32_t fraction = (uint32_t)check_range(c, 0, (1 << OST_MAP_FRACTION) - 1);
            if (i < 64) /* exactly a threshold, or one below it */
                fraction = (threshold[i] - (threshold[i] >> OST_MAP_FRACTION | (uint32_t)check_range(c, 0, 1)));
            int rank = 0;
            for (int t = 0; t < 64; t++)
                rank += threshold[t] <= fraction;
            if (!check_that(c, rank < 64 && carries->mask[a][rank] == carries_of(match, a, fraction),
                            "axis %d: the carries of fraction %u, whose rank is %d, are wrong", a, fraction, rank))
                return;
        }
        for (int i = 1; i < 64; i++)
            check_that(c, threshold[16 * (i & 3) + i / 4] >= threshold[16 * ((i - 1) & 3) + (i - 1) / 4],
                       "axis %d: threshold %d is less than the previous threshold", a, i);
    }
    for (int v = 0; match->wide && v < 64; v++)
        check_that(c, carries->wide[0][v] == 16 * whole[1][v] + whole[2][v] && carries->wide[1][v] == whole[0][v],
                   "the tables of the wide window are wrong for voxel %d", v);
    for (int v = 0; match->windows && v < 64; v++) {
        for (int k = 0; k < 3 * s.shape.windows.step; k++)
            check_that(c, carries->row[k][v] == 8 * (whole[1][v] + k % 3) + whole[2][v] + k / 3,
                       "row[%d] is wrong for voxel %d", k, v);
        for (int x = 0; x <= s.shape.windows.step && whole[0][v] + x < 8; x++)
            check_that(c, carries->bit[x][v] == 1 << (whole[0][v] + x), "bit[%d] is wrong for voxel %d", x, v);
    }
}

/* Computes the tables of all instruction sets, so that any kernel can read the tables that it needs. */
static void make_tables(ost_match *match)
{
    if (!match->windows && !match->wide)
        return;
    for (int isa = 0; isa < OST_ISA_COUNT; isa++) {
        ost_cpu_kernels kernels;
        ost_cpu_kernels_fill(&kernels, (ost_isa)isa);
        if (ost_isa_available((ost_isa)isa))
            kernels.match_tables(match);
    }
}

static void test_match(check *c)
{
    solid s;
    solid_make(c, &s);
    ost_shape *shape = check_input(c, "shape", 1, sizeof *shape, _Alignof(ost_shape));
    ost_match *match = check_input(c, "match", 1, sizeof *match, _Alignof(ost_match));
    ost_cubes *bricks = check_input(c, "bricks", 1, sizeof *bricks, _Alignof(ost_cubes));
    *shape = s.shape;
    if (check_chance(c, 8)) /* A shape for larger bone voxels has no windows. */
        shape->windows = shape->wide = (ost_windows){0};
    ost_match_make(s.step, shape, match);
    make_tables(match);
    ost_split split;
    ost_split_make(s.step, 8, &shape->cells, &split);
    const size_t wanted = c->number % 4 == 0 ? (size_t)check_range(c, 0, 20)
                                             : (size_t)check_range(c, 0, check_chance(c, 8) ? 512 : 150);
    bricks->count = wanted;
    if (match->windows || match->wide)
        bricks->count = place_mixed(c, match, &split, bricks, wanted);
    else
        place_anywhere(c, match, bricks, wanted);
    some_numbers(c, bricks->number, bricks->count, OST_UNIT_BRICKS);
    garbage(c, bricks);
    void *hits[2];
    check_outputs(c, "hits", bricks->count + OST_CUBES_SLACK, sizeof(uint64_t), sizeof(uint64_t), hits);
    check_note(c, "%s, %zu bricks, step of windows %d, of wide windows %d", s.text, bricks->count,
               match->windows ? shape->windows.step : 0, match->wide ? shape->wide.step : 0);
    match_arguments a = {match, bricks, hits[0]}, b = {match, bricks, hits[1]};
    if (!check_both(c, call_match, &a, &b) || !check_same(c, "hits", CHECK_BITS, hits[0], hits[1], bricks->count) ||
        !(match->windows || match->wide))
        return;
    /* Without windows, the scalar kernel reads the tool's own voxels. The hits must be the same. */
    static ost_match plain;
    static uint64_t voxels[OST_UNIT_BRICKS + OST_CUBES_SLACK];
    plain = *match;
    plain.windows = plain.wide = false;
    ost_match_scalar(&plain, bricks, voxels);
    check_same(c, "hits from the tool's voxels instead of the windows", CHECK_BITS, voxels, hits[1], bricks->count);
}

/* --------------------------------------------------------------------- take */

typedef struct take_arguments {
    const ost_take *take;
    int16_t *density;
    const int32_t *number;
    const uint64_t *hits;
    size_t count;
    ost_tally tally;
} take_arguments;

static void call_take(check_fn *kernel, void *with)
{
    take_arguments *a = with;
    ((ost_take_fn *)kernel)(a->take, a->density, a->number, a->hits, a->count, &a->tally);
}

static void some_borders(check *c, ost_take *take)
{
    take->borders = (int)check_range(c, 0, check_chance(c, 2) ? 3 : OST_CLASS_MAX - 1);
    const bool wide = check_chance(c, 4); /* true if some borders are outside the range of densities */
    int64_t at = wide ? check_range(c, INT16_MIN, 10) : check_range(c, 0, take->highest / 2 + 1);
    for (int b = 0; b < take->borders; b++) {
        take->border[b] = (int16_t)at;
        at += 1 + (check_chance(c, 3) ? 0 : check_range(c, 0, (wide ? INT16_MAX : take->highest) / OST_CLASS_MAX));
        at = at > INT16_MAX - (OST_CLASS_MAX - b) ? INT16_MAX - (OST_CLASS_MAX - b) : at;
    }
    if (take->borders > 0 && check_chance(c, 4))
        take->border[take->borders - 1] = check_chance(c, 2) ? INT16_MAX
                                                             : (int16_t)(take->highest > take->border[take->borders - 1]
                                                                             ? take->highest
                                                                             : INT16_MAX);
}

static void test_take(check *c)
{
    static const int32_t highest[] = {1, 2, 150, 255, 256, 1000, 8191, 8192, 16383, 16384, 32766, 32767};
    static const size_t counts[] = {0, 1, 2, 15, 16, 17, 511, 512, 513, 1024, 1025, 1100};
    ost_take *take = check_input(c, "take", 1, sizeof *take, _Alignof(ost_take));
    *take = (ost_take){.highest = check_chance(c, 2) ? highest[check_range(c, 0, 11)]
                                                     : (int32_t)check_range(c, 1, 32767),
                       .apply = check_chance(c, 2)};
    some_borders(c, take);
    const size_t count = check_chance(c, 4) ? counts[check_range(c, 0, 11)] : (size_t)check_range(c, 0, 70);
    const int32_t bricks = (int32_t)(count + (size_t)check_range(c, 0, 20));
    int32_t *number = check_input(c, "number", count, sizeof *number, sizeof *number);
    uint64_t *hits = check_input(c, "hits", count, sizeof *hits, sizeof *hits);
    some_numbers(c, number, count, bricks);
    /* 0 if each brick has one hit, 1 if each brick has a random number of hits, 2 if all voxels are hit */
    const int full = (int)check_range(c, 0, 2);
    for (size_t i = 0; i < count; i++)
        hits[i] = full == 2 ? UINT64_MAX : full == 1 ? rng_next(&c->rng) | 1 : UINT64_C(1) << check_range(c, 0, 63);
    const size_t voxels = 64 * (size_t)bricks;
    void *density[2];
    check_outputs(c, "density", voxels, sizeof(int16_t), 64, density);
    int16_t *d = density[0];
    /* 0 if all densities are the maximum, 1 if they are next to class borders, 2 if they are random */
    const int dense = (int)check_range(c, 0, 2);
    for (size_t i = 0; i < voxels; i++) { /* Voxels that are not hit may have any density. */
        int64_t v = dense == 0 ? take->highest : check_range(c, 1, take->highest);
        if (dense == 1 && take->borders > 0)
            v = take->border[check_range(c, 0, take->borders - 1)] - check_range(c, 0, 1);
        d[i] = (int16_t)(v < 1 ? 1 : v > take->highest ? take->highest : v);
    }
    if (check_chance(c, 2)) {
        uint64_t *hit = calloc((size_t)bricks + 1, sizeof *hit);
        for (size_t i = 0; hit && i < count; i++)
            hit[number[i]] = hits[i];
        for (size_t i = 0; hit && i < voxels; i++)
            if (!(hit[i / 64] >> (i % 64) & 1))
                d[i] = check_chance(c, 2) ? INT16_MAX : (int16_t)rng_next(&c->rng);
        free(hit);
    }
    memcpy(density[1], density[0], voxels * sizeof *d);
    take_arguments a = {take, density[0], number, hits, count, {{0}, {0}}};
    /* The tally begins with random values, because the kernel must add to it. */
    for (int i = 0; i < OST_CLASS_MAX; i++) {
        a.tally.voxels[i] = check_chance(c, 2) ? 0 : rng_next(&c->rng) >> 1;
        a.tally.density[i] = check_chance(c, 2) ? 0 : rng_next(&c->rng) >> 1;
    }
    take_arguments b = a;
    b.density = density[1];
    check_note(c, "%zu bricks, highest %d, %d borders, apply %d", count, take->highest, take->borders, take->apply);
    if (!check_both(c, call_take, &a, &b))
        return;
    check_same(c, "density", CHECK_I16, density[0], density[1], voxels);
    check_same(c, "tally->voxels", CHECK_U64, a.tally.voxels, b.tally.voxels, OST_CLASS_MAX);
    check_same(c, "tally->density", CHECK_U64, a.tally.density, b.tally.density, OST_CLASS_MAX);
}

/* -------------------------------------------------------------------- bench */

/* The workload of a benchmark: a ball with a diameter of 48 tool voxels around a unit of 32^3 bone voxels. */
typedef struct scene {
    ost_shape shape;
    ost_split split[2];
    ost_match match;
    ost_cubes blocks, cubes, bricks;
    ost_numbers inside, inside_bricks;
    uint64_t occupancy[OST_UNIT_BRICKS];
    _Alignas(64) uint64_t hits[OST_UNIT_BRICKS + OST_CUBES_SLACK];
} scene;

static scene *scene_make(void)
{
    enum { D = 48 };
    static _Alignas(64) scene s;
    static uint64_t rows[D * D]; /* one word per row */
    const int32_t step[3][3] = {{900000, 300000, 100000}, {-290000, 880000, 210000}, {-30000, -230000, 925000}};
    for (int32_t i = 0; i < D * D * D; i++) {
        const int32_t x = 2 * (i % D) + 1 - D, y = 2 * (i / D % D) + 1 - D, z = 2 * (i / D / D) + 1 - D;
        rows[i / D] |= (uint64_t)(x * x + y * y + z * z < D * D) << (i % D);
    }
    ost_error err = {0};
    if (ost_shape_make(rows, 1, (ost_dims){D, D, D}, 985000, &s.shape, &err) != OST_OK)
        exit(99);
    ost_split_make(step, 16, &s.shape.cells, &s.split[0]);
    ost_split_make(step, 8, &s.shape.cells, &s.split[1]);
    ost_match_make(step, &s.shape, &s.match);
    make_tables(&s.match);
    for (int b = 0; b < 8; b++) {
        for (int a = 0; a < 3; a++)
            s.blocks.u[a][b] = 3 * (1 << 20) +
                               16 * ((b & 1) * step[0][a] + (b >> 1 & 1) * step[1][a] + (b >> 2) * step[2][a]);
        s.blocks.number[b] = b;
    }
    s.blocks.count = 8;
    memset(s.occupancy, 0xff, sizeof s.occupancy);
    ost_split_scalar(&s.split[0], &s.shape.cells, &s.blocks, NULL, &s.cubes, &s.inside);
    ost_split_scalar(&s.split[1], &s.shape.cells, &s.cubes, s.occupancy, &s.bricks, &s.inside_bricks);
    ost_match_scalar(&s.match, &s.bricks, s.hits);
    return &s;
}

static void clear_counts(void *with)
{
    const split_arguments *a = with;
    a->mixed->count = a->inside->count = 0;
}

static void bench_split(check_bench *b)
{
    scene *s = scene_make();
    split_arguments a = {&s->split[1], &s->shape.cells, &s->cubes, s->occupancy, &s->bricks, &s->inside_bricks};
    bench_time(b, "the cubes of a unit into bricks", call_split, clear_counts, &a, 8 * (double)s->cubes.count, "part");
    ost_shape_free(&s->shape);
}

static void bench_match(check_bench *b)
{
    scene *s = scene_make();
    match_arguments a = {&s->match, &s->bricks, s->hits};
    const double count = (double)s->bricks.count;
    bench_time(b, "the mixed bricks of a unit", call_match, NULL, &a, count, "brick");
    s->match.windows = false;
    bench_time(b, "the same without windows", call_match, NULL, &a, count, "brick");
    ost_shape_free(&s->shape);
}

static void bench_take(check_bench *b)
{
    static _Alignas(64) int16_t density[OST_UNIT_BRICKS * 64];
    static int32_t number[OST_UNIT_BRICKS];
    static uint64_t hits[OST_UNIT_BRICKS];
    for (int i = 0; i < OST_UNIT_BRICKS; i++) {
        number[i] = i;
        hits[i] = UINT64_C(0x0f3f7fff37137f01) >> (i % 7) | 1;
        for (int v = 0; v < 64; v++)
            density[64 * i + v] = (int16_t)(120 + (v * i) % 900);
    }
    ost_take take = {.borders = 2, .border = {150, 650}, .highest = 1020};
    take_arguments a = {&take, density, number, hits, 200, {{0}, {0}}};
    bench_time(b, "200 bricks, 3 classes, counted", call_take, NULL, &a, 200, "brick");
    take.apply = true;
    bench_time(b, "the same, taken", call_take, NULL, &a, 200, "brick");
}

CHECK_CPU_SLOT(blocks)
CHECK_CPU_SLOT(split)
CHECK_CPU_SLOT(match_tables)
CHECK_CPU_SLOT(match)
CHECK_CPU_SLOT(take)
extern const check_kernel check_blocks, check_split, check_match_tables, check_match, check_take;
const check_kernel check_blocks = {.name = "blocks", .of = blocks_of, .test = test_blocks, .cases = 1000};
const check_kernel check_split = {
    .name = "split", .of = split_of, .test = test_split, .bench = bench_split, .cases = 1000};
const check_kernel check_match_tables = {
    .name = "match_tables", .of = match_tables_of, .test = test_match_tables, .cases = 300};
const check_kernel check_match = {
    .name = "match", .of = match_of, .test = test_match, .bench = bench_match, .cases = 800};
const check_kernel check_take = {.name = "take", .of = take_of, .test = test_take, .bench = bench_take, .cases = 600};
