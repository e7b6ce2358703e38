/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Wrong kernels of the removal.
 */
#include <stdlib.h>
#include <string.h>

#include "cpu/kernels.h"
#include "simd/wrong.h"

extern const check_kernel check_blocks, check_split, check_match, check_take;

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

static const wrong list[] = {
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
};
const wrong_list wrong_remove = {list, sizeof list / sizeof list[0]};
