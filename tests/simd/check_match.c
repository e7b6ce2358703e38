/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Checks of the kernels `match_tables` and `match`.
 *
 * `match` is tested with bricks that a split classifies as mixed. The bricks lie anywhere in the cells, also at the
 * edges. Half of the bricks are moved so that a voxel lies on a border between tool voxels or a few units from such a
 * border, where the 16-bit sums have ties.
 */
#include "simd/remove_cases.h"

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
 * Places bricks so that their centres lie in mixed cells. split->centre[a][0] is the distance from a
 * brick's first voxel to its centre, because part 0 begins at the first voxel of the split cube.
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

CHECK_CPU_SLOT(match_tables)
CHECK_CPU_SLOT(match)
extern const check_kernel check_match_tables, check_match;
const check_kernel check_match_tables = {
    .name = "match_tables", .of = match_tables_of, .test = test_match_tables, .cases = 300};
const check_kernel check_match = {
    .name = "match", .of = match_of, .test = test_match, .bench = bench_match, .cases = 800};
