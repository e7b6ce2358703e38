/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Reads the lines of a text header (NRRD, MetaImage) from an input, one by one. The lines may end in LF or CR LF, and
 * all of them remain in memory until the header is interpreted.
 */
#ifndef OST_IO_VOLUME_HEADER_LINES_H
#define OST_IO_VOLUME_HEADER_LINES_H

#include "io/volume/input.h"

enum { OST_HEADER_MAX = 1 << 22 }; /* maximum size of a header in bytes; enough for 16384 file names */

/* The lines of a header. Must be zero-initialised. Reading a line invalidates pointers into `bytes`. */
typedef struct ost_header_lines {
    char *bytes;   /* owned; text of all lines, each terminated by NUL */
    size_t size, capacity;
    size_t *start; /* owned; offset in `bytes` of each line */
    size_t count, start_capacity;
} ost_header_lines;

/*
 * Reads one line. At the end of the input, sets *ended instead. Returns OST_ERR_INPUT if the header contains a NUL or
 * exceeds OST_HEADER_MAX. `end_mark` is the text that ends a header, for the error message.
 */
ost_status ost_header_lines_next(ost_header_lines *lines, ost_input *input, const char *end_mark, bool *ended,
                                 ost_error *err);
void ost_header_lines_free(ost_header_lines *lines);

/* Returns the line with the given index, counted from 0. */
static inline char *ost_header_line(const ost_header_lines *lines, size_t index)
{
    return lines->bytes + lines->start[index];
}

#endif
