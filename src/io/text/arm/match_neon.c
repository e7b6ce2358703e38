/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Matches four lines at a time. The differences from the expected bytes are ORed into one register, which is tested
 * once. Densities are parsed one by one in general registers, because NEON has no multiply instruction for 64-bit
 * lanes. If at least one of the four lines does not match, the four lines are matched again one by one.
 */
#include "core/conditions.h"

#include "core/neon.h"
#include "io/text/density.h"
#include "io/text/match.h"

enum { LINES = 4 };

/* Returns found | ((bytes ^ text) & mask). The result is 0 if no difference has been found. */
static inline uint8x16_t differ(uint8x16_t found, const char *bytes, uint8x16_t text, uint8x16_t mask)
{
    return vorrq_u8(found, vandq_u8(veorq_u8(vld1q_u8((const uint8_t *)bytes), text), mask));
}

/*
 * Matches the first `count` lines (1 to 4) at *text. If all of them match and lie before `end`, advances *text and
 * returns true.
 */
static inline bool match_lines(const ost_text_pattern *pattern, const ost_text_column *columns, const uint8_t *lengths,
                               const char **text, const char *end, int count, int16_t *density)
{
    const ost_text_around *before = &pattern->before, *after = &pattern->after;
    uint8x16_t found = vdupq_n_u8(0);
    int16_t value[LINES];
    const char *p = *text;
    for (int i = 0; i < count; i++) {
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
        uint64_t word = ost_text_word(p);
        int64_t bytes = ost_text_bytes_of_line(word);
        if (pattern->carriage && (bytes < 1 || p[bytes - 1] != '\r'))
            return false;
        if (!ost_text_density(word, bytes - pattern->carriage, &value[i]))
            return false;
        p += bytes + 1;
    }
    if (p > end || ost_neon_any(found))
        return false;
    for (int i = 0; i < count; i++)
        density[i] = value[i];
    *text = p;
    return true;
}

size_t ost_text_match_neon(const ost_text_pattern *pattern, const ost_text_column *columns, const uint8_t *lengths,
                           const char *text, const char *end, size_t lines, int16_t *density, const char **next)
{
    size_t i = 0;
    while (i + LINES <= lines && match_lines(pattern, columns + i, lengths + i, &text, end, LINES, density + i))
        i += LINES;
    while (i < lines && text < end && match_lines(pattern, columns + i, lengths + i, &text, end, 1, density + i))
        i++;
    *next = text;
    return i;
}
