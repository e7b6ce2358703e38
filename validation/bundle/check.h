/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Checks a bundle without the machine that made it:
 *
 *   the folder has exactly the files of the manifest, with the allowed kinds and sizes (folder.h)
 *   the log's chain and lines (log.h)
 *   the protocol and its cases against the plan; measured files against each other (planned.h)
 *   every verdict, from the digests that were made of each backend's trace (judge.h)
 *   every derived file, derived again from protocol and cases
 *   on request the results of the reference or of any backend, computed again
 */
#ifndef OST_VALIDATION_CHECK_H
#define OST_VALIDATION_CHECK_H

#include "validation/bundle/bundle.h"
#include "validation/plan.h"

/* Checks everything except the results. *summary receives the bundle's verdict (evidence_summary), owned by the
   caller, or NULL if it cannot be read. */
ost_status check_bundle(const char *folder, bundle_problem *problem, void *user, int *found, json_t **summary,
                        ost_error *err);

typedef struct check_how {
    const char *program;   /* this program's file, for workers */
    const plan_user *own;  /* the user's own cases; NULL if the bundle has none */
    const char *backend;   /* a backend that ost_backend_open takes; NULL: only the reference */
    double limit_s;        /* time limit in seconds for the complete run of each backend */
    void (*show)(void *user, const char *what, double share); /* may be NULL */
    void *show_user;
} check_how;

/*
 * Runs the cases again in workers.  On the reference, the digests of the inputs
 * and of all records must be those of the bundle.  On how->backend, the digests
 * must be those of the bundle's results on it or, if the bundle does not have
 * this backend, those of the reference.
 */
ost_status check_again(const char *folder, const check_how *how, bundle_problem *problem, void *user, int *found,
                       ost_error *err);

#endif
