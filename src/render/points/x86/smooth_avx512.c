/* SPDX-License-Identifier: Apache-2.0 */
#include "core/conditions.h"
#include "render/points/smooth.h"

#include <immintrin.h>

static inline __m512i load(const uint16_t *at)
{
    return _mm512_loadu_si512(at);
}

void ost_nine_avx512(const uint16_t *in, uint16_t *out, int count, int step, bool sixteenth)
{
    const __m512i eight = _mm512_set1_epi16(8), three = _mm512_set1_epi16(3), five = _mm512_set1_epi16(5);
    for (int i = 0; i < count; i += OST_FIELD_LANES) {
        const uint16_t *a = in + i;
        const __m512i one = _mm512_add_epi16(load(a), load(a + 8 * step)), two = _mm512_add_epi16(load(a + step), load(a + 7 * step));
        const __m512i third = _mm512_add_epi16(load(a + 2 * step), load(a + 6 * step)), fourth = _mm512_add_epi16(load(a + 3 * step), load(a + 5 * step));
        const __m512i outer = _mm512_add_epi16(_mm512_add_epi16(one, _mm512_add_epi16(two, two)), _mm512_slli_epi16(fourth, 2));
        const __m512i inner = _mm512_add_epi16(_mm512_mullo_epi16(third, three), _mm512_mullo_epi16(load(a + 4 * step), five));
        const __m512i sum = _mm512_add_epi16(outer, inner);
        _mm512_storeu_si512(out + i, sixteenth ? _mm512_srli_epi16(_mm512_add_epi16(sum, eight), 4) : sum);
    }
}

void ost_field_bits_avx512(uint64_t row, uint16_t out[OST_FIELD_LINE])
{
    const __m512i all = _mm512_set1_epi16(OST_FIELD_ALL);
    _mm512_storeu_si512(out, _mm512_maskz_mov_epi16((__mmask32)row, all));
    _mm256_storeu_si256((void *)(out + 32), _mm256_maskz_mov_epi16((__mmask16)(row >> 32), _mm512_castsi512_si256(all)));
}

void ost_field_densities_avx512(uint64_t row, uint64_t near, const int16_t density[OST_FIELD_LINE], uint16_t out[OST_FIELD_LINE])
{
    const __m512i all = _mm512_set1_epi16(OST_FIELD_ALL), least = _mm512_set1_epi16(OST_FIELD_LEAST), dense = _mm512_set1_epi16(OST_FIELD_DENSE);
    for (int i = 0; i < OST_FIELD_LINE; i += OST_FIELD_LANES) {
        const __mmask32 line = i ? 0xffff : 0xffffffff;
        const __m512i v = _mm512_maskz_loadu_epi16(line, density + i);
        const __m512i some = _mm512_add_epi16(_mm512_srli_epi16(_mm512_max_epi16(v, _mm512_setzero_si512()), 4), least);
        const __mmask32 full = _mm512_cmpge_epi16_mask(v, dense) | (__mmask32)(near >> i);
        _mm512_mask_storeu_epi16(out + i, line, _mm512_maskz_mov_epi16((__mmask32)(row >> i), _mm512_mask_mov_epi16(some, full, all)));
    }
}
