/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A stream that writes into memory and reports each failed allocation.
 *
 * open_memstream is not suitable: in glibc (at least up to 2.41) it drops a byte for which its buffer cannot grow
 * without setting the stream's error flag, and a close without memory returns 0 with a buffer of NULL.
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

/*
 * Opens a write-only stream, which cannot be repositioned; *memory must remain valid until the close.
 * Returns NULL if there is no memory.
 */
FILE *ost_memory_stream_open(ost_memory_stream *memory);

/*
 * Closes the stream. Returns true if memory->bytes has all bytes that were written; the caller frees
 * it. Returns false if memory was lacking for a write; memory->bytes is then NULL.
 */
bool ost_memory_stream_close(FILE *stream, ost_memory_stream *memory);

#endif
