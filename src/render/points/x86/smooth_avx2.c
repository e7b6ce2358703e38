/* SPDX-License-Identifier: Apache-2.0 */
#include "core/conditions.h"
#include "render/points/smooth.h"

#include <immintrin.h>

enum { SIXTEEN = 16 };

static inline __m256i load(const uint16_t *at)
{
    return _mm256_loadu_si256((const void *)at);
}

void ost_nine_avx2(const uint16_t *in, uint16_t *out, int count, int step, bool sixteenth)
{
    const __m256i eight = _mm256_set1_epi16(8), three = _mm256_set1_epi16(3), five = _mm256_set1_epi16(5);
    for (int i = 0; i < count; i += SIXTEEN) {
        const uint16_t *a = in + i;
        const __m256i one = _mm256_add_epi16(load(a), load(a + 8 * step)), two = _mm256_add_epi16(load(a + step), load(a + 7 * step));
        const __m256i third = _mm256_add_epi16(load(a + 2 * step), load(a + 6 * step)), fourth = _mm256_add_epi16(load(a + 3 * step), load(a + 5 * step));
        const __m256i outer = _mm256_add_epi16(_mm256_add_epi16(one, _mm256_add_epi16(two, two)), _mm256_slli_epi16(fourth, 2));
        const __m256i inner = _mm256_add_epi16(_mm256_mullo_epi16(third, three), _mm256_mullo_epi16(load(a + 4 * step), five));
        const __m256i sum = _mm256_add_epi16(outer, inner);
        _mm256_storeu_si256((void *)(out + i), sixteenth ? _mm256_srli_epi16(_mm256_add_epi16(sum, eight), 4) : sum);
    }
}

/* All ones in lanes whose bit is set. */
static inline __m256i lanes_of(uint64_t row)
{
    const __m256i bit = _mm256_setr_epi16(1, 2, 4, 8, 16, 32, 64, 128, 256, 512, 1024, 2048, 4096, 8192, 16384, INT16_MIN);
    return _mm256_cmpeq_epi16(_mm256_and_si256(_mm256_set1_epi16((short)row), bit), bit);
}

void ost_field_bits_avx2(uint64_t row, uint16_t out[OST_FIELD_LINE])
{
    for (int i = 0; i < OST_FIELD_LINE; i += SIXTEEN)
        _mm256_storeu_si256((void *)(out + i), _mm256_and_si256(lanes_of(row >> i), _mm256_set1_epi16(OST_FIELD_ALL)));
}

void ost_field_densities_avx2(uint64_t row, uint64_t near, const int16_t density[OST_FIELD_LINE], uint16_t out[OST_FIELD_LINE])
{
    const __m256i all = _mm256_set1_epi16(OST_FIELD_ALL), least = _mm256_set1_epi16(OST_FIELD_LEAST), below = _mm256_set1_epi16(OST_FIELD_DENSE - 1);
    for (int i = 0; i < OST_FIELD_LINE; i += SIXTEEN) {
        const __m256i v = _mm256_loadu_si256((const void *)(density + i));
        const __m256i some = _mm256_add_epi16(_mm256_srli_epi16(_mm256_max_epi16(v, _mm256_setzero_si256()), 4), least);
        const __m256i full = _mm256_or_si256(_mm256_cmpgt_epi16(v, below), lanes_of(near >> i));
        _mm256_storeu_si256((void *)(out + i), _mm256_and_si256(lanes_of(row >> i), _mm256_blendv_epi8(some, all, full)));
    }
}
