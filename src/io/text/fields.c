/* SPDX-License-Identifier: Apache-2.0 */
#include "io/text/fields.h"

#include <string.h>

#include <osteon/grid.h>
#include <osteon/length.h>

const char *ost_text_quote(const char *field, const char *end, char quote[OST_TEXT_QUOTE])
{
    size_t length = (size_t)(end - field), capacity = OST_TEXT_QUOTE - 1;
    size_t taken = length <= capacity ? length : capacity - 3;
    for (size_t i = 0; i < taken; i++)
        quote[i] = field[i] ? field[i] : '?';
    quote[taken] = 0;
    if (taken < length)
        strcpy(quote + taken, "...");
    return quote;
}

bool ost_text_is_binary(const char *p, const char *end)
{
    for (; p < end; p++) {
        unsigned char c = (unsigned char)*p;
        if ((c < 0x20 && c != '\t') || c == 0x7f)
            return true;
    }
    return false;
}

static bool is_letter(char c)
{
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
}

/* Returns true if the word is nan, inf or infinity. Such a word indicates a defective line of numbers, not a header. */
static bool is_not_finite(const char *p, const char *end)
{
    static const char *const words[] = {"nan", "inf", "infinity"};
    if (p < end && (*p == '+' || *p == '-'))
        p++;
    for (size_t w = 0; w < sizeof words / sizeof words[0]; w++) {
        const char *word = words[w], *q = p;
        while (*word && q < end && (*q | 0x20) == *word) {
            word++;
            q++;
        }
        if (!*word && (q == end || *q == '('))
            return true;
    }
    return false;
}

bool ost_text_is_header(const char *p, const char *end)
{
    bool letters = false;
    if (ost_text_is_binary(p, end))
        return false;
    for (int i = 0;; i++) {
        ost_text_field_kind kind = ost_text_field_start(&p, end, i);
        if (kind != OST_TEXT_FIELD)
            return kind == OST_TEXT_END && letters;
        const char *field = p;
        ost_decimal ignored;
        p = ost_text_field_end(p, end);
        if (ost_decimal_read(field, p, &ignored) || is_not_finite(field, p))
            return false;
        for (const char *q = field; q < p; q++)
            letters |= is_letter(*q);
    }
}

_Static_assert(sizeof((ost_text_fact *)0)->key > OST_META_KEY && sizeof((ost_text_fact *)0)->value > OST_META_VALUE,
               "a fact that was cut is too long");

bool ost_text_fact_read(const char *comment, const char *end, ost_text_fact *fact)
{
    static const char word[] = "osteon";
    const size_t word_length = sizeof word - 1;
    const char *p = comment < end && *comment == '#' ? comment + 1 : comment;
    p = ost_text_skip_blanks(p, end);
    if ((size_t)(end - p) < word_length || memcmp(p, word, word_length) != 0)
        return false;
    p += word_length;
    if (p == end || !ost_text_is_blank(*p))
        return false;
    p = ost_text_skip_blanks(p, end);
    const char *colon = p;
    while (colon < end && *colon != ':' && !ost_text_is_blank(*colon))
        colon++;
    if (colon == p || colon == end || *colon != ':')
        return false;
    const char *value = ost_text_skip_blanks(colon + 1, end);
    while (end > value && ost_text_is_blank(end[-1]))
        end--;
    size_t key_length = (size_t)(colon - p), length = (size_t)(end - value);
    if (memchr(value, 0, length) || memchr(p, 0, key_length))
        return false;
    key_length = key_length < sizeof fact->key ? key_length : sizeof fact->key - 1;
    length = length < sizeof fact->value ? length : sizeof fact->value - 1;
    memcpy(fact->key, p, key_length);
    fact->key[key_length] = 0;
    memcpy(fact->value, value, length);
    fact->value[length] = 0;
    return true;
}
