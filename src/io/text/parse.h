/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Parses CT text, from bytes to rows (thesis, Alg. 2.2; docs/spec/arithmetic.md, AR-CT-1, AR-CT-2).
 *
 *   # osteon spacing_mm: 0.47 0.47 1      facts, one per comment
 *   x y z density                         one header line of words may come first
 *   -57.3400 12.2200 3.0000 1043          a sample: positions in mm, exact decimals
 *   -56.8700,12.2200,3.0000,-1.2e2        tabs, commas, semicolons; a sign, a point, an exponent
 *
 * The input is complete lines, and the output is rows. The parser opens no file and allocates no memory.
 */
#ifndef OST_IO_TEXT_PARSE_H
#define OST_IO_TEXT_PARSE_H

#include <osteon/backend.h>

#include "io/text/fields.h"
#include "io/text/lines.h"

/*
 * Limits on the number of decimal places. Fewer than MIN places are treated as MIN places, and digits beyond MAX
 * places are rounded.
 */
enum { OST_TEXT_PLACES_MIN = -3, OST_TEXT_PLACES_MAX = 9 };

typedef struct ost_text_row {
    ost_pm position[3];
    int64_t line;     /* line number, counted from 1 */
    int32_t density;  /* within int16 */
    int8_t places[3]; /* number of decimal places, OST_TEXT_PLACES_MIN to OST_TEXT_PLACES_MAX */
    uint8_t rounded;  /* bit a is 1 if coordinate a was rounded to a picometre */
} ost_text_row;

typedef struct ost_text_parser {
    const char *path;
    int64_t line;     /* number of lines parsed so far */
    bool past_header; /* true if a header or a sample has been read */
    /* Called for every header fact; parser->line is the line of the fact. NULL if facts are not needed. */
    ost_status (*fact)(void *user, const struct ost_text_parser *parser, const ost_text_fact *fact, ost_error *err);
    void *user;
} ost_text_parser;

/*
 * Parses lines from block->begin on, and advances block->begin. Stops at the end of the block, or when `rows` is full.
 * At the first invalid line, returns OST_ERR_INPUT; the message contains the file, line and column, the value and what
 * was expected.
 */
ost_status ost_text_parse(ost_text_parser *parser, ost_text_block *block, ost_text_row *rows, size_t capacity,
                          size_t *count, ost_error *err);

#endif
