/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Makes tools.json, which describes the build of the program and the libraries with which it runs.
 *
 *   build      commit, date of the source, compiler, flags, versions of the libraries' headers
 *   program    SHA-256 of the executable file
 *   libraries  the libraries that are currently loaded (libraries.h)
 *
 * The same build on the same machine gives the same file.
 */
#ifndef OST_VALIDATION_TOOLS_H
#define OST_VALIDATION_TOOLS_H

#include <jansson.h>
#include <osteon/status.h>

#define TOOLS_FILE "tools.json"

/* Makes the content of tools.json, which the caller owns. `program` is the path of the executable file of this
   process. */
ost_status tools_of(const char *program, json_t **out, ost_error *err);

/* Returns the commit from which this program was built; "unknown" if it was not built from a git checkout. */
const char *tools_commit(void);

#endif
