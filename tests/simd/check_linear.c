/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Checks of the kernels blend_rows, stretch_row and weigh_rows, with densities and weights at both ends of
 * their ranges. Some sums are ties or next to ties.
 */
#include "simd/check.h"

#include "cpu/kernels.h"

enum { ONE = OST_WEIGHT_ONE };

static int16_t some_density(check *c)
{
    static const int16_t special[] = {INT16_MIN, INT16_MIN + 1, -1, 0, 1, INT16_MAX - 1, INT16_MAX};
    return check_chance(c, 3) ? special[check_range(c, 0, 6)] : (int16_t)check_range(c, INT16_MIN, INT16_MAX);
}

/* Returns a weight. Half of the weights are special values that often cause ties. */
static int some_weight(check *c, int least, int most)
{
    static const int special[] = {0, 1, ONE / 4, ONE / 2 - 1, ONE / 2, ONE / 2 + 1, ONE * 3 / 4, ONE - 1, ONE};
    const int weight = check_chance(c, 2) ? special[check_range(c, 0, 8)] : (int)check_range(c, 0, ONE);
    return weight < least ? least : weight > most ? most : weight;
}

static int up_to_16(int width)
{
    return (width + 15) / 16 * 16;
}

/* --------------------------------------------------------------- blend_rows */

typedef struct blend_arguments {
    const int16_t *a, *b;
    const size_t *row;
    int count, width, weight;
    int16_t *to;
} blend_arguments;

static void call_blend_rows(check_fn *kernel, void *with)
{
    blend_arguments *a = with;
    ((ost_blend_rows_fn *)kernel)(a->a, a->b, a->row, a->count, a->width, a->weight, a->to);
}

static void test_blend_rows(check *c)
{
    const int width = c->number < 128 ? c->number % 64 + 1 : (int)check_range(c, 1, 64);
    const int count = (int)check_range(c, 0, 6), weight = some_weight(c, 1, ONE - 1);
    size_t *row = check_input(c, "row", (size_t)count, sizeof *row, sizeof *row), size = 0;
    for (int r = 0; r < count; r++) {
        row[r] = r > 0 && check_chance(c, 8) ? row[r - 1] : size + (size_t)check_range(c, 0, 40);
        size = row[r] + (size_t)width;
    }
    int16_t *from[2];
    for (int s = 0; s < 2; s++) {
        from[s] = check_input(c, s ? "b" : "a", size, sizeof *from[s], sizeof *from[s]);
        for (size_t i = 0; i < size; i++)
            from[s][i] = some_density(c);
    }
    /* The elements between the rows must not be written. */
    const size_t capacity = count > 0 ? (size_t)OST_ROW_STRIDE * (size_t)(count - 1) + (size_t)width : 0;
    void *to[2];
    check_outputs(c, "to", capacity, sizeof(int16_t), sizeof(int16_t), to);
    check_note(c, "%d rows of %d, weight %d", count, width, weight);
    blend_arguments a = {from[0], from[1], row, count, width, weight, to[0]}, b = a;
    b.to = to[1];
    if (check_both(c, call_blend_rows, &a, &b))
        check_same(c, "to", CHECK_I16, to[0], to[1], capacity);
}

static void bench_blend_rows(check_bench *b)
{
    static int16_t from[2][4 * 256], to[4 * OST_ROW_STRIDE];
    static const size_t row[4] = {3, 259, 515, 771};
    for (int i = 0; i < 4 * 256; i++) {
        from[0][i] = (int16_t)(i * 7919);
        from[1][i] = (int16_t)(i * 104729);
    }
    blend_arguments a = {from[0], from[1], row, 4, 32, 12345, to};
    bench_time(b, "4 rows of 32", call_blend_rows, NULL, &a, 128, "voxel");
}

/* -------------------------------------------------------------- stretch_row */

typedef struct stretch_arguments {
    const int16_t *from;
    const int32_t *at;
    const int16_t *minus;
    int width;
    int32_t *to;
} stretch_arguments;

static void call_stretch_row(check_fn *kernel, void *with)
{
    stretch_arguments *a = with;
    ((ost_stretch_row_fn *)kernel)(a->from, a->at, a->minus, a->width, a->to);
}

/*
 * Fills the array `at` with ascending positions. Either their steps are constant and fractional, as in
 * resampling, or most steps are 1 and a few are up to 40, so that neighbouring positions can be more than a
 * register apart.
 */
static void make_places(check *c, int32_t *at, int width)
{
    const int64_t first = check_chance(c, 2) ? 0 : check_range(c, 0, 300),
                  step = check_range(c, 1, check_chance(c, 2) ? 1500 : 6000);
    const bool leaps = check_chance(c, 3);
    for (int i = 0; i < width; i++)
        at[i] = !leaps || i == 0 ? (int32_t)(first + i * step / 1000)
                                 : at[i - 1] + (check_chance(c, 12) ? (int32_t)check_range(c, 0, 40) : 1);
    for (int i = width; i < up_to_16(width); i++)
        at[i] = (int32_t)check_range(c, INT32_MIN, INT32_MAX);
}

static void test_stretch_row(check *c)
{
    const int width = c->number < 128 ? c->number % 64 + 1 : (int)check_range(c, 1, 64), capacity = up_to_16(width);
    int32_t *at = check_input(c, "at", (size_t)capacity, sizeof *at, sizeof *at);
    int16_t *minus = check_input(c, "minus", 2 * (size_t)capacity, sizeof *minus, sizeof *minus);
    make_places(c, at, width);
    for (int i = 0; i < capacity; i++) {
        const int weight = some_weight(c, 0, ONE);
        minus[2 * i] = (int16_t)(weight - ONE);
        minus[2 * i + 1] = (int16_t)-weight;
    }
    const size_t reach = (size_t)at[width - 1] + 2;
    int16_t *from = check_input(c, "from", reach, sizeof *from, sizeof *from);
    for (size_t i = 0; i < reach; i++)
        from[i] = some_density(c);
    void *to[2];
    check_outputs(c, "to", (size_t)capacity, sizeof(int32_t), sizeof(int32_t), to);
    check_note(c, "%d sums of %zu voxels", width, reach);
    stretch_arguments a = {from, at, minus, width, to[0]}, b = a;
    b.to = to[1];
    if (check_both(c, call_stretch_row, &a, &b))
        check_same(c, "to", CHECK_I32, to[0], to[1], (size_t)width);
}

static void bench_stretch_row(check_bench *b)
{
    static int16_t from[256], minus[64];
    static int32_t at[32], to[32];
    for (int32_t i = 0; i < 32; i++) {
        at[i] = i * 5 / 8;
        minus[2 * i] = (int16_t)(i * 1000 - ONE);
        minus[2 * i + 1] = (int16_t)(-i * 1000);
    }
    stretch_arguments a = {from, at, minus, 32, to};
    bench_time(b, "32 sums of 21 voxels", call_stretch_row, NULL, &a, 32, "sum");
}

/* --------------------------------------------------------------- weigh_rows */

typedef struct weigh_arguments {
    const int32_t *const *rows;
    const int32_t *weight;
    int count, width;
    int16_t *to;
} weigh_arguments;

static void call_weigh_rows(check_fn *kernel, void *with)
{
    weigh_arguments *a = with;
    ((ost_weigh_rows_fn *)kernel)(a->rows, a->weight, a->count, a->width, a->to);
}

/* Returns a sum as stretch_row computes it, or the negative of such a sum. */
static int32_t some_sum(check *c, int sign)
{
    const int weight = some_weight(c, 0, ONE);
    return -sign * (some_density(c) * (ONE - weight) + some_density(c) * weight);
}

/*
 * Changes element i of the rows so that the weighted sum of the rows differs from a tie by at most 2. An
 * element that would leave its range is not changed.
 */
static void make_tie(check *c, int32_t *const rows[4], const int32_t weight[4], int count, int i)
{
    const int64_t unit = INT64_C(1) << 3 * OST_WEIGHT_BITS;
    int64_t sum = 0;
    for (int r = 0; r < count; r++)
        sum += (int64_t)rows[r][i] * weight[r];
    int64_t off = unit / 2 + check_range(c, -2, 2) - (sum & (unit - 1));
    for (int r = 0; r < count; r++) {
        const int64_t by = weight[r] ? off / weight[r] : 0;
        if (rows[r][i] + by > ONE * ONE || rows[r][i] + by < -ONE * ONE)
            continue;
        rows[r][i] += (int32_t)by;
        off -= by * weight[r];
    }
}

static void test_weigh_rows(check *c)
{
    const int width = c->number < 128 ? c->number % 64 + 1 : (int)check_range(c, 1, 64), capacity = up_to_16(width);
    const bool ties = check_chance(c, 2); /* if true, make_tie moves sums close to ties; this requires small weights */
    const int count = 1 << check_range(c, 0, 2), sign = check_chance(c, 4) ? -1 : 1;
    const int y = ties ? (int)check_range(c, 1, 8) : some_weight(c, 0, ONE),
              z = ties ? (int)check_range(c, 1, 8) : some_weight(c, 0, ONE);
    int32_t *weight = check_input(c, "weight", 4, sizeof *weight, sizeof *weight);
    for (int r = 0; r < 4; r++) {
        const int wy = count < 2 ? (r ? 0 : ONE)
                       : r % 2   ? y
                                 : ONE - y,
                  wz = count < 4 ? (r / 2 ? 0 : ONE)
                       : r / 2   ? z
                                 : ONE - z;
        weight[r] = -sign * wy * wz;
    }
    int32_t **rows = check_input(c, "rows", 4, sizeof *rows, sizeof *rows);
    for (int r = 0; r < count; r++) {
        int32_t *row = check_input(c, "a row", (size_t)capacity, sizeof *row, sizeof *row);
        for (int i = 0; i < capacity; i++)
            row[i] = i < width ? some_sum(c, sign) : (int32_t)check_range(c, INT32_MIN, INT32_MAX);
        rows[r] = row;
    }
    for (int i = 0; i < width && ties; i++)
        make_tie(c, rows, weight, count, i);
    void *to[2];
    check_outputs(c, "to", (size_t)capacity, sizeof(int16_t), sizeof(int16_t), to);
    check_note(c, "%d sums of %d rows, weights %d %d %d %d", width, count, (int)weight[0], (int)weight[1],
               (int)weight[2], (int)weight[3]);
    weigh_arguments a = {(const int32_t *const *)rows, weight, count, width, to[0]}, b = a;
    b.to = to[1];
    if (check_both(c, call_weigh_rows, &a, &b))
        check_same(c, "to", CHECK_I16, to[0], to[1], (size_t)width);
}

static void bench_weigh_rows(check_bench *b)
{
    static int32_t sums[4][32];
    static int16_t to[32];
    static const int32_t weight[4] = {-(ONE / 4) * (ONE / 8), -(ONE / 4) * (ONE / 8 * 7), -(ONE / 4 * 3) * (ONE / 8),
                                      -(ONE / 4 * 3) * (ONE / 8 * 7)};
    const int32_t *rows[4];
    for (int r = 0; r < 4; r++) {
        rows[r] = sums[r];
        for (int i = 0; i < 32; i++)
            sums[r][i] = (i - 16) * 1000 * (r + 1);
    }
    weigh_arguments a = {rows, weight, 4, 32, to};
    bench_time(b, "32 voxels of 4 rows", call_weigh_rows, NULL, &a, 32, "voxel");
    a.count = 2;
    bench_time(b, "32 voxels of 2 rows", call_weigh_rows, NULL, &a, 32, "voxel");
}

CHECK_CPU_SLOT(blend_rows)
CHECK_CPU_SLOT(stretch_row)
CHECK_CPU_SLOT(weigh_rows)
extern const check_kernel check_blend_rows, check_stretch_row, check_weigh_rows;
const check_kernel check_blend_rows = {
    .name = "blend_rows", .of = blend_rows_of, .test = test_blend_rows, .bench = bench_blend_rows, .cases = 800};
const check_kernel check_stretch_row = {
    .name = "stretch_row", .of = stretch_row_of, .test = test_stretch_row, .bench = bench_stretch_row, .cases = 1000};
const check_kernel check_weigh_rows = {
    .name = "weigh_rows", .of = weigh_rows_of, .test = test_weigh_rows, .bench = bench_weigh_rows, .cases = 800};
