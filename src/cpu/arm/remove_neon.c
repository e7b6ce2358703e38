/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The kernels of removal for NEON. The steps are the same as on x86, except for these differences:
 *
 *   split   the eight parts of a cube are in two registers, which are packed by byte moves from a table
 *   match   coordinates are the high bytes of 16-bit lanes; the 64 bytes of a
 *           window are one table for the instruction TBL
 *   take    a register contains eight densities; masks are vectors
 */
#include "core/conditions.h"
#include "core/neon.h"
#include "cpu/kernels.h"

/* ------------------------------------------------------------------ split */

enum { HALF = 4 };

static inline int32x4_t cell_along(int32x4_t u, const ost_cells *cells, int axis)
{
    const int32x4_t c = vaddq_s32(vshlq_s32(u, vdupq_n_s32(-cells->shift)), vdupq_n_s32(cells->margin));
    return vminq_s32(vmaxq_s32(c, vdupq_n_s32(0)), vdupq_n_s32(cells->dims[axis] - 1));
}

/* Returns one byte for each of eight words: -1 if the word is not 0, otherwise 0. */
static inline uint8x8_t filled(const uint64_t *words)
{
    uint32x4_t empty[2];
    for (int h = 0; h < 2; h++)
        empty[h] = vcombine_u32(vmovn_u64(vceqzq_u64(vld1q_u64(words + 4 * h))),
                                vmovn_u64(vceqzq_u64(vld1q_u64(words + 4 * h + 2))));
    return vmvn_u8(vmovn_u16(vcombine_u16(vmovn_u32(empty[0]), vmovn_u32(empty[1]))));
}

/* Stores v with some of its lanes moved to the front; `moves` is the table entry that selects these lanes. */
static inline void pack(int32_t *to, int32x4_t v, uint8x16_t moves)
{
    vst1q_s32(to, vreinterpretq_s32_u8(vqtbl1q_u8(vreinterpretq_u8_s32(v), moves)));
}

void ost_split_neon(const ost_split *split, const ost_cells *cells, const ost_cubes *cubes, const uint64_t *occupancy,
                    ost_cubes *mixed, ost_numbers *inside)
{
    /* No value of a cell exceeds 64 in magnitude, so limiting split->least to 127 changes no result. */
    const int least = split->least < 127 ? split->least : 127;
    const int8x8_t high = vdup_n_s8((int8_t)least), low = vdup_n_s8((int8_t)-least);
    const int8_t *const table = cells->value;
    const int32x4_t numbers[2] = {{0, 1, 2, 3}, {4, 5, 6, 7}};
    size_t m = mixed->count, n = inside->count;
    for (size_t i = 0; i < cubes->count; i++) {
        const uint8x8_t keep = occupancy ? filled(occupancy + 8 * (size_t)cubes->number[i]) : vdup_n_u8(0xff);
        if (!ost_neon_bits8(keep))
            continue;
        int8_t value[8];
        for (int h = 0; h < 2; h++) {
            int32x4_t c[3];
            for (int a = 0; a < 3; a++)
                c[a] = cell_along(vaddq_s32(vdupq_n_s32(cubes->u[a][i]), vld1q_s32(split->centre[a] + HALF * h)), cells,
                                  a);
            int32_t cell[HALF];
            vst1q_s32(cell, vmlaq_n_s32(c[0], vmlaq_n_s32(c[1], c[2], cells->dims[1]), cells->dims[0]));
            for (int j = 0; j < HALF; j++)
                value[HALF * h + j] = table[cell[j]];
        }
        const int8x8_t v = vld1_s8(value);
        const uint8x8_t in = vand_u8(keep, vcge_s8(v, high)), out = vcle_s8(v, low);
        const unsigned in_bits = ost_neon_bits8(in), mix_bits = ost_neon_bits8(vbic_u8(keep, vorr_u8(in, out)));
        const int32x4_t first = vdupq_n_s32(cubes->number[i] * 8);
        for (int h = 0; h < 2; h++) {
            const unsigned mix_half = mix_bits >> (HALF * h) & 15, in_half = in_bits >> (HALF * h) & 15;
            const uint8x16_t moves = ost_neon_together(mix_half);
            const int32x4_t number = vaddq_s32(first, numbers[h]);
            for (int a = 0; a < 3; a++)
                pack(mixed->u[a] + m, vaddq_s32(vdupq_n_s32(cubes->u[a][i]), vld1q_s32(split->first[a] + HALF * h)),
                     moves);
            pack(mixed->number + m, number, moves);
            pack(inside->number + n, number, ost_neon_together(in_half));
            m += (size_t)__builtin_popcount(mix_half);
            n += (size_t)__builtin_popcount(in_half);
        }
    }
    mixed->count = m;
    inside->count = n;
}

/* ------------------------------------------------------------------ match */

enum { LOW = OST_MAP_FRACTION - OST_TIE_BITS, PIECE = 128, SIXTEENS = 4 };

/*
 * The positions of at most PIECE bricks in their windows. c is the least coordinate of a brick, relative to the first
 * voxel of its window. `tied` lists the bricks that are ties (remove.h, "Sixteen bits per lane").
 */
typedef struct places {
    uint16_t high[3][PIECE]; /* c >> 7 */
    uint16_t low[3][PIECE];  /* c mod 2^7 */
    uint32_t line[PIECE]; /* number of each brick's window; later replaced by the number of the window's line */
    uint32_t tied[PIECE];
} places;

/*
 * Returns floor(voxel / step) for 0 <= voxel < 2^15 and a step of 1, 2 or 3. In this range,
 * (voxel * ceil(2^16 / step)) >> 16 is exact; for step 1, the product is a shift by 16.
 */
static inline int32x4_t windows_of(int32x4_t voxel, int32_t step)
{
    const uint32_t inverse = step == 3 ? 21846 : step == 2 ? 32768 : 65536;
    return vreinterpretq_s32_u32(vshrq_n_u32(vmulq_n_u32(vreinterpretq_u32_s32(voxel), inverse), 16));
}

/* Computes the positions of four bricks, beginning with brick number `from`. If the list has fewer bricks, the values
   of the remaining lanes are not used. */
static inline void place_four(const ost_match *match, const ost_cubes *bricks, size_t from, places *out, size_t to)
{
    const ost_windows *w = &match->shape->windows;
    const int32x4_t margin = vdupq_n_s32(OST_WINDOW_MARGIN);
    int32x4_t window[3];
    for (int a = 0; a < 3; a++) {
        const int32x4_t u = vaddq_s32(vld1q_s32(bricks->u[a] + from), vdupq_n_s32(match->lowest[a]));
        window[a] = windows_of(vaddq_s32(vshrq_n_s32(u, OST_MAP_FRACTION), margin), w->step);
        const int32x4_t begin = vshlq_n_s32(vsubq_s32(vmulq_n_s32(window[a], w->step), margin), OST_MAP_FRACTION);
        /* c is below 2^23, so c >> 7 fits in 16 bits */
        const uint32x4_t c = vreinterpretq_u32_s32(vsubq_s32(u, begin));
        vst1_u16(out->high[a] + to, vshrn_n_u32(c, LOW));
        vst1_u16(out->low[a] + to, vmovn_u32(vandq_u32(c, vdupq_n_u32((1 << LOW) - 1))));
    }
    const int32x4_t row = vmlaq_n_s32(window[1], window[2], w->dims[1]);
    vst1q_u32(out->line + to, vreinterpretq_u32_s32(vmlaq_n_s32(window[0], row, w->dims[0])));
}

static inline unsigned tie_at(const ost_match *match, const places *at, size_t i, int axis)
{
    return match->tie[at->high[axis][i] & ((1 << OST_TIE_BITS) - 1)] & (1u << axis);
}

static inline size_t find_lines(const ost_match *match, size_t count, places *at)
{
    size_t tied = 0;
    for (size_t i = 0; i < count; i++) {
        at->line[i] = match->shape->windows.index[at->line[i]];
        __builtin_prefetch(match->shape->windows.line[at->line[i]]);
        at->tied[tied] = (uint32_t)i;
        tied += (tie_at(match, at, i, 0) | tie_at(match, at, i, 1) | tie_at(match, at, i, 2)) != 0;
    }
    return tied;
}

/* Returns one byte for each of sixteen voxels: -1 if the voxel's bit in the window is set, otherwise 0. x, y and z
   contain one byte per voxel, with three bits for the coordinate in the window and five bits of fraction. */
static inline uint8x16_t lookup(uint8x16x4_t line, uint8x16_t x, uint8x16_t y, uint8x16_t z)
{
    /* number of the row in the window: 8 y + z, below 64 */
    const uint8x16_t row = vqtbl4q_u8(line, vsriq_n_u8(vshrq_n_u8(y, 2), z, 5));
    const uint8x16_t bit = vshlq_u8(vdupq_n_u8(1), vreinterpretq_s8_u8(vshrq_n_u8(x, 5)));
    return vtstq_u8(row, bit);
}

/* Returns the high byte of each 16-bit lane of two registers. */
static inline uint8x16_t high_bytes(uint16x8_t a, uint16x8_t b)
{
    return vuzp2q_u8(vreinterpretq_u8_u16(a), vreinterpretq_u8_u16(b));
}

static inline uint8x16_t coordinate(const uint16_t *offsets, uint16x8_t c)
{
    return high_bytes(vaddq_u16(vld1q_u16(offsets), c), vaddq_u16(vld1q_u16(offsets + 8), c));
}

/* Computes the same coordinates as the function `coordinate`, but exactly: the carries of the low bits are included. */
static inline uint8x16_t coordinate_tied(const uint16_t *offsets, uint16x8_t c, const uint16_t *low_offsets,
                                         uint16x8_t low)
{
    const uint16x8_t carry0 = vshrq_n_u16(vaddq_u16(vld1q_u16(low_offsets), low), LOW);
    const uint16x8_t carry1 = vshrq_n_u16(vaddq_u16(vld1q_u16(low_offsets + 8), low), LOW);
    return high_bytes(vaddq_u16(vaddq_u16(vld1q_u16(offsets), c), carry0),
                      vaddq_u16(vaddq_u16(vld1q_u16(offsets + 8), c), carry1));
}

static inline __attribute__((always_inline)) uint64_t match_brick(const ost_match *match, const places *at, size_t i,
                                                                  const bool tied)
{
    const uint8_t *line = match->shape->windows.line[at->line[i]];
    const uint8x16x4_t table = {{vld1q_u8(line), vld1q_u8(line + 16), vld1q_u8(line + 32), vld1q_u8(line + 48)}};
    uint16x8_t c[3], low[3];
    for (int a = 0; a < 3; a++) {
        c[a] = vld1q_dup_u16(&at->high[a][i]);
        low[a] = vld1q_dup_u16(&at->low[a][i]);
    }
    uint8x16_t hit[SIXTEENS];
    for (int s = 0; s < SIXTEENS; s++) {
        uint8x16_t bytes[3];
        for (int a = 0; a < 3; a++)
            bytes[a] = tied ? coordinate_tied(match->high[a] + 16 * s, c[a], match->low[a] + 16 * s, low[a])
                            : coordinate(match->high[a] + 16 * s, c[a]);
        hit[s] = lookup(table, bytes[0], bytes[1], bytes[2]);
    }
    return ost_neon_bits64(hit[0], hit[1], hit[2], hit[3]);
}

static void match_windows(const ost_match *match, const ost_cubes *bricks, uint64_t *hits)
{
    places at;
    for (size_t piece = 0; piece < bricks->count; piece += PIECE, hits += PIECE) {
        const size_t count = bricks->count - piece < PIECE ? bricks->count - piece : PIECE;
        for (size_t i = 0; i < count; i += 4)
            place_four(match, bricks, piece + i, &at, i);
        const size_t tied = find_lines(match, count, &at);
        for (size_t i = 0; i < count; i++)
            hits[i] = match_brick(match, &at, i, false);
        for (size_t t = 0; t < tied; t++)
            hits[at.tied[t]] = match_brick(match, &at, at.tied[t], true);
    }
}

void ost_match_neon(const ost_match *match, const ost_cubes *bricks, uint64_t *hits)
{
    if (match->windows)
        match_windows(match, bricks, hits);
    else
        ost_match_scalar(match, bricks, hits);
}

/* ------------------------------------------------------------------- take */

/*
 * Adds the hits of `count` bricks to the tally. The sums of densities are in 32-bit
 * lanes. A brick adds 8 registers with 2 densities per lane, less than
 * 8 * 2 * 2^15 = 2^19, so 512 bricks add less than 2^28. The counts are in 16-bit lanes.
 * A brick adds at most 8 to a lane, so 512 bricks add at most 4096. Callers pass the
 * number of borders as a constant.
 */
static inline __attribute__((always_inline)) void take_bricks(const ost_take *take, int16_t *density,
                                                              const int32_t *number, const uint64_t *hits, size_t count,
                                                              ost_tally *tally, const int borders)
{
    const uint16x8_t own = vmovl_u8(ost_neon_own_bits());
    const bool apply = take->apply;
    int16x8_t border[3];
    uint32x4_t sum[4];
    uint16x8_t voxels[3];
    for (int b = 0; b <= borders; b++)
        sum[b] = vdupq_n_u32(0);
    for (int b = 0; b < borders; b++) {
        border[b] = vdupq_n_s16(take->border[b]);
        voxels[b] = vdupq_n_u16(0);
    }
    uint64_t all = 0;
    for (size_t i = 0; i < count; i++) {
        int16_t *brick = density + (size_t)number[i] * 64;
        const uint64_t hit = hits[i];
        if (i + 16 < count) {
            __builtin_prefetch(density + (size_t)number[i + 16] * 64, 1);
            __builtin_prefetch(density + (size_t)number[i + 16] * 64 + 32, 1);
        }
        for (int q = 0; q < 8; q++) {
            const uint16x8_t mask = vtstq_u16(vdupq_n_u16((uint16_t)(hit >> (8 * q))), own);
            const int16x8_t d = vld1q_s16(brick + 8 * q);
            const uint16x8_t u = vreinterpretq_u16_s16(d);
            sum[0] = vpadalq_u16(sum[0], vandq_u16(u, mask));
            for (int b = 0; b < borders; b++) {
                const uint16x8_t above = vandq_u16(vcgeq_s16(d, border[b]), mask);
                sum[b + 1] = vpadalq_u16(sum[b + 1], vandq_u16(u, above));
                voxels[b] = vsubq_u16(voxels[b], above);
            }
            if (apply)
                vst1q_s16(brick + 8 * q, vreinterpretq_s16_u16(vbicq_u16(u, mask)));
        }
        all += (uint64_t)__builtin_popcountll(hit);
    }
    tally->voxels[0] += all;
    for (int b = 0; b <= borders; b++)
        tally->density[b] += vaddlvq_u32(sum[b]);
    for (int b = 0; b < borders; b++)
        tally->voxels[b + 1] += vaddlvq_u16(voxels[b]);
}

void ost_take_neon(const ost_take *take, int16_t *density, const int32_t *number, const uint64_t *hits, size_t count,
                   ost_tally *tally)
{
    for (size_t i = 0; i < count; i += 512) {
        const size_t piece = count - i < 512 ? count - i : 512;
        switch (take->borders) {
        case 0:
            take_bricks(take, density, number + i, hits + i, piece, tally, 0);
            break;
        case 1:
            take_bricks(take, density, number + i, hits + i, piece, tally, 1);
            break;
        case 2:
            take_bricks(take, density, number + i, hits + i, piece, tally, 2);
            break;
        case 3:
            take_bricks(take, density, number + i, hits + i, piece, tally, 3);
            break;
        default:
            ost_take_scalar(take, density, number + i, hits + i, piece, tally);
        }
    }
}
