/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Matches four lines at a time. The code corresponds to match_avx512.c, with four lanes instead of eight, and with
 * vector masks (lanes of all ones) instead of mask registers.
 */
#include "core/conditions.h"

#include "io/text/x86/match_four.h"

enum { LANES = 4 };

/*
 * Parses one density per lane and returns the values. A lane of `last` contains the eight bytes that end with the
 * density. A lane of `length` is the number of bytes of the density; any value is permitted, even a negative one. A
 * lane of *good is set to -1 if the density is valid, otherwise to 0.
 */
static inline __m256i parse(__m256i last, __m256i length, __m256i *good)
{
    const __m256i zero = _mm256_setzero_si256(), bits = _mm256_set1_epi64x(64);
    __m256i fits = _mm256_and_si256(_mm256_cmpgt_epi64(length, zero),
                                    _mm256_cmpgt_epi64(_mm256_set1_epi64x(7), length));
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
    /*
     * Combines digits into pairs, and pairs into groups of four. The upper group contains the last four digits of a
     * density, and the lower group the ten-thousands digit, if any.
     */
    __m256i pairs = _mm256_maddubs_epi16(t, _mm256_set1_epi16(0x010a));
    __m256i fours = _mm256_madd_epi16(pairs, _mm256_set1_epi32(0x00010064));
    __m256i value = _mm256_add_epi64(_mm256_mul_epu32(fours, _mm256_set1_epi64x(10000)), _mm256_srli_epi64(fours, 32));
    __m256i limit = _mm256_sub_epi64(_mm256_set1_epi64x(INT16_MAX), negative);
    *good = _mm256_andnot_si256(_mm256_cmpgt_epi64(value, limit), fits);
    /* Negates in two's complement, using -v = ~v + 1. */
    return _mm256_sub_epi64(_mm256_xor_si256(value, negative), negative);
}

/*
 * Shifts a word that begins with a density, so that the last byte of the density becomes the highest byte (density.h).
 * Returns the length of the density.
 */
static inline int64_t align(uint64_t *word, bool carriage)
{
    uint64_t x = *word ^ UINT64_C(0x0a0a0a0a0a0a0a0a);
    uint64_t bits = _tzcnt_u64((x - UINT64_C(0x0101010101010101)) & ~x & UINT64_C(0x8080808080808080));
    /* The lowest set bit is 8 n + 7, where n is the index of the first newline. If there is no newline, n is 8; if byte
     * 0 is a newline, n is 0. Both are invalid lengths. */
    *word <<= (71 - bits) & 63;
    return (int64_t)(bits >> 3) - carriage;
}

/* Parses the densities in `count` words (1 to 4). Returns true if all densities are of the common form. */
static inline bool parse_words(uint64_t words[LANES], int count, bool carriage, int64_t value[LANES])
{
    int64_t length[LANES];
    for (int i = 0; i < LANES; i++)
        length[i] = align(&words[i], carriage);
    __m256i last = _mm256_setr_epi64x((int64_t)words[0], (int64_t)words[1], (int64_t)words[2], (int64_t)words[3]);
    __m256i lines = _mm256_set1_epi64x(-1), good;
    if (carriage) {
        lines = _mm256_cmpeq_epi64(_mm256_srli_epi64(last, 56), _mm256_set1_epi64x('\r'));
        last = _mm256_slli_epi64(last, 8);
    }
    __m256i values = parse(last, _mm256_setr_epi64x(length[0], length[1], length[2], length[3]), &good);
    good = _mm256_and_si256(good, lines);
    _mm256_storeu_si256((void *)value, values);
    const int lanes = (1 << count) - 1;
    return (_mm256_movemask_pd(_mm256_castsi256_pd(good)) & lanes) == lanes;
}

/*
 * Matches the first `count` lines (1 to 4) at *text. If all of them match and lie before `end`, advances *text and
 * returns true.
 */
static inline __attribute__((always_inline)) bool match_some(const ost_text_pattern *pattern,
                                                             const ost_text_column *columns, const uint8_t *lengths,
                                                             const char **text, const char *end, bool jump, int count,
                                                             int16_t *density)
{
    match_state s = match_begin(pattern, lengths, *text);
    uint64_t words[LANES] = {0};
    if (jump) {
        __m128i pairs[2];
        match_four(&s, columns, lengths, pairs);
        for (int i = 0; i < 2; i++) {
            words[2 * i] = (uint64_t)_mm_cvtsi128_si64(pairs[i]);
            words[2 * i + 1] = (uint64_t)_mm_extract_epi64(pairs[i], 1);
        }
    } else {
        for (int i = 0; i < count; i++)
            words[i] = match_one(&s, &columns[i], lengths[i]);
    }
    int64_t value[LANES];
    if (!parse_words(words, count, pattern->carriage, value) || !match_fronts_are_good(&s) || s.line > end)
        return false;
    for (int i = 0; i < count; i++)
        density[i] = (int16_t)value[i];
    *text = s.line;
    return true;
}

size_t ost_text_match_avx2(const ost_text_pattern *pattern, const ost_text_column *columns, const uint8_t *lengths,
                           const char *text, const char *end, size_t lines, int16_t *density, const char **next)
{
    const bool jump = pattern->before.length + pattern->after.length + pattern->shortest >= OST_TEXT_JUMP;
    size_t i = 0;
    while (i + LANES <= lines &&
           (jump ? match_some(pattern, columns + i, lengths + i, &text, end, true, LANES, density + i)
                 : match_some(pattern, columns + i, lengths + i, &text, end, false, LANES, density + i)))
        i += LANES;
    while (i < lines && text < end && match_some(pattern, columns + i, lengths + i, &text, end, false, 1, density + i))
        i++;
    *next = text;
    return i;
}
