/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Atomic output files, used by all writers: a file appears under its final name only when it is complete.
 *
 *   open    creates an unnamed file in the target's folder (O_TMPFILE) or, if the
 *           file system does not support that, a hidden one with a random name: .osteon-*.part
 *   write   is buffered; errors report the number of bytes written
 *   commit  flushes and syncs the file and then names it: by linkat if the name is free,
 *           otherwise by a link under a hidden name, which is then renamed over the old file
 *   discard removes everything
 *
 *   ost_outfile *out;
 *   ost_status status = ost_outfile_open(path, &out, err);
 *   if (status != OST_OK)
 *       return status;
 *   status = ost_outfile_write(out, bytes, size, err);
 *   if (status == OST_OK)
 *       return ost_outfile_commit(out, err);
 *   ost_outfile_discard(out);
 *   return status;
 *
 * A process that is killed before the commit leaves no file under the final name. With O_TMPFILE, the process also
 * leaves no other file, unless it is killed between the link and the rename that replace an old file.
 *
 * A target that exists and is not a regular file (/dev/null, a pipe, a terminal) is written in place. /dev/stdout,
 * /dev/stderr and "-.ENDING" are the process's own streams; the ending selects the format. If writing to a stream
 * fails, the stream's reader has already received the bytes that were written before. A symbolic link is followed, not
 * replaced. Permissions follow the umask.
 *
 * Signals: a process that may be terminated by SIGINT, SIGTERM, SIGHUP or SIGXFSZ calls ost_outfile_unlink_pending from
 * its handler. The process should ignore SIGXFSZ and SIGPIPE, so that a size limit or a closed pipe becomes an error
 * message.
 *
 * Threads: one file is used by one thread at a time; different files are independent.
 */
#ifndef OST_IO_OUTFILE_H
#define OST_IO_OUTFILE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <osteon/status.h>

typedef struct ost_outfile ost_outfile;

/*
 * Opens an output file for `path`. Returns OST_ERR_IO with a message that names `path` if `path` is a folder, is
 * write-protected or cannot be created. On failure, *out is NULL.
 */
ost_status ost_outfile_open(const char *path, ost_outfile **out, ost_error *err);

/*
 * Writes `size` bytes. Small writes are collected in a buffer. After a failure, the caller should call
 * ost_outfile_discard, because ost_outfile_commit would return the same failure again.
 */
ost_status ost_outfile_write(ost_outfile *file, const void *bytes, size_t size, ost_error *err);
ost_status ost_outfile_printf(ost_outfile *file, ost_error *err, const char *format, ...) OST_PRINTF(3, 4);

/*
 * Returns true if the path is "-.ENDING", such as "-.nrrd", which denotes standard output. The path "./-.nrrd"
 * denotes a file.
 */
bool ost_outfile_is_stdout(const char *path);

/* Returns the path that was passed to ost_outfile_open, for messages. */
const char *ost_outfile_path(const ost_outfile *file);

/*
 * Returns the file's descriptor. Another program can write the file through /dev/fd/N; no other user can replace a part
 * of this path. The outfile still owns the descriptor, and the caller must not write to the outfile itself.
 */
int ost_outfile_descriptor(const ost_outfile *file);

/*
 * Completes the file under its final name and frees the outfile. On error, no file is left, and the outfile is freed
 * too.
 */
ost_status ost_outfile_commit(ost_outfile *file, ost_error *err);
/* Removes the unfinished file and frees the outfile. `file` may be NULL. */
void ost_outfile_discard(ost_outfile *file);

/*
 * Creates a file with the given contents. If the name already exists, creates nothing and sets *taken. The file is not
 * synced. A symbolic link counts as an existing name and is not followed.
 */
ost_status ost_outfile_put_new(const char *path, const void *bytes, size_t size, bool *taken, ost_error *err);

/*
 * Unlinks the hidden names of all open files. The function is async-signal-safe, so that a handler that terminates the
 * process can call it.
 */
void ost_outfile_unlink_pending(void);

/* For tests: if true, hidden names are used even if O_TMPFILE works. */
extern bool ost_outfile_named_only;

#endif
