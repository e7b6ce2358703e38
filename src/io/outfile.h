/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The output file that all writers use. A file appears complete under its name, or not at all.
 *
 *   open    creates an unnamed file in the target's folder (O_TMPFILE) or, if the
 *           file system does not support that, a hidden one with a random name: .osteon-*.part
 *   write   is buffered; every error is checked and reports the number of bytes written
 *   commit  flushes, syncs, then names the file: linkat if the name is free, else
 *           a link under a hidden name and a rename over the old file
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
 * A process that is killed before the commit leaves nothing under the final name.
 * With O_TMPFILE it leaves no file at all, except in the instant between linking
 * and renaming when an old file is replaced.
 *
 * A target that exists and is not a regular file (/dev/null, a pipe, a terminal)
 * is written in place; /dev/stdout, /dev/stderr and "-.ENDING", in which the ending
 * selects the format, are the process's own streams.  A reader of a stream has
 * received the first bytes when a later one fails.
 * A symbolic link is followed, not replaced.  Permissions follow the umask.
 *
 * Signals: a process that may be ended by SIGINT, SIGTERM, SIGHUP or SIGXFSZ
 * calls ost_outfile_unlink_pending from its handler.  It should ignore SIGXFSZ
 * and SIGPIPE, so that a size limit or a closed pipe becomes an error message.
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
 * Opens an output file for path. Returns OST_ERR_IO with a message that names path if it is a folder, is
 * write-protected or cannot be created. *out is NULL on failure.
 */
ost_status ost_outfile_open(const char *path, ost_outfile **out, ost_error *err);

/*
 * Writes size bytes; small writes are gathered in a buffer. After a failure the caller should call discard: commit
 * would return the same failure again.
 */
ost_status ost_outfile_write(ost_outfile *file, const void *bytes, size_t size, ost_error *err);
ost_status ost_outfile_printf(ost_outfile *file, ost_error *err, const char *format, ...) OST_PRINTF(3, 4);

/* Returns true for "-.ENDING", such as "-.nrrd", which is standard output ("./-.nrrd" is a file). */
bool ost_outfile_is_stdout(const char *path);

/* Returns the name as the caller passed it to open, for messages. */
const char *ost_outfile_path(const ost_outfile *file);

/*
 * Returns the descriptor, so that another program can write the file through /dev/fd/N, without a name that another
 * user could replace. The outfile still owns the descriptor. The caller must not write to the outfile in this case.
 */
int ost_outfile_descriptor(const ost_outfile *file);

/* Completes the file under its name and frees the outfile. After an error no file is left; the outfile is freed too. */
ost_status ost_outfile_commit(ost_outfile *file, ost_error *err);
/* Removes the unfinished file and frees the outfile; NULL is allowed. */
void ost_outfile_discard(ost_outfile *file);

/*
 * Creates a complete file under a name that is free, or creates nothing; the file is not synced.  Sets *taken if the
 * name already exists. A symbolic link of that name is not followed.
 */
ost_status ost_outfile_put_new(const char *path, const void *bytes, size_t size, bool *taken, ost_error *err);

/* Unlinks the hidden names of all files that are open now. Async-signal-safe; for a handler that ends the process. */
void ost_outfile_unlink_pending(void);

/* For tests: if true, hidden names are used even where O_TMPFILE works. */
extern bool ost_outfile_named_only;

#endif
