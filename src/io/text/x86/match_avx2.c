/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Four lines at a time: as match_avx512.c, with half the lanes and whole
 * lanes of bits in place of mask registers.
 */
#include "core/conditions.h"

#include "io/text/match.h"

#include <immintrin.h>
#include <string.h>

enum { LANES = 4 };

/*
 * last: bytes of which the last ones are the density; length: how many, of any
 * size, signed.  Returns lanes of values and in *good lanes of -1.
 */
static inline __m256i parse(__m256i last, __m256i length, __m256i *good)
{
    const __m256i zero = _mm256_setzero_si256(), bits = _mm256_set1_epi64x(64);
    __m256i fits = _mm256_and_si256(_mm256_cmpgt_epi64(length, zero), _mm256_cmpgt_epi64(_mm256_set1_epi64x(7), length));
    __m256i first = _mm256_srlv_epi64(last, _mm256_sub_epi64(bits, _mm256_slli_epi64(length, 3)));
    __m256i negative = _mm256_cmpeq_epi64(_mm256_and_si256(first, _mm256_set1_epi64x(0xff)), _mm256_set1_epi64x('-'));
    __m256i digits = _mm256_add_epi64(length, negative);
    fits = _mm256_and_si256(fits, _mm256_cmpgt_epi64(digits, zero));
    fits = _mm256_and_si256(fits, _mm256_cmpgt_epi64(_mm256_set1_epi64x(6), digits));
    __m256i keep = _mm256_sllv_epi64(_mm256_set1_epi64x(-1), _mm256_sub_epi64(bits, _mm256_slli_epi64(digits, 3)));
    __m256i t = _mm256_and_si256(_mm256_xor_si256(last, _mm256_set1_epi8('0')), keep);
    __m256i over = _mm256_or_si256(_mm256_add_epi8(t, _mm256_set1_epi8(6)), t);
    over = _mm256_and_si256(over, _mm256_set1_epi8((char)0xf0));
    fits = _mm256_and_si256(fits, _mm256_cmpeq_epi64(over, zero));
    /* Pairs, then fours: the lower one is the thousands above the upper one's, at most one digit of it is there. */
    __m256i pairs = _mm256_maddubs_epi16(t, _mm256_set1_epi16(0x010a));
    __m256i fours = _mm256_madd_epi16(pairs, _mm256_set1_epi32(0x00010064));
    __m256i value = _mm256_add_epi64(_mm256_mul_epu32(fours, _mm256_set1_epi64x(10000)), _mm256_srli_epi64(fours, 32));
    __m256i limit = _mm256_sub_epi64(_mm256_set1_epi64x(INT16_MAX), negative);
    *good = _mm256_andnot_si256(_mm256_cmpgt_epi64(value, limit), fits);
    /* -v = ~v + 1 */
    return _mm256_sub_epi64(_mm256_xor_si256(value, negative), negative);
}

/* found |= (bytes ^ text) & mask */
static inline __m128i differ16(__m128i found, const char *bytes, const ost_text_column *column)
{
    __m128i x = _mm_xor_si128(_mm_loadu_si128((const void *)bytes), _mm_loadu_si128((const void *)column->text));
    return _mm_or_si128(found, _mm_and_si128(x, _mm_loadu_si128((const void *)column->mask)));
}

static inline __m256i differ32(__m256i found, const char *bytes, __m256i text, __m256i mask)
{
    __m256i x = _mm256_xor_si256(_mm256_loadu_si256((const void *)bytes), text);
    return _mm256_or_si256(found, _mm256_and_si256(x, mask));
}

/*
 * The first `count` lines from *text on, 1 to 4; whether all of them match and
 * end before `end`.  *text moves behind them then.  Lanes beyond hold a 0, which is good.
 */
static inline __attribute__((always_inline)) bool match_four(const ost_text_pattern *pattern, const ost_text_column *columns,
                                                             const uint8_t *lengths, const char **text, const char *end, int count,
                                                             int16_t *density)
{
    const __m256i before = _mm256_loadu_si256((const void *)pattern->before.text);
    const __m256i before_mask = _mm256_loadu_si256((const void *)pattern->before.mask);
    const __m256i after = _mm256_loadu_si256((const void *)pattern->after.text);
    const __m256i after_mask = _mm256_loadu_si256((const void *)pattern->after.mask);
    const size_t lead = pattern->before.length, other = lead + pattern->after.length;
    __m128i found16 = _mm_setzero_si128();
    __m256i found32 = _mm256_setzero_si256();
    /* "0" as if it ended its eight bytes, or "0\r". */
    const uint64_t nothing = pattern->carriage ? UINT64_C(0x0d30000000000000) : UINT64_C(0x3000000000000000);
    uint64_t last[LANES] = {nothing, nothing, nothing, nothing};
    int64_t length[LANES] = {1, 1, 1, 1};
    const char *p = *text;
#pragma GCC unroll 4
    for (int i = 0; i < count; i++) {
        const char *q = p + other + lengths[i];
        uint64_t word;
        memcpy(&word, q, sizeof word);
        uint64_t x = word ^ UINT64_C(0x0a0a0a0a0a0a0a0a);
        uint64_t bits = _tzcnt_u64((x - UINT64_C(0x0101010101010101)) & ~x & UINT64_C(0x8080808080808080));
        const char *column = p + lead;
        if (lead)
            found32 = differ32(found32, p, before, before_mask);
        found16 = differ16(found16, column, &columns[i]);
        found32 = differ32(found32, column + lengths[i], after, after_mask);
        /* The newline's mark is bit 8 n + 7. Without one n is 8, and with it first, 0: no density has either. */
        length[i] = (int64_t)(bits >> 3) - pattern->carriage;
        last[i] = word << ((71 - bits) & 63);
        p = q + (bits >> 3) + 1;
    }
    found32 = _mm256_or_si256(found32, _mm256_zextsi128_si256(found16));
    __m256i tail = _mm256_loadu_si256((const void *)last), good, lines = _mm256_set1_epi64x(-1);
    if (pattern->carriage) {
        lines = _mm256_cmpeq_epi64(_mm256_srli_epi64(tail, 56), _mm256_set1_epi64x('\r'));
        tail = _mm256_slli_epi64(tail, 8);
    }
    __m256i values = parse(tail, _mm256_loadu_si256((const void *)length), &good);
    good = _mm256_and_si256(good, lines);
    int64_t value[LANES];
    _mm256_storeu_si256((void *)value, values);
    for (int i = 0; i < count; i++)
        density[i] = (int16_t)value[i];
    if (_mm256_movemask_epi8(good) != -1 || !_mm256_testz_si256(found32, found32) || p > end)
        return false;
    *text = p;
    return true;
}

size_t ost_text_match_avx2(const ost_text_pattern *pattern, const ost_text_column *columns, const uint8_t *lengths, const char *text,
                           const char *end, size_t lines, int16_t *density, const char **next)
{
    size_t i = 0;
    while (i + LANES <= lines && match_four(pattern, columns + i, lengths + i, &text, end, LANES, density + i))
        i += LANES;
    while (i < lines && text < end && match_four(pattern, columns + i, lengths + i, &text, end, 1, density + i))
        i++;
    *next = text;
    return i;
}
