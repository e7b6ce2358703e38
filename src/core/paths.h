/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The code paths on which an open backend computes voxels, each with the number of times it was
 * entered since the backend was opened.  A campaign uses these counts to list the paths that were not
 * executed.
 *
 *   kernel ost_remove                     312
 *   download of a bone in several parts     0     not entered
 *
 * A path is code that is not executed for every input, size or option: a kernel, the
 * remainder of a vector loop, a loop over parts, a fallback.  Its name is a noun phrase
 * of at most OST_PATH_NAME - 1 printable characters, unique in its backend.  The list
 * is the same whenever the backend is opened with the same options on the same machine.
 */
#ifndef OST_CORE_PATHS_H
#define OST_CORE_PATHS_H

#include <osteon/backend.h>

enum { OST_PATH_NAME = 96 };

typedef void ost_path_visit(void *user, const char *path, uint64_t entered);

/* Visits every path of the backend in a fixed order. Visits no path if the backend does not count paths. */
void ost_backend_paths(const ost_backend *backend, ost_path_visit *visit, void *user);

/* Implements the `paths` slot for a backend that does not count paths. */
void ost_no_paths(const ost_backend *backend, ost_path_visit *visit, void *user);

#endif
