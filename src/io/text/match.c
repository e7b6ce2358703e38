/* SPDX-License-Identifier: Apache-2.0 */
/*
 * In C: what every other variant must equal.  Eight bytes that end with the
 * last digit hold all of a density:
 *
 *   bytes    3 0 0 0 ' ' - 1 0 4 3      w = the last eight, the first in the lowest byte
 *   w ^ '0'  ... 1 0 4 3 in the highest bytes; the others are masked away
 *
 * A byte b is a digit iff b < 10, iff neither b nor b + 6 reaches 16.  (A
 * carry out of a byte needs b >= 250, which the first test has seen.)
 */
#include "core/conditions.h"

#include "io/text/match.h"

#include <string.h>

#include "config.h"

static size_t newlines(const char *text, size_t bytes, uint32_t base, uint32_t *at)
{
    size_t found = 0;
    const char *p = text, *end = text + bytes;
    while (p < end && (p = memchr(p, '\n', (size_t)(end - p))))
        at[found++] = base + (uint32_t)(p++ - text);
    return found;
}

static uint64_t load64(const char *p)
{
    uint64_t w;
    memcpy(&w, p, sizeof w);
    return w;
}

/* [q, end) as a density; false when it is not of the common form. */
static bool read_density(const char *q, const char *end, int16_t *density)
{
    int64_t length = end - q;
    if (length < 1 || length > 6)
        return false;
    int64_t negative = *q == '-', digits = length - negative;
    if (digits < 1 || digits > 5)
        return false;
    uint64_t t = (load64(end - 8) ^ UINT64_C(0x3030303030303030)) & (UINT64_MAX << (64 - 8 * digits));
    if (((t + UINT64_C(0x0606060606060606)) | t) & UINT64_C(0xf0f0f0f0f0f0f0f0))
        return false;
    /* Pairs, fours, the eight of them: each product's upper half is the sum wanted. */
    t = (t * 2561) >> 8 & UINT64_C(0x00ff00ff00ff00ff);
    t = (t * 6553601) >> 16 & UINT64_C(0x0000ffff0000ffff);
    t = (t * UINT64_C(42949672960001)) >> 32;
    if ((int64_t)t > INT16_MAX + negative)
        return false;
    *density = (int16_t)(negative ? -(int64_t)t : (int64_t)t);
    return true;
}

static size_t match(const ost_text_pattern *pattern, const ost_text_column *columns, const uint8_t *lengths, const char *text,
                    const uint32_t *ends, size_t lines, int16_t *density)
{
    for (size_t i = 0; i < lines; i++) {
        const char *p = text + ends[(ptrdiff_t)i - 1] + 1, *end = text + ends[i] - pattern->carriage;
        size_t length = (size_t)pattern->before.length + lengths[i] + pattern->after.length;
        if (end - p <= (ptrdiff_t)length || (pattern->carriage && *end != '\r'))
            return i;
        if (memcmp(p, pattern->before.text, pattern->before.length) != 0)
            return i;
        p += pattern->before.length;
        if (memcmp(p, columns[i].text, lengths[i]) != 0)
            return i;
        p += lengths[i];
        if (memcmp(p, pattern->after.text, pattern->after.length) != 0 || !read_density(p + pattern->after.length, end, &density[i]))
            return i;
    }
    return lines;
}

void ost_text_kernels_fill(ost_text_kernels *kernels, ost_isa isa)
{
    *kernels = (ost_text_kernels){newlines, match};
#if HAVE_AVX2_BUILD
    if (isa == OST_ISA_AVX2 || isa == OST_ISA_AVX512 || isa == OST_ISA_AVX512VBMI)
        ost_text_kernels_avx2(kernels);
#endif
#if HAVE_AVX512_BUILD
    if (isa == OST_ISA_AVX512 || isa == OST_ISA_AVX512VBMI)
        ost_text_kernels_avx512(kernels);
#endif
    (void)isa;
}
