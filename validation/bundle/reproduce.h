/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Makes the files cases/NAME.json. Each file is a small case that reproduces a difference found by a campaign. One
 * command runs the case.
 *
 *   campaign's differences --minimise--> cases/session-1-backend-2.json
 *
 * For every backend, only the first difference of each stage and class is reduced, because a defective
 * backend differs in the same way everywhere. The total number of small cases is also limited.
 */
#ifndef OST_VALIDATION_REPRODUCE_H
#define OST_VALIDATION_REPRODUCE_H

#include "validation/bundle/evidence.h"

enum { REPRODUCED = 6 };

/* Writes the small cases and stores the name of each small case in the campaign's findings. `program` is the path of
   this program's executable. Temporary files are written to `folder`. `show` may be NULL. */
ost_status reproduce(campaign *c, const char *program, const char *folder,
                     void (*show)(void *user, const char *what, double share), void *show_user, evidence_sink *sink,
                     void *user, ost_error *err);

/* Returns true for names in the form that `reproduce` generates: "cases/" followed by plain characters. Other names
   in a bundle are ignored. */
bool reproduce_name_ok(const char *name);

#endif
