/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A case as a file: which generated case, what of it is kept, and what it
 * showed when it was written.
 *
 *   {"osteon_case": 1, "id": "session/1", "tier": "smoke", "seed": "1",
 *    "keep": {"ct": false, "collide": false, "crop": [[x, y, z], [x, y, z]], "samples": [[from, to], ...],
 *             "ticks": [[from, to], ...], "no_tools": [0], "triangles": [[tool, part, from, to], ...]},
 *    "shows": {...}}
 *
 * Without "keep" it is the whole case.  Ranges are half-open and ascending;
 * "shows" is for people and decides nothing.  An object with "cases", a list
 * of such, holds several.  Files come from anywhere: all is checked.
 */
#ifndef OST_VALIDATION_CASE_FILE_H
#define OST_VALIDATION_CASE_FILE_H

#include <jansson.h>

#include "validation/locate/cut.h"

/* One case; out->cut is the caller's to free(). where: of messages. user: what the user's own cases are made of, NULL for none. */
ost_status case_of_json(const json_t *o, const char *where, const plan_user *user, plan_case *out, ost_error *err);
/* The caller's reference, NULL when there is no memory. */
json_t *case_to_json(const plan_case *c, const scene_cut *cut);

/* All cases of a file as a plan; *whole, when wanted, is what the file holds, the caller's reference. */
ost_status case_file_read(const char *path, const plan_user *user, plan *out, json_t **whole, ost_error *err);

#endif
