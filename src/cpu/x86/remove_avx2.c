/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The kernels of removal for AVX2 (with BMI2 and POPCNT). The steps are the same as in remove_avx512.c, with these
 * differences:
 *
 *   split   the eight parts of a cube are in one register; PEXT computes the shuffle
 *           that packs the parts
 *   match   coordinates in 16-bit lanes are packed to bytes; four byte shuffles
 *           read the 64 bytes of a window
 *   take    a register contains sixteen densities; masks are vectors
 *
 * The shuffles. The number of a row, n = 8 y + z, has six bits. VPSHUFB uses the
 * lowest four bits of an index and returns 0 if bit 7 is set. Let T0..T3 be the
 * quarters of the window. The sum
 *
 *     T0[n] ^ (T1 ^ T0)[n - 16] ^ (T2 ^ T1)[n - 32] ^ (T3 ^ T2)[n - 48]
 *
 * selects the byte of row n: a term with a negative index is 0, and in the other terms,
 * all quarters cancel except the one that contains the row.
 */
#include <immintrin.h>

#include "core/conditions.h"
#include "cpu/kernels.h"

static inline __m256i load(const void *at)
{
    return _mm256_loadu_si256((const __m256i *)at);
}

static inline void store(void *at, __m256i v)
{
    _mm256_storeu_si256((__m256i *)at, v);
}

/* ------------------------------------------------------------------ split */

static inline __m256i cell_along(__m256i u, const ost_cells *cells, int axis)
{
    const __m256i c = _mm256_add_epi32(_mm256_sra_epi32(u, _mm_cvtsi32_si128(cells->shift)),
                                       _mm256_set1_epi32(cells->margin));
    return _mm256_min_epi32(_mm256_max_epi32(c, _mm256_setzero_si256()), _mm256_set1_epi32(cells->dims[axis] - 1));
}

/* Returns a vector that begins with the lanes of v whose bits are set in `mask`, in order. */
static inline __m256i packed(__m256i v, unsigned mask)
{
    const uint64_t bytes = _pdep_u64(mask, UINT64_C(0x0101010101010101)) * 0xff;
    const __m128i order = _mm_cvtsi64_si128((long long)_pext_u64(UINT64_C(0x0706050403020100), bytes));
    return _mm256_permutevar8x32_epi32(v, _mm256_cvtepu8_epi32(order));
}

static inline unsigned filled(const uint64_t *words)
{
    const __m256i zero = _mm256_setzero_si256();
    const int low = _mm256_movemask_pd(_mm256_castsi256_pd(_mm256_cmpeq_epi64(load(words), zero)));
    const int high = _mm256_movemask_pd(_mm256_castsi256_pd(_mm256_cmpeq_epi64(load(words + 4), zero)));
    return (unsigned)~(low | high << 4) & 0xff;
}

void ost_split_avx2(const ost_split *split, const ost_cells *cells, const ost_cubes *cubes, const uint64_t *occupancy,
                    ost_cubes *mixed, ost_numbers *inside)
{
    const __m256i part = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
    /* No value of a cell exceeds 64 in magnitude, so limiting split->least to 127 changes no result. */
    const int least = split->least < 127 ? split->least : 127;
    const __m128i in_above = _mm_set1_epi8((int8_t)(least - 1)), out_below = _mm_set1_epi8((int8_t)(1 - least));
    const int8_t *const table = cells->value;
    size_t m = mixed->count, n = inside->count;
    for (size_t i = 0; i < cubes->count; i++) {
        const unsigned keep = occupancy ? filled(occupancy + 8 * cubes->number[i]) : 0xff;
        if (keep == 0)
            continue;
        const __m256i u[3] = {_mm256_set1_epi32(cubes->u[0][i]), _mm256_set1_epi32(cubes->u[1][i]),
                              _mm256_set1_epi32(cubes->u[2][i])};
        __m256i c[3];
        for (int a = 0; a < 3; a++)
            c[a] = cell_along(_mm256_add_epi32(u[a], load(split->centre[a])), cells, a);
        const __m256i row = _mm256_add_epi32(c[1], _mm256_mullo_epi32(c[2], _mm256_set1_epi32(cells->dims[1])));
        int32_t cell[8];
        int8_t value[8];
        store(cell, _mm256_add_epi32(c[0], _mm256_mullo_epi32(row, _mm256_set1_epi32(cells->dims[0]))));
        for (int j = 0; j < 8; j++)
            value[j] = table[cell[j]];
        const __m128i v = _mm_loadl_epi64((const __m128i *)value);
        const unsigned in = (unsigned)_mm_movemask_epi8(_mm_cmpgt_epi8(v, in_above)) & keep;
        const unsigned out = (unsigned)_mm_movemask_epi8(_mm_cmpgt_epi8(out_below, v)) & keep;
        const unsigned mix = keep & ~(in | out);
        const __m256i number = _mm256_add_epi32(_mm256_set1_epi32(cubes->number[i] * 8), part);
        for (int a = 0; a < 3; a++)
            store(mixed->u[a] + m, packed(_mm256_add_epi32(u[a], load(split->first[a])), mix));
        store(mixed->number + m, packed(number, mix));
        store(inside->number + n, packed(number, in));
        m += (size_t)_mm_popcnt_u32(mix);
        n += (size_t)_mm_popcnt_u32(in);
    }
    mixed->count = m;
    inside->count = n;
}

/* ------------------------------------------------------------------ match */

enum { LOW = OST_MAP_FRACTION - OST_TIE_BITS, PIECE = 128 };

/* The positions of the bricks of a piece in their windows, as in remove_avx512.c, and the list of the tied bricks
   (remove.h, "Sixteen bits per lane"). */
typedef struct places {
    _Alignas(32) uint32_t high[3][PIECE]; /* c >> 7 of each brick, a 16-bit value, in both halves of a 32-bit lane */
    uint32_t low[3][PIECE];               /* c mod 2^7 */
    uint32_t line[PIECE]; /* number of the window of each brick; later replaced by the number of the window's line */
    uint32_t tied[PIECE];
} places;

/* Returns floor(voxel / step) for 0 <= voxel < 2^15 and a step of 1, 2 or 3 (ost_window_of in window_avx512.h). */
static inline __m256i windows_of(__m256i voxel, int32_t step)
{
    const int32_t inverse = step == 3 ? 21846 : step == 2 ? 32768 : 65536;
    return _mm256_srli_epi32(_mm256_mullo_epi32(voxel, _mm256_set1_epi32(inverse)), 16);
}

static inline void place_eight(const ost_match *match, const ost_cubes *bricks, size_t from, places *out, size_t to)
{
    const ost_windows *w = &match->shape->windows;
    const __m256i margin = _mm256_set1_epi32(OST_WINDOW_MARGIN), step = _mm256_set1_epi32(w->step);
    __m256i window[3];
    for (int a = 0; a < 3; a++) {
        const __m256i u = _mm256_add_epi32(load(bricks->u[a] + from), _mm256_set1_epi32(match->lowest[a]));
        window[a] = windows_of(_mm256_add_epi32(_mm256_srai_epi32(u, OST_MAP_FRACTION), margin), w->step);
        const __m256i begin = _mm256_slli_epi32(_mm256_sub_epi32(_mm256_mullo_epi32(window[a], step), margin),
                                                OST_MAP_FRACTION);
        const __m256i c = _mm256_sub_epi32(u, begin), high = _mm256_srli_epi32(c, LOW);
        store(out->high[a] + to, _mm256_or_si256(high, _mm256_slli_epi32(high, 16)));
        store(out->low[a] + to, _mm256_and_si256(c, _mm256_set1_epi32((1 << LOW) - 1)));
    }
    const __m256i row = _mm256_add_epi32(window[1], _mm256_mullo_epi32(window[2], _mm256_set1_epi32(w->dims[1])));
    store(out->line + to, _mm256_add_epi32(window[0], _mm256_mullo_epi32(row, _mm256_set1_epi32(w->dims[0]))));
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
        _mm_prefetch((const char *)match->shape->windows.line[at->line[i]], _MM_HINT_T0);
        at->tied[tied] = (uint32_t)i;
        tied += (tie_at(match, at, i, 0) | tie_at(match, at, i, 1) | tie_at(match, at, i, 2)) != 0;
    }
    return tied;
}

/* Packs the high bytes of the 16-bit lanes of two registers. `a` contains the voxels 0..7 and 16..23, and `b` the
   voxels 8..15 and 24..31. The result contains the voxels 0..31 in order. */
static inline __m256i high_bytes(__m256i a, __m256i b)
{
    return _mm256_packus_epi16(_mm256_srli_epi16(a, 8), _mm256_srli_epi16(b, 8));
}

/* The four tables with which the bytes of a window are looked up (see "The shuffles"). t[0] is the first quarter of the
   window. For q > 0, t[q] is quarter q xor quarter q - 1. */
typedef struct quarters {
    __m256i t[4];
} quarters;

static inline quarters quarters_of(const uint8_t line[64])
{
    __m256i t[4];
    for (int q = 0; q < 4; q++)
        t[q] = _mm256_broadcastsi128_si256(_mm_load_si128((const __m128i *)(line + 16 * q)));
    return (quarters){{t[0], _mm256_xor_si256(t[1], t[0]), _mm256_xor_si256(t[2], t[1]), _mm256_xor_si256(t[3], t[2])}};
}

/* Returns the window's bits for 32 voxels. x, y and z contain one byte per voxel, with three bits for the coordinate in
   the window and five bits of fraction. */
static inline uint32_t lookup(const quarters *line, __m256i x, __m256i y, __m256i z)
{
    const __m256i one_of = _mm256_broadcastsi128_si256(
        _mm_setr_epi8(1, 2, 4, 8, 16, 32, 64, -128, 1, 2, 4, 8, 16, 32, 64, -128));
    const __m256i sixteen = _mm256_set1_epi8(16), seven = _mm256_set1_epi8(7);
    const __m256i n = _mm256_or_si256(_mm256_and_si256(_mm256_srli_epi16(y, 2), _mm256_set1_epi8(0x38)),
                                      _mm256_and_si256(_mm256_srli_epi16(z, 5), seven));
    const __m256i bit = _mm256_shuffle_epi8(one_of, _mm256_and_si256(_mm256_srli_epi16(x, 5), seven));
    const __m256i n1 = _mm256_sub_epi8(n, sixteen), n2 = _mm256_sub_epi8(n, _mm256_set1_epi8(32)),
                  n3 = _mm256_sub_epi8(n, _mm256_set1_epi8(48));
    const __m256i row = _mm256_xor_si256(
        _mm256_xor_si256(_mm256_shuffle_epi8(line->t[0], n), _mm256_shuffle_epi8(line->t[1], n1)),
        _mm256_xor_si256(_mm256_shuffle_epi8(line->t[2], n2), _mm256_shuffle_epi8(line->t[3], n3)));
    return (uint32_t)_mm256_movemask_epi8(_mm256_cmpeq_epi8(_mm256_and_si256(row, bit), bit));
}

/* Loads voxels 0..7 and 16..23, so that high_bytes returns the voxels of two such registers in order. */
static inline __m256i ordered(const uint16_t *voxels)
{
    return _mm256_inserti128_si256(_mm256_castsi128_si256(_mm_load_si128((const __m128i *)voxels)),
                                   _mm_load_si128((const __m128i *)(voxels + 16)), 1);
}

/* The offsets of a brick's voxels for one pose, indexed by [half of the brick][register of the half][axis]. */
typedef struct offsets {
    __m256i v[2][2][3];
} offsets;

static inline offsets offsets_of(const uint16_t table[3][64])
{
    offsets o;
    for (int h = 0; h < 2; h++)
        for (int s = 0; s < 2; s++)
            for (int a = 0; a < 3; a++)
                o.v[h][s][a] = ordered(table[a] + 32 * h + 8 * s);
    return o;
}

/* Recomputes the hits of the tied bricks with the carries of the low bits. */
static void match_tied(const ost_match *match, const offsets *high, const places *at, size_t count, uint64_t *hits)
{
    const offsets low = offsets_of(match->low);
    for (size_t t = 0; t < count; t++) {
        const size_t i = at->tied[t];
        const quarters line = quarters_of(match->shape->windows.line[at->line[i]]);
        uint64_t word = 0;
        for (int h = 0; h < 2; h++) {
            __m256i bytes[3];
            for (int a = 0; a < 3; a++) {
                const __m256i c = _mm256_set1_epi32((int32_t)at->high[a][i]),
                              l = _mm256_set1_epi16((int16_t)at->low[a][i]);
                __m256i u[2];
                for (int s = 0; s < 2; s++)
                    u[s] = _mm256_add_epi16(_mm256_add_epi16(c, high->v[h][s][a]),
                                            _mm256_srli_epi16(_mm256_add_epi16(l, low.v[h][s][a]), LOW));
                bytes[a] = high_bytes(u[0], u[1]);
            }
            word |= (uint64_t)lookup(&line, bytes[0], bytes[1], bytes[2]) << (32 * h);
        }
        hits[i] = word;
    }
}

static void match_windows(const ost_match *match, const ost_cubes *bricks, uint64_t *hits)
{
    const offsets o = offsets_of(match->high);
    places at;
    for (size_t piece = 0; piece < bricks->count; piece += PIECE, hits += PIECE) {
        const size_t count = bricks->count - piece < PIECE ? bricks->count - piece : PIECE;
        for (size_t i = 0; i < count; i += 8)
            place_eight(match, bricks, piece + i, &at, i);
        const size_t tied = find_lines(match, count, &at);
        for (size_t i = 0; i < count; i++) {
            const quarters line = quarters_of(match->shape->windows.line[at.line[i]]);
            const __m256i x = _mm256_set1_epi32((int32_t)at.high[0][i]), y = _mm256_set1_epi32((int32_t)at.high[1][i]),
                          z = _mm256_set1_epi32((int32_t)at.high[2][i]);
            uint32_t half[2];
            for (int h = 0; h < 2; h++)
                half[h] = lookup(&line,
                                 high_bytes(_mm256_add_epi16(x, o.v[h][0][0]), _mm256_add_epi16(x, o.v[h][1][0])),
                                 high_bytes(_mm256_add_epi16(y, o.v[h][0][1]), _mm256_add_epi16(y, o.v[h][1][1])),
                                 high_bytes(_mm256_add_epi16(z, o.v[h][0][2]), _mm256_add_epi16(z, o.v[h][1][2])));
            hits[i] = (uint64_t)half[0] | (uint64_t)half[1] << 32;
        }
        match_tied(match, &o, &at, tied, hits);
    }
}

void ost_match_avx2(const ost_match *match, const ost_cubes *bricks, uint64_t *hits)
{
    if (match->windows)
        match_windows(match, bricks, hits);
    else
        ost_match_scalar(match, bricks, hits);
}

/* ------------------------------------------------------------------- take */

static inline __m256i widen16(__m256i v)
{
    return _mm256_add_epi32(_mm256_and_si256(v, _mm256_set1_epi32(0xffff)), _mm256_srli_epi32(v, 16));
}

static inline uint64_t sum32(__m256i v)
{
    uint32_t lane[8];
    uint64_t sum = 0;
    store(lane, v);
    for (int i = 0; i < 8; i++)
        sum += lane[i];
    return sum;
}

/*
 * Adds the hits of `count` bricks to the tally. A brick adds four densities to each 16-bit lane. Such a lane
 * can sum 65535 / take->highest densities before it must be added to a 32-bit lane. A 32-bit lane can sum
 * 512 bricks of 4 * 2 * 32767 < 2^18 each. Callers pass the number of borders as a constant.
 */
static inline __attribute__((always_inline)) void take_bricks(const ost_take *take, int16_t *density,
                                                              const int32_t *number, const uint64_t *hits, size_t count,
                                                              ost_tally *tally, const int borders)
{
    const __m256i zero = _mm256_setzero_si256();
    const __m256i lane = _mm256_setr_epi16(1, 2, 4, 8, 16, 32, 64, 128, 256, 512, 1024, 2048, 4096, 8192, 16384,
                                           INT16_MIN);
    const size_t bricks = (size_t)(65535 / take->highest / 4);
    const bool apply = take->apply;
    __m256i below[3], sum[4], wide[4], voxels[3];
    for (int b = 0; b <= borders; b++)
        sum[b] = wide[b] = zero;
    for (int b = 0; b < borders; b++) {
        /* The densities of hits are at least 1, so a border below 1 has the same effect as a border of 1. */
        below[b] = _mm256_set1_epi16((int16_t)((take->border[b] > 1 ? take->border[b] : 1) - 1));
        voxels[b] = zero;
    }
    uint64_t all = 0;
    for (size_t i = 0; i < count;) {
        const size_t end = count - i < bricks ? count : i + bricks;
        for (; i < end; i++) {
            int16_t *brick = density + (size_t)number[i] * 64;
            const uint64_t hit = hits[i];
            if (i + 16 < count) {
                _mm_prefetch((const char *)(density + (size_t)number[i + 16] * 64), _MM_HINT_T0);
                _mm_prefetch((const char *)(density + (size_t)number[i + 16] * 64 + 32), _MM_HINT_T0);
            }
            for (int q = 0; q < 4; q++) {
                const __m256i mask = _mm256_cmpeq_epi16(
                    _mm256_and_si256(_mm256_set1_epi16((int16_t)(hit >> (16 * q))), lane), lane);
                const __m256i d = load(brick + 16 * q);
                sum[0] = _mm256_add_epi16(sum[0], _mm256_and_si256(d, mask));
                for (int b = 0; b < borders; b++) {
                    const __m256i above = _mm256_and_si256(_mm256_cmpgt_epi16(d, below[b]), mask);
                    sum[b + 1] = _mm256_add_epi16(sum[b + 1], _mm256_and_si256(d, above));
                    voxels[b] = _mm256_sub_epi16(voxels[b], above);
                }
                if (apply)
                    store(brick + 16 * q, _mm256_andnot_si256(mask, d));
            }
            all += (uint64_t)_mm_popcnt_u64(hit);
        }
        for (int b = 0; b <= borders; b++) {
            wide[b] = _mm256_add_epi32(wide[b], widen16(sum[b]));
            sum[b] = zero;
        }
    }
    tally->voxels[0] += all;
    for (int b = 0; b <= borders; b++)
        tally->density[b] += sum32(wide[b]);
    for (int b = 0; b < borders; b++)
        tally->voxels[b + 1] += sum32(widen16(voxels[b]));
}

void ost_take_avx2(const ost_take *take, int16_t *density, const int32_t *number, const uint64_t *hits, size_t count,
                   ost_tally *tally)
{
    if (take->highest > 65535 / 4) {
        ost_take_scalar(take, density, number, hits, count, tally);
        return;
    }
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
