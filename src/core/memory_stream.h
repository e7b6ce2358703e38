/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A stream that writes into memory and reports each failed allocation.
 *
 * open_memstream is not suitable. In glibc (at least up to 2.41), a stream whose buffer cannot grow drops a byte
 * without setting its error flag, and fclose then returns 0 with a NULL buffer.
 */
#ifndef OST_CORE_MEMORY_STREAM_H
#define OST_CORE_MEMORY_STREAM_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

typedef struct ost_memory_stream {
    char *bytes;           /* the bytes that were written, followed by a NUL, which `size` does not count */
    size_t size, capacity; /* in bytes; valid only after the stream has been closed */
} ost_memory_stream;

/*
 * Opens a write-only stream, which cannot be repositioned. *memory must remain valid until the stream is
 * closed. Returns NULL if memory is exhausted.
 */
FILE *ost_memory_stream_open(ost_memory_stream *memory);

/*
 * Closes the stream. Returns true if memory->bytes contains all written bytes; the caller then frees
 * memory->bytes. Returns false if an allocation failed; memory->bytes is then NULL.
 */
bool ost_memory_stream_close(FILE *stream, ost_memory_stream *memory);

#endif
