/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Rows of a NRRD's text encoding: decimals separated by blanks and line ends.
 * Integers must be whole and within the header's type; floats are rounded as
 * decimals, half to even, without ever being a binary float.
 */
#ifndef OST_IO_NRRD_TEXT_ROWS_H
#define OST_IO_NRRD_TEXT_ROWS_H

#include "io/volume/rows.h"

typedef struct ost_nrrd_text_rows {
    ost_rows rows; /* first, so that next can find the rest */
    uint64_t in_part, left; /* values in every part, and still to come in the open one */
} ost_nrrd_text_rows;

ost_status ost_nrrd_text_rows_next(ost_rows *rows, int64_t first, int16_t *out, ost_error *err);
/* After the last value: only blanks may follow. */
ost_status ost_nrrd_text_rows_end(ost_nrrd_text_rows *rows, ost_error *err);

#endif
