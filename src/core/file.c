/* SPDX-License-Identifier: Apache-2.0 */
#include "core/file.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static ost_status cannot_open(const char *path, ost_file *out, ost_error *err)
{
    out->absent = errno == ENOENT || errno == ENOTDIR;
    return ost_fail(err, OST_ERR_IO, "%s: cannot open: %s", path, strerror(errno));
}

static ost_status check_type(const char *path, const struct stat *info, ost_error *err)
{
    if (S_ISREG(info->st_mode))
        return OST_OK;
    if (S_ISDIR(info->st_mode))
        return ost_fail(err, OST_ERR_IO, "%s: is a folder; expected a regular file", path);
    return ost_fail(err, OST_ERR_IO, "%s: is a pipe or a device; expected a regular file, so save it to a file first",
                    path);
}

static ost_status open_at(int folder, const char *path, bool follow, ost_file *out, ost_error *err)
{
    struct stat info;
    *out = (ost_file){.fd = -1};
    /*
     * The type is checked before the file is opened, because an open can have side effects: it may
     * change the state of a device, and it unblocks the writer of a pipe.
     */
    if (fstatat(folder, path, &info, follow ? 0 : AT_SYMLINK_NOFOLLOW) != 0)
        return cannot_open(path, out, err);
    ost_status status = check_type(path, &info, err);
    if (status != OST_OK)
        return status;
    /* The name may refer to another file now. Therefore the open must not block, and the type is checked again. */
    const int fd = openat(folder, path, O_RDONLY | O_CLOEXEC | O_NOCTTY | O_NONBLOCK | (follow ? 0 : O_NOFOLLOW));
    if (fd < 0)
        return cannot_open(path, out, err);
    int flags = -1;
    if (fstat(fd, &info) != 0 || (flags = fcntl(fd, F_GETFL)) < 0)
        status = ost_fail(err, OST_ERR_IO, "%s: cannot open: %s", path, strerror(errno));
    if (status == OST_OK)
        status = check_type(path, &info, err);
    if (status == OST_OK && fcntl(fd, F_SETFL, flags & ~O_NONBLOCK) != 0)
        status = ost_fail(err, OST_ERR_IO, "%s: cannot open: %s", path, strerror(errno));
    if (status != OST_OK) {
        close(fd);
        return status;
    }
    out->fd = fd;
    out->size = info.st_size;
    return OST_OK;
}

ost_status ost_file_open(const char *path, ost_file *out, ost_error *err)
{
    return open_at(AT_FDCWD, path, true, out, err);
}

ost_status ost_file_open_within(int folder, const char *name, ost_file *out, ost_error *err)
{
    return open_at(folder, name, false, out, err);
}

ost_status ost_file_stream(const char *path, FILE **out, bool *absent, ost_error *err)
{
    ost_file file;
    ost_status status = ost_file_open(path, &file, err);
    if (absent)
        *absent = file.absent;
    *out = status == OST_OK ? fdopen(file.fd, "r") : NULL;
    if (status == OST_OK && !*out) {
        status = ost_fail(err, OST_ERR_MEMORY, "%s: out of memory for a stream", path);
        close(file.fd);
    }
    return status;
}

ost_status ost_file_fill(const char *path, const ost_file *file, void *to, ost_error *err)
{
    char more;
    int64_t done = 0;
    /* The loop tries to read one byte more than expected, to detect a file that has grown. */
    for (;;) {
        const size_t left = (size_t)(file->size - done);
        const ssize_t n = read(file->fd, left ? (char *)to + done : &more, left ? left : 1);
        if (n < 0 && errno == EINTR)
            continue;
        if (n < 0)
            return ost_fail(err, OST_ERR_IO, "%s: cannot read at byte %lld: %s", path, (long long)done,
                            strerror(errno));
        if (n == 0 && left == 0)
            return OST_OK;
        if (n == 0 || left == 0)
            return ost_fail(err, OST_ERR_IO, "%s: file changed while it was read; its size was %lld bytes", path,
                            (long long)file->size);
        done += n;
    }
}

ost_status ost_file_bytes(const char *path, const ost_file *file, char **bytes, size_t *size, ost_error *err)
{
    *size = 0;
    *bytes = malloc((size_t)file->size + 1);
    if (!*bytes)
        return ost_fail(err, OST_ERR_MEMORY, "%s: out of memory for %lld bytes", path, (long long)file->size);
    const ost_status status = ost_file_fill(path, file, *bytes, err);
    if (status != OST_OK) {
        free(*bytes);
        *bytes = NULL;
        return status;
    }
    (*bytes)[file->size] = '\0';
    *size = (size_t)file->size;
    return OST_OK;
}

ost_status ost_file_read(const char *path, size_t max, char **bytes, size_t *size, bool *absent, ost_error *err)
{
    ost_file file;
    *bytes = NULL;
    *size = 0;
    ost_status status = ost_file_open(path, &file, err);
    if (absent)
        *absent = file.absent;
    if (status != OST_OK)
        return status;
    if ((uint64_t)file.size > max)
        status = ost_fail(err, OST_ERR_RANGE, "%s: %lld bytes; expected at most %zu", path, (long long)file.size,
                          max);
    else
        status = ost_file_bytes(path, &file, bytes, size, err);
    close(file.fd);
    return status;
}
