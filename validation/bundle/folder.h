/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The files of a bundle's folder, and how they are opened. A bundle may come
 * from an untrusted source.
 *
 *   folder --folder_list--> names and sizes; anything else is reported as a problem
 *
 * A bundle may have the files that are listed in folder.c. They are in the bundle's folder itself or in its
 * folders pictures/, cases/ and signatures/. Each file has a maximum size. Symbolic links, pipes, devices
 * and folders with other names are reported and never opened: every component of a path is opened relative
 * to its parent folder, with O_NOFOLLOW.
 */
#ifndef OST_VALIDATION_FOLDER_H
#define OST_VALIDATION_FOLDER_H

#include <osteon/digest.h>

#include "core/file.h"
#include "validation/bundle/bundle.h"

typedef struct folder_file {
    char *name; /* name of the file within the bundle, for example "pictures/after.png" */
    int64_t size;
} folder_file;

typedef struct folder_files {
    folder_file *files; /* owned; the files, sorted by name */
    size_t count;
} folder_files;

/* The rules for a file of the bundle. The name of the file determines them. */
typedef struct folder_about {
    /* true if the file depends on times, identities or the machine and is therefore not part of results_root */
    bool varies;
    bool bound;   /* true if the log must contain a digest of the file (log.h) */
    int64_t most; /* maximum size in bytes */
} folder_about;
bool folder_describe(const char *name, folder_about *out);

/* Returns the name in row `row` of the table of files, or NULL after the last row. Pictures, cases and signatures are
   not in the table. */
const char *folder_name(size_t row);

/* Lists all files except the files in signatures/, which sign.c reads. Adds the number of problems to *found. */
ost_status folder_list(const char *folder, folder_files *out, bundle_problem *problem, void *user, int *found,
                       ost_error *err);
void folder_free(folder_files *l);

/* Opens the file folder/name as core/file.h does, but does not follow symbolic links. The caller closes out->fd.
   Returns OST_ERR_RANGE if the file exceeds its maximum size. */
ost_status folder_open(const char *folder, const char *name, ost_file *out, ost_error *err);

/* Computes the SHA-256 of a file, block by block. */
ost_status folder_digest(const char *folder, const char *name, ost_digest *out, int64_t *size, ost_error *err);

/* Compares a file with bytes in memory, block by block. Sets *absent and *same. */
ost_status folder_compare(const char *folder, const char *name, const void *bytes, size_t size, bool *absent,
                          bool *same, ost_error *err);

#endif
