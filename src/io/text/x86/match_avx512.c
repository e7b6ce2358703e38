/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Eight lines at a time.  Their bytes are compared line by line, a difference
 * in any of them collected in two registers; their densities are parsed side
 * by side, the eight bytes from each one's begin in a lane (match.c says how).
 * Eight that do not all match are gone over again one by one.
 *
 * A line begins where the one before it ends, so a chain of dependent steps
 * goes through all of them: a load at p + length, a few operations, a count of
 * zero bits.  It takes about 13 cycles a line and everything else fits beside it.
 */
#include "core/conditions.h"

#include "io/text/match.h"

#include <immintrin.h>
#include <string.h>

enum { LANES = 8 };
#define NEWLINES UINT64_C(0x0a0a0a0a0a0a0a0a)

typedef struct densities {
    __m128i values; /* eight int16 */
    __mmask8 good;
} densities;

/* last: bytes of which the last ones are the density; length: how many, of any size. */
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

/*
 * The first `count` lines from *text on, whose bits `lanes` has; whether all of
 * them match and end before `end`.  *text moves behind them then.
 */
static inline __attribute__((always_inline)) bool match_eight(const ost_text_pattern *pattern, const ost_text_column *columns,
                                                              const uint8_t *lengths, const char **text, const char *end, __mmask8 lanes,
                                                              int count, int16_t *density)
{
    const __m256i before = _mm256_loadu_si256((const void *)pattern->before.text);
    const __m256i before_mask = _mm256_loadu_si256((const void *)pattern->before.mask);
    const __m256i after = _mm256_loadu_si256((const void *)pattern->after.text);
    const __m256i after_mask = _mm256_loadu_si256((const void *)pattern->after.mask);
    const size_t lead = pattern->before.length, other = lead + pattern->after.length;
    __m128i found16 = _mm_setzero_si128();
    __m256i found32 = _mm256_setzero_si256();
    uint64_t word[LANES] = {0};
    const char *p = *text;
#pragma GCC unroll 8
    for (int i = 0; i < count; i++) {
        const char *q = p + other + lengths[i];
        memcpy(&word[i], q, sizeof word[i]);
        uint64_t x = word[i] ^ NEWLINES, zero = (x - UINT64_C(0x0101010101010101)) & ~x & UINT64_C(0x8080808080808080);
        const char *column = p + lead;
        if (lead)
            found32 = differ32(found32, p, before, before_mask);
        found16 = differ16(found16, column, &columns[i]);
        found32 = differ32(found32, column + lengths[i], after, after_mask);
        p = q + (_tzcnt_u64(zero) >> 3) + 1;
    }
    found32 = _mm256_or_si256(found32, _mm256_zextsi128_si256(found16));
    /* The newline's mark is bit 8 n + 7; without one, the shift is 72 and n is -1, which no density has. */
    __m512i words = _mm512_loadu_si512(word), x = _mm512_xor_si512(words, _mm512_set1_epi64((int64_t)NEWLINES));
    __m512i zero = _mm512_andnot_si512(x, _mm512_sub_epi64(x, _mm512_set1_epi64(INT64_C(0x0101010101010101))));
    zero = _mm512_and_si512(zero, _mm512_set1_epi64((int64_t)UINT64_C(0x8080808080808080)));
    zero = _mm512_and_si512(zero, _mm512_sub_epi64(_mm512_setzero_si512(), zero));
    __m512i shift = _mm512_add_epi64(_mm512_lzcnt_epi64(zero), _mm512_set1_epi64(8));
    __m512i last = _mm512_sllv_epi64(words, shift);
    __m512i length = _mm512_srai_epi64(_mm512_sub_epi64(_mm512_set1_epi64(64), shift), 3);
    __mmask8 good = 0xff;
    if (pattern->carriage) {
        good = _mm512_cmpeq_epi64_mask(_mm512_srli_epi64(last, 56), _mm512_set1_epi64('\r'));
        last = _mm512_slli_epi64(last, 8);
        length = _mm512_sub_epi64(length, _mm512_set1_epi64(1));
    }
    densities d = parse(last, length);
    _mm_mask_storeu_epi16(density, lanes, d.values);
    good &= d.good;
    if ((good & lanes) != lanes || !_mm256_testz_si256(found32, found32) || p > end)
        return false;
    *text = p;
    return true;
}

size_t ost_text_match_avx512(const ost_text_pattern *pattern, const ost_text_column *columns, const uint8_t *lengths, const char *text,
                             const char *end, size_t lines, int16_t *density, const char **next)
{
    size_t i = 0;
    while (i + LANES <= lines && match_eight(pattern, columns + i, lengths + i, &text, end, 0xff, LANES, density + i))
        i += LANES;
    int rest = lines - i < LANES ? (int)(lines - i) : 0;
    if (rest > 0 && match_eight(pattern, columns + i, lengths + i, &text, end, (__mmask8)((1 << rest) - 1), rest, density + i))
        i = lines;
    while (i < lines && text < end && match_eight(pattern, columns + i, lengths + i, &text, end, 1, 1, density + i))
        i++;
    *next = text;
    return i;
}
