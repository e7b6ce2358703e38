/* SPDX-License-Identifier: Apache-2.0 */
/* Reads a text file of limited size, such as a list of landmarks, into memory. */
#ifndef OST_IO_SMALL_TEXT_H
#define OST_IO_SMALL_TEXT_H

#include <stdbool.h>
#include <stddef.h>

#include <osteon/status.h>

/*
 * Reads the file at `path`, and skips a UTF-8 byte order mark. *text receives *size bytes and a final NUL; the caller
 * frees it. After an error, *text is NULL. Returns OST_ERR_INPUT if the file is larger than the limit `most` or
 * contains a NUL byte. Error messages include two texts: `contents` says what the file contains, for example
 * "landmarks", and `expected` says which formats are accepted.
 */
ost_status ost_small_text_read(const char *path, size_t most, const char *contents, const char *expected, char **text,
                               size_t *size, ost_error *err);

/* Returns true if the text is a JSON object, judging by its first character that is not white space. */
bool ost_small_text_is_json(const char *text);

#endif
