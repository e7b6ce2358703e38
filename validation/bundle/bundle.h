/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A bundle is a folder of evidence. The folder appears under its final name only when it is complete.
 *
 *   bundle_begin --> folder OUT.part-XXXXXX --files, log--> bundle_end: manifest, fsync, rename
 *
 * audit.log is a hash chain. Each line has the form
 *
 *   SHA-256 TAB UTC TAB action TAB detail
 *
 * where SHA-256 is the digest of the previous line, in 64 hexadecimal digits. The first line contains the
 * digest of the empty string. If a line is changed, removed or moved, all lines after it are therefore
 * invalid. The log is written line by line while the campaign runs; log.h lists the lines.
 */
#ifndef OST_VALIDATION_BUNDLE_H
#define OST_VALIDATION_BUNDLE_H

#include <dirent.h>
#include <jansson.h>
#include <osteon/digest.h>

typedef struct bundle bundle;

#define BUNDLE_LOG "audit.log"
enum { BUNDLE_PATH = 1024 };

/* Creates the folder OUT.part-XXXXXX. Returns OST_ERR_IO if `out` exists or cannot be created. */
ost_status bundle_begin(const char *out, bundle **b, ost_error *err);
/* Returns the path of the bundle's folder, which has a temporary name until bundle_end renames it. */
const char *bundle_folder(const bundle *b);
ost_status bundle_put(bundle *b, const char *name, const void *bytes, size_t size, ost_error *err);
/* Writes a file with sorted keys, one space of indentation and a newline at the end, so that equal values give equal
   files. */
ost_status bundle_put_json(bundle *b, const char *name, const json_t *value, ost_error *err);
ost_status bundle_log(bundle *b, const char *action, ost_error *err, const char *detail, ...) OST_PRINTF(4, 5);
/* Writes the manifest, and renames the folder to `out`. Frees b even on failure. */
ost_status bundle_end(bundle *b, ost_error *err);
void bundle_abandon(bundle *b); /* b may be NULL */

/* ------------------------------------------------------- checking a bundle */

/* BUNDLE_ABSENT: a file is missing, so the bundle is incomplete. BUNDLE_DIFFERENT: the bundle was changed after it
   was written. */
typedef enum bundle_problem_kind { BUNDLE_ABSENT, BUNDLE_DIFFERENT } bundle_problem_kind;

/* Called for each problem of a bundle. If a file cannot be read, the check itself fails and does not call this
   function. */
typedef void bundle_problem(void *user, bundle_problem_kind kind, const char *file, const char *problem);

/* Reports every problem of the folder's files, of the manifest and of the log's hash chain. Adds the number of
   problems to *found. */
ost_status bundle_check(const char *folder, bundle_problem *problem, void *user, int *found, ost_error *err);

/* Reads a file of a bundle and appends a NUL that is not counted in size; the caller frees *bytes. */
ost_status bundle_read(const char *folder, const char *name, char **bytes, size_t *size, ost_error *err);
/* Reads a file of a bundle as bundle_read does. If the file is absent, returns OST_OK and sets *bytes to NULL. */
ost_status bundle_find(const char *folder, const char *name, char **bytes, size_t *size, ost_error *err);

/* Parses a file of a bundle within the limits of limits.h. The caller owns *out. If the file is absent, *out is
   NULL. */
ost_status bundle_find_json(const char *folder, const char *name, json_t **out, ost_error *err);
/* Parses a JSON file of a bundle as bundle_find_json does, except that a missing file is an error. */
ost_status bundle_read_json(const char *folder, const char *name, json_t **out, ost_error *err);

/* Reads the next entry of a folder other than "." and "..". Sets *entry to NULL at the end of the folder. */
ost_status bundle_next_entry(DIR *dir, const char *folder, struct dirent **entry, ost_error *err);

#endif
