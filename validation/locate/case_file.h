/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A case as a file: the name of the generated case, the parts of it that are
 * retained, and the difference that the case showed when the file was written.
 *
 *   {"osteon_case": 1, "id": "session/1", "tier": "smoke", "seed": "1",
 *    "keep": {"ct": false, "collide": false, "crop": [[x, y, z], [x, y, z]], "samples": [[from, to], ...],
 *             "ticks": [[from, to], ...], "no_tools": [0], "triangles": [[tool, part, from, to], ...]},
 *    "shows": {...}}
 *
 * Without "keep" the entire case is retained.  Ranges are half-open and ascending.
 * "shows" is only information and has no effect.  A file with several cases is an
 * object with "cases", a list of such objects.  Files are not trusted, so all their
 * values are checked.
 */
#ifndef OST_VALIDATION_CASE_FILE_H
#define OST_VALIDATION_CASE_FILE_H

#include <jansson.h>

#include "validation/locate/cut.h"

/* Reads one case. The caller frees out->cut with free(). Error messages begin with the text `where`. The parameter user
   describes the user's own cases; it is NULL if there are none. */
ost_status case_of_json(const json_t *o, const char *where, const plan_user *user, plan_case *out, ost_error *err);
/* Returns the case as JSON, owned by the caller; NULL if memory is exhausted. */
json_t *case_to_json(const plan_case *c, const scene_cut *cut);

/* Reads all cases of a file as a plan. If document is not NULL, *document receives the content of the file, owned by
   the caller. */
ost_status case_file_read(const char *path, const plan_user *user, plan *out, json_t **document, ost_error *err);

#endif
