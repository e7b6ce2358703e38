/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The kernel `match` for AVX-512 VBMI. One register contains the 64 voxels of a brick, one byte per voxel, and another
 * register contains the 64 bytes of a window (remove.h, "Carries").
 *
 *   place    sixteen bricks at once: finds the window and, for each axis, the voxel in the window and the rank of the
 *            fraction
 *   look up  one brick: for each voxel, two masked additions compute the number 8 y + z of the byte, and a masked move
 *            selects the bit for x; VPERMB selects the bytes
 *
 * A brick takes about ten instructions on 512-bit registers; the kernel for AVX-512 needs 26.
 *
 * A wide window fills eight registers. Four VPERMI2B instructions select bytes from two registers each, and masked
 * moves select from the four results.
 */
#include <immintrin.h>

#include "core/conditions.h"
#include "cpu/kernels.h"
#include "cpu/x86/window_avx512.h"

/* ----------------------------------------------------------------- tables */

/* Returns the offsets of the voxels 16 q to 16 q + 15 from the least coordinate of the brick along axis a. */
static inline __m512i offsets_of(const ost_match *match, int a, int q)
{
    return _mm512_sub_epi32(_mm512_loadu_si512(match->offset[a] + 16 * q), _mm512_set1_epi32(match->lowest[a]));
}

/*
 * Sorts the 64 thresholds of axis a. A key is a threshold times 64 plus the number of its voxel, so that all keys
 * differ; the position of a key is the number of smaller keys.
 */
static void sort_thresholds(const ost_match *match, int a, ost_carries *out)
{
    _Alignas(64) uint32_t key[64];
    _Alignas(64) uint8_t position[64], element[64];
    uint64_t voxel_of[64];
    const __m512i lanes = _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15),
                  one = _mm512_set1_epi32(1);
    __m512i keys[4], smaller[4];
    for (int q = 0; q < 4; q++) {
        const __m512i fraction = _mm512_and_si512(offsets_of(match, a, q), _mm512_set1_epi32(OST_WINDOW_FRACTION));
        const __m512i threshold = _mm512_sub_epi32(_mm512_set1_epi32(1 << OST_MAP_FRACTION), fraction);
        keys[q] = _mm512_add_epi32(_mm512_slli_epi32(threshold, 6),
                                   _mm512_add_epi32(lanes, _mm512_set1_epi32(16 * q)));
        _mm512_store_si512(key + 16 * q, keys[q]);
        smaller[q] = _mm512_setzero_si512();
    }
    for (int v = 0; v < 64; v++) {
        const __m512i other = _mm512_set1_epi32((int32_t)key[v]);
        for (int q = 0; q < 4; q++)
            smaller[q] = _mm512_mask_add_epi32(smaller[q], _mm512_cmplt_epu32_mask(other, keys[q]), smaller[q], one);
    }
    for (int q = 0; q < 4; q++) {
        const __m512i k = _mm512_and_si512(smaller[q], _mm512_set1_epi32(3)), g = _mm512_srli_epi32(smaller[q], 2);
        _mm_store_si128((__m128i *)(void *)(position + 16 * q), _mm512_cvtepi32_epi8(smaller[q]));
        _mm_store_si128((__m128i *)(void *)(element + 16 * q),
                        _mm512_cvtepi32_epi8(_mm512_add_epi32(_mm512_slli_epi32(k, 4), g)));
    }
    uint32_t *const threshold = out->threshold[a][0];
    for (int v = 0; v < 64; v++) {
        threshold[element[v]] = key[v] >> 6;
        voxel_of[position[v]] = UINT64_C(1) << v;
    }
    uint64_t mask = 0;
    for (int r = 0; r < 64; r++) {
        out->mask[a][r] = mask;
        mask |= voxel_of[r];
    }
}

/* Returns one byte for each of the 64 voxels of a brick: floor(offset) along axis a, in complete tool voxels. */
static __m512i whole_offsets(const ost_match *match, int a)
{
    _Alignas(64) uint8_t whole[64];
    for (int q = 0; q < 4; q++)
        _mm_store_si128((__m128i *)(void *)(whole + 16 * q),
                        _mm512_cvtepi32_epi8(_mm512_srli_epi32(offsets_of(match, a, q), OST_MAP_FRACTION)));
    return _mm512_load_si512(whole);
}

/* Computes the tables for windows of 8^3 voxels, whose bytes have the numbers 8 y + z. */
static void make_rows(__m512i x, __m512i y, __m512i z, ost_carries *out)
{
    /* 8 y fits in a byte, and no bit moves to the next byte, because y < 8. */
    const __m512i row = _mm512_add_epi8(_mm512_slli_epi16(y, 3), z);
    for (int k = 0; k < 9; k++)
        _mm512_storeu_si512(out->row[k], _mm512_add_epi8(row, _mm512_set1_epi8((char)(8 * (k % 3) + k / 3))));
    const __m512i bits = _mm512_broadcast_i32x4(_mm_setr_epi8(1, 2, 4, 8, 16, 32, 64, -128, 0, 0, 0, 0, 0, 0, 0, 0));
    for (int k = 0; k < 4; k++)
        _mm512_storeu_si512(out->bit[k], _mm512_shuffle_epi8(bits, _mm512_add_epi8(x, _mm512_set1_epi8((char)k))));
}

void ost_match_carries_avx512vbmi(ost_match *match)
{
    ost_carries *const out = &match->carries;
    for (int a = 0; a < 3; a++)
        sort_thresholds(match, a, out);
    const __m512i x = whole_offsets(match, 0), y = whole_offsets(match, 1), z = whole_offsets(match, 2);
    if (match->windows)
        make_rows(x, y, z, out);
    else { /* 16 y fits in a byte, because y is below 16 */
        _mm512_storeu_si512(out->wide[0], _mm512_add_epi8(_mm512_slli_epi16(y, 4), z));
        _mm512_storeu_si512(out->wide[1], x);
    }
}

/* ------------------------------------------------------------------ match */

/* The tables with which the rank of a fraction is found. The thresholds are divided into 16 groups of four. A binary
   search over the greatest thresholds of the groups finds the group; the fraction is then compared with the other three
   thresholds of this group. The tables are rotated so that the result of each step is the index for the next step. */
typedef struct rank_tables {
    /*
     * The greatest thresholds of the groups. Element i belongs to group
     *   7 in `middle`     (i + 3) mod 16 in `quarter`     (i + 1) mod 16 in `eighth`     i in `last`
     */
    __m512i middle, quarter, eighth, last;
    __m512i group[3];
} rank_tables;

static inline rank_tables rank_tables_of(const uint32_t threshold[4][16])
{
    const __m512i fourth = _mm512_load_si512(threshold[3]);
    return (rank_tables){
        .middle = _mm512_set1_epi32((int32_t)threshold[3][7]),
        .quarter = _mm512_alignr_epi32(fourth, fourth, 3),
        .eighth = _mm512_alignr_epi32(fourth, fourth, 1),
        .last = fourth,
        .group = {_mm512_load_si512(threshold[0]), _mm512_load_si512(threshold[1]), _mm512_load_si512(threshold[2])}};
}

static inline __m512i step_if_reached(__m512i rank, __m512i fraction, __m512i threshold, int step)
{
    return _mm512_mask_add_epi32(rank, _mm512_cmpge_epu32_mask(fraction, threshold), rank, _mm512_set1_epi32(step));
}

/* Returns the rank of each lane's fraction: the number of thresholds that the fraction reaches. */
static inline __m512i ranks_of(const rank_tables *t, __m512i fraction)
{
    __m512i group = step_if_reached(_mm512_setzero_si512(), fraction, t->middle, 8);
    group = step_if_reached(group, fraction, _mm512_permutexvar_epi32(group, t->quarter), 4);
    group = step_if_reached(group, fraction, _mm512_permutexvar_epi32(group, t->eighth), 2);
    group = step_if_reached(group, fraction, _mm512_permutexvar_epi32(group, t->last), 1);
    __m512i rank = _mm512_slli_epi32(group, 2);
    for (int k = 0; k < 3; k++)
        rank = step_if_reached(rank, fraction, _mm512_permutexvar_epi32(group, t->group[k]), 1);
    return rank;
}

enum { PIECE = 128 };
/* For each of up to PIECE bricks, the position of the brick in its window. */
typedef struct places {
    _Alignas(64) uint32_t rank[3][PIECE];
    /* Let (x, y, z) be the voxel of the window that contains the least coordinate of the brick. `bit` is x. `row` is
       the index y + 3 z in ost_carries.row or, for wide windows, the byte number 16 y + z. */
    uint32_t row[PIECE], bit[PIECE];
    /* number of the window of each brick; later replaced by the number of the window's line */
    uint32_t line[PIECE];
} places;

/* Computes the positions of `count` bricks. With the y and z of `places`, at->row[i] is y row_y + z row_z. */
static inline void place_piece(const ost_match *match, const ost_windows *w, int32_t margin, int row_y, int row_z,
                               const rank_tables tables[3], const ost_cubes *bricks, size_t from, size_t count,
                               places *at)
{
    const __m512i fraction = _mm512_set1_epi32(OST_WINDOW_FRACTION), step = _mm512_set1_epi32(w->step);
    for (size_t i = 0; i < count; i += 16) {
        __m512i window[3], first[3];
        for (int a = 0; a < 3; a++) {
            const __m512i u = _mm512_add_epi32(_mm512_load_si512(bricks->u[a] + from + i),
                                               _mm512_set1_epi32(match->lowest[a]));
            const __m512i voxel = ost_window_voxel(u, margin);
            window[a] = ost_window_of(voxel, w->step);
            first[a] = _mm512_sub_epi32(voxel, _mm512_madd_epi16(window[a], step));
            _mm512_store_si512(at->rank[a] + i, ranks_of(&tables[a], _mm512_and_si512(u, fraction)));
        }
        _mm512_store_si512(at->bit + i, first[0]);
        _mm512_store_si512(at->row + i, _mm512_add_epi32(_mm512_madd_epi16(first[1], _mm512_set1_epi32(row_y)),
                                                         _mm512_madd_epi16(first[2], _mm512_set1_epi32(row_z))));
        _mm512_store_si512(at->line + i, ost_window_number(w, window));
    }
}

static inline uint64_t look_up(const ost_carries *c, __m512i line, const places *at, size_t i)
{
    const __mmask64 x = _cvtu64_mask64(c->mask[0][at->rank[0][i]]), y = _cvtu64_mask64(c->mask[1][at->rank[1][i]]),
                    z = _cvtu64_mask64(c->mask[2][at->rank[2][i]]);
    __m512i row = _mm512_loadu_si512(c->row[at->row[i]]);
    row = _mm512_mask_add_epi8(row, y, row, _mm512_set1_epi8(8));
    row = _mm512_mask_add_epi8(row, z, row, _mm512_set1_epi8(1));
    const uint8_t(*const bit)[64] = c->bit + at->bit[i];
    const __m512i column = _mm512_mask_loadu_epi8(_mm512_loadu_si512(bit[0]), x, bit[1]);
    return _cvtmask64_u64(_mm512_test_epi8_mask(_mm512_permutexvar_epi8(row, line), column));
}

static void match_windows(const ost_match *match, const ost_cubes *bricks, uint64_t *hits)
{
    const ost_carries *const carries = &match->carries;
    const uint8_t(*const line)[64] = match->shape->windows.line;
    const rank_tables tables[3] = {rank_tables_of(carries->threshold[0]), rank_tables_of(carries->threshold[1]),
                                   rank_tables_of(carries->threshold[2])};
    places at;
    for (size_t piece = 0; piece < bricks->count; piece += PIECE, hits += PIECE) {
        const size_t count = bricks->count - piece < PIECE ? bricks->count - piece : PIECE;
        place_piece(match, &match->shape->windows, OST_WINDOW_MARGIN, 1, 3, tables, bricks, piece, count, &at);
        ost_find_lines(&match->shape->windows, count, at.line);
        for (size_t i = 0; i < count; i++)
            hits[i] = look_up(carries, _mm512_load_si512(line[at.line[i]]), &at, i);
    }
}

/* The tables that the loop over bricks keeps in registers, for one pose. */
typedef struct wide_tables {
    __m512i row, x, bits;
} wide_tables;

/* Selects 64 of the 256 bytes in four lines; `row` contains the numbers of the selected bytes. */
static inline __m512i select_of_four(const uint8_t (*line)[64], __m512i row)
{
    const __m512i near = _mm512_permutex2var_epi8(_mm512_load_si512(line[0]), row, _mm512_load_si512(line[1])),
                  far = _mm512_permutex2var_epi8(_mm512_load_si512(line[2]), row, _mm512_load_si512(line[3]));
    return _mm512_mask_mov_epi8(near, _mm512_movepi8_mask(row), far);
}

static inline uint64_t look_up_wide(const ost_carries *c, const wide_tables *t, const uint8_t (*line)[64],
                                    const places *at, size_t i)
{
    const __mmask64 carry_x = _cvtu64_mask64(c->mask[0][at->rank[0][i]]),
                    carry_y = _cvtu64_mask64(c->mask[1][at->rank[1][i]]),
                    carry_z = _cvtu64_mask64(c->mask[2][at->rank[2][i]]);
    __m512i row = _mm512_add_epi8(t->row, _mm512_set1_epi8((char)at->row[i])),
            x = _mm512_add_epi8(t->x, _mm512_set1_epi8((char)at->bit[i]));
    row = _mm512_mask_add_epi8(row, carry_y, row, _mm512_set1_epi8(16));
    row = _mm512_mask_add_epi8(row, carry_z, row, _mm512_set1_epi8(1));
    x = _mm512_mask_add_epi8(x, carry_x, x, _mm512_set1_epi8(1));
    const __mmask64 beyond = _mm512_test_epi8_mask(x, _mm512_set1_epi8(8));
    const __m512i byte = _mm512_mask_mov_epi8(select_of_four(line, row), beyond, select_of_four(line + 4, row));
    return _cvtmask64_u64(_mm512_test_epi8_mask(byte, _mm512_shuffle_epi8(t->bits, x)));
}

/* Replaces window numbers with the numbers of the windows' lines, and prefetches these lines. */
static inline void find_wide_lines(const ost_windows *windows, size_t count, uint32_t *number)
{
    for (size_t i = 0; i < count; i++) {
        number[i] = windows->index[number[i]];
        for (int k = 0; k < OST_WIDE_LINES; k++)
            _mm_prefetch((const char *)windows->line[number[i] + (uint32_t)k], _MM_HINT_T0);
    }
}

/* PIECE bricks need 64 KiB of lines, which is more than the L1 cache holds. Fewer bricks are therefore prefetched at
   once. */
enum { WIDE_PIECE = 32 };

static void match_wide(const ost_match *match, const ost_cubes *bricks, uint64_t *hits)
{
    const ost_carries *const carries = &match->carries;
    const ost_windows *const w = &match->shape->wide;
    const rank_tables tables[3] = {rank_tables_of(carries->threshold[0]), rank_tables_of(carries->threshold[1]),
                                   rank_tables_of(carries->threshold[2])};
    const wide_tables t = {
        .row = _mm512_loadu_si512(carries->wide[0]),
        .x = _mm512_loadu_si512(carries->wide[1]),
        .bits = _mm512_broadcast_i32x4(_mm_setr_epi8(1, 2, 4, 8, 16, 32, 64, -128, 1, 2, 4, 8, 16, 32, 64, -128))};
    places at;
    for (size_t piece = 0; piece < bricks->count; piece += WIDE_PIECE, hits += WIDE_PIECE) {
        const size_t count = bricks->count - piece < WIDE_PIECE ? bricks->count - piece : WIDE_PIECE;
        place_piece(match, w, OST_WIDE_MARGIN, 16, 1, tables, bricks, piece, count, &at);
        find_wide_lines(w, count, at.line);
        for (size_t i = 0; i < count; i++)
            hits[i] = look_up_wide(carries, &t, w->line + at.line[i], &at, i);
    }
}

void ost_match_avx512vbmi(const ost_match *match, const ost_cubes *bricks, uint64_t *hits)
{
    if (match->windows)
        match_windows(match, bricks, hits);
    else if (match->wide)
        match_wide(match, bricks, hits);
    else
        ost_match_avx512(match, bricks, hits);
}
