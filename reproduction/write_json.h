/* SPDX-License-Identifier: Apache-2.0 */
/* Converts a result to JSON and back. docs/reproduction.md describes the keys. */
#ifndef OST_REPRODUCTION_WRITE_JSON_H
#define OST_REPRODUCTION_WRITE_JSON_H

#include "reproduction/result.h"

#define WRITE_JSON_FORMAT "osteon-reproduction-1"

/*
 * Returns a result as JSON text that ends with a line feed, or NULL if memory is exhausted. The caller frees the text.
 */
char *write_json_text(const result *r);

/* Reads a result from JSON text. Pictures have names but no bytes. Errors contain `name`, the name of the file. */
ost_status write_json_parse(const char *text, size_t size, const char *name, result *out, ost_error *err);

#endif
