/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The output file that every writer uses: whole under its name, or not there.
 *
 *   open    an unnamed file in the target's folder (O_TMPFILE), or, where the
 *           file system has none, a hidden one with a random name: .osteon-*.part
 *   write   buffered; every error is checked and says how far it came
 *   commit  flush, fsync, then the name: linkat when the name is free, else
 *           a link under a hidden name and rename over the old file
 *   discard nothing is left
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
 * A kill at any moment leaves nothing under the final name, and with
 * O_TMPFILE nothing at all, but for the instant between linking and renaming
 * when an old file is replaced.
 *
 * A target that exists and is not a regular file (/dev/null, a pipe, a
 * terminal) is simply written; /dev/stdout and /dev/stderr are the process's
 * own.  A symbolic link is followed, not replaced.  Permissions are by umask.
 *
 * Signals: a process that may be ended by SIGINT, SIGTERM, SIGHUP or SIGXFSZ
 * calls ost_outfile_unlink_pending from its handler.  It should ignore
 * SIGXFSZ and SIGPIPE, so that a limit or a closed pipe becomes an error text.
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

/* OST_ERR_IO naming path when it is a folder, write-protected, or cannot be made. *out is NULL on failure. */
ost_status ost_outfile_open(const char *path, ost_outfile **out, ost_error *err);

/* Small pieces are gathered. After a failure only discard makes sense; commit would repeat the failure. */
ost_status ost_outfile_write(ost_outfile *file, const void *bytes, size_t size, ost_error *err);
ost_status ost_outfile_printf(ost_outfile *file, ost_error *err, const char *format, ...) OST_PRINTF(3, 4);

/* Bytes given to write so far. */
uint64_t ost_outfile_size(const ost_outfile *file);
/* The name as the caller gave it, for messages. */
const char *ost_outfile_path(const ost_outfile *file);

/*
 * Returns the descriptor, for a program that writes the file in our place, as /dev/fd/N: it then needs no name that
 * another user could replace.  The outfile still owns it; nothing is given to write then.
 */
int ost_outfile_descriptor(const ost_outfile *file);

/* Ends the file in any case and frees it: whole under its name, or an error and nothing left. */
ost_status ost_outfile_commit(ost_outfile *file, ost_error *err);
/* Leaves nothing and frees it; NULL is allowed. */
void ost_outfile_discard(ost_outfile *file);

/*
 * Writes a file under a name that is free, complete or not at all, and does not sync it.  Sets *taken when the name is
 * not free; a link of that name is not followed.
 */
ost_status ost_outfile_put_new(const char *path, const void *bytes, size_t size, bool *taken, ost_error *err);

/* Unlinks the hidden names of all files that are open now. Async-signal-safe; for a handler that ends the process. */
void ost_outfile_unlink_pending(void);

/* For tests: hidden names even where O_TMPFILE works. */
extern bool ost_outfile_named_only;

#endif
