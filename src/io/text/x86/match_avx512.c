/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Eight lines at a time.  Their bytes are compared line by line, a difference
 * in any of them collected in two registers; their densities are parsed side
 * by side, the last eight bytes of each line in a lane (match.c says
 * how).  Eight that do not all match are gone over again one by one.
 */
#include "core/conditions.h"

#include "io/text/match.h"

#include <immintrin.h>

enum { LANES = 8 };

static size_t newlines(const char *text, size_t bytes, uint32_t base, uint32_t *at)
{
    const __m512i newline = _mm512_set1_epi8('\n');
    uint32_t *to = at;
    for (size_t i = 0; i < bytes; i += 64) {
        uint64_t bits = _mm512_cmpeq_epi8_mask(_mm512_loadu_si512(text + i), newline);
        uint32_t from = base + (uint32_t)i;
        size_t count = (size_t)_mm_popcnt_u64(bits);
        /* Two are written whether they are there or not: few lines are shorter than 32 bytes. */
        to[0] = from + (uint32_t)_tzcnt_u64(bits);
        bits = _blsr_u64(bits);
        to[1] = from + (uint32_t)_tzcnt_u64(bits);
        for (size_t k = 2; k < count; k++) {
            bits = _blsr_u64(bits);
            to[k] = from + (uint32_t)_tzcnt_u64(bits);
        }
        to += count;
    }
    return (size_t)(to - at);
}

typedef struct densities {
    __m128i values; /* eight int16 */
    __mmask8 good;
} densities;

/* last: the eight bytes before each line's end; length: of what must be its density, of any size. */
static inline densities parse(__m512i last, __m512i length)
{
    const __m512i one = _mm512_set1_epi64(1), bits = _mm512_set1_epi64(64);
    __mmask8 good = _mm512_cmplt_epu64_mask(_mm512_sub_epi64(length, one), _mm512_set1_epi64(6));
    __m512i first = _mm512_srlv_epi64(last, _mm512_sub_epi64(bits, _mm512_slli_epi64(length, 3)));
    __mmask8 negative = _mm512_cmpeq_epi64_mask(_mm512_and_si512(first, _mm512_set1_epi64(0xff)), _mm512_set1_epi64('-'));
    __m512i digits = _mm512_mask_sub_epi64(length, negative, length, one);
    good &= _mm512_cmplt_epu64_mask(_mm512_sub_epi64(digits, one), _mm512_set1_epi64(5));
    __m512i keep = _mm512_sllv_epi64(_mm512_set1_epi64(-1), _mm512_sub_epi64(bits, _mm512_slli_epi64(digits, 3)));
    __m512i t = _mm512_and_si512(_mm512_xor_si512(last, _mm512_set1_epi8('0')), keep);
    __m512i over = _mm512_or_si512(_mm512_add_epi8(t, _mm512_set1_epi8(6)), t);
    good &= _mm512_testn_epi64_mask(over, _mm512_set1_epi8((char)0xf0));
    /* Pairs, then fours: the lower one is the thousands above the upper one's, at most one digit of it is there. */
    __m512i pairs = _mm512_maddubs_epi16(t, _mm512_set1_epi16(0x010a));
    __m512i fours = _mm512_madd_epi16(pairs, _mm512_set1_epi32(0x00010064));
    __m512i value = _mm512_add_epi64(_mm512_mul_epu32(fours, _mm512_set1_epi64(10000)), _mm512_srli_epi64(fours, 32));
    __m512i limit = _mm512_mask_add_epi64(_mm512_set1_epi64(INT16_MAX), negative, _mm512_set1_epi64(INT16_MAX), one);
    good &= _mm512_cmple_epi64_mask(value, limit);
    value = _mm512_mask_sub_epi64(value, negative, _mm512_setzero_si512(), value);
    return (densities){_mm512_cvtepi64_epi16(value), good};
}

/* found |= (bytes ^ text) & mask */
static inline __m128i differ16(__m128i found, const char *bytes, const ost_text_column *column)
{
    __m128i x = _mm_xor_si128(_mm_loadu_si128((const void *)bytes), _mm_loadu_si128((const void *)column->text));
    return _mm_ternarylogic_epi64(found, x, _mm_loadu_si128((const void *)column->mask), 0xf8);
}

static inline __m256i differ32(__m256i found, const char *bytes, __m256i text, __m256i mask)
{
    __m256i x = _mm256_xor_si256(_mm256_loadu_si256((const void *)bytes), text);
    return _mm256_ternarylogic_epi64(found, x, mask, 0xf8);
}

/* The first `count` lines, whose bits `lanes` has; no other is read. Whether all of them match. */
static inline __attribute__((always_inline)) bool match_eight(const ost_text_pattern *pattern, const ost_text_column *columns, const uint8_t *lengths, const char *text,
                               const uint32_t *ends, __mmask8 lanes, int count, int16_t *density)
{
    const __m256i before = _mm256_loadu_si256((const void *)pattern->before.text);
    const __m256i before_mask = _mm256_loadu_si256((const void *)pattern->before.mask);
    const __m256i after = _mm256_loadu_si256((const void *)pattern->after.text);
    const __m256i after_mask = _mm256_loadu_si256((const void *)pattern->after.mask);
    const uint32_t lead = pattern->before.length;
    __m128i found16 = _mm_setzero_si128();
    __m256i found32 = _mm256_setzero_si256();
#pragma GCC unroll 8
    for (int i = 0; i < count; i++) {
        const char *p = text + ends[i - 1] + 1;
        if (lead) {
            found32 = differ32(found32, p, before, before_mask);
            p += lead;
        }
        found16 = differ16(found16, p, &columns[i]);
        found32 = differ32(found32, p + lengths[i], after, after_mask);
    }
    found32 = _mm256_or_si256(found32, _mm256_zextsi128_si256(found16));
    __m256i end = _mm256_maskz_loadu_epi32(lanes, ends);
    __m256i start = _mm256_add_epi32(_mm256_maskz_loadu_epi32(lanes, ends - 1), _mm256_set1_epi32(1));
    __m256i prefix = _mm256_add_epi32(_mm256_cvtepu8_epi32(_mm_maskz_loadu_epi8(lanes, lengths)),
                                      _mm256_set1_epi32((int)(lead + pattern->after.length + pattern->carriage)));
    /* Negative lengths wrap to large ones, which no density has. */
    __m512i length = _mm512_cvtepi32_epi64(_mm256_sub_epi32(_mm256_sub_epi32(end, start), prefix));
    __m512i last = _mm512_mask_i32gather_epi64(_mm512_setzero_si512(), lanes, _mm256_sub_epi32(end, _mm256_set1_epi32(8)), text, 1);
    __mmask8 good = 0xff;
    if (pattern->carriage) {
        good = _mm512_cmpeq_epi64_mask(_mm512_srli_epi64(last, 56), _mm512_set1_epi64('\r'));
        last = _mm512_slli_epi64(last, 8);
    }
    densities d = parse(last, length);
    _mm_mask_storeu_epi16(density, lanes, d.values);
    good &= d.good;
    return (good & lanes) == lanes && _mm256_testz_si256(found32, found32);
}

static size_t match(const ost_text_pattern *pattern, const ost_text_column *columns, const uint8_t *lengths, const char *text,
                    const uint32_t *ends, size_t lines, int16_t *density)
{
    size_t i = 0;
    while (i + LANES <= lines && match_eight(pattern, columns + i, lengths + i, text, ends + i, 0xff, LANES, density + i))
        i += LANES;
    int rest = lines - i < LANES ? (int)(lines - i) : 0;
    if (rest > 0 && match_eight(pattern, columns + i, lengths + i, text, ends + i, (__mmask8)((1 << rest) - 1), rest, density + i))
        return lines;
    while (i < lines && match_eight(pattern, columns + i, lengths + i, text, ends + i, 1, 1, density + i))
        i++;
    return i;
}

void ost_text_kernels_avx512(ost_text_kernels *kernels)
{
    *kernels = (ost_text_kernels){newlines, match};
}
