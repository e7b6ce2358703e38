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

static size_t newlines(const char *text, size_t bytes, uint32_t base, uint32_t *at)
{
    const __m256i newline = _mm256_set1_epi8('\n');
    uint32_t *to = at;
    for (size_t i = 0; i < bytes; i += 64) {
        __m256i low = _mm256_cmpeq_epi8(_mm256_loadu_si256((const void *)(text + i)), newline);
        __m256i high = _mm256_cmpeq_epi8(_mm256_loadu_si256((const void *)(text + i + 32)), newline);
        uint64_t bits = (uint32_t)_mm256_movemask_epi8(low) | (uint64_t)(uint32_t)_mm256_movemask_epi8(high) << 32;
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

/*
 * last: the eight bytes before each line's end; length: of what must be its
 * density, of any size, signed.  Returns lanes of values and in *good lanes of -1.
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

/* The first `count` lines, 1 to 4; lanes beyond repeat the first. */
static inline bool match_four(const ost_text_pattern *pattern, const ost_text_column *columns, const uint8_t *lengths, const char *text,
                              const uint32_t *ends, int count, int16_t *density)
{
    const __m256i before = _mm256_loadu_si256((const void *)pattern->before.text);
    const __m256i before_mask = _mm256_loadu_si256((const void *)pattern->before.mask);
    const __m256i after = _mm256_loadu_si256((const void *)pattern->after.text);
    const __m256i after_mask = _mm256_loadu_si256((const void *)pattern->after.mask);
    const uint32_t lead = pattern->before.length, other = lead + pattern->after.length + pattern->carriage;
    __m128i found16 = _mm_setzero_si128();
    __m256i found32 = _mm256_setzero_si256();
    int64_t length[LANES], last[LANES];
    for (int lane = 0; lane < LANES; lane++) {
        int i = lane < count ? lane : 0;
        const char *p = text + ends[i - 1] + 1;
        length[lane] = (int64_t)ends[i] - ends[i - 1] - 1 - lengths[i] - other;
        memcpy(&last[lane], text + ends[i] - 8, sizeof last[lane]);
        if (lead) {
            found32 = differ32(found32, p, before, before_mask);
            p += lead;
        }
        found16 = differ16(found16, p, &columns[i]);
        found32 = differ32(found32, p + lengths[i], after, after_mask);
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
    return _mm256_movemask_epi8(good) == -1 && _mm256_testz_si256(found32, found32);
}

static size_t match(const ost_text_pattern *pattern, const ost_text_column *columns, const uint8_t *lengths, const char *text,
                    const uint32_t *ends, size_t lines, int16_t *density)
{
    size_t i = 0;
    for (; i < lines; i += LANES)
        if (!match_four(pattern, columns + i, lengths + i, text, ends + i, lines - i < LANES ? (int)(lines - i) : LANES, density + i))
            break;
    while (i < lines && match_four(pattern, columns + i, lengths + i, text, ends + i, 1, density + i))
        i++;
    return i < lines ? i : lines;
}

void ost_text_kernels_avx2(ost_text_kernels *kernels)
{
    *kernels = (ost_text_kernels){newlines, match};
}
