/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Reads rows of a NRRD's text encoding: decimals separated by blanks and line ends. If the header's type is an
 * integer type, the values must be integers within the range of this type. If it is a float type, the decimals are
 * rounded half to even, without an intermediate binary float.
 */
#ifndef OST_IO_NRRD_TEXT_ROWS_H
#define OST_IO_NRRD_TEXT_ROWS_H

#include "io/volume/rows.h"

typedef struct ost_nrrd_text_rows {
    ost_rows rows; /* must be the first member, because `next` casts an ost_rows * to this struct */
    /* in_part: number of values in each part; left: number of unread values in the open part */
    uint64_t in_part, left;
} ost_nrrd_text_rows;

ost_status ost_nrrd_text_rows_next(ost_rows *rows, int64_t first, int16_t *out, ost_error *err);

#endif
