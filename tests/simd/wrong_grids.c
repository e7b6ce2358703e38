/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Defines wrong variants of the kernels for grids and for the import, and wrong variants of `drain`. Each variant of
 * `drain` either traps, never returns, or changes the state of the processor.
 */
#include <stdlib.h>
#include <string.h>

#include "cpu/bone/bone.h"
#include "cpu/kernels.h"
#include "simd/wrong.h"
#if defined __x86_64__
#include <xmmintrin.h>
#endif

extern const check_kernel check_gather_row, check_blend_rows, check_stretch_row, check_weigh_rows, check_brick_row,
    check_any_active, check_drain, check_sample;

/* ------------------------------------------------------------------ grids */

static void sample_wrong_last(const struct cpu_bone *bone, size_t count, const int32_t *const at[3],
                              int16_t *densities)
{
    ost_sample_scalar(bone, count, at, densities);
    if (count > 20)
        densities[count - 1] ^= 1;
}

static void sample_writes_beyond(const struct cpu_bone *bone, size_t count, const int32_t *const at[3],
                                 int16_t *densities)
{
    ost_sample_scalar(bone, count, at, densities);
    densities[count] = 7;
}

static void gather_wrong_last_of_64(const int16_t *from, const int32_t *map, int count, int16_t *to)
{
    ost_gather_row_scalar(from, map, count, to);
    if (count == 64)
        to[63] = from[map[62]];
}

static void gather_writes_beyond(const int16_t *from, const int32_t *map, int count, int16_t *to)
{
    ost_gather_row_scalar(from, map, count, to);
    to[count] = 0;
}

static void gather_reads_beyond(const int16_t *from, const int32_t *map, int count, int16_t *to)
{
    ost_gather_row_scalar(from, map, count, to);
    if (count > 0)
        touch(&from[map[count - 1] + 1]);
}

static void gather_reads_before(const int16_t *from, const int32_t *map, int count, int16_t *to)
{
    ost_gather_row_scalar(from, map, count, to);
    if (count > 0)
        touch((const char *)&from[map[0]] - 1);
}

static void gather_writes_input(const int16_t *from, const int32_t *map, int count, int16_t *to)
{
    ost_gather_row_scalar(from, map, count, to);
    if (count > 0)
        *(volatile int16_t *)writable(&from[map[0]]) = to[0];
}

/* Rounds ties up instead of to even. */
static void blend_rounds_ties_up(const int16_t *a, const int16_t *b, const size_t *row, int count, int width,
                                 int weight, int16_t *to)
{
    for (int r = 0; r < count; r++)
        for (int i = 0; i < width; i++)
            to[OST_ROW_STRIDE * r + i] = (int16_t)((a[row[r] + (size_t)i] * (OST_WEIGHT_ONE - weight) +
                                                    b[row[r] + (size_t)i] * weight + OST_WEIGHT_ONE / 2) >>
                                                   OST_WEIGHT_BITS);
}

static void blend_writes_between(const int16_t *a, const int16_t *b, const size_t *row, int count, int width,
                                 int weight, int16_t *to)
{
    ost_blend_rows_scalar(a, b, row, count, width, weight, to);
    if (count > 1 && width < OST_ROW_STRIDE)
        to[width] = 0;
}

static void blend_reads_beyond(const int16_t *a, const int16_t *b, const size_t *row, int count, int width, int weight,
                               int16_t *to)
{
    ost_blend_rows_scalar(a, b, row, count, width, weight, to);
    if (count > 0)
        touch(&b[row[count - 1] + (size_t)width]);
}

/* Negates sums to which a weight of -2^15 contributes. */
static void stretch_negates_least_weight(const int16_t *from, const int32_t *at, const int16_t *minus, int width,
                                         int32_t *to)
{
    ost_stretch_row_scalar(from, at, minus, width, to);
    for (int i = 0; i < width; i++)
        if (minus[2 * i] == INT16_MIN || minus[2 * i + 1] == INT16_MIN)
            to[i] = -to[i];
}

static void stretch_reads_beyond(const int16_t *from, const int32_t *at, const int16_t *minus, int width, int32_t *to)
{
    ost_stretch_row_scalar(from, at, minus, width, to);
    touch(&from[at[width - 1] + 2]);
}

static void weigh_rounds_ties_up(const int32_t *const rows[4], const int32_t weight[4], int count, int width,
                                 int16_t *to)
{
    for (int i = 0; i < width; i++) {
        int64_t sum = INT64_C(1) << (3 * OST_WEIGHT_BITS - 1);
        for (int r = 0; r < count; r++)
            sum += (int64_t)rows[r][i] * weight[r];
        to[i] = (int16_t)(sum >> 3 * OST_WEIGHT_BITS);
    }
}

/* Computes sums in doubles, whose 53 bits are not sufficient near a tie. */
static void weigh_in_doubles(const int32_t *const rows[4], const int32_t weight[4], int count, int width, int16_t *to)
{
    for (int i = 0; i < width; i++) {
        double sum = 0;
        for (int r = 0; r < count; r++)
            sum += (double)rows[r][i] * weight[r];
        volatile double rounded = sum / 35184372088832.0 + 6755399441055744.0;
        to[i] = (int16_t)(rounded - 6755399441055744.0);
    }
}

static void weigh_writes_beyond(const int32_t *const rows[4], const int32_t weight[4], int count, int width,
                                int16_t *to)
{
    ost_weigh_rows_scalar(rows, weight, count, width, to);
    to[(width + 15) / 16 * 16] = 0;
}

/* ------------------------------------------------------------------ bones */

static ost_brick_sums brick_above_threshold(const int16_t *const rows[16], size_t bricks, int16_t threshold,
                                            bool stream, int16_t *density, uint64_t *occupancy)
{
    return ost_brick_row_scalar(rows, bricks, (int16_t)(threshold + (threshold < INT16_MAX)), stream, density,
                                occupancy);
}

static ost_brick_sums brick_wrong_highest(const int16_t *const rows[16], size_t bricks, int16_t threshold, bool stream,
                                          int16_t *density, uint64_t *occupancy)
{
    ost_brick_sums sums = ost_brick_row_scalar(rows, bricks, threshold, stream, density, occupancy);
    sums.highest &= 0x7ffe;
    return sums;
}

static ost_brick_sums brick_reads_beyond(const int16_t *const rows[16], size_t bricks, int16_t threshold, bool stream,
                                         int16_t *density, uint64_t *occupancy)
{
    touch(rows[15] + 4 * bricks);
    return ost_brick_row_scalar(rows, bricks, threshold, stream, density, occupancy);
}

/* Writes to an element between the elements of the row's bricks. This element belongs to another row. */
static ost_brick_sums brick_writes_between(const int16_t *const rows[16], size_t bricks, int16_t threshold, bool stream,
                                           int16_t *density, uint64_t *occupancy)
{
    occupancy[2] = 0;
    return ost_brick_row_scalar(rows, bricks, threshold, stream, density, occupancy);
}

static bool any_tests_one_column_too_many(const int16_t *base, const size_t *row, int count, int width,
                                          int16_t threshold)
{
    return ost_any_active_scalar(base, row, count, width + 1, threshold);
}

static bool any_omits_the_last_column(const int16_t *base, const size_t *row, int count, int width, int16_t threshold)
{
    return ost_any_active_scalar(base, row, count, width - 1, threshold);
}

/* -------------------------------------------------------- processor state */

static void drain_traps(void)
{
    __builtin_trap();
}

static void drain_never_ends(void)
{
    for (volatile int i = 0; i == 0;)
        continue;
}

#if defined __x86_64__
static void drain_changes_rounding(void)
{
    _mm_setcsr(_mm_getcsr() ^ 0x2000);
}

static void drain_leaves_mmx_in_use(void)
{
    __asm__ volatile("pxor %%mm0, %%mm0" ::: "memory");
}

static void drain_leaves_upper_halves_in_use(void)
{
    if (call_watches_halves())
        __asm__ volatile("vpcmpeqd %%ymm9, %%ymm9, %%ymm9" ::: "xmm9");
    else
        drain_leaves_mmx_in_use();
}
#elif defined __aarch64__
static void drain_changes_rounding(void)
{
    uint64_t fpcr;
    __asm__ volatile("mrs %0, fpcr" : "=r"(fpcr));
    __asm__ volatile("msr fpcr, %0" ::"r"(fpcr ^ (UINT64_C(1) << 23)));
}
#endif

static const wrong list[] = {
    WRONG(gather_row, gather_wrong_last_of_64, DIFFERS),
    WRONG(gather_row, gather_writes_beyond, BEYOND),
    WRONG(gather_row, gather_reads_beyond, FAULT),
    WRONG(gather_row, gather_reads_before, FAULT),
    WRONG(gather_row, gather_writes_input, FAULT),
    WRONG(blend_rows, blend_rounds_ties_up, DIFFERS),
    WRONG(blend_rows, blend_writes_between, DIFFERS),
    WRONG(blend_rows, blend_reads_beyond, FAULT),
    WRONG(stretch_row, stretch_negates_least_weight, DIFFERS),
    WRONG(stretch_row, stretch_reads_beyond, FAULT),
    WRONG(weigh_rows, weigh_rounds_ties_up, DIFFERS),
    WRONG(weigh_rows, weigh_in_doubles, DIFFERS),
    WRONG(weigh_rows, weigh_writes_beyond, BEYOND),
    WRONG(brick_row, brick_above_threshold, DIFFERS),
    WRONG(brick_row, brick_wrong_highest, DIFFERS),
    WRONG(brick_row, brick_reads_beyond, FAULT),
    WRONG(brick_row, brick_writes_between, DIFFERS),
    WRONG(any_active, any_tests_one_column_too_many, OR(CHECK_DIFFERS, CHECK_FAULT)),
    WRONG(any_active, any_omits_the_last_column, DIFFERS),
    WRONG(drain, drain_traps, FAULT),
    WRONG(drain, drain_never_ends, FAULT),
#if defined __x86_64__
    WRONG(drain, drain_changes_rounding, STATE),
    WRONG(drain, drain_leaves_mmx_in_use, STATE),
    WRONG(drain, drain_leaves_upper_halves_in_use, STATE),
#elif defined __aarch64__
    WRONG(drain, drain_changes_rounding, STATE),
#endif
    WRONG(sample, sample_wrong_last, DIFFERS),
    WRONG(sample, sample_writes_beyond, BEYOND),
};
const wrong_list wrong_grids = {list, sizeof list / sizeof list[0]};
