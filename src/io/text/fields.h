/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Splits a line of a text of numbers into fields.
 *
 *   " 0.47,\t-57.34 ; 1  120 # comment"   ->   0.47 | -57.34 | 1 | 120
 *
 * Fields are separated by blanks and tabs, with at most one comma or semicolon between them. Two commas or semicolons
 * without a field between them are an error. '#' ends the line.
 */
#ifndef OST_IO_TEXT_FIELDS_H
#define OST_IO_TEXT_FIELDS_H

#include <stdbool.h>
#include <stddef.h>

enum { OST_TEXT_QUOTE = 48 };

typedef enum ost_text_field_kind { OST_TEXT_FIELD, OST_TEXT_END, OST_TEXT_EMPTY } ost_text_field_kind;

static inline bool ost_text_is_blank(char c)
{
    return c == ' ' || c == '\t';
}

static inline bool ost_text_ends_field(char c)
{
    return ost_text_is_blank(c) || c == ',' || c == ';' || c == '#';
}

static inline const char *ost_text_skip_blanks(const char *p, const char *end)
{
    while (p < end && ost_text_is_blank(*p))
        p++;
    return p;
}

/*
 * Moves *p to the start of field `index`, counted from 0. On entry, *p is the start of the line or the end of the
 * previous field. Returns the kind of the field, or OST_TEXT_END if the line has no further field.
 */
static inline ost_text_field_kind ost_text_field_start(const char **p, const char *end, int index)
{
    const char *q = ost_text_skip_blanks(*p, end);
    bool separated = false;
    if (index > 0 && q < end && (*q == ',' || *q == ';')) {
        separated = true;
        q = ost_text_skip_blanks(q + 1, end);
    }
    *p = q;
    if (q == end || *q == '#')
        return separated ? OST_TEXT_EMPTY : OST_TEXT_END;
    return *q == ',' || *q == ';' ? OST_TEXT_EMPTY : OST_TEXT_FIELD;
}

static inline const char *ost_text_field_end(const char *p, const char *end)
{
    while (p < end && !ost_text_ends_field(*p))
        p++;
    return p;
}

/* Copies the field to `quote` for a message, and returns `quote`. A long field is truncated. */
const char *ost_text_quote(const char *field, const char *end, char quote[OST_TEXT_QUOTE]);
/* Returns true if the text contains bytes that do not occur in a text of numbers. */
bool ost_text_is_binary(const char *p, const char *end);
/*
 * Returns true if the fields of the line are words, that is, if at least one field contains a letter, and no field is
 * empty, a decimal, nan or inf.
 */
bool ost_text_is_header(const char *p, const char *end);

/*
 * Reads a comment "# osteon KEY: VALUE" (AR-CT-8), where KEY is a word without blanks. Trims VALUE and returns true;
 * returns false for all other comments. A key or value that is too long is truncated to the size of its array. The
 * arrays are larger than OST_META_KEY and OST_META_VALUE, so a truncated text is still too long for a header fact and
 * is refused.
 */
typedef struct ost_text_fact {
    char key[48];
    char value[256];
} ost_text_fact;
bool ost_text_fact_read(const char *comment, const char *end, ost_text_fact *fact);

#endif
