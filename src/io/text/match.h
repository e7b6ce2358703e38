/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Lines of a CT text that are, but for their density, the bytes that were
 * expected.
 *
 *   "-57.340000 12.220000 3.000000 1043\n"
 *    |--text--||-------after------||--|
 *     column c   the row's own     density, a whole number
 *
 * In a scan every row repeats the columns of the first one, and keeps its
 * other two coordinates to its end.  Equal bytes are equal numbers, whatever
 * their form: so a line needs no parsing but that of its density.  Where
 * another axis than x runs fastest, `before` stands in front of the column.
 */
#ifndef OST_IO_TEXT_MATCH_H
#define OST_IO_TEXT_MATCH_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "core/isa.h"

/* MARGIN: eight lines, each as long as a pattern can be and a byte more than a density can, and what is read at the last one. */
enum { OST_TEXT_COLUMN_MAX = 16, OST_TEXT_AROUND_MAX = 32, OST_TEXT_MARGIN = 1024 };
_Static_assert(8 * (2 * OST_TEXT_AROUND_MAX + OST_TEXT_COLUMN_MAX + 9) + 2 * OST_TEXT_AROUND_MAX + OST_TEXT_COLUMN_MAX + 32 <= OST_TEXT_MARGIN,
               "kernels read no further");

/* Bytes beyond a length are 0 in text and mask; mask is 0xff elsewhere. */
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
    uint32_t shortest; /* no column is shorter */
    bool carriage;     /* lines end with "\r\n" */
} ost_text_pattern;

/*
 * Lines follow each other from `text` on; the last byte before `end` is a
 * newline, or text == end.  Line i, 0 <= i < lines, is matched when those
 * before it are, it begins before end, and it is
 *   before, columns[i].text with lengths[i] bytes, after,
 *   then [-]digits of 1 to 5 digits and a value within int16, then "\r" with carriage, and a newline.
 * Returns how many lines are matched, puts their densities, and in *next where
 * the line behind them begins.  No other density is written: those of lines
 * behind `end` may be another thread's.  OST_TEXT_MARGIN bytes from end on can be read.
 */
typedef size_t ost_text_match(const ost_text_pattern *pattern, const ost_text_column *columns, const uint8_t *lengths, const char *text,
                              const char *end, size_t lines, int16_t *density, const char **next);

/* Of an instruction set; every one equals the scalar one. */
ost_text_match *ost_text_match_for(ost_isa isa);
ost_text_match ost_text_match_avx2, ost_text_match_avx512, ost_text_match_neon;

#endif
