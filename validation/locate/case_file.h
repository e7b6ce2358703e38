/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A case as a file: the name of the generated case, the parts of it that are
 * kept, and the difference that it showed when it was written.
 *
 *   {"osteon_case": 1, "id": "session/1", "tier": "smoke", "seed": "1",
 *    "keep": {"ct": false, "collide": false, "crop": [[x, y, z], [x, y, z]], "samples": [[from, to], ...],
 *             "ticks": [[from, to], ...], "no_tools": [0], "triangles": [[tool, part, from, to], ...]},
 *    "shows": {...}}
 *
 * Without "keep" it is the entire case.  Ranges are half-open and ascending;
 * "shows" is for readers and has no effect.  An object with "cases", a list of
 * such objects, holds several.  Files are not trusted: everything is checked.
 */
#ifndef OST_VALIDATION_CASE_FILE_H
#define OST_VALIDATION_CASE_FILE_H

#include <jansson.h>

#include "validation/locate/cut.h"

/* Reads one case. The caller frees out->cut with free(). where: the beginning of messages. user: the store of the
   user's own cases, NULL for none. */
ost_status case_of_json(const json_t *o, const char *where, const plan_user *user, plan_case *out, ost_error *err);
/* Returns the case as JSON, owned by the caller; NULL if memory is exhausted. */
json_t *case_to_json(const plan_case *c, const scene_cut *cut);

/* Reads all cases of a file as a plan. If document is not NULL, *document receives the content
   of the file, owned by the caller. */
ost_status case_file_read(const char *path, const plan_user *user, plan *out, json_t **document, ost_error *err);

#endif
