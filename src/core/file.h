/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Opens and reads files.  All files are read through this module; docs/check-architecture checks this rule.
 *
 * Only regular files, and symbolic links to regular files, are opened, for three reasons. Readers check the size of a
 * file before they allocate memory. They read some files twice. They must not wait for the writer of a pipe or read an
 * endless device. /dev/stdin is accepted if the shell redirects it from a regular file. A verb that accepts a pipe as
 * its input passes the name to ost_file_spool first, which copies the pipe to a file.
 *
 * A failure to read a file must not be mistaken for a statement about the file's content.  Three
 * outcomes are therefore distinguished: the file is absent, the file cannot be read (no descriptor,
 * no memory, no permission, not a regular file, an I/O error), or the file was read and the caller
 * can examine its bytes.
 */
#ifndef OST_CORE_FILE_H
#define OST_CORE_FILE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include <osteon/status.h>

typedef struct ost_file {
    int fd;       /* file descriptor, close-on-exec and blocking; -1 if the file could not be opened */
    int64_t size; /* size in bytes when the file was opened */
    bool absent;  /* after a failure: true if the reason is that no file has this name */
} ost_file;

/*
 * Opens a regular file for reading. The caller closes out->fd. On failure, returns OST_ERR_IO with the path
 * and the reason in err.
 */
ost_status ost_file_open(const char *path, ost_file *out, ost_error *err);

/*
 * Copies a pipe into an unnamed temporary file, in TMPDIR or else in /tmp. If a function of this module opens `path`
 * later, it opens the temporary file instead, at the start of the file. Only streams that are already open are copied:
 * standard input ("-" or /dev/stdin), and /dev/fd/N, which a shell passes for <(command). The function therefore never
 * waits for a program to open a pipe. If standard input is redirected from a regular file, nothing is copied, and "-"
 * denotes the regular file. The function does nothing for any other path. A process can spool only one stream.
 *
 * Called by the command before a file is read; must not be called while another thread opens files. Returns
 * OST_ERR_USAGE if standard input is a terminal or a device, OST_ERR_RANGE if the stream has more than
 * ost_file_spool_max bytes, and OST_ERR_IO if the copy fails.
 */
ost_status ost_file_spool(const char *path, ost_error *err);

/*
 * Returns true if `path` is the stream that ost_file_spool has copied. A stream has no folder that could contain
 * related files.
 */
bool ost_file_is_stream(const char *path);

/* Maximum size in bytes of a stream that is spooled to a file. The value is 16 GiB; tests can reduce it. */
extern int64_t ost_file_spool_max;

/*
 * Opens a regular file by its name within the open folder `folder`. A symbolic link
 * is rejected, so that the file cannot be outside the folder.
 */
ost_status ost_file_open_within(int folder, const char *name, ost_file *out, ost_error *err);

/*
 * Opens a regular file as a stream, which the caller closes with fclose. *out is NULL after a failure. *absent is set
 * to true if no file has this name, otherwise to false. The pointer `absent` may be NULL.
 */
ost_status ost_file_stream(const char *path, FILE **out, bool *absent, ost_error *err);

/*
 * Reads all file->size bytes of an open file into `to`. Returns OST_ERR_IO if the size of the file has
 * changed. `path` is used only in messages.
 */
ost_status ost_file_fill(const char *path, const ost_file *file, void *to, ost_error *err);

/*
 * Reads an open file into new memory, which the caller frees. The bytes are followed by a NUL that
 * is not counted in *size. *bytes is NULL after a failure.
 */
ost_status ost_file_bytes(const char *path, const ost_file *file, char **bytes, size_t *size, ost_error *err);

/*
 * Reads a complete regular file into new memory, which the caller frees. The bytes are followed by a NUL that is not
 * counted in *size. *bytes is NULL after a failure. Returns OST_ERR_RANGE if the file has more than `max` bytes,
 * OST_ERR_IO if its size changes while it is read, or OST_ERR_MEMORY. *absent is set to true if no file has this name,
 * otherwise to false. The pointer `absent` may be NULL.
 */
ost_status ost_file_read(const char *path, size_t max, char **bytes, size_t *size, bool *absent, ost_error *err);

#endif
