/* SPDX-License-Identifier: Apache-2.0 */
/* Finds the edges of a row of pixels with AVX2 (antialias.h). */
#include "render/points/antialias.h"

#include <immintrin.h>

/* Compares two groups of eight pixels. Returns one bit per pixel, 1 if the pixels differ. */
static inline uint32_t eight(__m256i a, __m256i b)
{
    /* saturating subtraction sets differences below OST_ANTIALIAS_LEAST to 0; the top byte is not part of the colour,
     * so its difference is always set to 0 */
    const __m256i most = _mm256_or_si256(_mm256_set1_epi8(OST_ANTIALIAS_LEAST - 1),
                                         _mm256_set1_epi32((int32_t)0xff000000));
    const __m256i difference = _mm256_or_si256(_mm256_subs_epu8(a, b), _mm256_subs_epu8(b, a));
    const __m256i equal = _mm256_cmpeq_epi32(_mm256_subs_epu8(difference, most), _mm256_setzero_si256());
    return (uint32_t)_mm256_movemask_ps(_mm256_castsi256_ps(equal)) ^ 0xff;
}

void ost_antialias_find_avx2(const uint32_t *row, const uint32_t *next, int cells, uint16_t *below, uint16_t *right)
{
    for (int c = 0; c < cells; c++, row += OST_CELL_WIDTH, next += OST_CELL_WIDTH) {
        uint32_t down = 0, across = 0;
        for (int i = 0; i < 2; i++) {
            const __m256i here = _mm256_loadu_si256((const void *)(row + 8 * i));
            down |= eight(here, _mm256_loadu_si256((const void *)(next + 8 * i))) << (8 * i);
            across |= eight(here, _mm256_loadu_si256((const void *)(row + 8 * i + 1))) << (8 * i);
        }
        below[c] = (uint16_t)down;
        right[c] = (uint16_t)across;
    }
}
