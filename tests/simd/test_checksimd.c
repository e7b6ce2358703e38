/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests that checksimd detects errors. Each kernel in this file has one small error, which must be reported
 * with the right reason within the default number of cases.
 *
 * Most of the wrong kernels call the scalar kernel and cause an error before or after the call. The seed is
 * fixed, so that results do not vary between runs.
 *
 * Covers: AR-LAW-1
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cpu/bone/bone.h"
#include "cpu/kernels.h"
#include "cpu/voxelize/voxelize.h"
#include "io/text/match.h"
#include "simd/check.h"
#if defined __x86_64__
#include <xmmintrin.h>
#endif

extern const check_kernel check_gather_row, check_blend_rows, check_stretch_row, check_weigh_rows, check_brick_row,
    check_any_active, check_drain, check_sample, check_blocks, check_split, check_match, check_take, check_vox_mark,
    check_vox_keys, check_vox_fill, check_vox_expand, check_text_match;

/* Reads a byte; volatile prevents the compiler from removing the read. */
static void touch(const void *p)
{
    (void)*(const volatile char *)p;
}

/* Removes const from a pointer, so that a wrong kernel can write to its input. */
static void *writable(const void *p)
{
    return (void *)(uintptr_t)p;
}

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

/* ---------------------------------------------------------------- removal */

static void blocks_never_divides(const ost_block_bases *bases, const ost_block_reach *reach, const int32_t first[3],
                                 const int32_t from[3], const int32_t to[3], ost_cubes *blocks)
{
    ost_blocks_scalar(bases, reach, first, from, to, blocks);
    for (size_t i = 0; i < blocks->count; i++)
        for (int a = 0; a < 3; a++) {
            int64_t sum = 1 << 15;
            for (int b = 0; b < 3; b++)
                sum += bases->part[b][3 * (first[b] - bases->lo[b] + (blocks->number[i] >> b & 1)) + a];
            blocks->u[a][i] = (int32_t)(sum >> 16);
        }
}

static void blocks_reach_is_one_less(const ost_block_bases *bases, const ost_block_reach *reach, const int32_t first[3],
                                     const int32_t from[3], const int32_t to[3], ost_cubes *blocks)
{
    ost_block_reach less = *reach;
    less.width[1]--;
    ost_blocks_scalar(bases, &less, first, from, to, blocks);
}

static void blocks_wrong_numbers(const ost_block_bases *bases, const ost_block_reach *reach,
                                 const int32_t first[3], const int32_t from[3], const int32_t to[3],
                                 ost_cubes *blocks)
{
    (void)first;
    ost_blocks_scalar(bases, reach, from, from, to, blocks);
}

static void split_omits_the_last_cube(const ost_split *split, const ost_cells *cells, const ost_cubes *cubes,
                                      const uint64_t *occupancy, ost_cubes *mixed, ost_numbers *inside)
{
    static ost_cubes fewer;
    fewer = *cubes;
    fewer.count -= fewer.count % 8 == 7;
    ost_split_scalar(split, cells, &fewer, occupancy, mixed, inside);
}

static void split_clears_a_list(const ost_split *split, const ost_cells *cells, const ost_cubes *cubes,
                                const uint64_t *occupancy, ost_cubes *mixed, ost_numbers *inside)
{
    inside->count = 0;
    ost_split_scalar(split, cells, cubes, occupancy, mixed, inside);
}

static void split_least_is_one_less(const ost_split *split, const ost_cells *cells, const ost_cubes *cubes,
                                    const uint64_t *occupancy, ost_cubes *mixed, ost_numbers *inside)
{
    static ost_split nearer;
    nearer = *split;
    nearer.least -= nearer.least > 1;
    ost_split_scalar(&nearer, cells, cubes, occupancy, mixed, inside);
}

static void split_writes_beyond(const ost_split *split, const ost_cells *cells, const ost_cubes *cubes,
                                const uint64_t *occupancy, ost_cubes *mixed, ost_numbers *inside)
{
    const size_t capacity = mixed->count + 8 * cubes->count + OST_CUBES_SLACK;
    ost_split_scalar(split, cells, cubes, occupancy, mixed, inside);
    if (capacity < OST_UNIT_BRICKS + OST_CUBES_SLACK)
        mixed->u[1][capacity] = 0;
}

static void split_reads_before_the_margin(const ost_split *split, const ost_cells *cells, const ost_cubes *cubes,
                                          const uint64_t *occupancy, ost_cubes *mixed, ost_numbers *inside)
{
    touch(cells->value - 65);
    ost_split_scalar(split, cells, cubes, occupancy, mixed, inside);
}

static void match_wrong_voxel(const ost_match *match, const ost_cubes *bricks, uint64_t *hits)
{
    ost_match_scalar(match, bricks, hits);
    if (bricks->count % 8 == 5)
        hits[bricks->count - 1] ^= UINT64_C(1) << 63;
}

/*
 * Simulates a kernel that truncates coordinates and offsets before it adds them. Its results are wrong only for the
 * ties that remove.h describes.
 */
static void match_without_carries(const ost_match *match, const ost_cubes *bricks, uint64_t *hits)
{
    const int32_t cut = ~((1 << (OST_MAP_FRACTION - OST_TIE_BITS)) - 1);
    static ost_match coarse;
    static ost_cubes moved;
    coarse = *match;
    moved = *bricks;
    if (match->windows || match->wide)
        for (int a = 0; a < 3; a++) {
            for (size_t i = 0; i < moved.count; i++)
                moved.u[a][i] = ((moved.u[a][i] + match->lowest[a]) & cut) - match->lowest[a];
            for (int v = 0; v < 64; v++)
                coarse.offset[a][v] = ((match->offset[a][v] - match->lowest[a]) & cut) + match->lowest[a];
        }
    ost_match_scalar(&coarse, &moved, hits);
}

static void match_reads_beyond(const ost_match *match, const ost_cubes *bricks, uint64_t *hits)
{
    const ost_shape *s = match->shape;
    touch(s->bits + s->words * (size_t)s->dims[1] * (size_t)s->dims[2]);
    ost_match_scalar(match, bricks, hits);
}

static void match_writes_beyond(const ost_match *match, const ost_cubes *bricks, uint64_t *hits)
{
    ost_match_scalar(match, bricks, hits);
    hits[bricks->count + OST_CUBES_SLACK] = 0;
}

static void take_sums_in_16_bits(const ost_take *take, int16_t *density, const int32_t *number, const uint64_t *hits,
                                 size_t count, ost_tally *tally)
{
    ost_tally sum = {{0}, {0}};
    ost_take_scalar(take, density, number, hits, count, &sum);
    for (int b = 0; b < OST_CLASS_MAX; b++) {
        tally->voxels[b] += sum.voxels[b];
        tally->density[b] += sum.density[b] & 0xffff;
    }
}

static void take_always_removes(const ost_take *take, int16_t *density, const int32_t *number, const uint64_t *hits,
                                size_t count, ost_tally *tally)
{
    ost_take apply = *take;
    apply.apply = true;
    ost_take_scalar(&apply, density, number, hits, count, tally);
}

static void take_at_most_512_bricks(const ost_take *take, int16_t *density, const int32_t *number, const uint64_t *hits,
                                    size_t count, ost_tally *tally)
{
    ost_take_scalar(take, density, number, hits, count > 512 ? 512 : count, tally);
}

static void take_clears_a_voxel_that_is_not_hit(const ost_take *take, int16_t *density, const int32_t *number,
                                                const uint64_t *hits, size_t count, ost_tally *tally)
{
    ost_take_scalar(take, density, number, hits, count, tally);
    if (take->apply && count > 0 && !(hits[0] & 1))
        density[64 * number[0]] = 0;
}

/* ----------------------------------------------------------- voxelization */

static void mark_omits_the_last_slice(ost_vox_tile *tile, const uint32_t *list, size_t count)
{
    tile->k1--;
    ost_vox_mark_scalar(tile, list, count);
    tile->k1++;
}

static void mark_omits_the_last_triangle(ost_vox_tile *tile, const uint32_t *list, size_t count)
{
    ost_vox_mark_scalar(tile, list, count - (count > 0));
}

/* Simulates a kernel that loads four numbers of a vertex instead of three. */
static void mark_reads_beyond(ost_vox_tile *tile, const uint32_t *list, size_t count)
{
    ost_vox_mark_scalar(tile, list, count);
    touch(&tile->mesh->vertices[tile->mesh->vertex_count]);
}

static void mark_clears_the_row_states(ost_vox_tile *tile, const uint32_t *list, size_t count)
{
    ost_vox_mark_scalar(tile, list, count);
    if (tile->any_unproven)
        memset(tile->row_state, 0, ost_vox_rows(tile));
    tile->any_unproven = false;
}

static void keys_writes_beyond(const ost_vox_plan *plan, const ost_snapped_mesh *mesh, size_t first, size_t count,
                               uint32_t *keys)
{
    ost_vox_keys_scalar(plan, mesh, first, count, keys);
    keys[count] = 0;
}

static void keys_omits_the_many_value(const ost_vox_plan *plan, const ost_snapped_mesh *mesh, size_t first,
                                      size_t count, uint32_t *keys)
{
    ost_vox_keys_scalar(plan, mesh, first, count, keys);
    for (size_t i = 0; i < count; i++)
        keys[i] = keys[i] == OST_VOX_KEY_MANY ? 0 : keys[i];
}

static uint64_t fill_clears_nothing(ost_vox_tile *tile, size_t first_row, size_t rows, uint64_t *bits)
{
    const bool row_state = tile->any_unproven;
    tile->any_unproven = true;
    const uint64_t count = ost_vox_fill_scalar(tile, first_row, rows, bits);
    tile->any_unproven = row_state;
    for (size_t r = first_row; r < first_row + rows; r++)
        tile->any_unproven = tile->any_unproven || (tile->row_state[r] & OST_VOX_UNPROVEN);
    return count;
}

static uint64_t fill_reports_all_rows_as_proven(ost_vox_tile *tile, size_t first_row, size_t rows, uint64_t *bits)
{
    const bool row_state = tile->any_unproven;
    const uint64_t count = ost_vox_fill_scalar(tile, first_row, rows, bits);
    for (size_t r = first_row; r < first_row + rows; r++)
        tile->row_state[r] &= OST_VOX_SPILLED;
    tile->any_unproven = row_state;
    return count;
}

static uint64_t fill_counts_wrong(ost_vox_tile *tile, size_t first_row, size_t rows, uint64_t *bits)
{
    const uint64_t count = ost_vox_fill_scalar(tile, first_row, rows, bits);
    return count > 5000 ? count + 1 : count;
}

static uint64_t fill_clears_the_spills(ost_vox_tile *tile, size_t first_row, size_t rows, uint64_t *bits)
{
    const uint64_t count = ost_vox_fill_scalar(tile, first_row, rows, bits);
    for (size_t r = first_row; r < first_row + rows; r++)
        tile->row_state[r] &= OST_VOX_UNPROVEN;
    return count;
}

static void expand_writes_beyond(const uint64_t *cutting, const uint64_t *noncutting, size_t rows, int words,
                                 int32_t nx, bool stream, uint8_t *voxels)
{
    ost_vox_expand_scalar(cutting, noncutting, rows, words, nx, stream, voxels);
    if (rows > 0 && nx % 8 != 0)
        voxels[rows * (size_t)nx] = 0;
}

static void expand_reads_beyond(const uint64_t *cutting, const uint64_t *noncutting, size_t rows, int words, int32_t nx,
                                bool stream, uint8_t *voxels)
{
    touch(cutting + rows * (size_t)words);
    ost_vox_expand_scalar(cutting, noncutting, rows, words, nx, stream, voxels);
}

static void expand_omits_the_second_class(const uint64_t *cutting, const uint64_t *noncutting, size_t rows, int words,
                                          int32_t nx, bool stream, uint8_t *voxels)
{
    (void)noncutting;
    ost_vox_expand_scalar(cutting, NULL, rows, words, nx, stream, voxels);
}

/* ------------------------------------------------------------------- text */

static ost_text_match *text_match;

static size_t match_stops_early(const ost_text_pattern *pattern, const ost_text_column *columns, const uint8_t *lengths,
                                const char *text, const char *end, size_t lines, int16_t *density, const char **next)
{
    const size_t n = text_match(pattern, columns, lengths, text, end, lines, density, next);
    return n == lines && lines % 8 == 7 ? n - 1 : n;
}

/* Simulates a kernel that stores densities modulo 2^16, because it narrows them without a range check. */
static size_t match_wraps_densities(const ost_text_pattern *pattern, const ost_text_column *columns,
                                    const uint8_t *lengths, const char *text, const char *end, size_t lines,
                                    int16_t *density, const char **next)
{
    size_t n = text_match(pattern, columns, lengths, text, end, lines, density, next);
    while (n < lines && *next < end) {
        const char *q = *next + pattern->before.length + lengths[n] + pattern->after.length;
        if (memcmp(q, "32768\n", 6) != 0)
            break;
        density[n++] = INT16_MIN;
        n += text_match(pattern, columns + n, lengths + n, q + 6, end, lines - n, density + n, next);
    }
    return n;
}

/* Simulates a kernel that also matches the line that begins at `end`, although another thread reads this line. */
static size_t match_continues_after_the_end(const ost_text_pattern *pattern, const ost_text_column *columns,
                                            const uint8_t *lengths, const char *text, const char *end, size_t lines,
                                            int16_t *density, const char **next)
{
    const size_t n = text_match(pattern, columns, lengths, text, end, lines, density, next);
    if (n == lines || *next != end)
        return n;
    return n + text_match(pattern, columns + n, lengths + n, end, end + OST_TEXT_MARGIN, 1, density + n, next);
}

static size_t match_wrong_next(const ost_text_pattern *pattern, const ost_text_column *columns,
                               const uint8_t *lengths, const char *text, const char *end, size_t lines,
                               int16_t *density, const char **next)
{
    const size_t n = text_match(pattern, columns, lengths, text, end, lines, density, next);
    text_match(pattern, columns, lengths, text, end, n & ~(size_t)3, density, next);
    return n;
}

static size_t match_writes_an_unmatched_density(const ost_text_pattern *pattern, const ost_text_column *columns,
                                                const uint8_t *lengths, const char *text, const char *end, size_t lines,
                                                int16_t *density, const char **next)
{
    const size_t n = text_match(pattern, columns, lengths, text, end, lines, density, next);
    if (n < lines)
        density[n] = 0;
    return n;
}

static size_t match_reads_before(const ost_text_pattern *pattern, const ost_text_column *columns,
                                 const uint8_t *lengths, const char *text, const char *end, size_t lines,
                                 int16_t *density, const char **next)
{
    touch(text - 1);
    return text_match(pattern, columns, lengths, text, end, lines, density, next);
}

static size_t match_reads_past_the_margin(const ost_text_pattern *pattern, const ost_text_column *columns,
                                          const uint8_t *lengths, const char *text, const char *end, size_t lines,
                                          int16_t *density, const char **next)
{
    touch(end + OST_TEXT_MARGIN);
    return text_match(pattern, columns, lengths, text, end, lines, density, next);
}

/* ------------------------------------------------------ the wrong kernels */

/* The set that consists of the check_result values a and b. */
#define OR(a, b) (1u << (a) | 1u << (b))

static const struct wrong {
    const check_kernel *kernel;
    check_fn *fn;
    unsigned found_as; /* set of the accepted check_result values */
    const char *what;
} wrongs[] = {
#define WRONG(slot, fn, found_as) {&check_##slot, (check_fn *)(fn), found_as, #fn}
#define DIFFERS (1u << CHECK_DIFFERS)
#define FAULT (1u << CHECK_FAULT)
#define STATE (1u << CHECK_STATE)
#define BEYOND OR(CHECK_BEYOND, CHECK_FAULT)
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
    WRONG(blocks, blocks_never_divides, DIFFERS),
    WRONG(blocks, blocks_reach_is_one_less, DIFFERS),
    WRONG(blocks, blocks_wrong_numbers, DIFFERS),
    WRONG(split, split_omits_the_last_cube, DIFFERS),
    WRONG(split, split_clears_a_list, DIFFERS),
    WRONG(split, split_least_is_one_less, DIFFERS),
    WRONG(split, split_writes_beyond, DIFFERS),
    WRONG(split, split_reads_before_the_margin, FAULT),
    WRONG(match, match_wrong_voxel, DIFFERS),
    WRONG(match, match_without_carries, DIFFERS),
    WRONG(match, match_reads_beyond, FAULT),
    WRONG(match, match_writes_beyond, BEYOND),
    WRONG(take, take_sums_in_16_bits, DIFFERS),
    WRONG(take, take_always_removes, DIFFERS),
    WRONG(take, take_at_most_512_bricks, DIFFERS),
    WRONG(take, take_clears_a_voxel_that_is_not_hit, DIFFERS),
    WRONG(vox_mark, mark_omits_the_last_slice, DIFFERS),
    WRONG(vox_mark, mark_omits_the_last_triangle, DIFFERS),
    WRONG(vox_mark, mark_reads_beyond, FAULT),
    WRONG(vox_mark, mark_clears_the_row_states, DIFFERS),
    WRONG(vox_keys, keys_writes_beyond, BEYOND),
    WRONG(vox_keys, keys_omits_the_many_value, DIFFERS),
    WRONG(vox_fill, fill_clears_nothing, DIFFERS),
    WRONG(vox_fill, fill_reports_all_rows_as_proven, DIFFERS),
    WRONG(vox_fill, fill_counts_wrong, DIFFERS),
    WRONG(vox_fill, fill_clears_the_spills, DIFFERS),
    WRONG(vox_expand, expand_writes_beyond, BEYOND),
    WRONG(vox_expand, expand_reads_beyond, FAULT),
    WRONG(vox_expand, expand_omits_the_second_class, DIFFERS),
    WRONG(text_match, match_stops_early, DIFFERS),
    WRONG(text_match, match_wraps_densities, DIFFERS),
    WRONG(text_match, match_continues_after_the_end, DIFFERS),
    WRONG(text_match, match_wrong_next, DIFFERS),
    WRONG(text_match, match_writes_an_unmatched_density, DIFFERS),
    WRONG(text_match, match_reads_before, FAULT),
    WRONG(text_match, match_reads_past_the_margin, FAULT),
};
enum { WRONGS = sizeof wrongs / sizeof wrongs[0] };

int main(void)
{
    static const char *const results[] = {[CHECK_GOOD] = "not detected",
                                          [CHECK_DIFFERS] = "reported as a difference",
                                          [CHECK_BEYOND] = "reported as a write beyond the output",
                                          [CHECK_FAULT] = "reported as a fault",
                                          [CHECK_STATE] = "reported as a change of the processor's state"};
    const uint64_t seed = 20261121;
    int failed = 0;
    if (call_under_valgrind())
        return 77;
    text_match = ost_text_match_for(OST_ISA_SCALAR);
    call_watch(0.5);
    for (int i = 0; i < WRONGS; i++) {
        const struct wrong *w = &wrongs[i];
        const check_result r = check_run(w->kernel, w->kernel->of(OST_ISA_SCALAR), w->fn, "wrong", seed, 0,
                                         w->kernel->cases, true);
        if (w->found_as & 1u << r)
            continue;
        printf("FAILED %s: %s in %d cases of %s\n", w->what, results[r], w->kernel->cases, w->kernel->name);
        failed++;
    }
    /* The correct kernels must not be reported. */
    for (int i = 0; i < check_kernel_count; i++) {
        check_fn *scalar = check_kernels[i]->of(OST_ISA_SCALAR);
        failed += check_run(check_kernels[i], scalar, scalar, "scalar", seed, 0, 50, false) != CHECK_GOOD;
    }
    printf("%d wrong kernels, %d failed\n", WRONGS, failed);
    return failed > 0;
}
