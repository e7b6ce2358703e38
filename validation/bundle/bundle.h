/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A folder of evidence, whole under its name or not there.
 *
 *   bundle_begin --> hidden folder beside OUT --files, log--> bundle_end: manifest, fsync, rename
 *
 * audit.log is a chain: a line is
 *
 *   SHA-256 of the line before (64 digits, of nothing for the first) TAB UTC TAB action TAB detail
 *
 * so that a line changed, taken out or moved breaks all after it.  It is
 * written line by line while the campaign runs; log.h says which lines it has.
 */
#ifndef OST_VALIDATION_BUNDLE_H
#define OST_VALIDATION_BUNDLE_H

#include <dirent.h>
#include <jansson.h>
#include <osteon/digest.h>

typedef struct bundle bundle;

#define BUNDLE_LOG "audit.log"
enum { BUNDLE_PATH = 1024 };

/* OST_ERR_IO when `out` exists or cannot be made. */
ost_status bundle_begin(const char *out, bundle **b, ost_error *err);
/* The folder that files go into until the end. */
const char *bundle_folder(const bundle *b);
ost_status bundle_put(bundle *b, const char *name, const void *bytes, size_t size, ost_error *err);
/* Sorted keys, one space of indentation, a newline at the end: equal values are equal files. */
ost_status bundle_put_json(bundle *b, const char *name, const json_t *value, ost_error *err);
ost_status bundle_log(bundle *b, const char *action, ost_error *err, const char *detail, ...) OST_PRINTF(4, 5);
/* Manifest, and the folder gets its name. Frees b in any case. */
ost_status bundle_end(bundle *b, ost_error *err);
void bundle_abandon(bundle *b); /* NULL is allowed */

/* ---------------------------------------------------------------- checking */

/* A file that is absent makes a bundle incomplete; a file that is different makes it another one than was written. */
typedef enum bundle_problem_kind { BUNDLE_ABSENT, BUNDLE_DIFFERENT } bundle_problem_kind;

/* Receives one problem. A file that cannot be read is no problem of a bundle but an error of the check. */
typedef void bundle_problem(void *user, bundle_problem_kind kind, const char *file, const char *problem);

/* Every problem of the folder's files, of the manifest and of the log's chain; they are added to *found. */
ost_status bundle_check(const char *folder, bundle_problem *problem, void *user, int *found, ost_error *err);

/* Reads a file of a bundle, with a NUL behind it that size does not count; the caller frees it. */
ost_status bundle_read(const char *folder, const char *name, char **bytes, size_t *size, ost_error *err);
/* As bundle_read, but an absent file is OST_OK with *bytes NULL. */
ost_status bundle_find(const char *folder, const char *name, char **bytes, size_t *size, ost_error *err);

/* Parses a file of a bundle within the limits of limits.h; the caller's reference, *out NULL where it is absent. */
ost_status bundle_find_json(const char *folder, const char *name, json_t **out, ost_error *err);
/* The same for a file that must be there. */
ost_status bundle_read_json(const char *folder, const char *name, json_t **out, ost_error *err);

/* Reads the next entry of a folder other than . and ..; *entry is NULL at the end. */
ost_status bundle_next_entry(DIR *dir, const char *folder, struct dirent **entry, ost_error *err);

#endif
