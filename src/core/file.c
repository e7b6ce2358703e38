/* SPDX-License-Identifier: Apache-2.0 */
#include "core/file.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

int64_t ost_file_spool_max = INT64_C(16) << 30;

/* The pipe that ost_file_spool has copied to an unnamed file, or the regular file that is standard input. */
static struct {
    char name[64]; /* path of the file or pipe in the file system; "" before ost_file_spool is called */
    int fd;
} stream = {"", -1};

bool ost_file_is_stream(const char *path)
{
    return stream.name[0] && strcmp(path, stream.name) == 0;
}

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

/*
 * Opens the file of the stream again through /proc, because a duplicate of the descriptor would share its file
 * position.
 */
static ost_status open_stream(const char *path, ost_file *out, ost_error *err)
{
    char again[40];
    struct stat info;
    snprintf(again, sizeof again, "/proc/self/fd/%d", stream.fd);
    const int fd = open(again, O_RDONLY | O_CLOEXEC);
    if (fd < 0 || fstat(fd, &info) != 0) {
        const ost_status status = ost_fail(err, OST_ERR_IO, "%s: cannot open its copy: %s", path, strerror(errno));
        if (fd >= 0)
            close(fd);
        return status;
    }
    out->fd = fd;
    out->size = info.st_size;
    return OST_OK;
}

static ost_status open_at(int folder, const char *path, bool follow, ost_file *out, ost_error *err)
{
    struct stat info;
    *out = (ost_file){.fd = -1};
    if (folder == AT_FDCWD && ost_file_is_stream(path))
        return open_stream(path, out, err);
    if (folder == AT_FDCWD && strcmp(path, "-") == 0)
        return ost_fail(err, OST_ERR_IO, "-: standard input is not read here; save it to a file first");
    /*
     * The type is checked before the file is opened, because opening a file can have side effects: it may change the
     * state of a device, and it unblocks the writer of a pipe.
     */
    if (fstatat(folder, path, &info, follow ? 0 : AT_SYMLINK_NOFOLLOW) != 0)
        return cannot_open(path, out, err);
    ost_status status = check_type(path, &info, err);
    if (status != OST_OK)
        return status;
    /* By now, the name may refer to a different file. Therefore openat must not block, and the type is checked
       again. */
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

/* ----------------------------------------------------------------- streams */

/* Returns the file descriptor that the path "-", /dev/stdin or /dev/fd/N denotes, or -1 for any other path. */
static int descriptor_of(const char *path)
{
    if (strcmp(path, "-") == 0 || strcmp(path, "/dev/stdin") == 0)
        return STDIN_FILENO;
    if (strncmp(path, "/dev/fd/", 8) != 0 || strspn(path + 8, "0123456789") != strlen(path + 8) || !path[8] ||
        strlen(path) > 12)
        return -1;
    return (int)strtol(path + 8, NULL, 10);
}

/* Opens a temporary file without a name in the folder `folder`, for reading and writing. */
static int open_unnamed(const char *folder)
{
    int fd = -1;
#ifdef O_TMPFILE
    fd = open(folder, O_TMPFILE | O_RDWR | O_CLOEXEC, 0600);
#endif
    if (fd < 0) {
        char name[4096];
        const int n = snprintf(name, sizeof name, "%s/osteon-XXXXXX", folder);
        fd = n < (int)sizeof name ? mkstemp(name) : -1;
        if (fd >= 0) {
            unlink(name);
            fcntl(fd, F_SETFD, FD_CLOEXEC);
        }
    }
    return fd;
}

/* Writes `size` bytes, even if the system accepts only a part at a time. On failure, returns false and sets errno. */
static bool write_all(int fd, const char *bytes, size_t size)
{
    while (size > 0) {
        const ssize_t n = write(fd, bytes, size);
        if (n < 0 && errno == EINTR)
            continue;
        if (n < 0)
            return false;
        bytes += n;
        size -= (size_t)n;
    }
    return true;
}

static ost_status copy_stream(const char *path, int from, int to, const char *folder, ost_error *err)
{
    static char block[1 << 16];
    int64_t size = 0;
    for (;;) {
        const ssize_t n = read(from, block, sizeof block);
        if (n < 0 && errno == EINTR)
            continue;
        if (n < 0)
            return ost_fail(err, OST_ERR_IO, "%s: cannot read at byte %lld: %s", path, (long long)size,
                            strerror(errno));
        if (n == 0)
            return OST_OK;
        size += n;
        if (size > ost_file_spool_max)
            return ost_fail(err, OST_ERR_RANGE, "%s: more than %lld bytes from a pipe; save them to a file first", path,
                            (long long)ost_file_spool_max);
        if (!write_all(to, block, (size_t)n))
            return ost_fail(err, OST_ERR_IO, "%s: cannot store %lld bytes in %s: %s; TMPDIR selects another folder",
                            path, (long long)size, folder, strerror(errno));
    }
}

ost_status ost_file_spool(const char *path, ost_error *err)
{
    const int from = descriptor_of(path);
    const bool dash = strcmp(path, "-") == 0;
    struct stat info;
    if (from < 0 || ost_file_is_stream(path) || strlen(path) >= sizeof stream.name)
        return OST_OK;
    if (fstat(from, &info) != 0)
        return ost_fail(err, OST_ERR_IO, "%s: cannot open: %s", path, strerror(errno));
    if (S_ISREG(info.st_mode) && !dash)
        return OST_OK;
    if (!S_ISREG(info.st_mode) && !S_ISFIFO(info.st_mode) && !S_ISSOCK(info.st_mode))
        return ost_fail(err, OST_ERR_USAGE, "%s: is %s; expected a pipe or a redirected file", path,
                        isatty(from) ? "a terminal" : "a folder or a device");
    int fd;
    ost_status status = OST_OK;
    if (S_ISREG(info.st_mode)) {
        fd = fcntl(from, F_DUPFD_CLOEXEC, 3);
        if (fd < 0)
            return ost_fail(err, OST_ERR_IO, "%s: cannot open: %s", path, strerror(errno));
    } else {
        const char *chosen = getenv("TMPDIR"), *folder = chosen && *chosen ? chosen : "/tmp";
        fd = open_unnamed(folder);
        if (fd < 0)
            return ost_fail(err, OST_ERR_IO, "%s: cannot create a temporary file in %s: %s", path, folder,
                            strerror(errno));
        status = copy_stream(path, from, fd, folder, err);
    }
    if (status != OST_OK) {
        close(fd);
        return status;
    }
    if (stream.fd >= 0)
        close(stream.fd);
    snprintf(stream.name, sizeof stream.name, "%s", path);
    stream.fd = fd;
    return OST_OK;
}
