/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Counts how often a campaign executed each code path of a backend (core/paths.h). The counts of the
 * backend's workers are added.
 *
 *   worker: backend --paths_write--> the end record of its trace
 *   parent: the end record --paths_add--> path_list of the backend
 *
 * For each path the end record has the count as a word and the name as a block
 * of bytes.
 */
#ifndef OST_VALIDATION_PATHS_H
#define OST_VALIDATION_PATHS_H

#include <jansson.h>

#include "core/paths.h"
#include "validation/trace.h"

enum { PATHS_MAX = 1024 }; /* maximum number of paths per backend */

typedef struct path_count {
    char name[OST_PATH_NAME];
    uint64_t entered;
} path_count;

typedef struct path_list {
    int count;
    path_count *paths; /* owned; the paths in the order in which the backend reports them */
} path_list;

/* Adds the count and the name of each of the backend's paths to the record that is being written. */
void paths_write(const ost_backend *backend, trace_writer *w);
/* Adds the counts of an end record. A record that has no paths or is not well formed adds nothing. Fails only with
   OST_ERR_MEMORY. */
ost_status paths_add(path_list *list, const trace_record *end, ost_error *err);
/* Makes an object {"path": count} of the paths that were entered, and a list of the other paths. The caller owns
   both. */
void paths_json(const path_list *list, json_t **entered, json_t **missing);
void paths_free(path_list *list);

#endif
