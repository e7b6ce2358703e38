/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Runs a campaign and writes its bundle.
 *
 *   plan, subjects --protocol frozen--> campaign --> cases --> bundle, table, exit status
 */
#include "app/validate/validate.h"

#include <stdlib.h>
#include <string.h>

#include "app/common/progress.h"
#include "app/common/result.h"
#include "validation/bundle/environment.h"
#include "validation/bundle/evidence.h"
#include "validation/bundle/faults.h"
#include "validation/bundle/impact.h"
#include "validation/bundle/log.h"
#include "validation/bundle/record.h"
#include "validation/bundle/reproduce.h"
#include "validation/common/common.h"
#include "validation/report/pictures.h"
#include "validation/report/report.h"
#include "validation/bundle/suite.h"
#include "validation/bundle/trace_table.h"
#include "validation/scratch.h"
#include "validation/suite_run.h"

static void show(void *user, const char *what, double share)
{
    (void)user;
    progress_show(NULL, what, share);
}

ost_status validate_into_bundle(void *user, const char *name, const void *bytes, size_t size, ost_error *err)
{
    return bundle_put(user, name, bytes, size, err);
}

ost_status validate_freeze(bundle *b, const json_t *protocol, ost_error *err)
{
    char *bytes, hex[OST_DIGEST_HEX];
    size_t size;
    ost_digest digest;
    ost_status status = bundle_log(b, "begun", err, "osteon %s", ost_version());
    if (status == OST_OK)
        status = bundle_put_json(b, EVIDENCE_PROTOCOL, protocol, err);
    if (status == OST_OK)
        status = bundle_read(bundle_folder(b), EVIDENCE_PROTOCOL, &bytes, &size, err);
    if (status != OST_OK)
        return status;
    status = ost_digest_bytes(bytes, size, &digest, err);
    free(bytes);
    return status == OST_OK ? bundle_log(b, "protocol frozen", err, "%s", ost_digest_hex(&digest, hex)) : status;
}

/*
 * Makes an object such as {"cl": {"entered": {"kernel ost_remove": 12}, "not_entered": [...]}}, with one member for
 * each backend that counts its code paths.
 */
static json_t *paths_of(const campaign *c)
{
    json_t *all = json_object();
    for (int s = 0; s < c->subjects->count; s++) {
        json_t *entered, *missing;
        if (!c->paths[s].count)
            continue;
        paths_json(&c->paths[s], &entered, &missing);
        put(all, c->subjects->subjects[s].spec, json_pack("{s:o,s:o}", "entered", entered, "not_entered", missing));
    }
    return all;
}

ost_status validate_sign(app_state *app, const validate_args *args, ost_error *err)
{
    char name[SIGN_NAME];
    ost_error why = {0};
    if (!args->key)
        return OST_OK;
    const ost_status status = sign_bundle(args->out, args->key, "", "performed as the protocol says", name, &why);
    if (status != OST_OK)
        return ost_fail(err, status, "%s is written but not signed (osteon sign does that): %s", args->out, why.text);
    put_text(app->result, "signature", name);
    return OST_OK;
}

/*
 * Makes the object {begun: TIME, seconds: {BACKEND: S, ...}, cases: {CASE: {BACKEND: S, ...}, ...}}. TIME is in UTC. S
 * is the time of the backend's workers in seconds, in total or for a case.
 */
static json_t *times_of(const campaign *c)
{
    json_t *times = json_object(), *seconds = json_object(), *cases = json_object();
    struct tm utc;
    char begun[32];
    gmtime_r(&c->begun, &utc);
    strftime(begun, sizeof begun, "%Y-%m-%dT%H:%M:%SZ", &utc);
    put_text(times, "begun", begun);
    for (int s = 0; s < c->subjects->count; s++)
        put_real(seconds, c->subjects->subjects[s].spec, c->seconds[s]);
    for (int i = 0; i < c->plan->count; i++) {
        json_t *one = json_object();
        for (int s = 0; s < c->subjects->count; s++) {
            const double took = c->results[(size_t)i * (size_t)c->subjects->count + (size_t)s].seconds;
            if (took > 0)
                put_real(one, c->subjects->subjects[s].spec, took);
        }
        put(cases, c->plan->cases[i].id, one);
    }
    put(times, "seconds", seconds);
    put(times, "cases", cases);
    return times;
}

static ost_status put_machine(bundle *b, const campaign *c, const char *program, ost_error *err)
{
    json_t *machine, *times = times_of(c);
    ost_status status = environment_of(program, &machine, err);
    if (status == OST_OK)
        put(machine, "paths", paths_of(c));
    if (status == OST_OK)
        status = bundle_put_json(b, ENVIRONMENT_FILE, machine, err);
    if (status == OST_OK)
        status = bundle_put_json(b, TIMES_FILE, times, err);
    json_decref(times);
    json_decref(machine);
    return status;
}

/*
 * Compares the results with the bundle of --against and writes the changes. If --against is not given, *out remains
 * NULL.
 */
static ost_status put_impact(bundle *b, const char *against, json_t **out, ost_error *err)
{
    if (!against)
        return OST_OK;
    const ost_status status = impact_of(against, bundle_folder(b), out, err);
    return status == OST_OK ? bundle_put_json(b, IMPACT_FILE, *out, err) : status;
}

static ost_status put_evidence(bundle *b, const campaign *c, const json_t *protocol, const json_t *cases,
                               const json_t *faults, const json_t *common, const json_t *summary, const char *program,
                               const char *against, json_t **impact, ost_error *err)
{
    ost_status status = evidence_write(protocol, cases, validate_into_bundle, b, err);
    if (status == OST_OK && faults)
        status = bundle_put_json(b, FAULTS_FILE, faults, err);
    if (status == OST_OK)
        status = record_put(program, c->subjects, common, validate_into_bundle, b, err);
    if (status == OST_OK)
        status = put_machine(b, c, program, err);
    if (status == OST_OK)
        status = put_impact(b, against, impact, err);
    if (status == OST_OK)
        status = record_derive(bundle_folder(b), protocol, cases, validate_into_bundle, b, err);
    if (status == OST_OK)
        status = report_write(bundle_folder(b), protocol, cases, validate_into_bundle, b, err);
    return status == OST_OK ? log_end(b, summary, err) : status;
}

/* Runs the test suite and stores its result in *out. If --with-suite is not given, *out remains NULL. */
static ost_status run_suite(const validate_args *args, int jobs, json_t **out, ost_error *err)
{
    if (!args->suite)
        return OST_OK;
    char *requirements = trace_requirements();
    const suite_options how = {.folder = args->suite,
                               .requirements = requirements,
                               .limit_s = args->suite_limit_s,
                               .jobs = jobs,
                               .show = show};
    const ost_status status =
        requirements ? suite_run(&how, out, err) : ost_fail(err, OST_ERR_MEMORY, "out of memory for requirements");
    free(requirements);
    return status;
}

/* Everything that a run has allocated or opened. job_free frees it. */
typedef struct job {
    char program[1024];
    subject_list subjects;
    campaign run;
    bundle *b;
    json_t *protocol, *cases, *summary, *faults, *common, *impact, *suite;
    sensitivity proof; /* the sensitivity proof; valid if `faults` is not NULL */
} job;

static void job_free(job *j)
{
    campaign_free(&j->run);
    subjects_free(&j->subjects);
    bundle_abandon(j->b);
    json_decref(j->protocol);
    json_decref(j->cases);
    json_decref(j->summary);
    json_decref(j->faults);
    json_decref(j->common);
    json_decref(j->impact);
    json_decref(j->suite);
}

/* Stores the evidence of a batch's cases. Called while the reference's trace of these cases still exists. */
static ost_status take_batch(void *user, const campaign *c, int first, int count, ost_error *err)
{
    job *j = user;
    ost_status status = OST_OK;
    for (int i = first; i < first + count && status == OST_OK; i++) {
        json_t *row;
        status = evidence_case(c, i, &row, err);
        if (status == OST_OK && json_array_append_new(j->cases, row) != 0)
            status = ost_fail(err, OST_ERR_MEMORY, "out of memory for the evidence");
    }
    return status == OST_OK && j->b ? pictures_of_operation(c, validate_into_bundle, j->b, err) : status;
}

static ost_status run_all(job *j, const validate_args *args, const plan *p, ost_error *err)
{
    picture_keeper keeper = {.sink = validate_into_bundle, .user = j->b};
    const campaign_options how = {.program = j->program,
                                  .jobs = (int)args->jobs,
                                  .limit_s = (double)args->limit_s,
                                  .apart = args->apart,
                                  .show = show,
                                  .differs = j->b ? pictures_of_difference : NULL,
                                  .keeper = &keeper,
                                  .done = take_batch,
                                  .done_keeper = j};
    ost_status status = campaign_run(p, &j->subjects, &how, &j->run, err);
    if (status == OST_OK && j->b && j->run.counts[CASE_DIFFERS]) {
        char folder[SCRATCH_PATH];
        status = scratch_make(folder, err);
        if (status == OST_OK)
            status = reproduce(&j->run, j->program, folder, show, NULL, validate_into_bundle, j->b, err);
        scratch_remove(folder);
    }
    if (status == OST_OK)
        status = evidence_results(&j->run, j->cases, err);
    /* In a sharded campaign, the first shard runs the sensitivity proof. */
    if (status == OST_OK && p->shard == 1 && !p->only && !p->file) {
        status = sensitivity_run(p->seed, sensitivity_injections(p->tier), j->run.jobs, show, NULL, &j->proof, err);
        if (status == OST_OK)
            status = faults_json(&j->proof, &j->faults, err);
    }
    if (status == OST_OK && keeper.err.status != OST_OK) {
        *err = keeper.err;
        status = err->status;
    }
    return status;
}

ost_status validate_run(app_state *app, const validate_args *args, const plan *p, json_t *from_file, ost_error *err)
{
    job j = {.cases = json_array()};
    ost_status status = worker_program(j.program, sizeof j.program, err);
    if (status == OST_OK && args->out)
        status = bundle_begin(args->out, &j.b, err);
    if (status == OST_OK)
        status = subjects_find(p->tier,
                               args->backends   ? args->backends
                               : args->cpu_only ? "cpu"
                                                : NULL,
                               &j.subjects, err);
    if (status == OST_OK)
        status = evidence_protocol(p, &j.subjects, args->backends ? args->backends : "", args->cpu_only, &j.protocol,
                                   err);
    if (status == OST_OK && from_file)
        json_object_set(j.protocol, "case", from_file);
    if (status == OST_OK && args->record)
        json_object_set(j.protocol, "user", args->record);
    if (status == OST_OK && args->suite)
        json_object_set_new(j.protocol, "suite", json_pack("{s:I}", "limit_s", (json_int_t)args->suite_limit_s));
    if (status == OST_OK && j.b)
        status = validate_freeze(j.b, j.protocol, err);
    if (status == OST_OK && j.b && from_file)
        status = bundle_put_json(j.b, "case.json", from_file, err);
    if (status == OST_OK) {
        status = run_all(&j, args, p, err);
        if (status == OST_OK)
            status = run_suite(args, j.run.jobs, &j.suite, err);
        progress_end();
    }
    if (status == OST_OK)
        status = common_check(p->seed, &j.common, err);
    if (status == OST_OK)
        status = evidence_summary(j.protocol, j.cases, &j.summary, err);
    if (status == OST_OK && j.suite)
        status = bundle_put_json(j.b, SUITE_FILE, j.suite, err);
    if (status == OST_OK && j.b)
        status = put_evidence(j.b, &j.run, j.protocol, j.cases, j.faults, j.common, j.summary, j.program, args->against,
                              &j.impact, err);
    if (status == OST_OK && j.b) {
        status = bundle_end(j.b, err);
        j.b = NULL;
        if (status == OST_OK)
            status = validate_sign(app, args, err);
    }
    if (status == OST_OK) {
        if (j.faults)
            put(app->result, "faults", json_incref(j.faults));
        put(app->result, "common_mistakes", json_incref(j.common));
        if (j.impact)
            validate_print_impact(app, args->against, j.impact);
        if (j.suite)
            put(app->result, "suite", json_incref(j.suite));
        status = validate_print(app, args, &j.run, j.summary, j.faults ? &j.proof : NULL, j.common, err);
        if (status == OST_OK && j.suite)
            status = validate_judge_suite(j.suite, err);
    }
    job_free(&j);
    return status;
}

ost_status validate_faults(app_state *app, const validate_args *args, ost_error *err)
{
    sensitivity s;
    json_t *faults;
    ost_status status = sensitivity_run(
        (uint64_t)args->seed, args->faults ? (uint64_t)args->faults : sensitivity_injections((plan_tier)args->tier),
        args->jobs ? (int)args->jobs : campaign_cores(), show, NULL, &s, err);
    progress_end();
    if (status == OST_OK)
        status = faults_json(&s, &faults, err);
    if (status != OST_OK)
        return status;
    put(app->result, "faults", faults);
    validate_print_faults(app, &s);
    return faults_proved(&s) ? OST_OK
                             : ost_fail(err, OST_ERR_DIFFER, "the sensitivity proof failed: %s",
                                        s.first_problem[0] ? s.first_problem : "no result was changed");
}
