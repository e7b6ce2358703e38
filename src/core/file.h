/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The only place of the project that opens files for reading
 * (docs/check-architecture holds this).
 *
 * Only regular files are opened, also through symbolic links: readers check a
 * file's size before they reserve memory, read some files twice, and must not
 * wait for the writer of a pipe or read an endless device.  /dev/stdin is accepted
 * if the shell redirects it from a regular file.
 *
 * A failure is not a statement about a file's content.  Three outcomes are
 * therefore distinct: the file is absent, the file cannot be read (no
 * descriptor, no memory, no permission, not a regular file, an I/O error), or
 * it was read and the caller compares its bytes.
 */
#ifndef OST_CORE_FILE_H
#define OST_CORE_FILE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include <osteon/status.h>

typedef struct ost_file {
    int fd;       /* close-on-exec, blocking; -1 after a failure */
    int64_t size; /* bytes when it was opened */
    bool absent;  /* after a failure: no file has this name */
} ost_file;

/* Opens a regular file for reading; the caller closes out->fd. On failure, err has the path and
   the reason (OST_ERR_IO). */
ost_status ost_file_open(const char *path, ost_file *out, ost_error *err);

/*
 * Opens a regular file by its name within the open folder `folder`. A symbolic link
 * is refused, so that the file is one of that folder.
 */
ost_status ost_file_open_within(int folder, const char *name, ost_file *out, ost_error *err);

/*
 * Opens a regular file as a stream; the caller calls fclose. *out is NULL after a failure. absent may be NULL; it is
 * set to true if no file has this name, otherwise to false.
 */
ost_status ost_file_stream(const char *path, FILE **out, bool *absent, ost_error *err);

/*
 * Reads the file->size bytes of an open file into `to`; fails with OST_ERR_IO if its size has changed.
 * path is for messages.
 */
ost_status ost_file_fill(const char *path, const ost_file *file, void *to, ost_error *err);

/*
 * Reads an open file into new memory, which the caller frees. The bytes are followed by a NUL that
 * *size does not count. *bytes is NULL after a failure.
 */
ost_status ost_file_bytes(const char *path, const ost_file *file, char **bytes, size_t *size, ost_error *err);

/*
 * Reads a complete regular file into new memory, which the caller frees. The bytes
 * are followed by a NUL that *size does not count; *bytes is NULL after a failure.
 * Fails with OST_ERR_RANGE if the file has more than max bytes, OST_ERR_IO if its
 * size changes while it is read, or OST_ERR_MEMORY. absent may be NULL; it is set to
 * true if no file has this name, otherwise to false.
 */
ost_status ost_file_read(const char *path, size_t max, char **bytes, size_t *size, bool *absent, ost_error *err);

#endif
