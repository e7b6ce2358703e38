/* SPDX-License-Identifier: Apache-2.0 */
/* In C: what every other variant must equal. */
#include "core/conditions.h"

#include "io/text/density.h"
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
        if (memcmp(p, pattern->after.text, pattern->after.length) != 0 || !ost_text_density(p + pattern->after.length, end, &density[i]))
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
#if HAVE_NEON_BUILD
    if (isa == OST_ISA_NEON)
        ost_text_kernels_neon(kernels);
#endif
    (void)isa;
}
