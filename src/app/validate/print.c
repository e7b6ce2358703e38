/* SPDX-License-Identifier: Apache-2.0 */
/* Prints the results of `osteon validate` and determines its exit status. */
#include "app/validate/validate.h"

#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

#include "app/common/result.h"
#include "app/common/print.h"
#include "validation/bundle/evidence.h"
#include "validation/bundle/impact.h"
#include "validation/bundle/faults.h"
#include "validation/bundle/suite.h"
#include "validation/common/common.h"
#include "validation/locate/causes.h"
#include "validation/report/pictures.h"
#include "validation/report/report.h"

void validate_print_faults(const app_state *app, const sensitivity *s)
{
    char a[FORMAT_TEXT], b[FORMAT_TEXT], c[FORMAT_TEXT], statement[FAULTS_STATEMENT];
    faults_statement(s, statement);
    print_line(app, "SENSITIVITY%s: %s", faults_proved(s) ? "" : " NOT PROVED", statement);
    print_line(app,
               "  %s mistakes were made; %s changed a result, of which %s were detected and %llu were located wrongly; "
               "%llu false alarms in %llu runs without a mistake",
               format_count(a, (int64_t)s->all.injected), format_count(b, (int64_t)s->all.changed),
               format_count(c, (int64_t)(s->all.changed - s->all.not_detected)), (unsigned long long)s->all.not_located,
               (unsigned long long)s->false_alarms, (unsigned long long)s->clean_runs);
    if (s->first_problem[0])
        print_line(app, "  %s", s->first_problem);
    for (int k = DEVIATION_NONE + 1; k < DEVIATION_KINDS; k++)
        if (!s->of[k].changed)
            print_line(app, "  %s changed nothing; such a mistake has no effect when %s",
                       deviation_describe((deviation_kind)k)->name, deviation_describe((deviation_kind)k)->survives);
}

static const case_result *result_at(const campaign *c, int i, int s)
{
    return &c->results[(size_t)i * (size_t)c->subjects->count + (size_t)s];
}

void validate_print_difference(const app_state *app, const plan_case *c, const subject *s, const case_result *r)
{
    const compare_difference *d = &r->difference;
    char where[64] = "", name[TRACE_WORD];
    if (d->stage == TRACE_TICK || d->stage == TRACE_COLLIDE || d->stage == TRACE_TOOL || d->stage == TRACE_SNAP ||
        d->stage == TRACE_STEPS)
        snprintf(where, sizeof where, " %u", d->item);
    if (r->verdict != CASE_DIFFERS)
        print_line(app, "  %s on %s: %s: %s", c->id, s->spec, case_verdict_name(r->verdict), r->text);
    else if (d->kind == COMPARE_VOXEL)
        print_line(app, "  %s on %s: %s%s: %llu voxel%s, the first at (%d, %d, %d): %d, the reference has %d", c->id,
                   s->spec, trace_stage_name(d->stage), where, (unsigned long long)d->voxels, d->voxels == 1 ? "" : "s",
                   d->voxel[0], d->voxel[1], d->voxel[2], d->voxel_got, d->voxel_ref);
    else if (d->kind == COMPARE_WORD)
        print_line(app, "  %s on %s: %s%s: %s is %lld, the reference has %lld", c->id, s->spec,
                   trace_stage_name(d->stage), where, trace_word_name(d->stage, d->word, d->line_words, name),
                   (long long)d->word_got, (long long)d->word_ref);
    else
        print_line(app, "  %s on %s: %s%s: %s", c->id, s->spec, trace_stage_name(d->stage), where,
                   d->kind == COMPARE_MISSING ? "the backend failed there, the reference did not"
                                              : "its blocks differ from those of the reference");
    if (r->verdict == CASE_DIFFERS && r->found && r->found->class)
    {
        char hint[CAUSES_TEXT];
        causes_text(r->found->class, hint);
        if (r->found->chunk_size)
            print_line(app, "    in chunk (%d, %d, %d) of %d^3", r->found->chunk[0], r->found->chunk[1],
                       r->found->chunk[2], r->found->chunk_size);
        print_line(app, "    class %s: %s", r->found->class, r->found->text);
        if (*hint)
            print_line(app, "    %s", hint);
    }
    if (r->verdict == CASE_DIFFERS && strcmp(s->spec, SUBJECT_DENSE) == 0)
        print_line(app,
                   "    the cause is in the core (src/core, src/sim), which every backend shares, or in the second "
                   "implementation of it");
    if (r->verdict == CASE_DIFFERS && r->found && r->found->reproduce[0])
        print_line(app, "    reduced to %s: osteon validate --case BUNDLE/%s --backends '%s'%s", r->found->small,
                   r->found->reproduce, s->spec, c->family == PLAN_USER ? " and the same files" : "");
}

/*
 * Stores the code paths that the workers of a backend entered, and those that they did not enter. Prints only those
 * that were not entered.
 */
static void print_paths(const app_state *app, const path_list *list, json_t *o)
{
    json_t *entered, *missing;
    char line[1024] = "";
    size_t used = 0;
    if (!list->count)
        return;
    paths_json(list, &entered, &missing);
    for (size_t i = 0; i < json_array_size(missing) && used < sizeof line; i++)
        used += (size_t)snprintf(line + used, sizeof line - used, "%s%s", i ? ", " : "",
                                 json_string_value(json_array_get(missing, i)));
    if (used)
        print_line(app, "  %-32s not entered: %s%s", "", line, used < sizeof line ? "" : " ...");
    put(o, "entered", entered);
    put(o, "not_entered", missing);
}

/* Prints the result of the second implementation, which checks steps that are not covered by any other comparison. */
static void print_second(const app_state *app, const campaign *c, bool equal)
{
    char ticks[FORMAT_TEXT], tools[FORMAT_TEXT];
    print_line(app,
               "    sweep, map, boxes, poses and snapping of src/core, compared with a second implementation: %s, %s "
               "ticks, %s tools",
               equal ? "equal" : "NOT equal", format_count(ticks, (int64_t)c->stage_records[TRACE_STEPS]),
               format_count(tools, (int64_t)c->stage_records[TRACE_SNAP]));
}

/*
 * Prints whether the plugin itself or src/core computed the steps that precede the work on voxels (snapping, sweep,
 * map, boxes, poses).
 */
static void print_made(const app_state *app, const campaign *c, int s)
{
    uint64_t made = 0;
    for (int i = 0; i < c->plan->count; i++)
        made += result_at(c, i, s)->own_steps;
    if (made)
        print_line(app, "    computed by the backend itself and compared: %llu records of stages snap and steps",
                   (unsigned long long)made);
    else
        print_line(app, "    supplied by src/core and not compared: sweep, map, boxes, poses and snapping");
}

static void print_backends(app_state *app, const campaign *c)
{
    json_t *array = json_array();
    char time[FORMAT_TEXT];
    for (int s = 0; s < c->subjects->count; s++) {
        const subject *one = &c->subjects->subjects[s];
        int equal = 0, refused = 0;
        for (int i = 0; i < c->plan->count; i++) {
            const bool shown = result_at(c, i, 0)->verdict == CASE_EQUAL,
                       same = result_at(c, i, s)->verdict == CASE_EQUAL;
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
            print_line(app, "  %-32s not run: %s", one->spec, one->reason);
        else if (s == 0)
            print_line(app, "  %-32s the reference, %s", one->spec, format_time(time, 1e3 * c->seconds[s]));
        else
            print_line(app, "  %-32s %d of %d equal%s, %s", one->spec, equal, c->plan->count,
                       refused ? "; the others were refused as by the reference" : "",
                       format_time(time, 1e3 * c->seconds[s]));
        print_paths(app, &c->paths[s], o);
        if (s > 0 && one->available && strcmp(one->spec, SUBJECT_DENSE) == 0)
            print_second(app, c, equal + refused == c->plan->count);
        if (one->available &&
            (strncmp(one->spec, "plugin:", 7) == 0 || strncmp(one->spec, SUBJECT_DUMP, strlen(SUBJECT_DUMP)) == 0))
            print_made(app, c, s);
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

void validate_print_last(app_state *app, const char *out, const json_t *summary)
{
    char path[1200];
    struct stat info;
    snprintf(path, sizeof path, "%s/%s", out, PICTURE_AFTER);
    const bool picture = stat(path, &info) == 0;
    print_line(app, "  verify     osteon verify %s", out);
    print_line(app, "  verdict    %s%s%s", evidence_text(summary, "verdict"),
               json_is_true(json_object_get(summary, "evidence")) ? "" : " (a reduced run: no evidence)",
               json_integer_value(json_object_get(json_object_get(app->result, "suite"), "failed"))
                   ? "; the test suite FAILED"
                   : "");
    if (picture) {
        print_line(app, "  picture    %s", path);
        put_text(app->result, "picture", path);
    }
    snprintf(path, sizeof path, "%s/%s", out, REPORT_FILE);
    print_line(app, "  report     %s", path);
    put_text(app->result, "report", path);
}

/* Prints up to three rows of a list, and the number of the remaining rows. */
static void print_changes(const app_state *app, const json_t *list, const char *what)
{
    enum { SHOWN = 3 };
    for (size_t i = 0; i < json_array_size(list) && i < SHOWN; i++) {
        const json_t *one = json_array_get(list, i);
        print_line(app, "    %s %s: %.100s, was %.100s", what, evidence_text(one, "what"),
                   *evidence_text(one, "new") ? evidence_text(one, "new") : "none",
                   *evidence_text(one, "old") ? evidence_text(one, "old") : "none");
    }
    if (json_array_size(list) > SHOWN)
        print_line(app, "    and %zu more of %s, see " IMPACT_FILE, json_array_size(list) - SHOWN, what);
}

void validate_print_impact(app_state *app, const char *against, json_t *impact)
{
    const json_t *results = json_object_get(impact, "results");
    print_line(app, "AGAINST %s: %s", against, evidence_text(impact, "conclusion"));
    print_line(app, "  %lld case%s compared, %lld different, %zu not compared; %zu verdict%s of backends changed",
               (long long)json_integer_value(json_object_get(results, "compared")),
               json_integer_value(json_object_get(results, "compared")) == 1 ? "" : "s",
               (long long)json_integer_value(json_object_get(results, "different_cases")),
               json_array_size(json_object_get(results, "not_compared")),
               json_array_size(json_object_get(impact, "verdicts")),
               json_array_size(json_object_get(impact, "verdicts")) == 1 ? "" : "s");
    print_changes(app, json_object_get(impact, "causes"), "run:");
    print_changes(app, json_object_get(impact, "libraries"), "library");
    print_changes(app, json_object_get(impact, "devices"), "device");
    print_changes(app, json_object_get(impact, "requirements"), "requirement");
    put(app->result, "impact", json_incref(impact));
}

void validate_print_suite(const app_state *app, const json_t *suite)
{
    enum { SHOWN = 10 };
    const json_t *tests = json_object_get(suite, "tests");
    const json_int_t passed = json_integer_value(json_object_get(suite, "passed")),
                     failed = json_integer_value(json_object_get(suite, "failed"));
    int shown = 0;
    print_line(app,
               "TEST SUITE %s: of the %zu tests that requirements name, %lld passed, %lld failed and %lld were skipped",
               failed   ? "FAILED"
               : passed ? "PASSED"
                        : "NOT RUN",
               json_array_size(tests), (long long)passed, (long long)failed,
               (long long)json_integer_value(json_object_get(suite, "skipped")));
    for (size_t i = 0; i < json_array_size(tests); i++)
        if (strcmp(evidence_text(json_array_get(tests, i), "result"), "failed") == 0 && shown++ < SHOWN)
            print_line(app, "  %s %s", evidence_text(json_array_get(tests, i), "test"),
                       evidence_text(json_array_get(tests, i), "reason"));
    if (shown > SHOWN)
        print_line(app, "  and %d more, see " SUITE_FILE, shown - SHOWN);
}

ost_status validate_judge_suite(const json_t *suite, ost_error *err)
{
    const json_int_t failed = json_integer_value(json_object_get(suite, "failed"));
    if (failed)
        return ost_fail(err, OST_ERR_DIFFER, "%lld test%s of the suite failed; see " SUITE_FILE " and the report",
                        (long long)failed, failed == 1 ? "" : "s");
    if (!json_integer_value(json_object_get(suite, "passed")))
        return ost_fail(err, OST_ERR_UNAVAILABLE, "no test of the suite ran; see " SUITE_FILE " for the reasons");
    return OST_OK;
}

ost_status validate_nothing(ost_error *err)
{
    return ost_fail(err, OST_ERR_UNAVAILABLE, "nothing was compared: no backend other than the reference ran a case "
                    "that the reference accepted");
}

/* Adds to the JSON object the results that the summary lacks. All other results are in the bundle. */
ost_status validate_print(app_state *app, const validate_args *args, const campaign *c, json_t *summary,
                          const sensitivity *proof, const json_t *common, ost_error *err)
{
    char records[FORMAT_TEXT], bytes[FORMAT_TEXT];
    const json_t *list = json_object_get(summary, "not_shown");
    json_object_update(app->result, summary);
    put_text(app->result, "tier", plan_tier_name(c->plan->tier));
    put_integer(app->result, "seed", (int64_t)c->plan->seed);
    put_integer(app->result, "bytes_equal", (int64_t)c->bytes);
    put(app->result, "stages", stages_of(c));
    if (args->out)
        put_text(app->result, "out", args->out);
    const bool equal = json_is_true(json_object_get(summary, "equal")),
               something = json_integer_value(json_object_get(summary, "compared")) > 0;
    put_bool(app->result, "apart", args->apart);
    print_line(app, "%s: %d case%s on %d backend%s, tier %s, seed %llu%s%s", evidence_text(summary, "verdict"),
               c->plan->count, c->plan->count == 1 ? "" : "s", c->subjects->count, c->subjects->count == 1 ? "" : "s",
               plan_tier_name(c->plan->tier), (unsigned long long)c->plan->seed,
               json_is_true(json_object_get(summary, "evidence")) && !args->apart ? ""
                                                                                  : " (a reduced run: no evidence)",
               args->apart ? ", each stage and tick with the reference's input" : "");
    print_backends(app, c);
    for (int i = 0; i < c->plan->count; i++)
        for (int s = 1; s < c->subjects->count; s++)
            if (result_at(c, i, s)->verdict != CASE_EQUAL && result_at(c, i, s)->verdict != CASE_NOT_RUN)
                validate_print_difference(app, &c->plan->cases[i], &c->subjects->subjects[s], result_at(c, i, s));
    print_line(app,
               equal ? "  %s records with %s of results were compared byte by byte and are equal"
                     : "  %s records were compared byte by byte; the equal cases have %s of results",
               format_count(records, (int64_t)c->records), format_bytes(bytes, (int64_t)c->bytes));
    for (size_t i = 0; i < json_array_size(list); i++)
        print_line(app, "%s%s", i ? "             " : "  not shown: ", json_string_value(json_array_get(list, i)));
    print_line(app, "COMMON MISTAKES %s: the reference passed %lld of %lld checks by hand, by volume and by law",
               common_proved(common) ? "NONE FOUND" : "FOUND",
               (long long)json_integer_value(json_object_get(common, "passed")),
               (long long)json_array_size(json_object_get(common, "checks")));
    if (proof)
        validate_print_faults(app, proof);
    if (json_object_get(app->result, "suite"))
        validate_print_suite(app, json_object_get(app->result, "suite"));
    if (args->out)
        validate_print_last(app, args->out, summary);
    if (!something)
        return validate_nothing(err);
    if (!equal)
        return ost_fail(err, OST_ERR_DIFFER,
                        "%d results differ from the reference's, %d failed, %d crashed, %d took too long",
                        c->counts[CASE_DIFFERS], c->counts[CASE_FAILED], c->counts[CASE_CRASHED], c->counts[CASE_LATE]);
    if (proof && !faults_proved(proof))
        return ost_fail(err, OST_ERR_DIFFER, "the sensitivity proof failed: %s",
                        proof->first_problem[0] ? proof->first_problem : "no result was changed");
    if (!common_proved(common))
        return ost_fail(err, OST_ERR_DIFFER,
                        "%lld of the checks for common mistakes failed; see common.json and the report",
                        (long long)json_integer_value(json_object_get(common, "failed")));
    if (!c->subjects->opencl && !args->cpu_only && !args->backends)
        return ost_fail(err, OST_ERR_UNAVAILABLE, "OpenCL was not compared: %s; pass --cpu-only if this is intended",
                        c->subjects->no_opencl);
    return OST_OK;
}
