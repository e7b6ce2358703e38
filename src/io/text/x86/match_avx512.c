/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Matches eight lines at a time (match_four.h). Their densities are parsed in parallel, one per lane, from the eight
 * bytes that begin with the density (density.h). If at least one of the eight lines does not match, the eight lines are
 * matched again one by one.
 */
#include "core/conditions.h"

#include "io/text/x86/match_four.h"

enum { LANES = 8 };

typedef struct densities {
    __m128i values; /* eight int16 */
    __mmask8 good;
} densities;

/*
 * Parses one density per lane. `last` contains the eight bytes that end with the density. `length` is the density's
 * number of bytes; any value is permitted.
 */
static inline densities parse(__m512i last, __m512i length)
{
    const __m512i one = _mm512_set1_epi64(1), bits = _mm512_set1_epi64(64);
    __mmask8 good = _mm512_cmplt_epu64_mask(_mm512_sub_epi64(length, one), _mm512_set1_epi64(6));
    __m512i first = _mm512_srlv_epi64(last, _mm512_sub_epi64(bits, _mm512_slli_epi64(length, 3)));
    __mmask8 negative = _mm512_cmpeq_epi64_mask(_mm512_and_si512(first, _mm512_set1_epi64(0xff)),
                                                _mm512_set1_epi64('-'));
    __m512i digits = _mm512_mask_sub_epi64(length, negative, length, one);
    good &= _mm512_cmplt_epu64_mask(_mm512_sub_epi64(digits, one), _mm512_set1_epi64(5));
    __m512i keep = _mm512_sllv_epi64(_mm512_set1_epi64(-1), _mm512_sub_epi64(bits, _mm512_slli_epi64(digits, 3)));
    __m512i t = _mm512_and_si512(_mm512_xor_si512(last, _mm512_set1_epi8('0')), keep);
    __m512i over = _mm512_or_si512(_mm512_add_epi8(t, _mm512_set1_epi8(6)), t);
    good &= _mm512_testn_epi64_mask(over, _mm512_set1_epi8((char)0xf0));
    /*
     * Combines digits into pairs, and pairs into groups of four. The upper group contains the last four digits of a
     * density, and the lower group the ten-thousands digit, if any.
     */
    __m512i pairs = _mm512_maddubs_epi16(t, _mm512_set1_epi16(0x010a));
    __m512i fours = _mm512_madd_epi16(pairs, _mm512_set1_epi32(0x00010064));
    __m512i value = _mm512_add_epi64(_mm512_mul_epu32(fours, _mm512_set1_epi64(10000)), _mm512_srli_epi64(fours, 32));
    __m512i limit = _mm512_mask_add_epi64(_mm512_set1_epi64(INT16_MAX), negative, _mm512_set1_epi64(INT16_MAX), one);
    good &= _mm512_cmple_epi64_mask(value, limit);
    value = _mm512_mask_sub_epi64(value, negative, _mm512_setzero_si512(), value);
    return (densities){_mm512_cvtepi64_epi16(value), good};
}

/* Parses words that begin with a density (density.h). */
static inline densities parse_words(__m512i words, bool carriage)
{
    /* Bit 8 n + 7 is set if byte n is a newline. If there is no newline, n is -1, which is an invalid length, and a
     * shift by 64 - 8 n = 72 bits yields 0. */
    __m512i x = _mm512_xor_si512(words, _mm512_set1_epi8('\n'));
    __m512i zero = _mm512_andnot_si512(x, _mm512_sub_epi64(x, _mm512_set1_epi8(1)));
    zero = _mm512_and_si512(zero, _mm512_set1_epi8((char)0x80));
    zero = _mm512_and_si512(zero, _mm512_sub_epi64(_mm512_setzero_si512(), zero));
    __m512i shift = _mm512_add_epi64(_mm512_lzcnt_epi64(zero), _mm512_set1_epi64(8));
    __m512i last = _mm512_sllv_epi64(words, shift);
    __m512i length = _mm512_srai_epi64(_mm512_sub_epi64(_mm512_set1_epi64(64), shift), 3);
    if (!carriage)
        return parse(last, length);
    __mmask8 good = _mm512_cmpeq_epi64_mask(_mm512_srli_epi64(last, 56), _mm512_set1_epi64('\r'));
    densities d = parse(_mm512_slli_epi64(last, 8), _mm512_sub_epi64(length, _mm512_set1_epi64(1)));
    d.good &= good;
    return d;
}

/*
 * Matches the first eight lines at *text. If all of them match and lie before `end`, advances *text and returns true.
 */
static inline bool match_eight(const ost_text_pattern *pattern, const ost_text_column *columns, const uint8_t *lengths,
                               const char **text, const char *end, int16_t *density)
{
    match_state s = match_begin(pattern, lengths, *text);
    __m128i words[4];
    match_four(&s, columns, lengths, words);
    s.q = s.line + s.other + lengths[4];
    match_four(&s, columns + 4, lengths + 4, words + 2);
    __m256i low = _mm256_inserti128_si256(_mm256_castsi128_si256(words[0]), words[1], 1);
    __m256i high = _mm256_inserti128_si256(_mm256_castsi128_si256(words[2]), words[3], 1);
    densities d = parse_words(_mm512_inserti64x4(_mm512_castsi256_si512(low), high, 1), pattern->carriage);
    if (d.good != 0xff || !match_fronts_are_good(&s) || s.line > end)
        return false;
    _mm_storeu_si128((void *)density, d.values);
    *text = s.line;
    return true;
}

/* Matches `count` lines (1 to 8) as match_eight does, and stores their densities. */
static bool match_some(const ost_text_pattern *pattern, const ost_text_column *columns, const uint8_t *lengths,
                       const char **text, const char *end, int count, int16_t *density)
{
    match_state s = match_begin(pattern, lengths, *text);
    const __mmask8 lanes = (__mmask8)((1 << count) - 1);
    uint64_t words[LANES] = {0};
    for (int i = 0; i < count; i++)
        words[i] = match_one(&s, &columns[i], lengths[i]);
    densities d = parse_words(_mm512_loadu_si512(words), pattern->carriage);
    if ((d.good & lanes) != lanes || !match_fronts_are_good(&s) || s.line > end)
        return false;
    _mm_mask_storeu_epi16(density, lanes, d.values);
    *text = s.line;
    return true;
}

size_t ost_text_match_avx512(const ost_text_pattern *pattern, const ost_text_column *columns, const uint8_t *lengths,
                             const char *text, const char *end, size_t lines, int16_t *density, const char **next)
{
    const bool jump = pattern->before.length + pattern->after.length + pattern->shortest >= OST_TEXT_JUMP;
    size_t i = 0;
    while (i < lines) {
        const int count = lines - i < LANES ? (int)(lines - i) : LANES;
        if (!(jump && count == LANES ? match_eight(pattern, columns + i, lengths + i, &text, end, density + i)
                                     : match_some(pattern, columns + i, lengths + i, &text, end, count, density + i)))
            break;
        i += (size_t)count;
    }
    while (i < lines && text < end && match_some(pattern, columns + i, lengths + i, &text, end, 1, density + i))
        i++;
    *next = text;
    return i;
}
