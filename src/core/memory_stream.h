/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A stream that writes into memory and reports each failed allocation.
 *
 * open_memstream is unfit: in glibc (up to 2.41 at least) a byte for which its buffer cannot grow is dropped
 * without the stream's error flag, and a close without memory returns 0 with a buffer of NULL.
 */
#ifndef OST_CORE_MEMORY_STREAM_H
#define OST_CORE_MEMORY_STREAM_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

typedef struct ost_memory_stream {
    char *bytes;           /* followed by a NUL that size does not count */
    size_t size, capacity; /* valid after the close */
} ost_memory_stream;

/* Opens a stream for writing alone, which cannot be repositioned; *memory must remain until the close. NULL without memory. */
FILE *ost_memory_stream_open(ost_memory_stream *memory);

/*
 * Closes the stream. Returns true if memory->bytes holds all that was written; the caller frees it. Returns false
 * if a write had no memory; memory->bytes is then NULL.
 */
bool ost_memory_stream_close(FILE *stream, ost_memory_stream *memory);

#endif
