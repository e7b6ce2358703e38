/* SPDX-License-Identifier: Apache-2.0 */
/*
 * cases/NAME.json: small cases that show what a campaign found, each of them
 * run by one command.
 *
 *   campaign's differences --minimise--> cases/session-1-backend-2.json
 *
 * Of every backend the first difference of each stage and look, and so many
 * in all: a broken backend differs everywhere in the same way.
 */
#ifndef OST_VALIDATION_REPRODUCE_H
#define OST_VALIDATION_REPRODUCE_H

#include "validation/bundle/evidence.h"

enum { REPRODUCED = 6 };

/* Also notes each file in the campaign's findings.  program, folder: as campaign_options has them; show may be NULL. */
ost_status reproduce(campaign *c, const char *program, const char *folder, void (*show)(void *user, const char *what, double share), void *show_user,
                     evidence_sink *sink, void *user, ost_error *err);

/* A name that reproduce gives: "cases/" and plain letters; anything else in a bundle is not followed. */
bool reproduce_name_ok(const char *name);

#endif
