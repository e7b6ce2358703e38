/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Converts rows of voxels into bricks, four bricks at a time.  Eight rows contain half
 * of each of the four bricks, as words of four voxels.  The words are transposed, so
 * that each half is one register.
 *
 *   loads        A0 = [row 0 | row 2]   A1 = [row 1 | row 3]     32 bytes each
 *                A2 = [row 4 | row 6]   A3 = [row 5 | row 7]
 *   words        rows 0, 1 | rows 0, 1 | rows 2, 3 | rows 2, 3   (low or high words of A0, A1)
 *   quarters     of brick x: rows 0, 1 | rows 2, 3 | rows 4, 5 | rows 6, 7
 *
 * The voxels of a half are then in the brick's order.  Comparing the register with the threshold
 * results in half of the brick's occupancy word.  A masked move sets voxels below the threshold to
 * 0.
 */
#include "core/conditions.h"
#include "cpu/bone/bone.h"
#include "cpu/kernels.h"

#include <immintrin.h>

enum { GROUP = 4 };

static inline __m512i two_rows(const int16_t *low, const int16_t *high)
{
    __m512i v = _mm512_castsi256_si512(_mm256_loadu_si256((const void *)low));
    return _mm512_inserti64x4(v, _mm256_loadu_si256((const void *)high), 1);
}

static inline void put(int16_t *to, __m512i v, bool stream)
{
    if (stream)
        _mm512_stream_si512((void *)to, v);
    else
        _mm512_store_si512(to, v);
}

/* Computes a half of each of four bricks from eight rows. The first brick begins at voxel x of the rows. */
static inline void halves(const int16_t *const rows[8], size_t x, __m512i half[GROUP])
{
    __m512i a0 = two_rows(rows[0] + x, rows[2] + x), a1 = two_rows(rows[1] + x, rows[3] + x);
    __m512i a2 = two_rows(rows[4] + x, rows[6] + x), a3 = two_rows(rows[5] + x, rows[7] + x);
    __m512i even01 = _mm512_unpacklo_epi64(a0, a1), odd01 = _mm512_unpackhi_epi64(a0, a1);
    __m512i even23 = _mm512_unpacklo_epi64(a2, a3), odd23 = _mm512_unpackhi_epi64(a2, a3);
    half[0] = _mm512_shuffle_i64x2(even01, even23, 0x88);
    half[1] = _mm512_shuffle_i64x2(odd01, odd23, 0x88);
    half[2] = _mm512_shuffle_i64x2(even01, even23, 0xdd);
    half[3] = _mm512_shuffle_i64x2(odd01, odd23, 0xdd);
}

static inline __attribute__((always_inline)) ost_brick_sums brick_row(const int16_t *const rows[16], size_t bricks,
                                                                      int16_t threshold, bool stream, int16_t *density,
                                                                      uint64_t *occupancy)
{
    const __m512i least = _mm512_set1_epi16(threshold);
    __m512i highest = _mm512_setzero_si512();
    int32_t active = 0;
    for (size_t x = 0; x < bricks; x += GROUP) {
        __m512i low[GROUP], high[GROUP];
        halves(rows, 4 * x, low);
        halves(rows + 8, 4 * x, high);
        for (size_t i = 0; i < GROUP; i++) {
            size_t at = (size_t)ost_brick_spread((int32_t)(x + i));
            __mmask32 on0 = _mm512_cmpge_epi16_mask(low[i], least), on1 = _mm512_cmpge_epi16_mask(high[i], least);
            __m512i v0 = _mm512_maskz_mov_epi16(on0, low[i]), v1 = _mm512_maskz_mov_epi16(on1, high[i]);
            put(density + at * OST_BRICK_VOXELS, v0, stream);
            put(density + at * OST_BRICK_VOXELS + 32, v1, stream);
            occupancy[at] = on0 | (uint64_t)on1 << 32;
            active += (int32_t)_mm_popcnt_u64(occupancy[at]);
            highest = _mm512_max_epi16(highest, _mm512_max_epi16(v0, v1));
        }
    }
    __m256i half = _mm256_max_epi16(_mm512_castsi512_si256(highest), _mm512_extracti64x4_epi64(highest, 1));
    __m128i quarter = _mm_max_epi16(_mm256_castsi256_si128(half), _mm256_extracti128_si256(half, 1));
    /*
     * Computes the maximum of the lanes v, none of which is negative. SSE4.1 has an instruction for the minimum of
     * unsigned 16-bit lanes but none for the maximum, so the minimum of 2^15 - 1 - v is computed.
     */
    __m128i least_complement = _mm_minpos_epu16(_mm_xor_si128(quarter, _mm_set1_epi16(INT16_MAX)));
    return (ost_brick_sums){active, _mm_extract_epi16(least_complement, 0) ^ INT16_MAX};
}

ost_brick_sums ost_brick_row_avx512(const int16_t *const rows[16], size_t bricks, int16_t threshold, bool stream,
                                    int16_t *density, uint64_t *occupancy)
{
    return stream ? brick_row(rows, bricks, threshold, true, density, occupancy)
                  : brick_row(rows, bricks, threshold, false, density, occupancy);
}

bool ost_any_active_avx512(const int16_t *base, const size_t *row, int count, int width, int16_t threshold)
{
    const __m512i least = _mm512_set1_epi16(threshold);
    int first = width < 32 ? width : 32;
    const __mmask32 in0 = (__mmask32)_bzhi_u32(UINT32_MAX, (unsigned)first);
    const __mmask32 in1 = (__mmask32)_bzhi_u32(UINT32_MAX, (unsigned)(width - first));
    __m512i most = _mm512_setzero_si512(); /* starts at 0, because no threshold is below 1 */
    for (int r = 0; r < count; r++) {
        most = _mm512_max_epi16(most, _mm512_maskz_loadu_epi16(in0, base + row[r]));
        if (in1)
            most = _mm512_max_epi16(most, _mm512_maskz_loadu_epi16(in1, base + row[r] + 32));
    }
    return _mm512_cmpge_epi16_mask(most, least) != 0;
}
