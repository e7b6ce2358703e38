/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Gathers a row by ascending indices, 32 at a time.  If 32 indices span at most 64 elements, all elements to which they
 * refer fit in one or two registers.
 */
#include "cpu/kernels.h"

#include <immintrin.h>
#include <string.h>

#include "core/conditions.h"

/* Returns a mask whose lowest `count` bits are set, 0 <= count <= 32. */
static inline __mmask32 low_mask(int count)
{
    return (__mmask32)_bzhi_u32(UINT32_MAX, (unsigned)count);
}

/*
 * The map is ascending, so 32 results come from map[last] - map[first] + 1 adjacent elements. If there are at most 32
 * such elements, a permutation of one register selects the results; for up to 64 elements, a permutation of two
 * registers selects them. If there are more, the results are read one by one.
 */
void ost_gather_row_avx512(const int16_t *from, const int32_t *map, int count, int16_t *to)
{
    for (int i = 0; i < count; i += 32) {
        int part = count - i < 32 ? count - i : 32;
        const __mmask32 in = low_mask(part);
        const int32_t first = map[i];
        int span = map[i + part - 1] - first + 1;
        if (span > 64) {
            for (int k = i; k < i + part; k++)
                to[k] = from[map[k]];
            continue;
        }
        int low = part < 16 ? part : 16;
        const __m512i base = _mm512_set1_epi32(first);
        __m512i a = _mm512_sub_epi32(_mm512_maskz_loadu_epi32((__mmask16)low_mask(low), map + i), base);
        __m512i b = _mm512_setzero_si512();
        if (part > 16)
            b = _mm512_sub_epi32(_mm512_maskz_loadu_epi32((__mmask16)low_mask(part - 16), map + i + 16), base);
        __m512i index = _mm512_inserti64x4(_mm512_castsi256_si512(_mm512_cvtepi32_epi16(a)), _mm512_cvtepi32_epi16(b),
                                           1);
        int span0 = span < 32 ? span : 32;
        __m512i w0 = _mm512_maskz_loadu_epi16(low_mask(span0), from + first);
        if (span <= 32) {
            _mm512_mask_storeu_epi16(to + i, in, _mm512_permutexvar_epi16(index, w0));
        } else {
            __m512i w1 = _mm512_maskz_loadu_epi16(low_mask(span - 32), from + first + 32);
            _mm512_mask_storeu_epi16(to + i, in, _mm512_permutex2var_epi16(w0, index, w1));
        }
    }
}
