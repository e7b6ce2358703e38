/* SPDX-License-Identifier: Apache-2.0 */
/* A result as JSON: docs/reproduction.md describes the keys. */
#ifndef OST_REPRODUCTION_WRITE_JSON_H
#define OST_REPRODUCTION_WRITE_JSON_H

#include "reproduction/result.h"

#define WRITE_JSON_FORMAT "osteon-reproduction-1"

/* Returns a result as JSON text with a final line feed, which the caller frees, or NULL if memory is exhausted. */
char *write_json_text(const result *r);

/* Reads a result from JSON text; its pictures have names but no bytes. name: the file, for messages. */
ost_status write_json_parse(const char *text, size_t size, const char *name, result *out, ost_error *err);

#endif
