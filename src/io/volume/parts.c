/* SPDX-License-Identifier: Apache-2.0 */
#include "io/volume/parts.h"

#include <assert.h>

typedef unsigned long long ull;

static ost_status check_part(const ost_parts *parts, const ost_input *input, ost_error *err)
{
    uint64_t most = ost_input_at_most(input);
    char location[OST_LOCATION_TEXT];
    if (most < parts->part_bytes) {
        if (ost_input_is_packed(input))
            return ost_fail(
                err, OST_ERR_INPUT,
                "%s: the packed data end at byte %llu and unpack to at most %llu bytes; the header's sizes need %llu",
                ost_input_path(input), (ull)ost_input_file_bytes(input), (ull)most, (ull)parts->part_bytes);
        return ost_fail(err, OST_ERR_INPUT,
                        "%s: ends at byte %llu: %llu bytes of data from %s on, but the header's sizes need %s%llu",
                        ost_input_path(input), (ull)ost_input_file_bytes(input), (ull)most,
                        ost_input_location(input, 0, location), parts->text ? "at least " : "", (ull)parts->part_bytes);
    }
    if (!parts->text && !ost_input_is_packed(input) && most > parts->part_bytes)
        return ost_fail(err, OST_ERR_INPUT,
                        "%s: %llu bytes too many: %llu bytes of data from %s on, but the header's sizes need %llu",
                        ost_input_path(input), (ull)(most - parts->part_bytes), (ull)most,
                        ost_input_location(input, 0, location), (ull)parts->part_bytes);
    return OST_OK;
}

ost_status ost_parts_check(const ost_parts *parts, ost_error *err)
{
    for (uint64_t i = 0; i < parts->count; i++) {
        ost_input *input;
        ost_status status = parts->open(parts->user, i, &input, err);
        if (status == OST_OK)
            status = check_part(parts, input, err);
        ost_input_close(input);
        if (status != OST_OK)
            return status;
    }
    return OST_OK;
}

ost_status ost_parts_ready(ost_parts *parts, ost_error *err)
{
    if (parts->input)
        return OST_OK;
    assert(parts->index < parts->count);
    ost_status status = parts->open(parts->user, parts->index, &parts->input, err);
    if (status != OST_OK)
        return status;
    parts->index++;
    parts->left = parts->part_bytes;
    return OST_OK;
}

ost_status ost_parts_end(ost_parts *parts, ost_error *err)
{
    if (!parts->input)
        return OST_OK;
    ost_status status = ost_input_expect_end(parts->input, err);
    ost_input_close(parts->input);
    parts->input = NULL;
    return status;
}

ost_status ost_parts_read(ost_parts *parts, void *bytes, size_t size, ost_error *err)
{
    unsigned char *to = bytes;
    assert(!parts->text);
    while (size > 0) {
        ost_status status;
        if (parts->input && parts->left == 0 && (status = ost_parts_end(parts, err)) != OST_OK)
            return status;
        if ((status = ost_parts_ready(parts, err)) != OST_OK)
            return status;
        size_t wanted = size < parts->left ? size : (size_t)parts->left;
        size_t got;
        status = ost_input_read(parts->input, to, wanted, &got, err);
        if (status != OST_OK)
            return status;
        to += got;
        size -= got;
        parts->left -= got;
        if (got < wanted) {
            char location[OST_LOCATION_TEXT];
            return ost_fail(
                err, OST_ERR_INPUT, "%s: data end at %s, but the header's sizes need %llu more bytes",
                ost_input_path(parts->input), ost_input_location(parts->input, 0, location), (ull)parts->left);
        }
    }
    return OST_OK;
}

void ost_parts_close(ost_parts *parts)
{
    ost_input_close(parts->input);
    parts->input = NULL;
}
