/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Whether a bundle is what it says, without the machine that made it:
 *
 *   every file as the manifest has it, none more, none less, none of another kind or size (folder.h)
 *   the log's chain and lines (log.h)
 *   the protocol and its cases against the plan; measured files against each other (planned.h)
 *   every verdict, from the digests that were made of each backend's trace (judge.h)
 *   every derived file, derived again from protocol and cases
 *   on request what the reference or any backend made, made again
 */
#ifndef OST_VALIDATION_CHECK_H
#define OST_VALIDATION_CHECK_H

#include "validation/bundle/bundle.h"
#include "validation/plan.h"

/* summary receives the bundle's verdict (evidence_summary), or NULL when it cannot be read; the caller's reference. */
ost_status check_bundle(const char *folder, bundle_problem *problem, void *user, int *found, json_t **summary, ost_error *err);

typedef struct check_how {
    const char *program;   /* this program's file, for workers */
    const plan_user *own;  /* the user's own cases; NULL where the bundle has none */
    const char *backend;   /* a backend that ost_backend_open takes; NULL: the reference alone */
    double limit_s;        /* for the whole run of each */
    void (*show)(void *user, const char *what, double share); /* may be NULL */
    void *show_user;
} check_how;

/*
 * Makes the cases again in workers: on the reference, whose inputs' digests and
 * those of all records must be the bundle's; and on how->backend, whose digests
 * must be those of the bundle's results on it, or the reference's where the
 * bundle has no such backend.
 */
ost_status check_again(const char *folder, const check_how *how, bundle_problem *problem, void *user, int *found, ost_error *err);

#endif
