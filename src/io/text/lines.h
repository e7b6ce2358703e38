/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Reads a text file as blocks of complete lines, in bounded memory.
 *
 *   file:    ....\n.......\n...|...\n....
 *   buffer: [....\n.......\n...]            a block ends after its last newline;
 *                                           the bytes after it begin the next block
 *
 * Parsers receive bytes and never read the file, so that a faster parser can replace
 * a simple one. A last line without a newline gets one in the buffer; a UTF-8 byte
 * order mark at the start is skipped.
 */
#ifndef OST_IO_TEXT_LINES_H
#define OST_IO_TEXT_LINES_H

#include <stdbool.h>
#include <stdint.h>

#include <osteon/status.h>

enum {
    OST_TEXT_LINE_MAX = 4096,     /* bytes of a line; a longer one means that the file is not a text of numbers */
    OST_TEXT_BUFFER = 1 << 18
};

typedef struct ost_text_lines ost_text_lines;

typedef struct ost_text_block {
    const char *begin, *end; /* end[-1] == '\n'; begin == end: the file has ended */
} ost_text_block;

/*
 * Opens a text file. Returns OST_ERR_IO if path cannot be opened or is not a regular
 * file: every text is read twice, which is impossible with a pipe.
 */
ost_status ost_text_lines_open(const char *path, ost_text_lines **out, ost_error *err);
/* Called before the first block. A file packed by gzip is unpacked while it is read; a plain file is read unchanged. */
ost_status ost_text_lines_unpack(ost_text_lines *lines, bool *packed, ost_error *err);
void ost_text_lines_close(ost_text_lines *lines); /* NULL is allowed */

/*
 * Reads the next block, which is valid until the next call. line_number is used in the message about a line that is
 * too long.
 */
ost_status ost_text_lines_next(ost_text_lines *lines, int64_t line_number, ost_text_block *block, ost_error *err);
/* Returns to the file's start. */
ost_status ost_text_lines_rewind(ost_text_lines *lines, ost_error *err);

/* Returns the share of the file's bytes that has been read, from 0 to 1, for progress. */
double ost_text_lines_share(const ost_text_lines *lines);
/* Returns true if the file's last byte is a newline; valid once the file has ended. */
bool ost_text_lines_terminated(const ost_text_lines *lines);

#endif
