/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Parses JSON from untrusted sources within limits.
 *
 *   bytes --scan: depth, number of values--> an error line, or jansson's parser
 *
 * The memory that a parser allocates grows with the number of values, not with the number of bytes:
 * for the text "[0,0,0,...", it is sixteen times the size of the text. The scan allocates no memory.
 */
#ifndef OST_VALIDATION_LIMITS_H
#define OST_VALIDATION_LIMITS_H

#include <jansson.h>
#include <stddef.h>

#include <osteon/status.h>

enum {
    LIMIT_DEPTH = 16, /* maximum nesting depth of arrays and objects */
    LIMIT_VALUES = 1 << 20, /* maximum number of values in a JSON text */
    LIMIT_LINE =
        /* maximum size in bytes of a line of cases.jsonl; a leaf takes 67 bytes of a line, and a grid of 2^30
           voxels has 32768 leaves */
        64 << 20,
    LIMIT_ALL_VALUES = LIMIT_VALUES * 8, /* maximum number of values in cases.jsonl, over all its lines */
};

/* Counts the values of a JSON text. Each value takes about 100 bytes when parsed. Returns OST_ERR_INPUT with an error
   line "WHERE: ..." if a limit is exceeded. */
ost_status limits_count(const char *where, const char *bytes, size_t size, size_t *values, ost_error *err);

/* Parses a JSON text within the limits; the caller owns *out. Returns OST_ERR_MEMORY, or OST_ERR_INPUT with an error
   line "WHERE:LINE: ...". */
ost_status limits_parse(const char *where, const char *bytes, size_t size, json_t **out, ost_error *err);

/* Copies a name or another string of a bundle for a message, and replaces characters other than printable ASCII with
   '?'. Returns out. */
char *limits_printable(const char *text, char out[], size_t size);

#endif
