/* SPDX-License-Identifier: Apache-2.0 */
/*
 * osteon validate: backends compared stage by stage, with evidence.
 *
 *   plan, subjects --protocol frozen--> campaign --> cases --> bundle, table, exit status
 *
 * The same verb with --worker is what it starts for each backend: cases on one
 * backend, and a trace of everything that was made.
 */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "app/options.h"
#include "app/progress.h"
#include "app/result.h"
#include "app/say.h"
#include "app/user_files.h"
#include "validation/bundle/bundle.h"
#include "validation/bundle/environment.h"
#include "validation/bundle/evidence.h"
#include "validation/bundle/faults.h"
#include "validation/bundle/merge.h"
#include "validation/bundle/record.h"
#include "validation/bundle/reproduce.h"
#include "validation/campaign.h"
#include "validation/dump.h"
#include "validation/export.h"
#include "validation/common/common.h"
#include "validation/locate/case_file.h"
#include "validation/scratch.h"
#include "validation/report/pictures.h"
#include "validation/report/report.h"

typedef struct validate_args {
    const char *out, *backends, *shard, *only, *merge, *worker, *trace, *given, *dump, *export_to, *case_file;
    int tier; /* place in "smoke|standard|full" */
    int64_t seed, from, to, limit_s, jobs;
    int64_t faults;
    bool cpu_only, faults_only, from_parent;
    user_files own;
    json_t *record; /* of them; NULL: there are none */
} validate_args;

/* Up to six digits; what is after them, or NULL. */
static const char *small_number(const char *at, int *out)
{
    const char *begin = at;
    for (*out = 0; *at >= '0' && *at <= '9' && at - begin < 6; at++)
        *out = 10 * *out + (*at - '0');
    return at > begin ? at : NULL;
}

/* "2/8" */
static ost_status shard_of(const app_state *app, const char *text, int *shard, int *shards, ost_error *err)
{
    *shard = *shards = 1;
    if (!text)
        return OST_OK;
    const char *at = small_number(text, shard);
    at = at && *at == '/' ? small_number(at + 1, shards) : NULL;
    if (!at || *at || *shard < 1 || *shard > *shards)
        return usage_error(app, err, "--shard %s: must be I/N with 1 <= I <= N", text);
    return OST_OK;
}

/* This program's own file, for workers. */
static ost_status own_file(char path[], size_t size, ost_error *err)
{
    const ssize_t n = readlink("/proc/self/exe", path, size - 1);
    if (n < 0)
        return ost_fail(err, OST_ERR_IO, "/proc/self/exe: %s", strerror(errno));
    path[n] = '\0';
    return OST_OK;
}

static void show(void *user, const char *what, double share)
{
    (void)user;
    progress_show(NULL, what, share);
}

/* ------------------------------------------------------------------- faults */

/* What was never triggered or never changed anything is named: a proof says what it is no proof of. */
static void say_faults(const app_state *app, const sensitivity *s)
{
    char a[SAY_TEXT], b[SAY_TEXT], c[SAY_TEXT];
    int silent = 0;
    say(app, "SENSITIVITY %s: %s mistakes made on purpose, %s changed a result, %s of them were found, %llu not where they are; %llu false alarms in %llu right runs",
        faults_proved(s) ? "PROVED" : "NOT PROVED", say_count(a, (int64_t)s->all.injected), say_count(b, (int64_t)s->all.changed),
        say_count(c, (int64_t)(s->all.changed - s->all.not_detected)), (unsigned long long)s->all.not_located, (unsigned long long)s->false_alarms,
        (unsigned long long)s->clean_runs);
    if (s->first_problem[0])
        say(app, "  %s", s->first_problem);
    for (int k = DEVIATION_NONE + 1; k < DEVIATION_KINDS; k++)
        silent += !s->of[k].changed;
    if (silent)
        say(app, "  %d of %d kinds changed nothing in this run; sensitivity.json and --json say which, and when a kind survives", silent, DEVIATION_KINDS - 1);
}

/* ------------------------------------------------------------------ results */

static const case_result *result_at(const campaign *c, int i, int s)
{
    return &c->results[(size_t)i * (size_t)c->subjects->count + (size_t)s];
}

static void say_difference(const app_state *app, const plan_case *c, const subject *s, const case_result *r)
{
    const compare_difference *d = &r->difference;
    char where[64] = "", name[TRACE_WORD];
    if (d->stage == TRACE_TICK || d->stage == TRACE_COLLIDE || d->stage == TRACE_TOOL)
        snprintf(where, sizeof where, " %u", d->item);
    if (r->verdict != CASE_DIFFERS)
        say(app, "  %s on %s: %s: %s", c->id, s->spec, case_verdict_name(r->verdict), r->text);
    else if (d->kind == COMPARE_VOXEL)
        say(app, "  %s on %s: %s%s: %llu voxel%s, the first at (%d, %d, %d): %d, the reference has %d", c->id, s->spec,
            trace_stage_name(d->stage), where, (unsigned long long)d->voxels, d->voxels == 1 ? "" : "s", d->voxel[0], d->voxel[1], d->voxel[2],
            d->voxel_got, d->voxel_ref);
    else if (d->kind == COMPARE_WORD)
        say(app, "  %s on %s: %s%s: %s is %lld, the reference has %lld", c->id, s->spec, trace_stage_name(d->stage), where,
            trace_word_name(d->stage, d->word, d->line_words, name), (long long)d->word_got, (long long)d->word_ref);
    else
        say(app, "  %s on %s: %s%s: %s", c->id, s->spec, trace_stage_name(d->stage), where,
            d->kind == COMPARE_MISSING ? "the backend failed there, the reference did not" : "its blocks are not those of the reference");
    if (r->verdict == CASE_DIFFERS && r->found && r->found->class)
        say(app, "    looks like %s: %s", r->found->class, r->found->text);
    if (r->verdict == CASE_DIFFERS && r->found && r->found->reproduce[0])
        say(app, "    made small: %s: osteon validate --case BUNDLE/%s --backends '%s'%s", r->found->small, r->found->reproduce, s->spec,
            c->family == PLAN_USER ? " and the files that you gave" : "");
}

static void say_backends(app_state *app, const campaign *c)
{
    json_t *array = json_array();
    char time[SAY_TEXT];
    for (int s = 0; s < c->subjects->count; s++) {
        const subject *one = &c->subjects->subjects[s];
        int equal = 0, refused = 0;
        for (int i = 0; i < c->plan->count; i++) {
            const bool shown = result_at(c, i, 0)->verdict == CASE_EQUAL, same = result_at(c, i, s)->verdict == CASE_EQUAL;
            equal += same && shown;
            refused += s > 0 && same && !shown;
        }
        json_t *o = json_object();
        put_text(o, "name", one->spec);
        put_text(o, "what", one->what);
        put_bool(o, "available", one->available);
        if (!one->available)
            put_text(o, "reason", one->reason);
        put_integer(o, "equal", one->available ? equal : 0);
        put_real(o, "time_s", c->seconds[s]);
        append(array, o);
        if (!one->available)
            say(app, "  %-32s not run: %s", one->spec, one->reason);
        else if (s == 0)
            say(app, "  %-32s the reference, %s", one->spec, say_time(time, 1e3 * c->seconds[s]));
        else
            say(app, "  %-32s %d of %d equal%s, %s", one->spec, equal, c->plan->count, refused ? ", others refused as by the reference" : "",
                say_time(time, 1e3 * c->seconds[s]));
    }
    put(app->result, "backends", array);
}

static json_t *stages_of(const campaign *c)
{
    json_t *stages = json_array();
    for (int i = TRACE_RECT; i <= TRACE_FINAL; i++) {
        json_t *o = json_object();
        put_text(o, "name", trace_stage_name((trace_stage)i));
        put_integer(o, "records", (int64_t)c->stage_records[i]);
        append(stages, o);
    }
    return stages;
}

/* The last lines: what checks it, the verdict, the picture, the report. */
static void say_last(app_state *app, const char *out, const json_t *summary)
{
    char path[1200];
    struct stat info;
    snprintf(path, sizeof path, "%s/%s", out, PICTURE_AFTER);
    const bool picture = stat(path, &info) == 0;
    say(app, "  check it   osteon verify %s", out);
    say(app, "  verdict    %s%s", evidence_text(summary, "verdict"),
        json_is_true(json_object_get(summary, "evidence")) ? "" : " (a reduced run: no evidence)");
    if (picture) {
        say(app, "  picture    %s", path);
        put_text(app->result, "picture", path);
    }
    snprintf(path, sizeof path, "%s/%s", out, REPORT_FILE);
    say(app, "  report     %s", path);
    put_text(app->result, "report", path);
}

/* Not a difference: there was nothing to differ. */
static ost_status nothing_compared(ost_error *err)
{
    return ost_fail(err, OST_ERR_UNAVAILABLE, "nothing was compared: no backend but the reference ran a case that the reference did not refuse");
}

/* Only what the summary does not have: the rest of --json is the bundle's own. */
static ost_status report(app_state *app, const validate_args *args, const campaign *c, json_t *summary, const sensitivity *proof, const json_t *common,
                         ost_error *err)
{
    char records[SAY_TEXT], bytes[SAY_TEXT];
    const json_t *list = json_object_get(summary, "not_shown");
    json_object_update(app->result, summary);
    put_text(app->result, "tier", plan_tier_name(c->plan->tier));
    put_integer(app->result, "seed", (int64_t)c->plan->seed);
    put_integer(app->result, "bytes_equal", (int64_t)c->bytes);
    put(app->result, "stages", stages_of(c));
    if (args->out)
        put_text(app->result, "out", args->out);
    const bool equal = json_is_true(json_object_get(summary, "equal")), something = json_integer_value(json_object_get(summary, "compared")) > 0;
    say(app, "%s: %d case%s on %d backend%s, tier %s, seed %llu%s", evidence_text(summary, "verdict"), c->plan->count, c->plan->count == 1 ? "" : "s",
        c->subjects->count, c->subjects->count == 1 ? "" : "s", plan_tier_name(c->plan->tier), (unsigned long long)c->plan->seed,
        json_is_true(json_object_get(summary, "evidence")) ? "" : " (a reduced run: no evidence)");
    say_backends(app, c);
    for (int i = 0; i < c->plan->count; i++)
        for (int s = 1; s < c->subjects->count; s++)
            if (result_at(c, i, s)->verdict != CASE_EQUAL && result_at(c, i, s)->verdict != CASE_NOT_RUN)
                say_difference(app, &c->plan->cases[i], &c->subjects->subjects[s], result_at(c, i, s));
    say(app, equal ? "  %s records, %s of results, compared byte by byte and found equal" : "  %s records compared byte by byte; the cases that are equal: %s of results",
        say_count(records, (int64_t)c->records), say_bytes(bytes, (int64_t)c->bytes));
    for (size_t i = 0; i < json_array_size(list); i++)
        say(app, "%s%s", i ? "             " : "  not shown: ", json_string_value(json_array_get(list, i)));
    say(app, "COMMON MISTAKES %s: %lld of %lld checks by hand, by volume and by law passed on the reference", common_proved(common) ? "NONE FOUND" : "FOUND",
        (long long)json_integer_value(json_object_get(common, "passed")), (long long)json_array_size(json_object_get(common, "checks")));
    if (proof)
        say_faults(app, proof);
    if (args->out)
        say_last(app, args->out, summary);
    if (!something)
        return nothing_compared(err);
    if (!equal)
        return ost_fail(err, OST_ERR_DIFFER, "%d results differ from the reference's, %d failed, %d crashed, %d took too long",
                        c->counts[CASE_DIFFERS], c->counts[CASE_FAILED], c->counts[CASE_CRASHED], c->counts[CASE_LATE]);
    if (proof && !faults_proved(proof))
        return ost_fail(err, OST_ERR_DIFFER, "the sensitivity proof failed: %s", proof->first_problem[0] ? proof->first_problem : "nothing was changed");
    if (!common_proved(common))
        return ost_fail(err, OST_ERR_DIFFER, "%lld of the checks of common mistakes failed; common.json and the report say which",
                        (long long)json_integer_value(json_object_get(common, "failed")));
    if (!c->subjects->opencl && !args->cpu_only && !args->backends)
        return ost_fail(err, OST_ERR_UNAVAILABLE, "OpenCL was not compared: %s; --cpu-only says that this is meant", c->subjects->no_opencl);
    return OST_OK;
}

/* ---------------------------------------------------------------------- run */

static ost_status into_bundle(void *user, const char *name, const void *bytes, size_t size, ost_error *err)
{
    return bundle_put(user, name, bytes, size, err);
}

/* The protocol and its hash are written before anything runs. */
static ost_status freeze(bundle *b, const json_t *protocol, ost_error *err)
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

static ost_status put_machine(bundle *b, const campaign *c, const char *program, ost_error *err)
{
    json_t *machine, *times = json_object();
    for (int s = 0; s < c->subjects->count; s++)
        put_real(times, c->subjects->subjects[s].spec, c->seconds[s]);
    ost_status status = environment_of(program, &machine, err);
    if (status == OST_OK)
        status = bundle_put_json(b, "environment.json", machine, err);
    if (status == OST_OK)
        status = bundle_put_json(b, "times.json", times, err);
    json_decref(times);
    json_decref(machine);
    return status;
}

static ost_status put_evidence(bundle *b, const campaign *c, const json_t *protocol, const json_t *cases, const json_t *faults, const json_t *common,
                               const char *program, ost_error *err)
{
    ost_status status = bundle_log(b, "results", err, "%d equal, %d differ, %d failed, %d crashed, %d timed out, %d not run", c->counts[CASE_EQUAL],
                                   c->counts[CASE_DIFFERS], c->counts[CASE_FAILED], c->counts[CASE_CRASHED], c->counts[CASE_LATE], c->counts[CASE_NOT_RUN]);
    if (status == OST_OK)
        status = evidence_write(protocol, cases, into_bundle, b, err);
    if (status == OST_OK && faults)
        status = bundle_put_json(b, FAULTS_FILE, faults, err);
    if (status == OST_OK)
        status = record_put(program, c->subjects, common, into_bundle, b, err);
    if (status == OST_OK)
        status = record_derive(bundle_folder(b), cases, into_bundle, b, err);
    if (status == OST_OK)
        status = put_machine(b, c, program, err);
    if (status == OST_OK)
        status = report_write(bundle_folder(b), protocol, cases, into_bundle, b, err);
    if (status == OST_OK)
        status = bundle_log(b, "ended", err, "files written");
    return status;
}

/* Everything that must be freed, in one place. */
typedef struct job {
    char program[1024];
    subject_list subjects;
    campaign run;
    bundle *b;
    json_t *protocol, *cases, *summary, *faults, *common;
    sensitivity proof; /* where faults is not NULL */
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
}

/* A batch's cases, while the reference's trace of them is there. */
static ost_status take_batch(void *user, const campaign *c, int first, int count, ost_error *err)
{
    job *j = user;
    ost_status status = OST_OK;
    for (int i = first; i < first + count && status == OST_OK; i++) {
        json_t *row;
        status = evidence_case(c, i, &row, err);
        if (status == OST_OK && json_array_append_new(j->cases, row) != 0)
            status = ost_fail(err, OST_ERR_MEMORY, "no memory for the evidence");
    }
    return status == OST_OK && j->b ? pictures_of_operation(c, into_bundle, j->b, err) : status;
}

static ost_status run_all(job *j, const validate_args *args, const plan *p, ost_error *err)
{
    picture_keeper keeper = {.sink = into_bundle, .user = j->b};
    const campaign_options how = {.program = j->program, .jobs = (int)args->jobs, .limit_s = (double)args->limit_s, .show = show,
                                  .differs = j->b ? pictures_of_difference : NULL, .keeper = &keeper, .done = take_batch, .done_keeper = j};
    ost_status status = campaign_run(p, &j->subjects, &how, &j->run, err);
    if (status == OST_OK && j->b && j->run.counts[CASE_DIFFERS]) {
        char folder[SCRATCH_PATH];
        status = scratch_make(folder, err);
        if (status == OST_OK)
            status = reproduce(&j->run, j->program, folder, show, NULL, into_bundle, j->b, err);
        scratch_remove(folder);
    }
    if (status == OST_OK)
        status = evidence_results(&j->run, j->cases, err);
    /* The first of several shards makes it for all. */
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

static ost_status compare_all(app_state *app, const validate_args *args, const plan *p, json_t *from_file, ost_error *err)
{
    job j = {.cases = json_array()};
    ost_status status = own_file(j.program, sizeof j.program, err);
    if (status == OST_OK && args->out)
        status = bundle_begin(args->out, &j.b, err);
    if (status == OST_OK)
        status = subjects_find(p->tier, args->backends ? args->backends : args->cpu_only ? "cpu" : NULL, &j.subjects, err);
    if (status == OST_OK)
        status = evidence_protocol(p, &j.subjects, args->backends ? args->backends : "", args->cpu_only, &j.protocol, err);
    if (status == OST_OK && from_file)
        json_object_set(j.protocol, "case", from_file);
    if (status == OST_OK && args->record)
        json_object_set(j.protocol, "user", args->record);
    if (status == OST_OK && j.b)
        status = freeze(j.b, j.protocol, err);
    if (status == OST_OK && j.b && from_file)
        status = bundle_put_json(j.b, "case.json", from_file, err);
    if (status == OST_OK) {
        progress_begin(app);
        status = run_all(&j, args, p, err);
        progress_clear();
    }
    if (status == OST_OK)
        status = common_check(p->seed, &j.common, err);
    if (status == OST_OK)
        status = evidence_summary(j.protocol, j.cases, &j.summary, err);
    if (status == OST_OK && j.b)
        status = put_evidence(j.b, &j.run, j.protocol, j.cases, j.faults, j.common, j.program, err);
    if (status == OST_OK && j.b) {
        status = bundle_end(j.b, err);
        j.b = NULL;
    }
    if (status == OST_OK) {
        if (j.faults)
            put(app->result, "faults", json_incref(j.faults));
        put(app->result, "common_mistakes", json_incref(j.common));
        status = report(app, args, &j.run, j.summary, j.faults ? &j.proof : NULL, j.common, err);
    }
    job_free(&j);
    return status;
}

/* Shards to a whole: nothing runs. */
static ost_status merge_all(app_state *app, const validate_args *args, ost_error *err)
{
    merged m;
    bundle *b = NULL;
    json_t *summary = NULL;
    ost_status status = merge_read(args->merge, &m, err);
    if (status != OST_OK)
        return status;
    status = bundle_begin(args->out, &b, err);
    if (status == OST_OK)
        status = freeze(b, m.protocol, err);
    if (status == OST_OK)
        status = bundle_log(b, "merged", err, "%d shards of %s, their machines in environment.json", m.shards, args->merge);
    if (status == OST_OK)
        status = bundle_log(b, "results", err, "%zu cases", json_array_size(m.cases));
    if (status == OST_OK)
        status = evidence_write(m.protocol, m.cases, into_bundle, b, err);
    if (status == OST_OK)
        status = bundle_put_json(b, "environment.json", m.environment, err);
    if (status == OST_OK)
        status = bundle_put_json(b, "times.json", m.times, err);
    if (status == OST_OK && m.faults)
        status = bundle_put_json(b, FAULTS_FILE, m.faults, err);
    if (status == OST_OK)
        status = record_merge(args->merge, into_bundle, b, err);
    if (status == OST_OK)
        status = record_derive(bundle_folder(b), m.cases, into_bundle, b, err);
    if (status == OST_OK)
        status = pictures_of_shards(args->merge, m.protocol, m.cases, into_bundle, b, err);
    if (status == OST_OK)
        status = report_write(bundle_folder(b), m.protocol, m.cases, into_bundle, b, err);
    if (status == OST_OK)
        status = evidence_summary(m.protocol, m.cases, &summary, err);
    if (status == OST_OK) {
        status = bundle_end(b, err);
        b = NULL;
    }
    if (status == OST_OK) {
        const bool equal = json_is_true(json_object_get(summary, "equal"));
        json_object_update(app->result, summary);
        put_text(app->result, "out", args->out);
        put_integer(app->result, "shards", m.shards);
        say(app, "%s: %zu case%s from %d shard%s", evidence_text(summary, "verdict"), json_array_size(m.cases), json_array_size(m.cases) == 1 ? "" : "s", m.shards,
            m.shards == 1 ? "" : "s");
        say_last(app, args->out, summary);
        if (!json_integer_value(json_object_get(summary, "compared")))
            status = nothing_compared(err);
        else if (!equal)
            status = ost_fail(err, OST_ERR_DIFFER, "%s: results differ from the reference's; see anomalies.csv", args->out);
    }
    bundle_abandon(b);
    json_decref(summary);
    merge_free(&m);
    return status;
}

static ost_status prove_faults(app_state *app, const validate_args *args, ost_error *err)
{
    sensitivity s;
    json_t *faults;
    progress_begin(app);
    ost_status status = sensitivity_run((uint64_t)args->seed, args->faults ? (uint64_t)args->faults : sensitivity_injections((plan_tier)args->tier),
                                        args->jobs ? (int)args->jobs : campaign_cores(), show, NULL, &s, err);
    progress_clear();
    if (status == OST_OK)
        status = faults_json(&s, &faults, err);
    if (status != OST_OK)
        return status;
    put(app->result, "faults", faults);
    say_faults(app, &s);
    return faults_proved(&s) ? OST_OK : ost_fail(err, OST_ERR_DIFFER, "the sensitivity proof failed: %s", s.first_problem[0] ? s.first_problem : "nothing was changed");
}

/* One backend's results as files, by way of a trace. */
static ost_status dump_worker(const plan *p, const char *spec, const char *folder, ost_error *err)
{
    char path[SCRATCH_NAME];
    trace t = {0};
    int fd;
    ost_status status = scratch_file(&fd, err);
    if (status != OST_OK)
        return status;
    scratch_name(fd, path);
    status = worker_run(p, 0, p->count, spec, path, NULL, err);
    if (status == OST_OK)
        status = trace_open(path, &t, err);
    if (status == OST_OK)
        status = dump_write(folder, spec, p, &t, err);
    trace_free(&t);
    close(fd);
    return status;
}

/* The user's own cases, read before anything else is done. */
static ost_status own_files(const app_state *app, validate_args *args, int argc, char **argv, user_store **store, ost_error *err)
{
    json_t *how = user_files_how(argc, argv);
    ost_status status = OST_OK;
    if (user_files_given(&args->own))
        status = user_files_read(app, &args->own, how, store, &args->record, err);
    else if (json_array_size(how))
        status = usage_error(app, err, "%s is for files of your own: give them with --ct, --tool and --path", json_string_value(json_array_get(how, 0)));
    json_decref(how);
    return status;
}

ost_status cmd_validate(app_state *app, int argc, char **argv, ost_error *err)
{
    static const int64_t limits[PLAN_TIERS] = {120, 1800, 36000};
    enum { LIMIT_OWN = 36000 }; /* nobody knows how long the user's own cases take */
    validate_args args = {.seed = 1, .own = USER_FILES_DEFAULT};
    const option options[] = {
        {.name = "out", .kind = OPTION_TEXT, .out = &args.out, .value = "BUNDLE", .help = "a folder for the evidence; must not exist"},
        {.name = "tier", .kind = OPTION_CHOICE, .out = &args.tier, .value = "smoke|standard|full",
         .help = "how much (default: smoke, under a minute;\nstandard: under 15 minutes; full: hours)"},
        {.name = "backends", .kind = OPTION_TEXT, .out = &args.backends, .value = "A;B",
         .help = "these alone, besides the reference (default: all that are here)"},
        {.name = "cpu-only", .kind = OPTION_FLAG, .out = &args.cpu_only, .help = "the CPU's variants alone: no OpenCL is no failure"},
        {.name = "faults-only", .kind = OPTION_FLAG, .out = &args.faults_only, .help = "the sensitivity proof alone: mistakes made on purpose"},
        {.name = "faults", .kind = OPTION_INTEGER, .out = &args.faults, .value = "N", .min = 1, .max = 100000000, .help = "how many, with --faults-only (default: the tier's)"},
        {.name = "seed", .kind = OPTION_INTEGER, .out = &args.seed, .value = "N", .min = 1, .max = INT64_MAX, .help = "of the generated cases (default: 1)"},
        USER_FILES(args.own, "a CT of your own: a case with all tools and paths; may repeat", "a mesh of your own, or builtin:reamer; may repeat",
                   "a CSV, builtin:peg-hole or builtin:glenoid-ream, as for ream; may repeat"),
        {.name = "shard", .kind = OPTION_TEXT, .out = &args.shard, .value = "I/N", .help = "every N-th case alone, from the I-th on"},
        {.name = "only", .kind = OPTION_TEXT, .out = &args.only, .value = "CASE", .help = "cases whose name begins so: mesh, session/1"},
        {.name = "case", .kind = OPTION_TEXT, .out = &args.case_file, .value = "FILE", .help = "the cases of this file alone, as a bundle's cases/ has them"},
        {.name = "merge", .kind = OPTION_TEXT, .out = &args.merge, .value = "FOLDER", .help = "put the shards' bundles in FOLDER together into --out; runs nothing"},
        {.name = "limit", .kind = OPTION_INTEGER, .out = &args.limit_s, .value = "S", .min = 1, .max = 1000000,
         .help = "seconds after which a backend is stopped"},
        {.name = "jobs", .kind = OPTION_INTEGER, .out = &args.jobs, .value = "N", .min = 1, .max = WORKERS_MAX,
         .help = "backends that run at a time (default: as many as cores)"},
        {.name = "worker", .kind = OPTION_TEXT, .out = &args.worker, .value = "BACKEND", .help = "run the cases on this backend alone, write --trace and compare nothing"},
        {.name = "trace", .kind = OPTION_TEXT, .out = &args.trace, .value = "FILE", .help = "where --worker writes what the backend made"},
        {.name = "given", .kind = OPTION_TEXT, .out = &args.given, .value = "FILE", .help = "the reference's trace, whose grids every stage of --worker gets (osteon compare --apart)"},
        {.name = "dump", .kind = OPTION_TEXT, .out = &args.dump, .value = "FOLDER", .help = "write what --worker made as a dump, for osteon compare; needs no --trace"},
        {.name = "export-cases", .kind = OPTION_TEXT, .out = &args.export_to, .value = "FOLDER",
         .help = "write the cases' inputs as files, for another program to run; runs nothing"},
        {.name = "user", .kind = OPTION_FLAG, .out = &args.from_parent, .help = "--worker has the cases of --ct, --tool and --path from who started it"},
        {.name = "from", .kind = OPTION_INTEGER, .out = &args.from, .value = "N", .min = 0, .max = 1000000, .help = "first case of --worker, from 0"},
        {.name = "to", .kind = OPTION_INTEGER, .out = &args.to, .value = "N", .min = 0, .max = 1000000, .help = "the case before which --worker ends (default: none)"},
        USER_FILES_HOW(args.own),
        {.name = NULL}};
    const usage_text usage = {
        .synopsis = "[--tier TIER] [--ct FILE] [--tool FILE] [--path FILE] [options]",
        .about = "Runs generated cases, and those of your own files, on every backend, each in its\n"
                 "own process, and compares every stage with the scalar reference, byte by byte.",

        .options = options,
        .notes = "Cases of your own files are user/1, user/2, ... behind the tier's; --only user runs\n"
                 "them alone. Options from --spacing on say how the files are read, as import,\n"
                 "voxelize and ream have them. The bundle has the files' sizes and SHA-256, not\n"
                 "their names or content.\n\n"
                 "This is backend equivalence verification (code verification): that all backends\n"
                 "compute the same. It is no clinical validation.",
        .example = "  osteon validate --out bundle\n  osteon validate --tier standard --cpu-only --json\n"
                   "  osteon validate --backends 'cpu:isa=avx2,threads=7;cl' --only session\n"
                   "  osteon validate --ct shoulder.nii.gz --tool reamer.stl --path motion.csv --out bundle\n"
                   "  osteon validate --tier full --shard 2/8 --out shards/2\n"
                   "  osteon validate --merge shards --out bundle",
    };
    ost_status status;
    plan p;
    int shard, shards;
    if (!options_parse(app, &usage, argc, argv, &status, err) || (status = shard_of(app, args.shard, &shard, &shards, err)) != OST_OK)
        return status;
    if (!args.worker != !(args.trace || args.dump) || (args.trace && args.dump))
        return usage_error(app, err, "--worker and one of --trace and --dump belong together");
    if (args.given && !args.trace)
        return usage_error(app, err, "--given belongs to --worker and --trace");
    if (args.export_to && (args.worker || args.out))
        return usage_error(app, err, "--export-cases runs nothing: no --worker and no --out");
    if (args.merge && (!args.out || args.worker || args.shard))
        return usage_error(app, err, "--merge needs --out and no shard or worker");
    if ((args.merge || args.faults_only) && user_files_given(&args.own))
        return usage_error(app, err, "%s reads no files of your own: no --ct, --tool and --path with it", args.merge ? "--merge" : "--faults-only");
    if (args.merge)
        return merge_all(app, &args, err);
    if (args.faults_only)
        return prove_faults(app, &args, err);
    if (args.case_file && !args.worker && (args.only || args.shard))
        return usage_error(app, err, "--case says which cases: no --only and no --shard with it");
    user_store *store = NULL;
    json_t *from_file = NULL;
    status = args.from_parent ? user_store_open(WORKER_USER, &store, err) : own_files(app, &args, argc, argv, &store, err);
    const plan_user own = {.count = user_store_count(store), .store = store};
    if (!args.limit_s)
        args.limit_s = own.count ? LIMIT_OWN : limits[args.tier];
    if (status == OST_OK)
        status = args.case_file ? case_file_read(args.case_file, own.count ? &own : NULL, &p, &from_file, err)
                                : plan_make((plan_tier)args.tier, (uint64_t)args.seed, shard, shards, args.only, &own, &p, err);
    if (status != OST_OK) {
        json_decref(args.record);
        user_store_free(store);
        return status;
    }
    status = args.export_to ? export_cases(args.export_to, &p, err)
             : args.dump    ? dump_worker(&p, args.worker, args.dump, err)
             : args.worker  ? worker_run(&p, (int)args.from, args.to ? (int)args.to : p.count, args.worker, args.trace, args.given, err)
                            : compare_all(app, &args, &p, from_file, err);
    if (status == OST_OK && args.export_to) {
        say(app, "%s: inputs of %d case%s", args.export_to, p.count, p.count == 1 ? "" : "s");
        put_text(app->result, "out", args.export_to);
        put_integer(app->result, "cases", p.count);
    }
    plan_free(&p);
    json_decref(from_file);
    json_decref(args.record);
    user_store_free(store);
    return status;
}
