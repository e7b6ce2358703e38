/* SPDX-License-Identifier: Apache-2.0 */
#include "io/text/lines.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include <zlib.h>

#include "core/file.h"
#include "io/text/fields.h"

struct ost_text_lines {
    char *path;
    int fd;
    gzFile packed; /* gzip stream that unpacks the file of fd; NULL if the file is not packed */
    int64_t file_size;
    int64_t read_bytes;
    bool at_start, ended, terminated;
    size_t used, next; /* buffer[0, used) contains data; buffer[next, used) has not been returned yet */
    char buffer[OST_TEXT_BUFFER + 1]; /* one extra byte for a newline after the last line */
};

ost_status ost_text_lines_open(const char *path, ost_text_lines **out, ost_error *err)
{
    *out = NULL;
    ost_text_lines *lines = malloc(sizeof *lines);
    if (!lines)
        return ost_fail(err, OST_ERR_MEMORY, "%s: out of memory for a read buffer of %zu bytes", path, sizeof *lines);
    lines->path = strdup(path);
    lines->fd = -1;
    lines->packed = NULL;
    lines->read_bytes = 0;
    lines->at_start = true;
    lines->ended = false;
    lines->terminated = true;
    lines->used = lines->next = 0;

    ost_status status = OST_OK;
    ost_file file;
    if (!lines->path)
        status = ost_fail(err, OST_ERR_MEMORY, "%s: out of memory for a file name", path);
    else
        status = ost_file_open(path, &file, err);
    if (status != OST_OK) {
        ost_text_lines_close(lines);
        return status;
    }
    lines->fd = file.fd;
    lines->file_size = file.size;
    (void)posix_fadvise(lines->fd, 0, 0, POSIX_FADV_SEQUENTIAL);
    *out = lines;
    return OST_OK;
}

void ost_text_lines_close(ost_text_lines *lines)
{
    if (!lines)
        return;
    if (lines->packed)
        gzclose(lines->packed);
    if (lines->fd >= 0)
        close(lines->fd);
    free(lines->path);
    free(lines);
}

ost_status ost_text_lines_unpack(ost_text_lines *lines, bool *packed, ost_error *err)
{
    unsigned char magic[2];
    *packed = pread(lines->fd, magic, 2, 0) == 2 && magic[0] == 0x1f && magic[1] == 0x8b;
    if (!*packed)
        return OST_OK;
    const int fd = fcntl(lines->fd, F_DUPFD_CLOEXEC, 0);
    lines->packed = fd < 0 ? NULL : gzdopen(fd, "rb");
    if (lines->packed)
        return OST_OK;
    if (fd >= 0)
        close(fd);
    return fd < 0 ? ost_fail(err, OST_ERR_IO, "%s: cannot open: %s", lines->path, strerror(errno)) : ost_fail(err,
                             OST_ERR_MEMORY, "%s: out of memory for decompression", lines->path);
}

/* Reads up to `size` bytes. Returns 0 at the end of the file. If the file is damaged, returns -1 and sets *status. */
static ssize_t unpack(ost_text_lines *lines, char *to, size_t size, ost_status *status, ost_error *err)
{
    const int n = gzread(lines->packed, to, (unsigned)size);
    int number = Z_OK;
    const char *why = gzerror(lines->packed, &number);
    if (n >= 0 && number != Z_BUF_ERROR)
        return n;
    *status = number == Z_ERRNO ? ost_fail(err, OST_ERR_IO, "%s: read failed after %lld bytes: %s", lines->path,
                                           (long long)lines->read_bytes, strerror(errno))
              : number == Z_MEM_ERROR
                  ? ost_fail(err, OST_ERR_MEMORY, "%s: out of memory for decompression", lines->path)
                  : ost_fail(err, OST_ERR_INPUT,
                             "%s: the gzip data are damaged or cut off after %lld bytes of text: %.80s", lines->path,
                             (long long)lines->read_bytes, why);
    return -1;
}

/* Fills the buffer from offset `used` on. Stops at the end of the file. */
static ost_status fill(ost_text_lines *lines, ost_error *err)
{
    while (!lines->ended && lines->used < OST_TEXT_BUFFER) {
        ost_status status = OST_OK;
        ssize_t n = lines->packed
                        ? unpack(lines, lines->buffer + lines->used, OST_TEXT_BUFFER - lines->used, &status, err)
                        : read(lines->fd, lines->buffer + lines->used, OST_TEXT_BUFFER - lines->used);
        if (status != OST_OK)
            return status;
        if (n < 0 && errno == EINTR)
            continue;
        if (n < 0)
            return ost_fail(err, OST_ERR_IO, "%s: read failed after %lld bytes: %s", lines->path,
                            (long long)lines->read_bytes, strerror(errno));
        lines->ended = n == 0;
        lines->used += (size_t)n;
        lines->read_bytes += n;
    }
    return OST_OK;
}

/*
 * Returns true if the text contains CR but no LF; some systems before 2001 ended lines with CR alone. A CR at the end
 * of the text is ignored, because it may be the first half of a CR LF.
 */
static bool ends_lines_with_cr(const char *text, size_t size)
{
    const char *cr = memchr(text, '\r', size);
    return cr && cr + 1 < text + size && !memchr(text, '\n', size) && !ost_text_is_binary(text, cr);
}

ost_status ost_text_lines_next(ost_text_lines *lines, int64_t line_number, ost_text_block *block, ost_error *err)
{
    char *buffer = lines->buffer;
    block->begin = block->end = buffer;
    memmove(buffer, buffer + lines->next, lines->used - lines->next);
    lines->used -= lines->next;
    lines->next = 0;
    ost_status status = fill(lines, err);
    if (status != OST_OK)
        return status;
    if (lines->at_start) {
        lines->at_start = false;
        if (lines->used >= 3 && memcmp(buffer, "\xef\xbb\xbf", 3) == 0)
            block->begin = buffer + 3;
        else if (lines->used >= 2 && (memcmp(buffer, "\xff\xfe", 2) == 0 || memcmp(buffer, "\xfe\xff", 2) == 0))
            return ost_fail(err, OST_ERR_INPUT, "%s:1: the text is UTF-16; save it as plain text (ASCII or UTF-8)",
                            lines->path);
        if (ends_lines_with_cr(block->begin, lines->used - (size_t)(block->begin - buffer)))
            return ost_fail(err, OST_ERR_INPUT, "%s:1: line ends are CR alone; LF or CR LF expected", lines->path);
    }
    if (lines->used == 0) {
        block->end = block->begin;
        return OST_OK;
    }
    char *last = memrchr(buffer, '\n', lines->used);
    if (lines->ended) {
        lines->terminated = last == buffer + lines->used - 1;
        if (!lines->terminated)
            buffer[lines->used++] = '\n';
        lines->next = lines->used;
    } else if (last) {
        lines->next = (size_t)(last - buffer) + 1;
    } else {
        return ost_fail(err, OST_ERR_INPUT, "%s:%lld: the line is longer than %d bytes; expected a text file",
                        lines->path, (long long)line_number, OST_TEXT_LINE_MAX);
    }
    block->end = buffer + lines->next;
    return OST_OK;
}

ost_status ost_text_lines_rewind(ost_text_lines *lines, ost_error *err)
{
    if (lines->packed ? gzrewind(lines->packed) != 0 : lseek(lines->fd, 0, SEEK_SET) != 0)
        return ost_fail(err, OST_ERR_IO, "%s: cannot read a second time: %s", lines->path, strerror(errno));
    lines->read_bytes = 0;
    lines->at_start = true;
    lines->ended = false;
    lines->terminated = true;
    lines->used = lines->next = 0;
    return OST_OK;
}

double ost_text_lines_share(const ost_text_lines *lines)
{
    double share = lines->file_size > 0 ? (double)lines->read_bytes / (double)lines->file_size : 1;
    return share < 1 ? share : 1;
}

bool ost_text_lines_terminated(const ost_text_lines *lines)
{
    return lines->terminated;
}
