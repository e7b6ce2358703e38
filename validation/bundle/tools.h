/* SPDX-License-Identifier: Apache-2.0 */
/*
 * tools.json: the sources of the program's build, and the libraries with which it runs.
 *
 *   build      commit, date of the source, compiler, flags, versions of libraries' headers
 *   program    its file's SHA-256
 *   libraries  those that are loaded now (libraries.h)
 *
 * The same build on the same machine gives the same file.
 */
#ifndef OST_VALIDATION_TOOLS_H
#define OST_VALIDATION_TOOLS_H

#include <jansson.h>
#include <osteon/status.h>

#define TOOLS_FILE "tools.json"

/* Makes the content of tools.json; the caller owns *out. program: this program's file. */
ost_status tools_of(const char *program, json_t **out, ost_error *err);

/* Returns the commit from which this program was built; "unknown" if it was not built from a git checkout. */
const char *tools_commit(void);

#endif
