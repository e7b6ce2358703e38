/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Reads rows of a NRRD's text encoding: decimals separated by blanks and line ends.
 * In integer types, values must be integers within the header's type; in float
 * types they are rounded as decimals, half to even, without an intermediate binary
 * float.
 */
#ifndef OST_IO_NRRD_TEXT_ROWS_H
#define OST_IO_NRRD_TEXT_ROWS_H

#include "io/volume/rows.h"

typedef struct ost_nrrd_text_rows {
    ost_rows rows; /* the first member, because `next` converts an ost_rows * to a pointer to this struct */
    uint64_t in_part, left; /* number of values in each part; number of values not yet read from the open part */
} ost_nrrd_text_rows;

ost_status ost_nrrd_text_rows_next(ost_rows *rows, int64_t first, int16_t *out, ost_error *err);
/* Called after the last value of a part: returns an error if anything but blanks follows. */
ost_status ost_nrrd_text_rows_end(ost_nrrd_text_rows *rows, ost_error *err);

#endif
