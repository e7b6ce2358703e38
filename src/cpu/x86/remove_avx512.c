/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The kernels of removal for AVX-512 (F, BW, DQ, VL, CD).
 *
 *   blocks  the eight blocks of a unit at once, in 64-bit lanes
 *   split   sixteen parts at once: two parts of each of eight cubes, or four parts of
 *           each of four cubes
 *   match   the 64 voxels of a brick, 32 at a time in 16-bit lanes: a window of 64
 *           bytes is one register, and VPERMW selects its rows
 *   take    a brick is two registers; comparisons with the borders result in masks
 *
 * Indices are stored to memory, and tables are read by scalar loads. Many scalar loads are executed at the
 * same time, so sixteen of them take half the time of a gather instruction.
 *
 * The file has more than 500 lines, because the four kernels share helper functions that are inlined
 * into them.
 *
 * The 16-bit word 4 y + z / 2 of a window contains the bytes of the rows (y, z) and
 * (y, z + 1), where z is even.  A lane contains a coordinate u with 3 bits of voxel and
 * 13 bits of fraction:
 *
 *   word     uy >> 11  ->  y2 y1 y0 f f        uz >> 14  ->  z2 z1
 *            5 bits:       y2 y1 y0 z2 z1      (VPERMW ignores the higher bits)
 *   bit      ux >> 13  ->  x2 x1 x0            uz >> 10  ->  bit 3 is z0
 *            4 bits:    z0 x2 x1 x0
 */
#include <immintrin.h>
#include <string.h>

#include "core/conditions.h"
#include "cpu/kernels.h"
#include "cpu/x86/window_avx512.h"

/* ----------------------------------------------------------------- blocks */

/*
 * Block (x, y, z) of the unit is in lane x + 2y + 4z. The bases are computed with the formula of ost_block_base. If the
 * base of one of the blocks needs a division, the scalar kernel computes all blocks.
 */
void ost_blocks_avx512(const ost_block_bases *bases, const ost_block_reach *reach, const int32_t first[3],
                       const int32_t from[3], const int32_t to[3], ost_cubes *blocks)
{
    /* for each axis, the lanes of the blocks whose index on this axis is first + 1 */
    static const __mmask8 second[3] = {0xaa, 0xcc, 0xf0};
    const int64_t *part[3][2];
    unsigned valid = 0xff, unsure = 0;
    for (int b = 0; b < 3; b++) {
        /* A lane without a block loads the values of a neighbouring block, so that its address is valid. */
        part[b][0] = bases->part[b] + 3 * (size_t)(from[b] - bases->lo[b]);
        part[b][1] = bases->part[b] + 3 * (size_t)(to[b] - 1 - bases->lo[b]);
        valid &= (from[b] == first[b] ? 0xff : second[b]) & (to[b] == first[b] + 2 ? 0xff : ~(unsigned)second[b]);
    }
    __m256i base[3];
    __mmask8 near = (__mmask8)valid;
    for (int a = 0; a < 3; a++) {
        __m512i sum = _mm512_set1_epi64(1 << 15);
        for (int b = 0; b < 3; b++)
            sum = _mm512_add_epi64(sum,
                                   _mm512_mask_set1_epi64(_mm512_set1_epi64(part[b][0][a]), second[b], part[b][1][a]));
        const __m512i wide = _mm512_srai_epi64(sum, 16);
        /* The base needs no division if the low 16 bits of the sum, minus 1, are below 2^16 - 7. */
        const __m512i low = _mm512_and_si512(_mm512_sub_epi64(sum, _mm512_set1_epi64(1)), _mm512_set1_epi64(0xffff));
        unsure |= _mm512_cmpge_epu64_mask(low, _mm512_set1_epi64(0xffff - 6));
        near = _mm512_mask_cmplt_epu64_mask(near, _mm512_add_epi64(wide, _mm512_set1_epi64(1 << 29)),
                                            _mm512_set1_epi64(INT64_C(1) << 31));
        base[a] = _mm512_cvtepi64_epi32(wide);
        near = _mm256_mask_cmplt_epu32_mask(near, _mm256_sub_epi32(base[a], _mm256_set1_epi32(reach->from[a])),
                                            _mm256_set1_epi32((int32_t)reach->width[a]));
    }
    if (unsure & valid) {
        ost_blocks_scalar(bases, reach, first, from, to, blocks);
        return;
    }
    for (int a = 0; a < 3; a++)
        _mm256_store_si256((__m256i *)(void *)blocks->u[a], _mm256_maskz_compress_epi32(near, base[a]));
    _mm256_storeu_si256((__m256i *)(void *)blocks->number,
                        _mm256_maskz_compress_epi32(near, _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7)));
    blocks->count = (size_t)_mm_popcnt_u32(near);
}

/* ------------------------------------------------------------------ split */

/*
 * Computes for each lane the number of the cell that contains the point (x, y, z), or of
 * the nearest cell if the point is outside the table.  An axis has at most 2^15 cells,
 * so that y and dims[0] fit in 16 bits and their product fits in 32 bits.
 */
static inline __m512i cells_of(const ost_cells *cells, __m512i x, __m512i y, __m512i z)
{
    const __m512i zero = _mm512_setzero_si512(), margin = _mm512_set1_epi32(cells->margin),
                  shift = _mm512_set1_epi32(cells->shift);
    x = _mm512_add_epi32(_mm512_srav_epi32(x, shift), margin);
    y = _mm512_add_epi32(_mm512_srav_epi32(y, shift), margin);
    z = _mm512_add_epi32(_mm512_srav_epi32(z, shift), margin);
    x = _mm512_min_epi32(_mm512_max_epi32(x, zero), _mm512_set1_epi32(cells->dims[0] - 1));
    y = _mm512_min_epi32(_mm512_max_epi32(y, zero), _mm512_set1_epi32(cells->dims[1] - 1));
    z = _mm512_min_epi32(_mm512_max_epi32(z, zero), _mm512_set1_epi32(cells->dims[2] - 1));
    const __m512i row = _mm512_madd_epi16(y, _mm512_set1_epi32(cells->dims[0]));
    const __m512i slice = _mm512_mullo_epi32(z, _mm512_set1_epi32(cells->dims[0] * cells->dims[1]));
    return _mm512_add_epi32(x, _mm512_add_epi32(row, slice));
}

/*
 * Cubes are processed in groups of eight, with two parts of each cube per register: lanes 0..7 of
 * register q are part 2q of the eight cubes, lanes 8..15 are part 2q + 1.  If the last group has at most four cubes, a
 * register has four parts of each cube, so that all lanes are used. This case is frequent, because a unit has few
 * blocks. The cells of all groups are found first, then the values of the cells are read one by one, and then the parts
 * are classified.
 */
enum { GROUPS = 8, PIECE_CUBES = 8 * GROUPS };
typedef struct split_piece {
    _Alignas(64) int32_t cell[GROUPS][64];
    _Alignas(64) int8_t value[GROUPS][64];
    /* bit p of keep[c] is set if part p of cube c is to be classified; elements beyond the last cube are 0 */
    _Alignas(8) uint8_t keep[PIECE_CUBES + 8];
    /* the cubes of the piece that have active voxels; used only if the occupancy of the cubes' parts is available */
    int32_t u[3][PIECE_CUBES + 8], number[PIECE_CUBES + 8];
} split_piece;
/* The cubes of a piece. The pointers refer to elements of the kernel's list or of a split_piece. */
typedef struct some_cubes {
    const int32_t *u[3], *number;
    size_t count;
} some_cubes;

#define INLINED static inline __attribute__((always_inline))

/* Returns for each lane of register q the number of the part in this lane. A register contains parts of `wide` cubes,
   8 or 4. */
INLINED __m512i part_numbers(int wide, int q)
{
    const __m512i of_two = _mm512_setr_epi32(0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 1, 1, 1, 1);
    const __m512i of_four = _mm512_setr_epi32(0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3);
    return wide == 8 ? _mm512_add_epi32(of_two, _mm512_set1_epi32(2 * q))
                     : _mm512_add_epi32(of_four, _mm512_set1_epi32(4 * q));
}

/* Returns eight[p] in each lane in which register q contains part p of a cube. */
INLINED __m512i parts(const int32_t eight[8], int wide, int q)
{
    if (wide == 8)
        return _mm512_mask_set1_epi32(_mm512_set1_epi32(eight[2 * q]), 0xff00, eight[2 * q + 1]);
    const __m512i all = _mm512_castsi256_si512(_mm256_load_si256((const __m256i *)(const void *)eight));
    return _mm512_permutexvar_epi32(part_numbers(4, q), all);
}

INLINED __m512i repeated(const int32_t *u, int wide)
{
    return wide == 8 ? _mm512_broadcast_i64x4(_mm256_loadu_si256((const __m256i *)(const void *)u))
                     : _mm512_broadcast_i32x4(_mm_loadu_si128((const __m128i *)(const void *)u));
}

/* Returns all cubes of a piece and marks all their parts in `keep`. */
static inline some_cubes all_cubes(const ost_cubes *cubes, size_t from, size_t count, split_piece *piece)
{
    memset(piece->keep, 0xff, count);
    memset(piece->keep + count, 0, 8);
    return (some_cubes){{cubes->u[0] + from, cubes->u[1] + from, cubes->u[2] + from}, cubes->number + from, count};
}

/*
 * Selects the parts with active voxels. Cubes without active voxels are dropped before their parts are classified: in a
 * sequence of ticks, these are a third of the cubes, because the tool moves in a space that it has emptied itself.
 */
static inline some_cubes active_cubes(const ost_cubes *cubes, size_t from, size_t count, const uint64_t *occupancy,
                                      split_piece *piece)
{
    size_t n = 0;
    for (size_t begin = 0; begin < count; begin += 8) {
        const size_t eight = count - begin < 8 ? count - begin : 8, at = n;
        unsigned active = 0;
        for (size_t c = 0; c < eight; c++) {
            const __m512i words = _mm512_loadu_si512(occupancy + 8 * cubes->number[from + begin + c]);
            const unsigned parts = _mm512_test_epi64_mask(words, words);
            piece->keep[n] = (uint8_t)parts;
            n += parts != 0;
            active |= (unsigned)(parts != 0) << c;
        }
        for (int a = 0; a < 3; a++)
            _mm256_storeu_si256((__m256i *)(void *)(piece->u[a] + at),
                                _mm256_maskz_compress_epi32((__mmask8)active,
                                                            _mm256_loadu_si256((const __m256i *)(const void *)(
                                                                cubes->u[a] + from + begin))));
        _mm256_storeu_si256((__m256i *)(void *)(piece->number + at),
                            _mm256_maskz_compress_epi32((__mmask8)active,
                                                        _mm256_loadu_si256((const __m256i *)(const void *)(
                                                            cubes->number + from + begin))));
    }
    memset(piece->keep + n, 0, 8);
    return (some_cubes){{piece->u[0], piece->u[1], piece->u[2]}, piece->number, n};
}

INLINED void find_cells(const ost_split *split, const ost_cells *cells, const some_cubes *cubes, size_t from, int wide,
                        int32_t out[64])
{
    const __m512i x = repeated(cubes->u[0] + from, wide), y = repeated(cubes->u[1] + from, wide),
                  z = repeated(cubes->u[2] + from, wide);
    for (int q = 0; q < wide / 2; q++)
        _mm512_store_si512(out + 16 * q, cells_of(cells, _mm512_add_epi32(x, parts(split->centre[0], wide, q)),
                                                  _mm512_add_epi32(y, parts(split->centre[1], wide, q)),
                                                  _mm512_add_epi32(z, parts(split->centre[2], wide, q))));
}

INLINED void read_cells(const int8_t *table, const int32_t *cell, int wide, int8_t *value)
{
    for (int j = 0; j < 8 * wide; j += 4) {
        value[j] = table[cell[j]];
        value[j + 1] = table[cell[j + 1]];
        value[j + 2] = table[cell[j + 2]];
        value[j + 3] = table[cell[j + 3]];
    }
}

/* Returns the mask of the lanes of register q whose parts are kept. Part p of cube c is kept if bit p of byte c of
   `keep` is set. */
INLINED __mmask16 kept_of(uint64_t keep, int wide, int q)
{
    if (wide == 8)
        return _mm_test_epi8_mask(_mm_set1_epi64x((long long)keep),
                                  _mm_set_epi64x((long long)(UINT64_C(0x0202020202020202) << 2 * q),
                                                 (long long)(UINT64_C(0x0101010101010101) << 2 * q)));
    return _mm_test_epi8_mask(_mm_set1_epi32((int32_t)keep),
                              _mm_slli_epi32(_mm_setr_epi32(0x01010101, 0x02020202, 0x04040404, 0x08080808), 4 * q));
}

/* Appends the parts of a group that are mixed to the list `mixed`, and those that are inside to the list `inside`. */
INLINED void sort_parts(const ost_split *split, const some_cubes *cubes, size_t from, int wide, const int8_t *value,
                        uint64_t keep, ost_cubes *mixed, ost_numbers *inside, size_t *m, size_t *n)
{
    /* No value of a cell exceeds 64 in magnitude, so limiting split->least to 127 changes no result. */
    const int least = split->least < 127 ? split->least : 127;
    const __m128i high = _mm_set1_epi8((int8_t)least), low = _mm_set1_epi8((int8_t)-least);
    const __m512i x = repeated(cubes->u[0] + from, wide), y = repeated(cubes->u[1] + from, wide),
                  z = repeated(cubes->u[2] + from, wide);
    const __m512i number = _mm512_slli_epi32(repeated(cubes->number + from, wide), 3);
    for (int q = 0; q < wide / 2; q++) {
        const __m128i v = _mm_load_si128((const __m128i *)(const void *)(value + 16 * q));
        const __mmask16 kept = kept_of(keep, wide, q);
        const __mmask16 in = _mm_mask_cmpge_epi8_mask(kept, v, high);
        const __mmask16 mix = kept & ~(in | _mm_cmple_epi8_mask(v, low));
        const __m512i part = _mm512_add_epi32(number, part_numbers(wide, q));
        _mm512_storeu_si512(mixed->u[0] + *m,
                            _mm512_maskz_compress_epi32(mix, _mm512_add_epi32(x, parts(split->first[0], wide, q))));
        _mm512_storeu_si512(mixed->u[1] + *m,
                            _mm512_maskz_compress_epi32(mix, _mm512_add_epi32(y, parts(split->first[1], wide, q))));
        _mm512_storeu_si512(mixed->u[2] + *m,
                            _mm512_maskz_compress_epi32(mix, _mm512_add_epi32(z, parts(split->first[2], wide, q))));
        _mm512_storeu_si512(mixed->number + *m, _mm512_maskz_compress_epi32(mix, part));
        _mm512_storeu_si512(inside->number + *n, _mm512_maskz_compress_epi32(in, part));
        *m += (size_t)_mm_popcnt_u32(mix);
        *n += (size_t)_mm_popcnt_u32(in);
    }
}

static inline uint64_t eight_bytes(const uint8_t *bytes)
{
    uint64_t word;
    memcpy(&word, bytes, 8);
    return word;
}

void ost_split_avx512(const ost_split *split, const ost_cells *cells, const ost_cubes *cubes, const uint64_t *occupancy,
                      ost_cubes *mixed, ost_numbers *inside)
{
    /* The pointer is copied, because the compiler must assume that a store of a byte changes cells->value. */
    const int8_t *const table = cells->value;
    split_piece piece;
    size_t m = mixed->count, n = inside->count;
    for (size_t from = 0; from < cubes->count; from += PIECE_CUBES) {
        const size_t left = cubes->count - from, piece_count = left < PIECE_CUBES ? left : PIECE_CUBES;
        const some_cubes some = occupancy ? active_cubes(cubes, from, piece_count, occupancy, &piece)
                                          : all_cubes(cubes, from, piece_count, &piece);
        const size_t remainder = some.count % 8, full = some.count / 8 + (remainder > 4);
        const bool narrow = remainder > 0 && remainder <= 4;
        for (size_t g = 0; g < full; g++)
            find_cells(split, cells, &some, 8 * g, 8, piece.cell[g]);
        if (narrow)
            find_cells(split, cells, &some, 8 * full, 4, piece.cell[full]);
        for (size_t g = 0; g < full; g++)
            read_cells(table, piece.cell[g], 8, piece.value[g]);
        if (narrow)
            read_cells(table, piece.cell[full], 4, piece.value[full]);
        for (size_t g = 0; g < full; g++)
            sort_parts(split, &some, 8 * g, 8, piece.value[g], eight_bytes(piece.keep + 8 * g), mixed, inside, &m, &n);
        if (narrow)
            sort_parts(split, &some, 8 * full, 4, piece.value[full], eight_bytes(piece.keep + 8 * full), mixed, inside,
                       &m, &n);
    }
    mixed->count = m;
    inside->count = n;
}

/* ------------------------------------------------------------------ match */

enum { LOW = OST_MAP_FRACTION - OST_TIE_BITS };

/*
 * Bricks are processed in pieces of PIECE bricks. A piece has three passes: the first computes the positions
 * of the bricks in their windows, the second finds the lines of the windows, and the third looks up the
 * voxels.
 */
enum { PIECE = 128 };
/*
 * The positions of the bricks of a piece. c is the least coordinate of a brick, relative to the first voxel
 * of the brick's window (remove.h).
 */
typedef struct places {
    _Alignas(64) uint32_t high[3][PIECE]; /* c >> 7 of each brick, a 16-bit value, in both halves of a 32-bit lane */
    uint32_t low[3][PIECE];               /* c mod 2^7 */
    /* number of the window of each brick; later replaced by the number of the window's line */
    uint32_t line[PIECE];
    /* bricks whose coordinates are near a tie (near_tie); their hits may be recomputed with carries */
    uint32_t tied[PIECE + 16];
} places;

/*
 * Returns the mask of the lanes whose c is near a tie. A value c is near a tie if bit (c >> LOW >> 3) % 1024
 * of `near` is set. The rotation instruction uses its count modulo 32.
 */
static inline __mmask16 near_tie(const uint32_t near[32], __m512i c)
{
    const __m512i word = _mm512_permutex2var_epi32(_mm512_load_si512(near), _mm512_srli_epi32(c, LOW + 3 + 5),
                                                   _mm512_load_si512(near + 16));
    return _mm512_test_epi32_mask(word, _mm512_rolv_epi32(_mm512_set1_epi32(1), _mm512_srli_epi32(c, LOW + 3)));
}

/*
 * Computes the positions of the bricks `from` to `from` + 15. If the list has fewer bricks, the values of the
 * remaining lanes are not used. Returns the mask of the lanes whose bricks are near a tie.
 */
static inline __mmask16 place_sixteen(const ost_match *match, const ost_cubes *bricks, size_t from, places *out,
                                      size_t to)
{
    const ost_windows *w = &match->shape->windows;
    const __m512i margin = _mm512_set1_epi32(OST_WINDOW_MARGIN), step = _mm512_set1_epi32(w->step);
    __m512i window[3];
    __mmask16 near = 0;
    for (int a = 0; a < 3; a++) {
        const __m512i u = _mm512_add_epi32(_mm512_load_si512(bricks->u[a] + from), _mm512_set1_epi32(match->lowest[a]));
        window[a] = ost_window_of(ost_window_voxel(u, OST_WINDOW_MARGIN), w->step);
        const __m512i begin = _mm512_slli_epi32(_mm512_sub_epi32(_mm512_madd_epi16(window[a], step), margin),
                                                OST_MAP_FRACTION);
        const __m512i c = _mm512_sub_epi32(u, begin), high = _mm512_srli_epi32(c, LOW);
        _mm512_store_si512(out->high[a] + to, _mm512_or_si512(high, _mm512_slli_epi32(high, 16)));
        _mm512_store_si512(out->low[a] + to, _mm512_and_si512(c, _mm512_set1_epi32((1 << LOW) - 1)));
        near |= near_tie(match->near_tie[a], c);
    }
    _mm512_store_si512(out->line + to, ost_window_number(w, window));
    return near;
}

/*
 * Computes the positions of all bricks of a piece, and lists the bricks near a tie. Returns the number of listed
 * bricks.
 */
static inline size_t place_all(const ost_match *match, const ost_cubes *bricks, size_t from, size_t count, places *at)
{
    const __m512i sixteen = _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
    size_t tied = 0;
    for (size_t i = 0; i < count; i += 16) {
        const unsigned valid = count - i < 16 ? (1u << (count - i)) - 1 : 0xffff;
        const __mmask16 near = (__mmask16)(place_sixteen(match, bricks, from + i, at, i) & valid);
        _mm512_storeu_si512(at->tied + tied,
                            _mm512_maskz_compress_epi32(near, _mm512_add_epi32(sixteen, _mm512_set1_epi32((int)i))));
        tied += (size_t)_mm_popcnt_u32(near);
    }
    return tied;
}

static inline bool is_tied(const ost_match *match, const places *at, size_t i)
{
    const uint8_t *const tie = match->tie;
    const uint32_t fraction = (1u << OST_TIE_BITS) - 1;
    return ((tie[at->high[0][i] & fraction] & 1) | (tie[at->high[1][i] & fraction] & 2) |
            (tie[at->high[2][i] & fraction] & 4)) != 0;
}

/* Returns the window's bits for 32 voxels. x, y and z are the coordinates of the voxels in the window. */
static inline __mmask32 lookup(__m512i line, __m512i x, __m512i y, __m512i z)
{
    /* The ternary function 0xe4 selects the bit of the first operand if the bit of the third operand is set, otherwise
       the bit of the second operand. */
    const __m512i word = _mm512_ternarylogic_epi32(_mm512_srli_epi16(z, 14), _mm512_srli_epi16(y, 11),
                                                   _mm512_set1_epi16(3), 0xe4);
    const __m512i bit = _mm512_ternarylogic_epi32(_mm512_srli_epi16(z, 10), _mm512_srli_epi16(x, 13),
                                                  _mm512_set1_epi16(8), 0xe4);
    return _mm512_test_epi16_mask(_mm512_permutexvar_epi16(word, line), _mm512_sllv_epi16(_mm512_set1_epi16(1), bit));
}

/* Determines which of the `count` bricks near a tie are tied, and recomputes the hits of the tied bricks with the
   carries of the low bits. */
static void match_tied(const ost_match *match, const places *at, size_t count, uint64_t *hits)
{
    for (size_t t = 0; t < count; t++) {
        const size_t i = at->tied[t];
        if (!is_tied(match, at, i))
            continue;
        const __m512i line = _mm512_load_si512(match->shape->windows.line[at->line[i]]);
        __mmask32 half[2];
        for (int h = 0; h < 2; h++) {
            __m512i u[3];
            for (int a = 0; a < 3; a++) {
                const __m512i low = _mm512_add_epi16(_mm512_load_si512(match->low[a] + 32 * h),
                                                     _mm512_set1_epi16((int16_t)at->low[a][i]));
                const __m512i high = _mm512_add_epi16(_mm512_load_si512(match->high[a] + 32 * h),
                                                      _mm512_set1_epi32((int32_t)at->high[a][i]));
                u[a] = _mm512_add_epi16(high, _mm512_srli_epi16(low, LOW));
            }
            half[h] = lookup(line, u[0], u[1], u[2]);
        }
        hits[i] = (uint64_t)half[0] | (uint64_t)half[1] << 32;
    }
}

static void match_windows(const ost_match *match, const ost_cubes *bricks, uint64_t *hits)
{
    const uint8_t(*const line)[64] = match->shape->windows.line;
    const __m512i x0 = _mm512_load_si512(match->high[0]), x1 = _mm512_load_si512(match->high[0] + 32);
    const __m512i y0 = _mm512_load_si512(match->high[1]), y1 = _mm512_load_si512(match->high[1] + 32);
    const __m512i z0 = _mm512_load_si512(match->high[2]), z1 = _mm512_load_si512(match->high[2] + 32);
    places at;
    for (size_t piece = 0; piece < bricks->count; piece += PIECE, hits += PIECE) {
        const size_t count = bricks->count - piece < PIECE ? bricks->count - piece : PIECE;
        const size_t tied = place_all(match, bricks, piece, count, &at);
        ost_find_lines(&match->shape->windows, count, at.line);
        for (size_t i = 0; i < count; i++) {
            const __m512i window = _mm512_load_si512(line[at.line[i]]);
            const __m512i x = _mm512_set1_epi32((int32_t)at.high[0][i]), y = _mm512_set1_epi32((int32_t)at.high[1][i]),
                          z = _mm512_set1_epi32((int32_t)at.high[2][i]);
            /* Storing the masks directly avoids a move to general registers. */
            __mmask32 *half = (__mmask32 *)(void *)(hits + i);
            _store_mask32(half,
                          lookup(window, _mm512_add_epi16(x, x0), _mm512_add_epi16(y, y0), _mm512_add_epi16(z, z0)));
            _store_mask32(half + 1,
                          lookup(window, _mm512_add_epi16(x, x1), _mm512_add_epi16(y, y1), _mm512_add_epi16(z, z1)));
        }
        match_tied(match, &at, tied, hits);
    }
}

/* Computes the hits of bricks from the bits of the tool, for sixteen voxels at once. Used if there are no windows. */
static void match_voxels(const ost_match *match, const ost_cubes *bricks, uint64_t *hits)
{
    const ost_shape *s = match->shape;
    /* A row has `halves` words of 32 bits. A tool has at most 2^20 rows of 32 such words, so an index fits in int32. */
    const __m512i halves = _mm512_set1_epi32(2 * (int32_t)s->words);
    const __m512i dx = _mm512_set1_epi32(s->dims[0]), dy = _mm512_set1_epi32(s->dims[1]),
                  dz = _mm512_set1_epi32(s->dims[2]);
    const __m512i first_bit = _mm512_set1_epi32(1), within = _mm512_set1_epi32(31);
    for (size_t i = 0; i < bricks->count; i++) {
        uint64_t word = 0;
        for (int q = 0; q < 4; q++) {
            __m512i v[3];
            for (int a = 0; a < 3; a++)
                v[a] = _mm512_srai_epi32(
                    _mm512_add_epi32(_mm512_loadu_si512(match->offset[a] + 16 * q), _mm512_set1_epi32(bricks->u[a][i])),
                    OST_MAP_FRACTION);
            /* Compared as unsigned numbers, negative coordinates are above every dimension. */
            __mmask16 in = _mm512_cmplt_epu32_mask(v[0], dx);
            in = _mm512_mask_cmplt_epu32_mask(in, v[1], dy);
            in = _mm512_mask_cmplt_epu32_mask(in, v[2], dz);
            const __m512i row = _mm512_add_epi32(v[1], _mm512_mullo_epi32(dy, v[2]));
            const __m512i at = _mm512_add_epi32(_mm512_srli_epi32(v[0], 5), _mm512_mullo_epi32(halves, row));
            const __m512i bits = _mm512_mask_i32gather_epi32(_mm512_setzero_si512(), in, at, s->bits, 4);
            const __m512i own = _mm512_srlv_epi32(bits, _mm512_and_si512(v[0], within));
            word |= (uint64_t)_mm512_test_epi32_mask(own, first_bit) << (16 * q);
        }
        hits[i] = word;
    }
}

void ost_match_avx512(const ost_match *match, const ost_cubes *bricks, uint64_t *hits)
{
    if (match->windows)
        match_windows(match, bricks, hits);
    else
        match_voxels(match, bricks, hits);
}

/* ------------------------------------------------------------------- take */

enum { AHEAD = 16 }; /* prefetch distance, in bricks */

/* Returns the sum of the unsigned 16-bit lanes of v. */
static inline uint64_t sum16(__m512i v)
{
    const __m512i even = _mm512_and_si512(v, _mm512_set1_epi32(0xffff)), odd = _mm512_srli_epi32(v, 16);
    return (uint32_t)_mm512_reduce_add_epi32(_mm512_add_epi32(even, odd));
}

static inline __m512i widen16(__m512i v)
{
    return _mm512_add_epi32(_mm512_and_si512(v, _mm512_set1_epi32(0xffff)), _mm512_srli_epi32(v, 16));
}

/*
 * Adds the hits of `count` bricks to the tally. A brick adds two densities to each 16-bit
 * lane, which can sum 65535 / take->highest (at least two) densities before it must be
 * added to a 32-bit lane. A 32-bit lane can sum 512 bricks of 2 * 2 * 32767 < 2^17 each.
 * Callers pass the number of borders as a constant, so that all sums stay in registers.
 */
static inline __attribute__((always_inline)) void take_bricks(const ost_take *take, int16_t *density,
                                                              const int32_t *number, const uint64_t *hits, size_t count,
                                                              ost_tally *tally, const int borders)
{
    const __m512i zero = _mm512_setzero_si512(), minus_one = _mm512_set1_epi16(-1);
    const size_t bricks = (size_t)(65535 / take->highest / 2);
    const bool apply = take->apply;
    __m512i border[3], sum[4], wide[4], voxels[3];
    for (int b = 0; b <= borders; b++)
        sum[b] = wide[b] = zero;
    for (int b = 0; b < borders; b++) {
        border[b] = _mm512_set1_epi16(take->border[b]);
        voxels[b] = zero;
    }
    uint64_t all = 0;
    for (size_t i = 0; i < count;) {
        const size_t end = count - i < bricks ? count : i + bricks;
        for (; i < end; i++) {
            int16_t *brick = density + (size_t)number[i] * 64;
            const uint64_t hit = hits[i];
            const __mmask32 k0 = (__mmask32)hit, k1 = (__mmask32)(hit >> 32);
            const __m512i d0 = _mm512_load_si512(brick), d1 = _mm512_load_si512(brick + 32);
            if (i + AHEAD < count) {
                _mm_prefetch((const char *)(density + (size_t)number[i + AHEAD] * 64), _MM_HINT_T0);
                _mm_prefetch((const char *)(density + (size_t)number[i + AHEAD] * 64 + 32), _MM_HINT_T0);
            }
            sum[0] = _mm512_mask_add_epi16(sum[0], k0, sum[0], d0);
            sum[0] = _mm512_mask_add_epi16(sum[0], k1, sum[0], d1);
            for (int b = 0; b < borders; b++) {
                const __mmask32 c0 = _mm512_mask_cmpge_epi16_mask(k0, d0, border[b]),
                                c1 = _mm512_mask_cmpge_epi16_mask(k1, d1, border[b]);
                sum[b + 1] = _mm512_mask_add_epi16(sum[b + 1], c0, sum[b + 1], d0);
                sum[b + 1] = _mm512_mask_add_epi16(sum[b + 1], c1, sum[b + 1], d1);
                voxels[b] = _mm512_mask_sub_epi16(voxels[b], c0, voxels[b], minus_one);
                voxels[b] = _mm512_mask_sub_epi16(voxels[b], c1, voxels[b], minus_one);
            }
            all += (uint64_t)_mm_popcnt_u64(hit);
            if (apply) {
                _mm512_mask_storeu_epi16(brick, k0, zero);
                _mm512_mask_storeu_epi16(brick + 32, k1, zero);
            }
        }
        for (int b = 0; b <= borders; b++) {
            wide[b] = _mm512_add_epi32(wide[b], widen16(sum[b]));
            sum[b] = zero;
        }
    }
    tally->voxels[0] += all;
    for (int b = 0; b <= borders; b++)
        tally->density[b] += (uint32_t)_mm512_reduce_add_epi32(wide[b]);
    for (int b = 0; b < borders; b++)
        tally->voxels[b + 1] += sum16(voxels[b]);
}

/*
 * Processes the bricks in pieces of 512, so that no lane overflows. In a piece, a count
 * is at most 512 * 2, a sum of densities in a 32-bit lane is below 512 * 2^17 = 2^26, and
 * the sum of 16 of these lanes is below 2^30.
 */
void ost_take_avx512(const ost_take *take, int16_t *density, const int32_t *number, const uint64_t *hits, size_t count,
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
