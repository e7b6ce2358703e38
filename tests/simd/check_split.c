/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Checks of the kernels `blocks` and `split`.
 *
 * `blocks` computes the base of a block as the sum of three parts. The parts are random, but their sums lie near one of
 * three kinds of limits: the fraction above which the base is computed by a division, the least and greatest base that
 * a block can have, and the least and greatest base at which the tool reaches the block.
 *
 * `split` may write its lists in any order, so both lists are sorted by part number before they are compared. No two
 * parts have the same number. The previous content of the lists must not change, and nothing beyond the OST_CUBES_SLACK
 * elements after a list may be written.
 */
#include "core/int128.h"
#include "simd/remove_cases.h"

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

CHECK_CPU_SLOT(blocks)
CHECK_CPU_SLOT(split)
extern const check_kernel check_blocks, check_split;
const check_kernel check_blocks = {.name = "blocks", .of = blocks_of, .test = test_blocks, .cases = 1000};
const check_kernel check_split = {
    .name = "split", .of = split_of, .test = test_split, .bench = bench_split, .cases = 1000};
