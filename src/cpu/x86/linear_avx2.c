/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Linear interpolation for AVX2. Either 16 voxels between two slices or eight sums are computed at a time. The steps
 * and the ranges are the same as in linear_avx512.c, with one exception: pairs along x are loaded one by one, because a
 * gather instruction takes longer than eight loads.
 */
#include "core/conditions.h"
#include "cpu/kernels.h"

#include <immintrin.h>
#include <string.h>

enum { LANES = 16 };

/* Returns RHE(sum / 2^15) for each of eight sums. */
static inline __m256i rounded15(__m256i sum)
{
    const __m256i odd = _mm256_and_si256(_mm256_srli_epi32(sum, OST_WEIGHT_BITS), _mm256_set1_epi32(1));
    return _mm256_srai_epi32(
        _mm256_add_epi32(_mm256_add_epi32(sum, _mm256_set1_epi32((1 << (OST_WEIGHT_BITS - 1)) - 1)), odd),
        OST_WEIGHT_BITS);
}

/*
 * Writes the weighted means of the elements of a and b. Unpacking and packing both work within 128-bit lanes, so the
 * results have the order of a and b.
 */
static inline void blend(const int16_t *a, const int16_t *b, __m256i weights, int16_t *to)
{
    const __m256i va = _mm256_loadu_si256((const void *)a), vb = _mm256_loadu_si256((const void *)b);
    const __m256i low = rounded15(_mm256_madd_epi16(_mm256_unpacklo_epi16(va, vb), weights));
    const __m256i high = rounded15(_mm256_madd_epi16(_mm256_unpackhi_epi16(va, vb), weights));
    _mm256_storeu_si256((void *)to, _mm256_packs_epi32(low, high));
}

static void blend_row(const int16_t *a, const int16_t *b, int width, __m256i weights, int16_t *to)
{
    if (width < LANES) {
        int16_t few[3][LANES] = {{0}};
        memcpy(few[0], a, (size_t)width * sizeof *a);
        memcpy(few[1], b, (size_t)width * sizeof *b);
        blend(few[0], few[1], weights, few[2]);
        memcpy(to, few[2], (size_t)width * sizeof *to);
        return;
    }
    for (int x = 0; x + LANES <= width; x += LANES)
        blend(a + x, b + x, weights, to + x);
    if (width % LANES) /* interpolates the last 16 voxels of the row; some of them are computed a second time */
        blend(a + width - LANES, b + width - LANES, weights, to + width - LANES);
}

void ost_blend_rows_avx2(const int16_t *a, const int16_t *b, const size_t *row, int count, int width, int weight,
                         int16_t *to)
{
    const __m256i weights = _mm256_set1_epi32((int32_t)((uint32_t)weight << 16 | (uint32_t)(OST_WEIGHT_ONE - weight)));
    for (int r = 0; r < count; r++)
        blend_row(a + row[r], b + row[r], width, weights, to + (size_t)OST_ROW_STRIDE * (size_t)r);
}

static inline int32_t pair_at(const int16_t *from)
{
    int32_t pair;
    memcpy(&pair, from, sizeof pair);
    return pair;
}

void ost_stretch_row_avx2(const int16_t *from, const int32_t *at, const int16_t *minus, int width, int32_t *to)
{
    int i = 0;
    for (; i + 8 <= width; i += 8) {
        const __m256i pairs = _mm256_setr_epi32(
            pair_at(from + at[i]), pair_at(from + at[i + 1]), pair_at(from + at[i + 2]), pair_at(from + at[i + 3]),
            pair_at(from + at[i + 4]), pair_at(from + at[i + 5]), pair_at(from + at[i + 6]), pair_at(from + at[i + 7]));
        _mm256_storeu_si256((void *)(to + i),
                            _mm256_madd_epi16(pairs, _mm256_loadu_si256((const void *)(minus + 2 * (size_t)i))));
    }
    for (; i < width; i++)
        to[i] = from[at[i]] * minus[2 * i] + from[at[i] + 1] * minus[2 * i + 1];
}

/* Returns RHE(sum / 2^45) for each sum, in bits 45 and above. The lower bits of the results are undefined. */
static inline __m256i rounded45(__m256i sum)
{
    const __m256i odd = _mm256_and_si256(_mm256_srli_epi64(sum, 3 * OST_WEIGHT_BITS), _mm256_set1_epi64x(1));
    return _mm256_add_epi64(_mm256_add_epi64(sum, _mm256_set1_epi64x((INT64_C(1) << (3 * OST_WEIGHT_BITS - 1)) - 1)),
                            odd);
}

/* Computes the weighted sums of the elements i to i + 7 of the rows. Each rounded result is in the low half of 32 bits;
   the high half is 0. */
static inline __attribute__((always_inline)) __m256i weighed(const int32_t *const rows[4], const __m256i by[4],
                                                             int count, int i)
{
    __m256i even = _mm256_setzero_si256(), odd = even;
    for (int r = 0; r < count; r++) {
        const __m256i v = _mm256_loadu_si256((const void *)(rows[r] + i));
        even = _mm256_add_epi64(even, _mm256_mul_epi32(v, by[r]));
        odd = _mm256_add_epi64(odd, _mm256_mul_epi32(_mm256_srli_epi64(v, 32), by[r]));
    }
    const __m256i low = _mm256_srli_epi64(rounded45(even), 3 * OST_WEIGHT_BITS),
                  high = _mm256_srli_epi64(rounded45(odd), 3 * OST_WEIGHT_BITS - 32);
    return _mm256_and_si256(_mm256_blend_epi32(low, high, 0xaa), _mm256_set1_epi32(0xffff));
}

/* Writes the weighted sums of rows. Packing works within 128-bit lanes, so the quarters of the packed register must be
   reordered. */
static inline __attribute__((always_inline)) void weigh(const int32_t *const rows[4], const int32_t weight[4],
                                                        int count, int width, int16_t *to)
{
    __m256i by[4] = {_mm256_setzero_si256()};
    for (int r = 0; r < count; r++)
        by[r] = _mm256_set1_epi64x(weight[r]);
    for (int i = 0; i < width; i += LANES) {
        const __m256i packed = _mm256_packus_epi32(weighed(rows, by, count, i), weighed(rows, by, count, i + 8));
        _mm256_storeu_si256((void *)(to + i), _mm256_permute4x64_epi64(packed, 0xd8));
    }
}

void ost_weigh_rows_avx2(const int32_t *const rows[4], const int32_t weight[4], int count, int width, int16_t *to)
{
    if (count == 4)
        weigh(rows, weight, 4, width, to);
    else if (count == 2)
        weigh(rows, weight, 2, width, to);
    else
        weigh(rows, weight, 1, width, to);
}
