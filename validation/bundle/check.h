/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Whether a bundle is what it says, without the machine that made it:
 *
 *   every file as the manifest has it, none more, none less
 *   the log's chain, and the protocol's hash in it before the first result
 *   every derived file, derived again from protocol and cases
 *   on request what the reference made, made again
 */
#ifndef OST_VALIDATION_CHECK_H
#define OST_VALIDATION_CHECK_H

#include "validation/bundle/bundle.h"
#include "validation/plan.h"

/* summary receives the bundle's verdict (evidence_summary), or NULL when it cannot be read; the caller's reference. */
ost_status check_bundle(const char *folder, bundle_problem *problem, void *user, int *found, json_t **summary, ost_error *err);

/*
 * The cases made again on the reference of this program: their inputs' digests
 * and those of all records must be the bundle's.  own: the user's own cases,
 * NULL where the bundle has none.  show may be NULL.
 */
ost_status check_again(const char *folder, const plan_user *own, bundle_problem *problem, void *user, int *found, void (*show)(void *user, const char *what, double share),
                       void *show_user, ost_error *err);

#endif
