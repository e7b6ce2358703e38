/* SPDX-License-Identifier: Apache-2.0 */
/* Reads a text file of limited size, such as a list of landmarks, into memory. */
#ifndef OST_IO_SMALL_TEXT_H
#define OST_IO_SMALL_TEXT_H

#include <stdbool.h>
#include <stddef.h>

#include <osteon/status.h>

/*
 * Reads the file at `path`, and skips a UTF-8 byte order mark. *text receives *size bytes and a final NUL; the caller
 * frees it. After an error, *text is NULL. Returns OST_ERR_INPUT if the file has more than `most` bytes or contains a
 * NUL byte; the message names the contents, for example "landmarks", and the expected formats.
 */
ost_status ost_small_text_read(const char *path, size_t most, const char *contents, const char *expected, char **text,
                               size_t *size, ost_error *err);

/* Returns true if the text is a JSON object, judging by its first character that is not white space. */
bool ost_small_text_is_json(const char *text);

#endif
