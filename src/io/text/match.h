/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Matches lines of a CT text. A line matches if all its bytes except the density are equal to the expected bytes.
 *
 *   "-57.340000 12.220000 3.000000 1043\n"
 *    |--text--||-------after------||--|
 *     column c   the row's own     density, a whole number
 *
 * In a raster scan, every row repeats the column texts of the first row, and the other two coordinates are constant
 * within a row. Equal bytes represent equal numbers, so only the density of a line needs to be parsed. If x does not
 * run fastest, a text precedes the column; the pattern contains this text in `before`.
 */
#ifndef OST_IO_TEXT_MATCH_H
#define OST_IO_TEXT_MATCH_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "core/isa.h"

/*
 * OST_TEXT_MARGIN is the maximum number of bytes that a kernel reads beyond the end of the text. A kernel may read
 * eight lines beyond the end, each with the longest pattern and a density that is one byte longer than the maximum. It
 * may also read the first bytes after these lines.
 */
enum { OST_TEXT_COLUMN_MAX = 16, OST_TEXT_AROUND_MAX = 32, OST_TEXT_MARGIN = 1024 };
_Static_assert(8 * (2 * OST_TEXT_AROUND_MAX + OST_TEXT_COLUMN_MAX + 9) + 2 * OST_TEXT_AROUND_MAX + OST_TEXT_COLUMN_MAX +
                       32 <=
                   OST_TEXT_MARGIN,
               "kernels read no further");

/* The text of a column. Bytes beyond its length are 0 in `text` and in `mask`; all other bytes of `mask` are 0xff. */
typedef struct ost_text_column {
    unsigned char text[OST_TEXT_COLUMN_MAX];
    unsigned char mask[OST_TEXT_COLUMN_MAX];
} ost_text_column;

typedef struct ost_text_around {
    unsigned char text[OST_TEXT_AROUND_MAX];
    unsigned char mask[OST_TEXT_AROUND_MAX];
    uint32_t length;
} ost_text_around;

typedef struct ost_text_pattern {
    ost_text_around before, after;
    uint32_t shortest; /* minimum length of a column's text */
    bool carriage;     /* true if lines end with "\r\n" */
} ost_text_pattern;

/*
 * Matches consecutive lines from `text` on, and stops after `lines` lines or at the first line that does not match. The
 * last byte before `end` must be a newline, or text == end. Line i matches if it begins before `end` and consists of
 *   before, columns[i].text with lengths[i] bytes, after,
 *   a density of the common form (density.h), "\r" if `carriage` is true, and a newline.
 * Returns the number of matched lines, stores their densities, and sets *next to the line after them. Writes no other
 * element of `density`, because another thread may own it. OST_TEXT_MARGIN bytes from `end` on must be readable.
 */
typedef size_t ost_text_match(const ost_text_pattern *pattern, const ost_text_column *columns, const uint8_t *lengths,
                              const char *text, const char *end, size_t lines, int16_t *density, const char **next);

/* Returns the matcher for an instruction set. All matchers are equivalent to the scalar one. */
ost_text_match *ost_text_match_for(ost_isa isa);
ost_text_match ost_text_match_avx2, ost_text_match_avx512, ost_text_match_neon;

#endif
