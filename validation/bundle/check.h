/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Checks a bundle. The check can run on any machine. It covers these parts of a bundle:
 *
 *   folder              contains exactly the files of the manifest, of allowed types and sizes (folder.h)
 *   log                 has an intact hash chain and the required lines (log.h)
 *   protocol, cases     are compared with the plan (planned.h)
 *   measured files      are compared with each other (planned.h)
 *   verdicts            follow from the digests of each backend's trace (judge.h)
 *   derived files       are derived again from the protocol and the cases, and compared
 *   results             are computed again on request, on the reference or on another backend
 */
#ifndef OST_VALIDATION_CHECK_H
#define OST_VALIDATION_CHECK_H

#include "validation/bundle/bundle.h"
#include "validation/plan.h"

/* Checks everything except the results. Sets *summary to the bundle's verdict (evidence_summary). If the verdict cannot
   be read, sets *summary to NULL. The caller owns *summary. */
ost_status check_bundle(const char *folder, bundle_problem *problem, void *user, int *found, json_t **summary,
                        ost_error *err);

typedef struct check_how {
    const char *program;   /* path of this program; workers are started from it */
    const plan_user *own;  /* cases from the user's own files; NULL if the bundle has none */
    const char *backend;   /* backend specification, as for ost_backend_open; NULL selects only the reference */
    double limit_s;        /* time limit in seconds for each backend, over all its cases */
    /* called to report the progress; `share` increases from 0 to 1; may be NULL */
    void (*show)(void *user, const char *what, double share);
    void *show_user;
} check_how;

/*
 * Runs the cases again in workers. The reference's digests of the inputs and of all records must equal those in the
 * bundle. The digests of how->backend must equal those in the bundle or, if the bundle has none for this backend, those
 * of the reference.
 */
ost_status check_again(const char *folder, const check_how *how, bundle_problem *problem, void *user, int *found,
                       ost_error *err);

#endif
