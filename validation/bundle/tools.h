/* SPDX-License-Identifier: Apache-2.0 */
/*
 * tools.json: what the program was built from and what it runs with.
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

/* program: this program's file. The caller's reference. */
ost_status tools_of(const char *program, json_t **out, ost_error *err);

/* The commit that this program was built from; "unknown" when it was built from no git checkout. */
const char *tools_commit(void);

#endif
