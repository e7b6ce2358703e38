/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Reads a text file as blocks of complete lines, in bounded memory.
 *
 *   file:    ....\n.......\n...|...\n....
 *   buffer: [....\n.......\n...]            a block ends after its last newline;
 *                                           the bytes after it begin the next block
 *
 * Parsers receive bytes and never read the file, so that a faster parser can replace a simple one. If the last line
 * has no newline, a newline is added in the buffer. A UTF-8 byte order mark at the start is skipped.
 */
#ifndef OST_IO_TEXT_LINES_H
#define OST_IO_TEXT_LINES_H

#include <stdbool.h>
#include <stdint.h>

#include <osteon/status.h>

enum {
    OST_TEXT_LINE_MAX = 4096,     /* maximum length in bytes of a line in a numeric text file */
    OST_TEXT_BUFFER = 1 << 18
};

typedef struct ost_text_lines ost_text_lines;

typedef struct ost_text_block {
    const char *begin, *end; /* end[-1] is a newline; begin == end means that the file has ended */
} ost_text_block;

/*
 * Opens a text file. Returns OST_ERR_IO if path cannot be opened or is not a regular file. A pipe is refused because
 * every text is read twice.
 */
ost_status ost_text_lines_open(const char *path, ost_text_lines **out, ost_error *err);
/*
 * Enables unpacking. Must be called before the first block is read. If the file is a gzip file, *packed is set, and the
 * following blocks are unpacked. Other files are read unchanged.
 */
ost_status ost_text_lines_unpack(ost_text_lines *lines, bool *packed, ost_error *err);
void ost_text_lines_close(ost_text_lines *lines); /* NULL is allowed */

/*
 * Reads the next block, which remains valid until the next call. `line_number` is the number of the block's first
 * line; the error message for a line that is too long states this number.
 */
ost_status ost_text_lines_next(ost_text_lines *lines, int64_t line_number, ost_text_block *block, ost_error *err);
/* Moves to the start of the file. */
ost_status ost_text_lines_rewind(ost_text_lines *lines, ost_error *err);

/* Returns the share of the file's bytes that has been read, from 0 to 1. Used to report progress. */
double ost_text_lines_share(const ost_text_lines *lines);
/* Returns true if the last byte of the file is a newline. Valid only after the end of the file was reached. */
bool ost_text_lines_terminated(const ost_text_lines *lines);

#endif
