/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Checks of the kernels brick_row, any_active and drain, which process rows of voxels and bricks.
 *
 * Densities come from the entire range of int16. Most of them are the threshold, one below the
 * threshold, or an end of the range.
 */
#include "simd/check.h"

#include <string.h>

#include "cpu/bone/bone.h"
#include "cpu/kernels.h"

static int16_t some_threshold(check *c)
{
    static const int16_t special[] = {1, 2, 120, 255, 256, 32766, 32767};
    return check_chance(c, 2) ? special[check_range(c, 0, 6)] : (int16_t)check_range(c, 1, 32767);
}

static int16_t some_density(check *c, int16_t threshold, int64_t active_in_8)
{
    const bool active = check_range(c, 0, 7) < active_in_8;
    switch (check_range(c, 0, 3)) {
    case 0:
        return (int16_t)(threshold - !active);
    case 1:
        return active ? 32767 : (int16_t)-32768;
    case 2:
        return (int16_t)(active ? check_range(c, threshold, 32767) : check_range(c, -32768, threshold - 1));
    default:
        return active ? threshold : 0;
    }
}

/* ---------------------------------------------------------------- brick_row */

typedef struct brick_arguments {
    const int16_t *const *rows;
    size_t bricks;
    int16_t threshold;
    bool stream;
    int16_t *density;
    uint64_t *occupancy;
    ost_brick_sums sums;
} brick_arguments;

static void call_brick_row(check_fn *kernel, void *with)
{
    brick_arguments *a = with;
    a->sums = ((ost_brick_row_fn *)kernel)(a->rows, a->bricks, a->threshold, a->stream, a->density, a->occupancy);
}

static void test_brick_row(check *c)
{
    const size_t bricks = (size_t)4 << check_range(c, 0, 2), width = 4 * bricks;
    const size_t reach = (size_t)ost_brick_spread((int32_t)bricks - 1) + 1;
    const int16_t threshold = some_threshold(c);
    const int64_t active_in_8 = check_range(c, 0, 8);
    const bool same_rows = check_chance(c, 4);
    const int16_t **rows = check_input(c, "rows", 16, sizeof *rows, sizeof *rows);
    for (int r = 0; r < 16; r++) {
        /* A caller passes the same row several times if a chunk extends beyond the grid. */
        if (r > 0 && same_rows && check_chance(c, 2)) {
            rows[r] = rows[r - 1];
            continue;
        }
        int16_t *row = check_input(c, "a row", width, sizeof *row, sizeof *row);
        for (size_t x = 0; x < width; x++)
            row[x] = some_density(c, threshold, active_in_8);
        rows[r] = row;
    }
    void *density[2], *occupancy[2];
    check_outputs(c, "density", reach * OST_BRICK_VOXELS, sizeof(int16_t), 64, density);
    check_outputs(c, "occupancy", reach, sizeof(uint64_t), sizeof(uint64_t), occupancy);
    brick_arguments a[2];
    for (int i = 0; i < 2; i++)
        a[i] = (brick_arguments){rows, bricks, threshold, check_chance(c, 2), density[i], occupancy[i], {0, 0}};
    a[0].stream = a[1].stream;
    check_note(c, "%zu bricks, threshold %d, stream %d", bricks, threshold, a[1].stream);
    if (!check_both(c, call_brick_row, &a[0], &a[1]))
        return;
    check_same(c, "density", CHECK_I16, density[0], density[1], reach * OST_BRICK_VOXELS);
    check_same(c, "occupancy", CHECK_BITS, occupancy[0], occupancy[1], reach);
    check_that(c, a[0].sums.active == a[1].sums.active && a[0].sums.highest == a[1].sums.highest,
               "the kernel returns %d active voxels and the highest density %d; expected %d and %d", a[1].sums.active,
               a[1].sums.highest, a[0].sums.active, a[0].sums.highest);
}

static void bench_brick_row(check_bench *b)
{
    static int16_t voxels[16][64];
    static _Alignas(64) int16_t density[586 * 64];
    static uint64_t occupancy[586];
    const int16_t *rows[16];
    for (int r = 0; r < 16; r++) {
        rows[r] = voxels[r];
        for (int x = 0; x < 64; x++)
            voxels[r][x] = (int16_t)(r * x % 500);
    }
    brick_arguments a = {rows, 8, 120, false, density, occupancy, {0, 0}};
    bench_time(b, "8 bricks of a chunk of 32", call_brick_row, NULL, &a, 512, "voxel");
}

/* --------------------------------------------------------------- any_active */

typedef struct any_arguments {
    const int16_t *base;
    const size_t *row;
    int count, width;
    int16_t threshold;
    bool any;
} any_arguments;

static void call_any_active(check_fn *kernel, void *with)
{
    any_arguments *a = with;
    a->any = ((ost_any_active_fn *)kernel)(a->base, a->row, a->count, a->width, a->threshold);
}

/* The elements between the rows are active, so that reading one element too many changes the result. */
static void test_any_active(check *c)
{
    const int width = c->number < 128 ? c->number % 64 + 1 : (int)check_range(c, 1, 64);
    const int count = check_chance(c, 3) ? 1 : (int)check_range(c, 1, 64);
    const int16_t threshold = some_threshold(c);
    size_t *row = check_input(c, "row", (size_t)count, sizeof *row, sizeof *row),
           at = check_chance(c, 2) ? 0 : (size_t)check_range(c, 0, 9);
    const bool gaps = check_chance(c, 2);
    for (int r = 0; r < count; r++) {
        row[r] = at;
        at += check_chance(c, 8) ? 0 : (size_t)width + (gaps ? (size_t)check_range(c, 0, 40) : 0);
    }
    const size_t size = row[count - 1] + (size_t)width;
    int16_t *base = check_input(c, "base", size, sizeof *base, sizeof *base);
    for (size_t i = 0; i < size; i++)
        base[i] = INT16_MAX;
    for (int r = 0; r < count; r++)
        for (int x = 0; x < width; x++)
            base[row[r] + (size_t)x] = some_density(c, threshold, 0);
    /* 0 if no voxel is active, 1 if one random voxel is active, 2 if only the last voxel is active */
    const int active = (int)check_range(c, 0, 2);
    const int r = active == 2 ? count - 1 : (int)check_range(c, 0, count - 1),
              x = active == 2 ? width - 1 : (int)check_range(c, 0, width - 1);
    if (active)
        base[row[r] + (size_t)x] = some_density(c, threshold, 8) >= threshold && check_chance(c, 2) ? threshold
                                                                                                    : INT16_MAX;
    check_note(c, "%d rows of %d, threshold %d, active: %d (row %d, element %d)", count, width, threshold, active, r,
               x);
    any_arguments a = {base, row, count, width, threshold, false}, b = a;
    if (check_both(c, call_any_active, &a, &b)) {
        check_that(c, a.any == (active != 0), "the scalar kernel returns %d", a.any);
        check_that(c, b.any == a.any, "the kernel returns %d, expected %d", b.any, a.any);
    }
}

static void bench_any_active(check_bench *b)
{
    static int16_t base[32 * 256];
    static size_t row[32];
    for (size_t r = 0; r < 32; r++)
        row[r] = 256 * r + 3;
    any_arguments a = {base, row, 32, 32, 120, false};
    bench_time(b, "32 rows of 32, none active", call_any_active, NULL, &a, 1024, "voxel");
}

/* -------------------------------------------------------------------- drain */

static void call_drain(check_fn *kernel, void *with)
{
    (void)with;
    ((ost_drain_fn *)kernel)();
}

static void test_drain(check *c)
{
    check_note(c, "no inputs");
    check_both(c, call_drain, NULL, NULL);
}

CHECK_CPU_SLOT(brick_row)
CHECK_CPU_SLOT(any_active)
CHECK_CPU_SLOT(drain)
extern const check_kernel check_brick_row, check_any_active, check_drain;
const check_kernel check_brick_row = {
    .name = "brick_row", .of = brick_row_of, .test = test_brick_row, .bench = bench_brick_row, .cases = 500};
const check_kernel check_any_active = {
    .name = "any_active", .of = any_active_of, .test = test_any_active, .bench = bench_any_active, .cases = 1000};
const check_kernel check_drain = {.name = "drain", .of = drain_of, .test = test_drain, .cases = 3};
