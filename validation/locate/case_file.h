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

/* One case; out->cut is the caller's to free(). where: of messages. user: what the user's own cases are made of, NULL for none. */
ost_status case_of_json(const json_t *o, const char *where, const plan_user *user, plan_case *out, ost_error *err);
/* Returns the case as JSON, the caller's reference; NULL if memory is exhausted. */
json_t *case_to_json(const plan_case *c, const scene_cut *cut);

/* All cases of a file as a plan; *whole, when wanted, is what the file holds, the caller's reference. */
ost_status case_file_read(const char *path, const plan_user *user, plan *out, json_t **whole, ost_error *err);

#endif
