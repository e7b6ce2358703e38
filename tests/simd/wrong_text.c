/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Wrong kernels of the text reader.
 */
#include <stdlib.h>
#include <string.h>

#include "io/text/match.h"
#include "simd/wrong.h"

extern const check_kernel check_text_match;

static size_t text_match(const ost_text_pattern *pattern, const ost_text_column *columns, const uint8_t *lengths,
                         const char *text, const char *end, size_t lines, int16_t *density, const char **next)
{
    return ost_text_match_for(OST_ISA_SCALAR)(pattern, columns, lengths, text, end, lines, density, next);
}

static size_t match_stops_early(const ost_text_pattern *pattern, const ost_text_column *columns, const uint8_t *lengths,
                                const char *text, const char *end, size_t lines, int16_t *density, const char **next)
{
    const size_t n = text_match(pattern, columns, lengths, text, end, lines, density, next);
    return n == lines && lines % 8 == 7 ? n - 1 : n;
}

/* Simulates a kernel that stores densities modulo 2^16, because it narrows them without a range check. */
static size_t match_wraps_densities(const ost_text_pattern *pattern, const ost_text_column *columns,
                                    const uint8_t *lengths, const char *text, const char *end, size_t lines,
                                    int16_t *density, const char **next)
{
    size_t n = text_match(pattern, columns, lengths, text, end, lines, density, next);
    while (n < lines && *next < end) {
        const char *q = *next + pattern->before.length + lengths[n] + pattern->after.length;
        if (memcmp(q, "32768\n", 6) != 0)
            break;
        density[n++] = INT16_MIN;
        n += text_match(pattern, columns + n, lengths + n, q + 6, end, lines - n, density + n, next);
    }
    return n;
}

/* Simulates a kernel that does not stop at `end` and also matches the next line, which another thread reads. */
static size_t match_continues_after_the_end(const ost_text_pattern *pattern, const ost_text_column *columns,
                                            const uint8_t *lengths, const char *text, const char *end, size_t lines,
                                            int16_t *density, const char **next)
{
    const size_t n = text_match(pattern, columns, lengths, text, end, lines, density, next);
    if (n == lines || *next != end)
        return n;
    return n + text_match(pattern, columns + n, lengths + n, end, end + OST_TEXT_MARGIN, 1, density + n, next);
}

static size_t match_wrong_next(const ost_text_pattern *pattern, const ost_text_column *columns,
                               const uint8_t *lengths, const char *text, const char *end, size_t lines,
                               int16_t *density, const char **next)
{
    const size_t n = text_match(pattern, columns, lengths, text, end, lines, density, next);
    text_match(pattern, columns, lengths, text, end, n & ~(size_t)3, density, next);
    return n;
}

static size_t match_writes_an_unmatched_density(const ost_text_pattern *pattern, const ost_text_column *columns,
                                                const uint8_t *lengths, const char *text, const char *end, size_t lines,
                                                int16_t *density, const char **next)
{
    const size_t n = text_match(pattern, columns, lengths, text, end, lines, density, next);
    if (n < lines)
        density[n] = 0;
    return n;
}

static size_t match_reads_before(const ost_text_pattern *pattern, const ost_text_column *columns,
                                 const uint8_t *lengths, const char *text, const char *end, size_t lines,
                                 int16_t *density, const char **next)
{
    touch(text - 1);
    return text_match(pattern, columns, lengths, text, end, lines, density, next);
}

static size_t match_reads_past_the_margin(const ost_text_pattern *pattern, const ost_text_column *columns,
                                          const uint8_t *lengths, const char *text, const char *end, size_t lines,
                                          int16_t *density, const char **next)
{
    touch(end + OST_TEXT_MARGIN);
    return text_match(pattern, columns, lengths, text, end, lines, density, next);
}

static const wrong list[] = {
    WRONG(text_match, match_stops_early, DIFFERS),
    WRONG(text_match, match_wraps_densities, DIFFERS),
    WRONG(text_match, match_continues_after_the_end, DIFFERS),
    WRONG(text_match, match_wrong_next, DIFFERS),
    WRONG(text_match, match_writes_an_unmatched_density, DIFFERS),
    WRONG(text_match, match_reads_before, FAULT),
    WRONG(text_match, match_reads_past_the_margin, FAULT),
};
const wrong_list wrong_text = {list, sizeof list / sizeof list[0]};
