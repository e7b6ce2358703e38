/* SPDX-License-Identifier: Apache-2.0 */
#include "io/volume/header_lines.h"

#include <stdlib.h>

static ost_status append(ost_header_lines *lines, int byte, const char *path, const char *end_mark, ost_error *err)
{
    if (lines->size == OST_HEADER_MAX)
        return ost_fail(err, OST_ERR_INPUT, "%s: the header is longer than %d bytes; expected %s at its end", path,
                        OST_HEADER_MAX, end_mark);
    if (lines->size == lines->capacity) {
        size_t more = lines->capacity ? 2 * lines->capacity : 4096;
        char *bytes = realloc(lines->bytes, more);
        if (!bytes)
            return ost_fail(err, OST_ERR_MEMORY, "%s: out of memory for a header of %zu bytes", path, more);
        lines->bytes = bytes;
        lines->capacity = more;
    }
    lines->bytes[lines->size++] = (char)byte;
    return OST_OK;
}

static ost_status append_start(ost_header_lines *lines, size_t start, const char *path, ost_error *err)
{
    if (lines->count == lines->start_capacity) {
        size_t more = lines->start_capacity ? 2 * lines->start_capacity : 64;
        size_t *bigger = realloc(lines->start, more * sizeof *bigger);
        if (!bigger)
            return ost_fail(err, OST_ERR_MEMORY, "%s: out of memory for %zu header lines", path, more);
        lines->start = bigger;
        lines->start_capacity = more;
    }
    lines->start[lines->count++] = start;
    return OST_OK;
}

ost_status ost_header_lines_next(ost_header_lines *lines, ost_input *input, const char *end_mark, bool *ended,
                                 ost_error *err)
{
    const char *path = ost_input_path(input);
    const size_t start = lines->size;
    *ended = false;
    for (;;) {
        int byte;
        ost_status status = ost_input_byte(input, &byte, err);
        if (status != OST_OK)
            return status;
        if (byte < 0 && lines->size == start) {
            *ended = true;
            return OST_OK;
        }
        if (byte == 0)
            return ost_fail(err, OST_ERR_INPUT, "%s: a NUL in its header, before byte %llu; expected text", path,
                            (unsigned long long)ost_input_offset(input));
        if (byte < 0 || byte == '\n') {
            if (lines->size > start && lines->bytes[lines->size - 1] == '\r')
                lines->bytes[lines->size - 1] = 0;
            status = append(lines, 0, path, end_mark, err);
            return status == OST_OK ? append_start(lines, start, path, err) : status;
        }
        status = append(lines, byte, path, end_mark, err);
        if (status != OST_OK)
            return status;
    }
}

void ost_header_lines_free(ost_header_lines *lines)
{
    free(lines->bytes);
    free(lines->start);
    *lines = (ost_header_lines){0};
}
