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

enum { OST_TEXT_COLUMN_MAX = 16, OST_TEXT_AROUND_MAX = 32, OST_TEXT_MARGIN = 128 };

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
    bool carriage; /* lines end with "\r\n" */
} ost_text_pattern;

/*
 * The places of all newlines in text[0, bytes), each plus `base`, ascending;
 * returns how many.  bytes is a multiple of 64, base + bytes is below 2^31; `at`
 * has room for bytes + 8, all of which may be overwritten.
 */
typedef size_t ost_text_newlines(const char *text, size_t bytes, uint32_t base, uint32_t *at);

/*
 * Line i, 0 <= i < lines, is text[ends[i - 1] + 1, ends[i]), with a newline at
 * ends[i]; it is matched when it is
 *   before, columns[i].text with lengths[i] bytes, after,
 *   then [-]digits of 1 to 5 digits and a value within int16, then "\r" with carriage.
 * Returns how many lines from the first on are matched, and puts their
 * densities; density[i] of others up to `lines` may hold anything.
 * ends[-1] is there, ends ascend and are below 2^31.  OST_TEXT_MARGIN bytes
 * before line 0 and behind the last newline can be read.
 */
typedef size_t ost_text_match(const ost_text_pattern *pattern, const ost_text_column *columns, const uint8_t *lengths, const char *text,
                              const uint32_t *ends, size_t lines, int16_t *density);

typedef struct ost_text_kernels {
    ost_text_newlines *newlines;
    ost_text_match *match;
} ost_text_kernels;

void ost_text_kernels_fill(ost_text_kernels *kernels, ost_isa isa);
void ost_text_kernels_avx2(ost_text_kernels *kernels);
void ost_text_kernels_avx512(ost_text_kernels *kernels);
void ost_text_kernels_neon(ost_text_kernels *kernels);

#endif
