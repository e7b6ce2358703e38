/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Reads and writes case files. A case file contains the name of a generated case, the parts of the case
 * that are retained, and the difference that the case showed when the file was written.
 *
 *   {"osteon_case": 1, "id": "session/1", "tier": "smoke", "seed": "1",
 *    "keep": {"ct": false, "collide": false, "crop": [[x, y, z], [x, y, z]], "samples": [[from, to], ...],
 *             "ticks": [[from, to], ...], "no_tools": [0], "triangles": [[tool, part, from, to], ...]},
 *    "shows": {...}}
 *
 * Without the member "keep" the entire case is retained. Ranges are half-open and ascending. The member
 * "shows" is for readers and has no effect. A file with several cases is an object whose member "cases" is
 * a list of such objects. Files may come from untrusted sources, so all values are checked.
 */
#ifndef OST_VALIDATION_CASE_FILE_H
#define OST_VALIDATION_CASE_FILE_H

#include <jansson.h>

#include "validation/locate/cut.h"

/* Reads one case. The caller frees out->cut with free(). Error lines begin with the text in `where`. `user`
   describes the user's own cases, and is NULL if there are none. */
ost_status case_of_json(const json_t *o, const char *where, const plan_user *user, plan_case *out, ost_error *err);
/* Returns the case as a JSON object that the caller owns, or NULL if memory is exhausted. */
json_t *case_to_json(const plan_case *c, const scene_cut *cut);

/* Reads all cases of a file as a plan. If `document` is not NULL, sets *document to the content of the file, which the
   caller owns. */
ost_status case_file_read(const char *path, const plan_user *user, plan *out, json_t **document, ost_error *err);

#endif
