/* SPDX-License-Identifier: Apache-2.0 */
#include "io/outfile.h"

#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <limits.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>

enum { BUFFER_BYTES = 1 << 16, NAME_BYTES = 64, SLOTS = 64, NAME_TRIES = 1000 };

/*
 * Hidden names of files that exist or are about to be created, stored where a signal handler can find and unlink them.
 * The handler reads a slot only in the state LISTED, in which its name is complete. Unlinking a name that does not
 * exist yet is harmless.
 */
enum { SLOT_FREE, SLOT_TAKEN, SLOT_LISTED };
static struct {
    atomic_int state;
    int folder;
    char name[NAME_BYTES];
} slots[SLOTS];

bool ost_outfile_named_only;

struct ost_outfile {
    char *path;       /* path as passed by the caller */
    char *target;     /* path with symbolic links resolved; NULL if the file is written in place */
    const char *base; /* last component of target */
    int folder;       /* descriptor of the target's folder; -1 if the file is written in place */
    int fd;
    int slot;         /* slot of the hidden name; -1 if there is none */
    ost_status failed;
    int failed_errno;
    uint64_t flushed; /* number of bytes that the system has accepted */
    size_t used;
    unsigned char buffer[BUFFER_BYTES];
};

/* ------------------------------------------------------------ hidden names */

/*
 * Stores a random name in a free slot and returns the index of the slot. Returns -1
 * and sets errno if all slots are in use or the system returns no random numbers.
 */
static int slot_take(int folder)
{
    uint64_t random[2];
    if (getrandom(random, sizeof random, 0) != (ssize_t)sizeof random)
        return -1;
    for (int i = 0; i < SLOTS; i++) {
        int expected = SLOT_FREE;
        if (!atomic_compare_exchange_strong(&slots[i].state, &expected, SLOT_TAKEN))
            continue;
        slots[i].folder = folder;
        snprintf(slots[i].name, sizeof slots[i].name, ".osteon-%016" PRIx64 "%016" PRIx64 ".part", random[0],
                 random[1]);
        atomic_store(&slots[i].state, SLOT_LISTED);
        return i;
    }
    errno = EMFILE;
    return -1;
}

static void slot_drop(int slot)
{
    if (slot >= 0)
        atomic_store(&slots[slot].state, SLOT_FREE);
}

void ost_outfile_unlink_pending(void)
{
    int saved = errno;
    for (int i = 0; i < SLOTS; i++)
        if (atomic_load(&slots[i].state) == SLOT_LISTED)
            unlinkat(slots[i].folder, slots[i].name, 0);
    errno = saved;
}

/* Creates the file under a hidden name. Returns its descriptor, or -1 on failure. */
static int open_hidden(ost_outfile *file)
{
    for (int i = 0; i < NAME_TRIES; i++) {
        file->slot = slot_take(file->folder);
        if (file->slot < 0)
            return -1;
        int fd = openat(file->folder, slots[file->slot].name, O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC,
                        0666);
        if (fd >= 0)
            return fd;
        slot_drop(file->slot);
        file->slot = -1;
        if (errno != EEXIST)
            return -1;
    }
    return -1;
}

static void proc_path(int fd, char text[NAME_BYTES])
{
    snprintf(text, NAME_BYTES, "/proc/self/fd/%d", fd);
}

/*
 * Opens an unnamed file and returns its descriptor, or -1 on failure. The file is later named through /proc, so the
 * function checks that /proc leads to the file.
 */
static int open_unnamed(const ost_outfile *file)
{
#ifdef O_TMPFILE
    if (ost_outfile_named_only)
        return -1;
    int fd = openat(file->folder, ".", O_TMPFILE | O_WRONLY | O_CLOEXEC, 0666);
    if (fd < 0)
        return -1;
    char proc[NAME_BYTES];
    struct stat by_fd, by_name;
    proc_path(fd, proc);
    if (fstat(fd, &by_fd) == 0 && stat(proc, &by_name) == 0 && by_fd.st_dev == by_name.st_dev &&
        by_fd.st_ino == by_name.st_ino)
        return fd;
    close(fd);
#else
    (void)file;
#endif
    return -1;
}

/* ------------------------------------------------------------------- open */

static ost_status cannot_write(const ost_outfile *file, int number, ost_error *err)
{
    return ost_fail(err, OST_ERR_IO, "%s: cannot write: %s", file->path, strerror(number));
}

bool ost_outfile_is_stdout(const char *path)
{
    return strncmp(path, "-.", 2) == 0 && !strchr(path, '/');
}

/*
 * Duplicates the process's own stream if `path` denotes one, such as /dev/stdout. A shell may have opened this stream
 * to append to a file; writing to the duplicate preserves the content of that file. Returns -1 for any other path.
 */
static int standard_stream(const char *path)
{
    if (strcmp(path, "/dev/stdout") == 0 || ost_outfile_is_stdout(path))
        return dup(STDOUT_FILENO);
    if (strcmp(path, "/dev/stderr") == 0)
        return dup(STDERR_FILENO);
    return -1;
}

static ost_status open_destination(ost_outfile *file, ost_error *err)
{
    file->fd = open(file->path, O_WRONLY | O_CLOEXEC | O_NOCTTY);
    return file->fd < 0 ? cannot_write(file, errno, err) : OST_OK;
}

/* Opens an unnamed file in the target's folder. If this fails, opens a hidden file instead. */
static ost_status open_in_folder(ost_outfile *file, ost_error *err)
{
    char *slash = strrchr(file->target, '/');
    file->base = slash ? slash + 1 : file->target;
    if (!*file->base)
        return ost_fail(err, OST_ERR_IO, "%s: is a folder; expected a file name", file->path);

    if (!slash) {
        file->folder = open(".", O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    } else {
        char separator = slash[1];
        slash[1] = 0;
        file->folder = open(file->target, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
        if (file->folder < 0 && errno == EACCES)
            file->folder = open(file->target, O_PATH | O_DIRECTORY | O_CLOEXEC);
        slash[1] = separator;
    }
    if (file->folder < 0)
        return ost_fail(err, OST_ERR_IO, "%s: cannot open the folder %.*s: %s", file->path,
                        slash ? (int)(slash - file->target) + 1 : 1, slash ? file->target : ".", strerror(errno));
    file->fd = open_unnamed(file);
    if (file->fd < 0)
        file->fd = open_hidden(file);
    return file->fd < 0 ? cannot_write(file, errno, err) : OST_OK;
}

static ost_status no_name(const char *path, ost_error *err)
{
    return ost_fail(err, OST_ERR_MEMORY, "%s: out of memory for a file name", path);
}

static ost_status open_temporary(ost_outfile *file, ost_error *err)
{
    struct stat st;
    if (lstat(file->path, &st) == 0 && S_ISLNK(st.st_mode)) {
        file->target = realpath(file->path, NULL);
        if (!file->target)
            return ost_fail(err, OST_ERR_IO, "%s: is a dangling symbolic link (%s)", file->path, strerror(errno));
    } else {
        file->target = strdup(file->path);
    }
    return file->target ? open_in_folder(file, err) : no_name(file->path, err);
}

/* Allocates an ost_outfile. The file is not opened. */
static ost_status allocate(const char *path, ost_outfile **out, ost_error *err)
{
    *out = NULL;
    if (!*path)
        return ost_fail(err, OST_ERR_USAGE, "empty name of an output file");
    ost_outfile *file = malloc(sizeof *file);
    if (!file)
        return ost_fail(err, OST_ERR_MEMORY, "%s: out of memory for an output buffer of %d bytes", path,
                        BUFFER_BYTES);
    file->target = NULL;
    file->base = NULL;
    file->folder = file->fd = file->slot = -1;
    file->failed = OST_OK;
    file->failed_errno = 0;
    file->flushed = 0;
    file->used = 0;
    file->path = strdup(path);
    if (!file->path) {
        ost_outfile_discard(file);
        return no_name(path, err);
    }
    *out = file;
    return OST_OK;
}

ost_status ost_outfile_open(const char *path, ost_outfile **out, ost_error *err)
{
    ost_outfile *file;
    *out = NULL;
    ost_status status = allocate(path, &file, err);
    if (status != OST_OK)
        return status;
    struct stat st;
    if ((file->fd = standard_stream(path)) >= 0) {
        ;
    } else if (stat(path, &st) != 0) {
        /* If the name is too long for the file system, an error is returned here, before any data are written. */
        status = errno == ENAMETOOLONG ? cannot_write(file, errno, err) : open_temporary(file, err);
    } else if (S_ISDIR(st.st_mode)) {
        status = ost_fail(err, OST_ERR_IO, "%s: is a folder; expected a file name", path);
    } else if (!S_ISREG(st.st_mode)) {
        status = open_destination(file, err);
    } else if (access(path, W_OK) != 0) {
        status = ost_fail(err, OST_ERR_IO, "%s: cannot overwrite: %s", path, strerror(errno));
    } else {
        status = open_temporary(file, err);
    }
    if (status != OST_OK) {
        ost_outfile_discard(file);
        return status;
    }
    *out = file;
    return OST_OK;
}

/* ------------------------------------------------------------------ write */

static ost_status write_failed(const ost_outfile *file, ost_error *err)
{
    const char *reason = strerror(file->failed_errno);
    if (file->failed_errno == ENOSPC)
        reason = "the disk is full";
    else if (file->failed_errno == EDQUOT)
        reason = "the disk quota is used up";
    else if (file->failed_errno == EFBIG)
        reason = "the limit of a file's size is reached";
    else if (file->failed_errno == EPIPE)
        reason = "the reader has closed the pipe";
    return ost_fail(err, OST_ERR_IO, "%s: write failed after %llu bytes: %s", file->path,
                    (unsigned long long)file->flushed, reason);
}

static ost_status write_all(ost_outfile *file, const unsigned char *bytes, size_t size, ost_error *err)
{
    while (size > 0) {
        /* Linux writes at most 0x7ffff000 bytes in one call. */
        ssize_t n = write(file->fd, bytes, size < (1u << 30) ? size : (1u << 30));
        if (n < 0 && errno == EINTR)
            continue;
        if (n <= 0) {
            file->failed = OST_ERR_IO;
            file->failed_errno = n < 0 ? errno : ENOSPC;
            return write_failed(file, err);
        }
        bytes += n;
        size -= (size_t)n;
        file->flushed += (uint64_t)n;
    }
    return OST_OK;
}

static ost_status flush_buffer(ost_outfile *file, ost_error *err)
{
    if (file->failed != OST_OK)
        return write_failed(file, err);
    size_t used = file->used;
    file->used = 0;
    return write_all(file, file->buffer, used, err);
}

ost_status ost_outfile_write(ost_outfile *file, const void *bytes, size_t size, ost_error *err)
{
    if (file->failed != OST_OK)
        return write_failed(file, err);
    if (size <= BUFFER_BYTES - file->used) {
        memcpy(file->buffer + file->used, bytes, size);
        file->used += size;
        return OST_OK;
    }
    ost_status status = flush_buffer(file, err);
    if (status != OST_OK)
        return status;
    if (size >= BUFFER_BYTES)
        return write_all(file, bytes, size, err);
    memcpy(file->buffer, bytes, size);
    file->used = size;
    return OST_OK;
}

ost_status ost_outfile_printf(ost_outfile *file, ost_error *err, const char *format, ...)
{
    char text[2048];
    va_list args;
    va_start(args, format);
    int n = vsnprintf(text, sizeof text, format, args);
    va_end(args);
    if (n < 0 || (size_t)n >= sizeof text)
        return ost_fail(err, OST_ERR_INTERNAL, "%s: a formatted line of output is too long", file->path);
    return ost_outfile_write(file, text, (size_t)n, err);
}

const char *ost_outfile_path(const ost_outfile *file)
{
    return file->path;
}

int ost_outfile_descriptor(const ost_outfile *file)
{
    return file->fd;
}

/* -------------------------------------------------------------------- end */

/*
 * Links the unnamed file to its final name. If the name exists, the file first gets a hidden name and is then
 * renamed.
 */
static int name_unnamed(ost_outfile *file)
{
    char proc[NAME_BYTES];
    proc_path(file->fd, proc);
    if (linkat(AT_FDCWD, proc, file->folder, file->base, AT_SYMLINK_FOLLOW) == 0)
        return 0;
    if (errno != EEXIST)
        return -1;
    for (int i = 0; i < NAME_TRIES; i++) {
        int slot = slot_take(file->folder);
        if (slot < 0)
            return -1;
        file->slot = slot;
        if (linkat(AT_FDCWD, proc, file->folder, slots[slot].name, AT_SYMLINK_FOLLOW) == 0)
            return renameat(file->folder, slots[slot].name, file->folder, file->base);
        slot_drop(slot);
        file->slot = -1;
        if (errno != EEXIST)
            return -1;
    }
    return -1;
}

ost_status ost_outfile_commit(ost_outfile *file, ost_error *err)
{
    ost_status status = flush_buffer(file, err);
    if (status == OST_OK && file->target) {
        if (fsync(file->fd) != 0) {
            file->failed_errno = errno;
            status = write_failed(file, err);
        } else {
            int named = file->slot < 0 ? name_unnamed(file)
                                       : renameat(file->folder, slots[file->slot].name, file->folder, file->base);
            if (named != 0) {
                status = ost_fail(err, OST_ERR_IO, "%s: cannot rename the temporary file to this name: %s",
                                  file->path, strerror(errno));
            } else {
                slot_drop(file->slot);
                file->slot = -1;
                /* Syncing the folder makes the name durable. A failure is ignored, because the file itself is
                 * already complete and synced. */
                (void)fsync(file->folder);
            }
        }
    }
    if (file->fd >= 0 && close(file->fd) != 0 && status == OST_OK && !file->target) {
        file->failed_errno = errno;
        status = write_failed(file, err);
    }
    file->fd = -1;
    ost_outfile_discard(file);
    return status;
}

void ost_outfile_discard(ost_outfile *file)
{
    if (!file)
        return;
    if (file->slot >= 0) {
        unlinkat(file->folder, slots[file->slot].name, 0);
        slot_drop(file->slot);
    }
    if (file->fd >= 0)
        close(file->fd);
    if (file->folder >= 0)
        close(file->folder);
    free(file->target);
    free(file->path);
    free(file);
}

ost_status ost_outfile_put_new(const char *path, const void *bytes, size_t size, bool *taken, ost_error *err)
{
    ost_outfile *file;
    *taken = false;
    ost_status status = allocate(path, &file, err);
    if (status != OST_OK)
        return status;
    file->target = strdup(path);
    status = file->target ? open_in_folder(file, err) : no_name(path, err);
    if (status == OST_OK)
        status = write_all(file, bytes, size, err);
    if (status == OST_OK) {
        char proc[NAME_BYTES];
        proc_path(file->fd, proc);
        const int linked = file->slot < 0 ? linkat(AT_FDCWD, proc, file->folder, file->base, AT_SYMLINK_FOLLOW)
                                          : linkat(file->folder, slots[file->slot].name, file->folder, file->base, 0);
        if (linked != 0) {
            *taken = errno == EEXIST;
            status = ost_fail(err, OST_ERR_IO, "%s: %s", path, strerror(errno));
        }
    }
    ost_outfile_discard(file);
    return status;
}
