/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The parts of `osteon validate`.
 *
 *   cmd_validate.c   the options
 *   args.c           checks of the options
 *   task.c           the choice of the task, and workers
 *   run.c            a campaign, and the bundle of its results
 *   merge.c          merging the bundles of shards
 *   print.c          the printed report, and the exit status
 */
#ifndef OST_APP_VALIDATE_VALIDATE_H
#define OST_APP_VALIDATE_VALIDATE_H

#include "app/validate/user_files.h"
#include "validation/bundle/bundle.h"
#include "validation/bundle/sign.h"
#include "validation/campaign.h"
#include "validation/sensitivity.h"

typedef struct validate_args {
    const char *out, *backends, *shard, *only, *merge, *worker, *trace, *given, *dump, *export_to, *case_file, *sign,
        *passphrase, *against, *suite;
    int tier; /* index in "smoke|standard|full" */
    int64_t seed, from, to, limit_s, jobs;
    int64_t faults, suite_limit_s;
    int shard_index, shard_count; /* the values of --shard; 1 and 1 if the option is not given */
    bool cpu_only, faults_only, from_parent, apart;
    user_files own;
    json_t *record; /* the evidence's record of the user's files; NULL without such files */
    sign_key *key;  /* the key of --sign, or NULL */
} validate_args;

/* ------------------------------------------------------------------ args.c */

/* Checks the options and sets shard_index and shard_count. */
ost_status validate_check(const app_state *app, validate_args *args, ost_error *err);

/* ------------------------------------------------------------------ task.c */

/*
 * Runs the task that the options select: a merge, a worker, a dump, an export of the cases, or a campaign. `argc` and
 * `argv` are the arguments of the verb; they determine the order of the user's own files.
 */
ost_status validate_task(app_state *app, validate_args *args, int argc, char **argv, ost_error *err);

/* ------------------------------------------------------------------- run.c */

/* Runs a campaign. from_file contains the cases of --case and is owned by the caller; it may be NULL. */
ost_status validate_run(app_state *app, const validate_args *args, const plan *p, json_t *from_file, ost_error *err);
ost_status validate_faults(app_state *app, const validate_args *args, ost_error *err);

/* Signs the bundle at args->out with the key of --sign. Does nothing if there is no key. */
ost_status validate_sign(app_state *app, const validate_args *args, ost_error *err);

/* Writes the protocol and its hash to the bundle. Called before any case is run. */
ost_status validate_freeze(bundle *b, const json_t *protocol, ost_error *err);
/* An evidence_sink that adds the file to a bundle; `user` is the bundle. */
ost_status validate_into_bundle(void *user, const char *name, const void *bytes, size_t size, ost_error *err);

/* ----------------------------------------------------------------- merge.c */

ost_status validate_merge(app_state *app, const validate_args *args, ost_error *err);

/* ----------------------------------------------------------------- print.c */

/* Prints the results of a campaign and returns the status of the verb. `proof` is NULL if there is none. */
ost_status validate_print(app_state *app, const validate_args *args, const campaign *c, json_t *summary,
                          const sensitivity *proof, const json_t *common, ost_error *err);
/*
 * Prints the last lines: the command that checks the bundle, the verdict, and the names of the picture and the
 * report.
 */
void validate_print_last(app_state *app, const char *out, const json_t *summary);
/* Prints the position of a difference, both values, and the pattern that it matches. */
void validate_print_difference(const app_state *app, const plan_case *c, const subject *s, const case_result *r);
/*
 * Prints the sensitivity proof. Lists each mistake that was never triggered or never changed a result, because the
 * proof does not cover these mistakes.
 */
void validate_print_faults(const app_state *app, const sensitivity *s);
/* Prints the counts of the suite and the first tests that failed. `suite` contains the contents of suite.json. */
void validate_print_suite(const app_state *app, const json_t *suite);
/* Returns OST_ERR_DIFFER if a test of the suite failed, and OST_ERR_UNAVAILABLE if no test passed. */
ost_status validate_judge_suite(const json_t *suite, ost_error *err);
/* Prints what has changed since the bundle of --against. `impact` is the content of impact.json. */
void validate_print_impact(app_state *app, const char *against, json_t *impact);
/* Returns the error for a campaign in which nothing was compared. The status of the error is not OST_ERR_DIFFER. */
ost_status validate_nothing(ost_error *err);

#endif
