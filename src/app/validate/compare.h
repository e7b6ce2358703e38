/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The parts of `osteon compare`.
 *
 *   cmd_compare.c      the options
 *   compare.c          finds the dumps or the backend, and compares them with the reference
 *   compare_report.c   the printed report and the margins
 */
#ifndef OST_APP_VALIDATE_COMPARE_H
#define OST_APP_VALIDATE_COMPARE_H

#include "app/validate/user_files.h"
#include "validation/campaign.h"

typedef struct compare_args {
    const char *subject_spec, *only;
    int tier;
    int64_t seed, limit_s;
    bool apart, tier_given, seed_given;
    user_files own;
} compare_args;

/*
 * Compares the dumps or the backend with the reference, and reports the result. `argc` and `argv` are the arguments of
 * the verb; they determine the order of the user's own files.
 */
ost_status compare_run(app_state *app, const compare_args *given, int argc, char **argv, ost_error *err);

/*
 * Prints and stores the results. The verdict covers all backends. The margins are collected separately for each
 * compared backend. Returns OST_ERR_DIFFER if a result differs.
 */
ost_status compare_report(app_state *app, const campaign *c, bool apart, ost_error *err);

#endif
