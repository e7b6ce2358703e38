/* SPDX-License-Identifier: Apache-2.0 */
#include "core/memory_stream.h"

#include <stdlib.h>
#include <string.h>

/*
 * Appends bytes to the memory of a stream. Returns `size`. If memory is exhausted, returns 0, and the C library then
 * sets the error flag of the stream.
 */
static ssize_t add_bytes(void *user, const char *bytes, size_t size)
{
    ost_memory_stream *memory = user;
    if (size >= memory->capacity - memory->size) {
        size_t capacity = 2 * memory->capacity;
        while (size >= capacity - memory->size)
            capacity *= 2;
        char *more = realloc(memory->bytes, capacity);
        if (!more)
            return 0;
        memory->bytes = more;
        memory->capacity = capacity;
    }
    memcpy(memory->bytes + memory->size, bytes, size);
    memory->size += size;
    return (ssize_t)size;
}

FILE *ost_memory_stream_open(ost_memory_stream *memory)
{
    enum { FIRST_BYTES = 1 << 13 };
    *memory = (ost_memory_stream){.bytes = malloc(FIRST_BYTES), .capacity = FIRST_BYTES};
    FILE *stream = memory->bytes ? fopencookie(memory, "w", (cookie_io_functions_t){.write = add_bytes}) : NULL;
    if (!stream) {
        free(memory->bytes);
        memory->bytes = NULL;
    }
    return stream;
}

bool ost_memory_stream_close(FILE *stream, ost_memory_stream *memory)
{
    bool complete = ferror(stream) == 0;
    complete &= fclose(stream) == 0;
    if (complete) {
        memory->bytes[memory->size] = '\0';
        return true;
    }
    free(memory->bytes);
    memory->bytes = NULL;
    return false;
}
