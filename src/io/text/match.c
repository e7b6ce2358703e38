/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The portable matcher; all other variants are equivalent to it. A density follows directly after the expected texts,
 * so its position is known. The newline is searched for in the eight bytes from this position on.
 */
#include "core/conditions.h"

#include "io/text/density.h"
#include "io/text/match.h"

#include <string.h>

#include "config.h"

static size_t match(const ost_text_pattern *pattern, const ost_text_column *columns, const uint8_t *lengths,
                    const char *text, const char *end, size_t lines, int16_t *density, const char **next)
{
    size_t i = 0;
    const size_t before = pattern->before.length, after = pattern->after.length;
    for (; i < lines && text < end; i++) {
        const char *column = text + before, *tail = column + lengths[i], *q = tail + after;
        if (memcmp(text, pattern->before.text, before) != 0 || memcmp(column, columns[i].text, lengths[i]) != 0 ||
            memcmp(tail, pattern->after.text, after) != 0)
            break;
        uint64_t w = ost_text_word(q);
        int64_t bytes = ost_text_bytes_of_line(w);
        if (q + bytes >= end || (pattern->carriage && (bytes < 1 || q[bytes - 1] != '\r')) ||
            !ost_text_density(w, bytes - pattern->carriage, &density[i]))
            break;
        text = q + bytes + 1;
    }
    *next = text;
    return i;
}

ost_text_match *ost_text_match_for(ost_isa isa)
{
#if HAVE_AVX512_BUILD
    if (ost_isa_includes(isa, OST_ISA_AVX512))
        return ost_text_match_avx512;
#endif
#if HAVE_AVX2_BUILD
    if (ost_isa_includes(isa, OST_ISA_AVX2))
        return ost_text_match_avx2;
#endif
#if HAVE_NEON_BUILD
    if (isa == OST_ISA_NEON)
        return ost_text_match_neon;
#endif
    (void)isa;
    return match;
}
