/* SPDX-License-Identifier: Apache-2.0 */
#include "io/stack/slice.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

ost_slice_kind ost_slice_sniff(const unsigned char *head, size_t size)
{
    static const struct {
        const char *bytes;
        size_t length;
        ost_slice_kind kind;
    } formats[] = {
        {"II*\0", 4, OST_SLICE_TIFF}, {"MM\0*", 4, OST_SLICE_TIFF}, {"II+\0", 4, OST_SLICE_TIFF},
        {"MM\0+", 4, OST_SLICE_TIFF}, {"\x89PNG\r\n\x1a\n", 8, OST_SLICE_PNG},
    };
    for (size_t f = 0; f < sizeof formats / sizeof formats[0]; f++)
        if (size >= formats[f].length && memcmp(head, formats[f].bytes, formats[f].length) == 0)
            return formats[f].kind;
    return OST_SLICE_NONE;
}

const char *ost_slice_name(const ost_slice *slice, char text[OST_SLICE_NAME])
{
    if (slice->page)
        snprintf(text, OST_SLICE_NAME, "%s: page %u", slice->path, (unsigned)slice->page);
    else
        snprintf(text, OST_SLICE_NAME, "%s", slice->path);
    return text;
}

ost_status ost_slice_check(const ost_slice *slice, ost_error *err)
{
    char name[OST_SLICE_NAME];
    ost_slice_name(slice, name);
    if (slice->width < 1 || slice->height < 1 || slice->width > OST_DIM_MAX || slice->height > OST_DIM_MAX)
        return ost_fail(err, OST_ERR_RANGE, "%s: %ld x %ld pixels; expected 1 to %d along each axis", name,
                        (long)slice->width, (long)slice->height, OST_DIM_MAX);
    const uint64_t row = (uint64_t)slice->width * ost_element_bytes(slice->element);
    const uint64_t bytes = row * (uint64_t)slice->height;
    const uint64_t most = (uint64_t)slice->bytes * (slice->packed ? OST_SLICE_UNPACK_MAX : 1);
    if (bytes > most)
        return ost_fail(err, OST_ERR_INPUT,
                        "%s: %d x %d pixels of %s need %llu bytes; a file of %lld bytes has at most %llu", name,
                        (int)slice->width, (int)slice->height, ost_element_name(slice->element),
                        (unsigned long long)bytes, (long long)slice->bytes, (unsigned long long)most);
    return OST_OK;
}

ost_status ost_slice_row(ost_slice *slice, int32_t y, void *out, ost_error *err)
{
    return slice->row(slice, y, out, err);
}

ost_status ost_slice_next(ost_slice *slice, bool *more, ost_error *err)
{
    *more = false;
    return slice->next ? slice->next(slice, more, err) : OST_OK;
}

void ost_slice_close(ost_slice *slice)
{
    if (!slice)
        return;
    if (slice->close)
        slice->close(slice);
    free(slice->path);
    free(slice);
}
