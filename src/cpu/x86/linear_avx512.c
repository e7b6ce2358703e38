/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Linear interpolation for AVX-512. Either 32 voxels between two slices or 16 sums are
 * computed at a time.
 *
 *   blend     interleaves a and b into pairs; one multiplication of 16-bit pairs
 *             (vpmaddwd) by the pair of weights computes a (2^15 - w) + b w
 *   stretch   permutes the window that contains 16 pairs from[at], from[at + 1],
 *             then performs the same multiplication
 *   weigh     multiplies even and odd lanes separately, 32 by 32 bits to 64
 *
 * Ranges.  blend: weights are 1 to 2^15 - 1, sums at most 2^30.  stretch:
 * weights are -2^15 to 0, a pair sums to -2^15, sums are at most 2^30.  weigh:
 * sums are at most 2^60, and adding half of 2^45 does not overflow.  A quotient
 * fits in 16 bits, so bits 45 to 60 of a sum contain all of it.
 */
#include "core/conditions.h"
#include "cpu/kernels.h"

#include <immintrin.h>

static inline __mmask32 low_mask(int count)
{
    return (__mmask32)_bzhi_u32(UINT32_MAX, (unsigned)count);
}

/* Returns RHE(sum / 2^15) for each of 16 sums. */
static inline __m512i rounded15(__m512i sum)
{
    const __m512i odd = _mm512_and_si512(_mm512_srli_epi32(sum, OST_WEIGHT_BITS), _mm512_set1_epi32(1));
    return _mm512_srai_epi32(
        _mm512_add_epi32(_mm512_add_epi32(sum, _mm512_set1_epi32((1 << (OST_WEIGHT_BITS - 1)) - 1)), odd),
        OST_WEIGHT_BITS);
}

/*
 * Returns the weighted means of the elements of a and b. Unpacking and packing both work within 128-bit lanes, so the
 * results have the order of a and b.
 */
static inline __m512i blended(__m512i a, __m512i b, __m512i weights)
{
    return _mm512_packs_epi32(rounded15(_mm512_madd_epi16(_mm512_unpacklo_epi16(a, b), weights)),
                              rounded15(_mm512_madd_epi16(_mm512_unpackhi_epi16(a, b), weights)));
}

void ost_blend_rows_avx512(const int16_t *a, const int16_t *b, const size_t *row, int count, int width, int weight,
                           int16_t *to)
{
    const __m512i weights = _mm512_set1_epi32((int32_t)((uint32_t)weight << 16 | (uint32_t)(OST_WEIGHT_ONE - weight)));
    const int first = width < 32 ? width : 32;
    const __mmask32 in0 = low_mask(first), in1 = low_mask(width - first);
    for (int r = 0; r < count; r++) {
        const int16_t *const ra = a + row[r], *const rb = b + row[r];
        int16_t *const result = to + (size_t)OST_ROW_STRIDE * (size_t)r;
        _mm512_mask_storeu_epi16(
            result, in0, blended(_mm512_maskz_loadu_epi16(in0, ra), _mm512_maskz_loadu_epi16(in0, rb), weights));
        if (in1)
            _mm512_mask_storeu_epi16(
                result + 32, in1,
                blended(_mm512_maskz_loadu_epi16(in1, ra + 32), _mm512_maskz_loadu_epi16(in1, rb + 32), weights));
    }
}

void ost_stretch_row_avx512(const int16_t *from, const int32_t *at, const int16_t *minus, int width, int32_t *to)
{
    for (int i = 0; i < width; i += 16) {
        const int part = width - i < 16 ? width - i : 16;
        const int32_t first = at[i];
        const int span = at[i + part - 1] - first + 2;
        if (span > 64) {
            for (int k = i; k < i + part; k++)
                to[k] = from[at[k]] * minus[2 * k] + from[at[k] + 1] * minus[2 * k + 1];
            continue;
        }
        /*
         * The indices of each pair in the window: at - first and at - first + 1.  Only the first `part` lanes
         * are used, so the other lanes may select any element.
         */
        const __m512i lower =
            _mm512_sub_epi32(_mm512_maskz_loadu_epi32((__mmask16)low_mask(part), at + i), _mm512_set1_epi32(first));
        const __m512i pairs = _mm512_or_si512(_mm512_and_si512(lower, _mm512_set1_epi32(0xffff)),
                                              _mm512_slli_epi32(_mm512_add_epi32(lower, _mm512_set1_epi32(1)), 16));
        const int low = span < 32 ? span : 32;
        const __m512i w0 = _mm512_maskz_loadu_epi16(low_mask(low), from + first);
        __m512i values;
        if (span <= 32)
            values = _mm512_permutexvar_epi16(pairs, w0);
        else
            values =
                _mm512_permutex2var_epi16(w0, pairs, _mm512_maskz_loadu_epi16(low_mask(span - 32), from + first + 32));
        _mm512_storeu_si512(to + i, _mm512_madd_epi16(values, _mm512_loadu_si512(minus + 2 * (size_t)i)));
    }
}

/* Returns RHE(sum / 2^45) for each sum, in bits 45 and above. The lower bits of the results are undefined. */
static inline __m512i rounded45(__m512i sum)
{
    const __m512i odd = _mm512_and_si512(_mm512_srli_epi64(sum, 3 * OST_WEIGHT_BITS), _mm512_set1_epi64(1));
    return _mm512_add_epi64(_mm512_add_epi64(sum, _mm512_set1_epi64((INT64_C(1) << (3 * OST_WEIGHT_BITS - 1)) - 1)),
                            odd);
}

static inline __attribute__((always_inline)) void weigh(const int32_t *const rows[4], const int32_t weight[4],
                                                        int count, int width, int16_t *to)
{
    __m512i by[4];
    for (int r = 0; r < count; r++)
        by[r] = _mm512_set1_epi64(weight[r]);
    for (int i = 0; i < width; i += 16) {
        __m512i even = _mm512_setzero_si512(), odd = even;
        for (int r = 0; r < count; r++) {
            const __m512i v = _mm512_loadu_si512(rows[r] + i);
            even = _mm512_add_epi64(even, _mm512_mul_epi32(v, by[r]));
            odd = _mm512_add_epi64(odd, _mm512_mul_epi32(_mm512_srli_epi64(v, 32), by[r]));
        }
        const __m512i low = _mm512_srli_epi64(rounded45(even), 3 * OST_WEIGHT_BITS),
                      high = _mm512_srli_epi64(rounded45(odd), 3 * OST_WEIGHT_BITS - 32);
        _mm256_storeu_si256((void *)(to + i), _mm512_cvtepi32_epi16(_mm512_mask_blend_epi32(0xaaaa, low, high)));
    }
}

void ost_weigh_rows_avx512(const int32_t *const rows[4], const int32_t weight[4], int count, int width, int16_t *to)
{
    if (count == 4)
        weigh(rows, weight, 4, width, to);
    else if (count == 2)
        weigh(rows, weight, 2, width, to);
    else
        weigh(rows, weight, 1, width, to);
}
