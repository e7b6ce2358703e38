/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Four lines at a time: their differences from what is expected are collected
 * in one register, which is looked at once.  Densities are parsed one by one,
 * as 64-bit lanes have no multiplication.  Four that do not all match are
 * gone over again one by one.
 */
#include "core/conditions.h"

#include "core/neon.h"
#include "io/text/density.h"
#include "io/text/match.h"

enum { LINES = 4 };

static size_t newlines(const char *text, size_t bytes, uint32_t base, uint32_t *at)
{
    const uint8x16_t newline = vdupq_n_u8('\n');
    uint32_t *to = at;
    for (size_t i = 0; i < bytes; i += 64) {
        const uint8_t *p = (const uint8_t *)text + i;
        uint64_t bits = ost_neon_bits64(vceqq_u8(vld1q_u8(p), newline), vceqq_u8(vld1q_u8(p + 16), newline),
                                        vceqq_u8(vld1q_u8(p + 32), newline), vceqq_u8(vld1q_u8(p + 48), newline));
        for (; bits; bits &= bits - 1)
            *to++ = base + (uint32_t)i + (uint32_t)__builtin_ctzll(bits);
    }
    return (size_t)(to - at);
}

/* found | (bytes ^ text) & mask */
static inline uint8x16_t differ(uint8x16_t found, const char *bytes, uint8x16_t text, uint8x16_t mask)
{
    return vorrq_u8(found, vandq_u8(veorq_u8(vld1q_u8((const uint8_t *)bytes), text), mask));
}

/* The first `count` lines. */
static inline bool match_lines(const ost_text_pattern *pattern, const ost_text_column *columns, const uint8_t *lengths, const char *text,
                               const uint32_t *ends, int count, int16_t *density)
{
    const ost_text_around *before = &pattern->before, *after = &pattern->after;
    uint8x16_t found = vdupq_n_u8(0);
    for (int i = 0; i < count; i++) {
        const char *p = text + ends[i - 1] + 1, *end = text + ends[i];
        if (before->length) {
            for (int h = 0; h < OST_TEXT_AROUND_MAX; h += 16)
                found = differ(found, p + h, vld1q_u8(before->text + h), vld1q_u8(before->mask + h));
            p += before->length;
        }
        found = differ(found, p, vld1q_u8(columns[i].text), vld1q_u8(columns[i].mask));
        p += lengths[i];
        for (int h = 0; h < OST_TEXT_AROUND_MAX; h += 16)
            found = differ(found, p + h, vld1q_u8(after->text + h), vld1q_u8(after->mask + h));
        p += after->length;
        if (pattern->carriage && *--end != '\r')
            return false;
        /* A line too short for all of this ends at p or before: that is no density. */
        if (!ost_text_density(p, end, &density[i]))
            return false;
    }
    return !ost_neon_any(found);
}

static size_t match(const ost_text_pattern *pattern, const ost_text_column *columns, const uint8_t *lengths, const char *text,
                    const uint32_t *ends, size_t lines, int16_t *density)
{
    size_t i = 0;
    while (i + LINES <= lines && match_lines(pattern, columns + i, lengths + i, text, ends + i, LINES, density + i))
        i += LINES;
    while (i < lines && match_lines(pattern, columns + i, lengths + i, text, ends + i, 1, density + i))
        i++;
    return i;
}

void ost_text_kernels_neon(ost_text_kernels *kernels)
{
    *kernels = (ost_text_kernels){newlines, match};
}
