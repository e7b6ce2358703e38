/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The common part of the variants for AVX2 and AVX-512: finds the ends of lines and compares all their bytes except the
 * densities.
 *
 * A line begins where the previous one ends. Processing lines one by one is therefore a chain of dependent steps of
 * about 14 cycles each: load, compare, count zeros, add. Here, the ends of four lines are found in one step instead:
 *
 *   q = density of line 0       c_k = number of bytes from the end of density k - 1
 *   |                                 to the start of density k
 *   1043\n-56.87 12.22 3.0 -7\n-56.40 12.22 3.0 512\n-55.93 12.22 3.0 88\n
 *   [0..........31]
 *             |  [1..........31]         window k: 32 bytes from q + c_1 + .. + c_k,
 *             q + c_1       |  [2...        searched for the first newline
 *
 * Proof that the first newline in window k is the end of line k. Let lines 0 to k - 1 match, so that their densities
 * have n_i <= 7 bytes ("-12345" and a carriage return). The density of line k begins n_0 + .. + n_(k-1) <= 21 bytes
 * after the beginning of its window. Let all lines have at least OST_TEXT_JUMP = 21 bytes in front of their densities.
 * The window then begins within these bytes. If line k matches, these bytes contain no newline, so the newline is at
 * index n_0 + .. + n_k <= 28 of the 32 bytes. If line k does not match, the ends that were found do not matter,
 * because a caller accepts all four lines or none.
 */
#ifndef OST_IO_TEXT_X86_MATCH_FOUR_H
#define OST_IO_TEXT_X86_MATCH_FOUR_H

#include "io/text/match.h"

#include <immintrin.h>
#include <string.h>

enum { OST_TEXT_JUMP = 21, OST_TEXT_AHEAD = 768 };

/* Expected bytes, current position, and the differences found so far. */
typedef struct match_state {
    __m256i before, before_mask, after, after_mask;
    size_t lead, other; /* lead: length of `before` in bytes; other: length of `before` plus length of `after` */
    const char *line;   /* start of the next line */
    const char *q;      /* start of the next line's density */
    __m128i found16;    /* found16 or found32 is not 0 if at least one byte differs */
    __m256i found32;
} match_state;

static inline __attribute__((always_inline)) match_state match_begin(const ost_text_pattern *pattern,
                                                                     const uint8_t *lengths, const char *text)
{
    const size_t lead = pattern->before.length, other = lead + pattern->after.length;
    return (match_state){
        .before = _mm256_loadu_si256((const void *)pattern->before.text),
        .before_mask = _mm256_loadu_si256((const void *)pattern->before.mask),
        .after = _mm256_loadu_si256((const void *)pattern->after.text),
        .after_mask = _mm256_loadu_si256((const void *)pattern->after.mask),
        .lead = lead,
        .other = other,
        .line = text,
        .q = text + other + lengths[0],
        .found16 = _mm_setzero_si128(),
        .found32 = _mm256_setzero_si256(),
    };
}

/* Both functions return found | ((bytes ^ text) & mask). The result is 0 if no difference has been found. */
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

/* Compares the bytes before the density in the line at p. */
static inline __attribute__((always_inline)) void match_front(match_state *s, const char *p,
                                                              const ost_text_column *column, size_t length)
{
    if (s->lead)
        s->found32 = differ32(s->found32, p, s->before, s->before_mask);
    s->found16 = differ16(s->found16, p + s->lead, column);
    s->found32 = differ32(s->found32, p + s->lead + length, s->after, s->after_mask);
}

/*
 * Processes the next four lines. `words` receives the eight bytes from the start of each density; a vector contains
 * the bytes of two lines.
 */
static inline __attribute__((always_inline)) void match_four(match_state *s, const ost_text_column *columns,
                                                             const uint8_t *lengths, __m128i words[2])
{
    const __m256i newline = _mm256_set1_epi8('\n');
    const char *window = s->q, *line = s->line, *q = s->q, *at[4];
#pragma GCC unroll 4
    for (int k = 0; k < 4; k++) {
        const size_t length = lengths[k];
        if (k > 0) {
            window += s->other + 1 + length;
            q = line + s->other + length;
        }
        at[k] = q;
        uint32_t newlines = (uint32_t)_mm256_movemask_epi8(
            _mm256_cmpeq_epi8(_mm256_loadu_si256((const void *)window), newline));
        match_front(s, line, &columns[k], length);
        line = window + _tzcnt_u32(newlines) + 1;
    }
    for (int k = 0; k < 2; k++)
        words[k] = _mm_castpd_si128(
            _mm_loadh_pd(_mm_castsi128_pd(_mm_loadl_epi64((const void *)at[2 * k])), (const void *)at[2 * k + 1]));
    _mm_prefetch(line + OST_TEXT_AHEAD, _MM_HINT_T0);
    _mm_prefetch(line + OST_TEXT_AHEAD + 64, _MM_HINT_T0);
    s->line = line;
}

/*
 * Processes one line, whose pattern may have any length. Returns eight bytes, which contain the density and the end of
 * the line.
 */
static inline __attribute__((always_inline)) uint64_t match_one(match_state *s, const ost_text_column *column,
                                                                uint8_t length)
{
    uint64_t word;
    s->q = s->line + s->other + length;
    memcpy(&word, s->q, sizeof word);
    match_front(s, s->line, column, length);
    uint64_t x = word ^ UINT64_C(0x0a0a0a0a0a0a0a0a);
    s->line = s->q + (_tzcnt_u64((x - UINT64_C(0x0101010101010101)) & ~x & UINT64_C(0x8080808080808080)) >> 3) + 1;
    return word;
}

static inline bool match_fronts_are_good(const match_state *s)
{
    return _mm256_testz_si256(s->found32, s->found32) && _mm_testz_si128(s->found16, s->found16);
}

#endif
