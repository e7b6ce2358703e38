/* SPDX-License-Identifier: Apache-2.0 */
#include "io/volume/input.h"

#include <assert.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <zlib.h>

#include "core/file.h"

enum { BUFFER_BYTES = 1 << 16, DEFLATE_LIMIT = 1032 };

/*
 * file --raw--> [raw_at, raw_end) --inflate--> [out_at, out_end) --> caller
 *                 plain bytes are copied to the caller from this range
 */
struct ost_input {
    char *path;
    int fd;
    uint64_t file_bytes;
    uint64_t raw_read; /* number of bytes read from the file so far, that is, the file offset of raw[raw_end] */
    size_t raw_at, raw_end;
    bool packed;
    const char *form; /* "gzip" or "compressed", for messages; valid only for packed files */
    bool member_done; /* true if the current gzip member has ended */
    z_stream z;
    uint64_t unpacked; /* number of bytes that inflate has produced so far */
    size_t out_at, out_end;
    unsigned char raw[BUFFER_BYTES];
    unsigned char out[BUFFER_BYTES];
};

ost_status ost_input_open(const char *path, ost_input **out, ost_error *err)
{
    *out = NULL;
    ost_input *input = malloc(sizeof *input);
    if (!input)
        return ost_fail(err, OST_ERR_MEMORY, "%s: out of memory for input buffers of %d bytes", path,
                        2 * BUFFER_BYTES);
    memset(input, 0, offsetof(ost_input, raw));
    input->fd = -1;
    input->path = strdup(path);
    ost_file file;
    ost_status status = input->path ? ost_file_open(path, &file, err)
                                    : ost_fail(err, OST_ERR_MEMORY, "%s: out of memory for a file name", path);
    if (status != OST_OK) {
        ost_input_close(input);
        return status;
    }
    input->fd = file.fd;
    input->file_bytes = (uint64_t)file.size;
    *out = input;
    return OST_OK;
}

void ost_input_close(ost_input *input)
{
    if (!input)
        return;
    if (input->packed)
        inflateEnd(&input->z);
    if (input->fd >= 0)
        close(input->fd);
    free(input->path);
    free(input);
}

const char *ost_input_path(const ost_input *input)
{
    return input->path;
}

uint64_t ost_input_file_bytes(const ost_input *input)
{
    return input->file_bytes;
}

static uint64_t file_offset(const ost_input *input)
{
    return input->raw_read - (input->raw_end - input->raw_at);
}

uint64_t ost_input_file_left(const ost_input *input)
{
    uint64_t at = file_offset(input);
    return at < input->file_bytes ? input->file_bytes - at : 0;
}

uint64_t ost_input_offset(const ost_input *input)
{
    return input->packed ? input->unpacked - (input->out_end - input->out_at) : file_offset(input);
}

bool ost_input_is_packed(const ost_input *input)
{
    return input->packed;
}

uint64_t ost_input_at_most(const ost_input *input)
{
    uint64_t left = ost_input_file_left(input);
    if (!input->packed)
        return left;
    if (left > UINT64_MAX / DEFLATE_LIMIT - BUFFER_BYTES)
        return UINT64_MAX;
    /* 8 bytes are added, because inflate may hold back a few input bytes and one incomplete match. */
    return (left + 8) * DEFLATE_LIMIT + (input->out_end - input->out_at);
}

char *ost_input_location(const ost_input *input, uint64_t back, char text[OST_LOCATION_TEXT])
{
    snprintf(text, OST_LOCATION_TEXT, "byte %llu%s", (unsigned long long)(ost_input_offset(input) - back),
             input->packed ? " of the unpacked data" : "");
    return text;
}

ost_status ost_input_seek(ost_input *input, uint64_t offset, ost_error *err)
{
    if (input->packed) {
        inflateEnd(&input->z);
        input->packed = false;
    }
    if (offset > input->file_bytes)
        return ost_fail(err, OST_ERR_INPUT, "%s: ends at byte %llu, before byte %llu where data were expected",
                        input->path, (unsigned long long)input->file_bytes, (unsigned long long)offset);
    if (lseek(input->fd, (off_t)offset, SEEK_SET) < 0)
        return ost_fail(err, OST_ERR_IO, "%s: cannot seek to byte %llu: %s", input->path, (unsigned long long)offset,
                        strerror(errno));
    input->raw_read = offset;
    input->raw_at = input->raw_end = 0;
    return OST_OK;
}

/* Starts to unpack. window_bits is the argument of zlib's inflateInit2, which selects the accepted formats. */
static ost_status start_inflate(ost_input *input, int window_bits, const char *form, ost_error *err)
{
    assert(!input->packed);
    memset(&input->z, 0, sizeof input->z);
    if (inflateInit2(&input->z, window_bits) != Z_OK)
        return ost_fail(err, OST_ERR_MEMORY, "%s: out of memory for decompression", input->path);
    input->packed = true;
    input->form = form;
    input->member_done = false;
    input->unpacked = 0;
    input->out_at = input->out_end = 0;
    return OST_OK;
}

ost_status ost_input_gunzip(ost_input *input, ost_error *err)
{
    return start_inflate(input, 15 + 16, "gzip", err);
}

ost_status ost_input_inflate(ost_input *input, ost_error *err)
{
    return start_inflate(input, 15 + 32, "compressed", err);
}

/* Reads more raw bytes. At the end of the file, raw_at == raw_end on return. */
static ost_status fill_raw(ost_input *input, ost_error *err)
{
    assert(input->raw_at == input->raw_end);
    ssize_t n;
    do
        n = read(input->fd, input->raw, BUFFER_BYTES);
    while (n < 0 && errno == EINTR);
    if (n < 0)
        return ost_fail(err, OST_ERR_IO, "%s: read failed at byte %llu: %s", input->path,
                        (unsigned long long)input->raw_read, strerror(errno));
    input->raw_at = 0;
    input->raw_end = (size_t)n;
    input->raw_read += (uint64_t)n;
    return OST_OK;
}

static ost_status damaged(const ost_input *input, const char *what, ost_error *err)
{
    return ost_fail(err, OST_ERR_INPUT, "%s: %s data damaged at byte %llu (%s), %llu bytes unpacked", input->path,
                    input->form, (unsigned long long)file_offset(input), what, (unsigned long long)input->unpacked);
}

/* Unpacks more bytes. At the end of the data, out_at == out_end on return. */
static ost_status fill_out(ost_input *input, ost_error *err)
{
    assert(input->out_at == input->out_end);
    input->out_at = input->out_end = 0;
    while (input->out_end == 0) {
        if (input->raw_at == input->raw_end) {
            ost_status status = fill_raw(input, err);
            if (status != OST_OK)
                return status;
            if (input->raw_end == 0) {
                if (input->member_done)
                    return OST_OK;
                return ost_fail(err, OST_ERR_INPUT,
                                "%s: %s data truncated at the end of the file, byte %llu, %llu bytes unpacked",
                                input->path, input->form, (unsigned long long)input->file_bytes,
                                (unsigned long long)input->unpacked);
            }
        }
        if (input->member_done) {
            if (input->raw[input->raw_at] != 0x1f)
                return ost_fail(err, OST_ERR_INPUT, "%s: %llu bytes follow its %s data, from byte %llu", input->path,
                                (unsigned long long)ost_input_file_left(input), input->form,
                                (unsigned long long)file_offset(input));
            if (inflateReset(&input->z) != Z_OK)
                return damaged(input, "next member", err);
            input->member_done = false;
        }
        input->z.next_in = input->raw + input->raw_at;
        input->z.avail_in = (uInt)(input->raw_end - input->raw_at);
        input->z.next_out = input->out;
        input->z.avail_out = BUFFER_BYTES;
        int result = inflate(&input->z, Z_NO_FLUSH);
        input->raw_at = input->raw_end - input->z.avail_in;
        input->out_end = BUFFER_BYTES - input->z.avail_out;
        input->unpacked += input->out_end;
        if (result == Z_STREAM_END)
            input->member_done = true;
        else if (result == Z_MEM_ERROR)
            return ost_fail(err, OST_ERR_MEMORY, "%s: out of memory for decompression", input->path);
        else if (result != Z_OK)
            return damaged(input, input->z.msg ? input->z.msg : "bad stream", err);
    }
    return OST_OK;
}

/* Sets *bytes and *count to the available bytes. If there are none, reads more first. *count is 0 only at the end. */
static ost_status have(ost_input *input, const unsigned char **bytes, size_t *count, ost_error *err)
{
    size_t *at = input->packed ? &input->out_at : &input->raw_at;
    size_t *end = input->packed ? &input->out_end : &input->raw_end;
    if (*at == *end) {
        ost_status status = input->packed ? fill_out(input, err) : fill_raw(input, err);
        if (status != OST_OK)
            return status;
    }
    *bytes = (input->packed ? input->out : input->raw) + *at;
    *count = *end - *at;
    return OST_OK;
}

static void take(ost_input *input, size_t count)
{
    if (input->packed)
        input->out_at += count;
    else
        input->raw_at += count;
}

ost_status ost_input_read(ost_input *input, void *bytes, size_t wanted, size_t *got, ost_error *err)
{
    unsigned char *to = bytes;
    *got = 0;
    while (*got < wanted) {
        const unsigned char *from;
        size_t count;
        ost_status status = have(input, &from, &count, err);
        if (status != OST_OK)
            return status;
        if (count == 0)
            break;
        if (count > wanted - *got)
            count = wanted - *got;
        memcpy(to + *got, from, count);
        take(input, count);
        *got += count;
    }
    return OST_OK;
}

ost_status ost_input_byte(ost_input *input, int *byte, ost_error *err)
{
    const unsigned char *from;
    size_t count;
    ost_status status = have(input, &from, &count, err);
    if (status != OST_OK)
        return status;
    *byte = -1;
    if (count > 0) {
        *byte = *from;
        take(input, 1);
    }
    return OST_OK;
}

ost_status ost_input_skip(ost_input *input, uint64_t count, ost_error *err)
{
    if (!input->packed) {
        uint64_t left = ost_input_file_left(input);
        uint64_t at = file_offset(input);
        if (count > left)
            return ost_fail(err, OST_ERR_INPUT,
                            "%s: ends at byte %llu, but %llu bytes were to be skipped from byte %llu", input->path,
                            (unsigned long long)input->file_bytes, (unsigned long long)count, (unsigned long long)at);
        return ost_input_seek(input, at + count, err);
    }
    for (uint64_t remaining = count; remaining > 0;) {
        const unsigned char *from;
        size_t there;
        ost_status status = have(input, &from, &there, err);
        if (status != OST_OK)
            return status;
        if (there == 0)
            return ost_fail(err, OST_ERR_INPUT, "%s: unpacks to %llu bytes, but %llu were to be skipped", input->path,
                            (unsigned long long)input->unpacked, (unsigned long long)count);
        if (there > remaining)
            there = (size_t)remaining;
        take(input, there);
        remaining -= there;
    }
    return OST_OK;
}

ost_status ost_input_expect_end(ost_input *input, ost_error *err)
{
    const unsigned char *from;
    size_t count;
    ost_status status = have(input, &from, &count, err);
    if (status != OST_OK || count == 0)
        return status;
    char location[OST_LOCATION_TEXT];
    if (input->packed)
        return ost_fail(err, OST_ERR_INPUT, "%s: data continue at %s, but the header's sizes need no more bytes",
                        input->path, ost_input_location(input, 0, location));
    return ost_fail(err, OST_ERR_INPUT,
                    "%s: %llu bytes too many: unexpected data at %s, after the end given by the header's sizes",
                    input->path, (unsigned long long)ost_input_file_left(input), ost_input_location(input, 0,
                    location));
}
