/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The parts of osteon validate.
 *
 *   cmd_validate.c     options, and which of these is meant; workers
 *   validate_run.c     a campaign, and the bundle of what came of it
 *   validate_merge.c   shards' bundles put together
 *   validate_say.c     what is printed, and the exit status
 */
#ifndef OST_APP_VALIDATE_H
#define OST_APP_VALIDATE_H

#include "app/user_files.h"
#include "validation/bundle/bundle.h"
#include "validation/bundle/sign.h"
#include "validation/campaign.h"
#include "validation/sensitivity.h"

typedef struct validate_args {
    const char *out, *backends, *shard, *only, *merge, *worker, *trace, *given, *dump, *export_to, *case_file, *sign,
        *passphrase, *against, *suite;
    int tier; /* place in "smoke|standard|full" */
    int64_t seed, from, to, limit_s, jobs;
    int64_t faults, suite_limit_s;
    bool cpu_only, faults_only, from_parent, apart;
    user_files own;
    json_t *record; /* of them; NULL: there are none */
    sign_key *key;  /* of --sign; NULL: the bundle is not signed */
} validate_args;

/* ------------------------------------------------------------ validate_run.c */

/* from_file: what --case gave, or NULL; the caller's. */
ost_status validate_run(app_state *app, const validate_args *args, const plan *p, json_t *from_file, ost_error *err);
ost_status validate_faults(app_state *app, const validate_args *args, ost_error *err);

/* Signs the bundle at args->out with the key of --sign; nothing without one. */
ost_status validate_sign(app_state *app, const validate_args *args, ost_error *err);

/* The protocol and its hash, written before anything runs. */
ost_status validate_freeze(bundle *b, const json_t *protocol, ost_error *err);
/* An evidence_sink: user is a bundle. */
ost_status validate_into_bundle(void *user, const char *name, const void *bytes, size_t size, ost_error *err);

/* ---------------------------------------------------------- validate_merge.c */

ost_status validate_merge(app_state *app, const validate_args *args, ost_error *err);

/* ------------------------------------------------------------ validate_say.c */

/* All of a campaign; the status is the verb's. proof: NULL without one. */
ost_status validate_say(app_state *app, const validate_args *args, const campaign *c, json_t *summary, const sensitivity *proof, const json_t *common, ost_error *err);
/* The last lines: what checks it, the verdict, the picture, the report. */
void validate_say_last(app_state *app, const char *out, const json_t *summary);
/* A result that is not equal: where, with both values, and what it looks like. */
void validate_say_difference(const app_state *app, const plan_case *c, const subject *s, const case_result *r);
/* What was never triggered or never changed anything is named: a proof says what it is no proof of. */
void validate_say_faults(const app_state *app, const sensitivity *s);
/* The suite's counts, and the first tests that failed; suite: suite.json. */
void validate_say_suite(const app_state *app, const json_t *suite);
/* OST_ERR_DIFFER where a test of the suite failed, OST_ERR_UNAVAILABLE where none passed. */
ost_status validate_judge_suite(const json_t *suite, ost_error *err);
/* Prints the changes since the bundle of --against; impact: impact.json. */
void validate_say_impact(app_state *app, const char *against, json_t *impact);
/* Not a difference: there was nothing to differ. */
ost_status validate_nothing(ost_error *err);

#endif
