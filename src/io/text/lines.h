/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A text file as blocks of whole lines, in bounded memory.
 *
 *   file:    ....\n.......\n...|...\n....
 *   buffer: [....\n.......\n...]            a block ends behind its last newline;
 *                                           what follows it opens the next block
 *
 * Parsers see bytes and never the file, so that a faster one can take the
 * place of a plain one.  A last line without a newline gets one in the
 * buffer; a UTF-8 byte order mark at the start is skipped.
 */
#ifndef OST_IO_TEXT_LINES_H
#define OST_IO_TEXT_LINES_H

#include <stdbool.h>
#include <stdint.h>

#include <osteon/status.h>

enum {
    OST_TEXT_LINE_MAX = 4096,     /* bytes of a line; a longer one is not a text of numbers */
    OST_TEXT_BUFFER = 1 << 18
};

typedef struct ost_text_lines ost_text_lines;

typedef struct ost_text_block {
    const char *begin, *end; /* end[-1] == '\n'; begin == end: the file has ended */
} ost_text_block;

/*
 * OST_ERR_IO when path cannot be opened or is not a regular file: every text
 * is read twice, which a pipe cannot be.
 */
ost_status ost_text_lines_open(const char *path, ost_text_lines **out, ost_error *err);
/* Called before the first block: a file that is packed by gzip is unpacked as it is read; a plain one stays as it is. */
ost_status ost_text_lines_unpack(ost_text_lines *lines, bool *packed, ost_error *err);
void ost_text_lines_close(ost_text_lines *lines); /* NULL is allowed */

/* The block stays as it is until the next call. line_number is for the message about a line without end. */
ost_status ost_text_lines_next(ost_text_lines *lines, int64_t line_number, ost_text_block *block, ost_error *err);
/* Back to the file's start. */
ost_status ost_text_lines_rewind(ost_text_lines *lines, ost_error *err);

/* Bytes read so far and in all, for progress. */
double ost_text_lines_share(const ost_text_lines *lines);
/* Whether the file's last byte was a newline; known once it has ended. */
bool ost_text_lines_terminated(const ost_text_lines *lines);

#endif
