/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Implements `osteon compare`: compares the grids of another program with those of the reference,
 * and reports the margin of every difference.
 *
 *   a folder of dumps, or a backend's name --campaign--> verdicts, margins --> table, --json, exit status
 *
 * The comparison is the same as in `osteon validate`, but the verb makes neither a bundle nor a sensitivity proof. The
 * verb is intended for developers of another program.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "app/common/options.h"
#include "app/common/progress.h"
#include "app/common/result.h"
#include "app/common/print.h"
#include "app/validate/user_files.h"
#include "app/validate/validate.h"
#include "validation/bundle/evidence.h"
#include "validation/campaign.h"
#include "validation/dump/dump.h"

typedef struct compare_args {
    const char *subject_spec, *only;
    int tier;
    int64_t seed, limit_s;
    bool apart, tier_given, seed_given;
    user_files own;
} compare_args;

static void show(void *user, const char *what, double share)
{
    (void)user;
    progress_show(NULL, what, share);
}

static const case_result *result_at(const campaign *c, int i, int s)
{
    return &c->results[(size_t)i * (size_t)c->subjects->count + (size_t)s];
}

/*
 * Prints one line per stage with the number of differences, their causes, and the maximum margin. A margin is the
 * distance between a value and the border at which a decision changes.
 */
static void print_margins(const app_state *app, const margins *m)
{
    print_line(app, "  stage    differing   inherited   below thr.   unexplained   at borders   greatest margin");
    for (int i = 0; i < TRACE_STAGES; i++) {
        const margin_stage *x = &m->of[i];
        char most[FORMAT_TEXT] = "-";
        if (!x->voxels && !x->reports)
            continue;
        if (x->decided)
            snprintf(most, sizeof most, "%.7f of a %s", (double)x->max / MARGIN_ONE, margin_unit((trace_stage)i));
        print_line(app, "  %-8s %9llu   %9llu   %10llu   %11llu   %10llu   %s", trace_stage_name((trace_stage)i),
                   (unsigned long long)x->voxels, (unsigned long long)x->inherited,
                   (unsigned long long)x->below_threshold, (unsigned long long)(x->unexplained + x->unmeasured),
                   (unsigned long long)x->decided, most);
    }
    for (int i = 0; i < TRACE_STAGES; i++) {
        const margin_stage *x = &m->of[i];
        if (!x->decided)
            continue;
        print_line(app, "  margins of stage %s, in parts of a %s", trace_stage_name((trace_stage)i),
                   margin_unit((trace_stage)i));
        for (int b = 0; b < MARGIN_BINS; b++)
            if (x->bins[b] && b == 0)
                print_line(app, "    on the border  %10llu", (unsigned long long)x->bins[b]);
            else if (x->bins[b] && b == MARGIN_BINS - 1)
                print_line(app, "    a voxel, more  %10llu", (unsigned long long)x->bins[b]);
            else if (x->bins[b])
                print_line(app, "    below %8.6f %10llu", (double)(1 << b) / MARGIN_ONE,
                           (unsigned long long)x->bins[b]);
    }
}

static void print_case(const app_state *app, const plan_case *c, const subject *subject_spec, const case_result *r)
{
    if (r->verdict == CASE_DIFFERS)
        validate_print_difference(app, c, subject_spec, r);
    else
        print_line(app, "  %s: %s%s%s", c->id, case_verdict_name(r->verdict), r->text[0] ? ": " : "", r->text);
}

/*
 * Prints and stores the results. The verdict covers all backends. The margins are collected separately for each
 * compared backend.
 */
static ost_status report(app_state *app, const campaign *c, bool apart, ost_error *err)
{
    json_t *stages = json_array(), *list = json_array(), *cases = json_array();
    margins total = {0};
    int compared = 0;
    for (int s = 1; s < c->subjects->count; s++) {
        margins all = {0};
        int equal = 0, of_this = 0;
        for (int i = 0; i < c->plan->count; i++) {
            const case_result *r = result_at(c, i, s);
            /* if both backends refused the case, no results were compared */
            const bool refused = r->verdict == CASE_EQUAL && result_at(c, i, 0)->verdict != CASE_EQUAL;
            equal += r->verdict == CASE_EQUAL && !refused;
            of_this += r->verdict != CASE_NOT_RUN && !refused;
            if (r->margins)
                margins_add(&all, r->margins);
            json_t *o = evidence_result(r);
            json_object_del(o, "margins"); /* margins are given per backend, so they are omitted here */
            put_text(o, "case", c->plan->cases[i].id);
            put_text(o, "backend", c->subjects->subjects[s].spec);
            append(cases, o);
        }
        compared += of_this;
        print_line(app, "%s: %s, %d of %d case%s equal%s",
                   equal == of_this && of_this ? "EQUAL"
                   : of_this                   ? "NOT EQUAL"
                                               : "NOT COMPARED",
                   c->subjects->subjects[s].spec, equal, of_this, of_this == 1 ? "" : "s",
                   apart ? ", every stage and tick apart" : "");
        for (int i = 0; i < c->plan->count; i++)
            print_case(app, &c->plan->cases[i], &c->subjects->subjects[s], result_at(c, i, s));
        margins_add(&total, &all);
        if (c->counts[CASE_DIFFERS])
            print_margins(app, &all);
        json_t *o = json_object();
        put_text(o, "backend", c->subjects->subjects[s].spec);
        put(o, "stages", margins_json(&all));
        append(list, o);
    }
    for (int i = TRACE_RECT; i <= TRACE_FINAL; i++) {
        json_t *o = json_object();
        put_text(o, "name", trace_stage_name((trace_stage)i));
        put_integer(o, "records", (int64_t)c->stage_records[i]);
        put_integer(o, "different_voxels", (int64_t)total.of[i].voxels);
        put_integer(o, "different_reports", (int64_t)total.of[i].reports);
        append(stages, o);
    }
    put_bool(app->result, "equal", campaign_equal(c));
    put_bool(app->result, "apart", apart);
    put(app->result, "stages", stages);
    put(app->result, "margins", list);
    put(app->result, "cases", cases);
    if (!compared)
        return ost_fail(err, OST_ERR_INPUT, "no grid of these cases found; see docs/spec/dumps.md for their names");
    if (!campaign_equal(c))
        return ost_fail(err, OST_ERR_DIFFER, "%d of %d results differ from the reference's, %d failed",
                        c->counts[CASE_DIFFERS], compared,
                        c->counts[CASE_FAILED] + c->counts[CASE_CRASHED] + c->counts[CASE_LATE]);
    return OST_OK;
}

/* Returns true if the text up to the first ':' is the name of a backend. */
static bool is_backend(const char *spec)
{
    ost_backend_info info;
    for (int i = 0; i < ost_backend_count(); i++)
        if (ost_backend_describe(i, &info, NULL) == OST_OK && spec_is(spec, info.name))
            return true;
    return spec_is(spec, SUBJECT_DENSE);
}

/*
 * Finds the subject to compare. If the name is a folder, the subject is a dump, whose header contains the tier and
 * the seed of its campaign. Any other name denotes a backend.
 */
static ost_status find_subject(const app_state *app, compare_args *args, char spec[SUBJECT_SPEC], char only[PLAN_ID],
                               ost_error *err)
{
    struct stat info;
    dump_head head;
    const bool folder = stat(args->subject_spec, &info) == 0 && S_ISDIR(info.st_mode);
    const int n = snprintf(spec, SUBJECT_SPEC, "%s%s", folder ? SUBJECT_DUMP : "", args->subject_spec);
    if (n < 0 || n >= SUBJECT_SPEC || strchr(args->subject_spec, ';'))
        return usage_error(app, err, "'%.60s': expected one folder or one backend, shorter than %d bytes and without "
                           "a semicolon", args->subject_spec, SUBJECT_SPEC);
    if (strncmp(spec, SUBJECT_DUMP, strlen(SUBJECT_DUMP)) != 0) {
        if (!is_backend(spec))
            return ost_fail(err, OST_ERR_USAGE, "%s: neither a folder of dumps nor a backend; 'osteon devices' lists "
                            "the backends", spec);
        return OST_OK;
    }
    const ost_status status = dump_read_head(spec + strlen(SUBJECT_DUMP), &head, err);
    if (status != OST_OK)
        return status;
    if (args->apart)
        return usage_error(app, err, "--apart needs a backend that runs now, not a dump");
    if (args->tier_given || args->seed_given)
        return usage_error(app, err, "--tier and --seed cannot be combined with a dump: dump.json states them");
    args->tier = (int)head.tier;
    args->seed = (int64_t)head.seed;
    memcpy(only, head.only, sizeof head.only);
    if (!args->only && only[0])
        args->only = only;
    return OST_OK;
}

ost_status cmd_compare(app_state *app, int argc, char **argv, ost_error *err)
{
    compare_args args = {.seed = 1, .limit_s = 3600, .own = USER_FILES_DEFAULT};
    const operand names[] = {{"DUMPS", &args.subject_spec, "no dumps or backend given"}, {NULL, NULL, NULL}};
    const option options[] = {
        {.name = "only",
         .kind = OPTION_TEXT,
         .out = &args.only,
         .value = "CASE",
         .help = "compare the cases whose name starts with CASE, such as import, static/2 or operation"},
        {.name = "apart",
         .kind = OPTION_FLAG,
         .out = &args.apart,
         .help = "give every stage and tick the reference's input, so that a difference does not affect later "
                 "stages; not for dumps"},
        {.name = "tier",
         .kind = OPTION_CHOICE,
         .out = &args.tier,
         .given = &args.tier_given,
         .value = "smoke|standard|full",
         .help = "tier of the cases (default: smoke; a dump states its own)"},
        {.name = "seed",
         .kind = OPTION_INTEGER,
         .out = &args.seed,
         .given = &args.seed_given,
         .value = "N",
         .min = 1,
         .max = INT64_MAX,
         .help = "seed of the cases (default: 1; a dump states its own)"},
        {.name = "limit",
         .kind = OPTION_INTEGER,
         .out = &args.limit_s,
         .value = "S",
         .min = 1,
         .max = 1000000,
         .help = "seconds after which a backend is stopped (default: 3600)"},
        HEADING("your own files"),
        USER_FILES(args.own, "a CT of your own, for case user/1 as in osteon validate; may repeat",
                   "a mesh of your own, or builtin:reamer; may repeat",
                   "a CSV, builtin:peg-hole or builtin:glenoid-ream; may repeat"),
        HEADING("reading your own files"),
        USER_FILES_HOW(args.own),
        {.name = NULL}};
    const usage_text usage = {
        .synopsis = "DUMPS | BACKEND [options]",
        .about = "Compares the grids of another program with those of the scalar reference, stage by\n"
                 "stage. For every voxel that differs, prints a margin, which states how close the\n"
                 "voxel was to the other result.\n"
                 "DUMPS is a folder with a dump.json (docs/spec/dumps.md); BACKEND is the name of a\n"
                 "backend, such as plugin:./mine.so.",
        .operands = names,
        .options = options,
        .notes = "The reference determines a voxel by the position of a point. The margin of a voxel\n"
                 "is the distance, on its worst axis, from this point to the nearest border beyond\n"
                 "which the other result would be correct. Rounding gives margins near 0. A\n"
                 "difference that no border explains is not caused by rounding.",
        .example = "  osteon validate --export-cases cases --only import/0   # inputs, for your program\n"
                   "  osteon compare my-dumps\n"
                   "  osteon compare plugin:./thesis_f32.so --only static --apart\n"
                   "  osteon compare my-dumps --only user --ct shoulder.nii.gz --tool reamer.stl",
    };
    char spec[SUBJECT_SPEC], only[PLAN_ID], program[1024];
    ost_status status;
    plan p = {.count = 0};
    subject_list subjects = {.count = 0};
    campaign run = {.plan = NULL};
    if (!options_parse(app, &usage, argc, argv, &status, err) ||
        (status = find_subject(app, &args, spec, only, err)) != OST_OK)
        return status;
    const ssize_t n = readlink("/proc/self/exe", program, sizeof program - 1);
    if (n < 0)
        return ost_fail(err, OST_ERR_IO, "/proc/self/exe cannot be read");
    program[n] = '\0';
    user_store *store = NULL;
    json_t *record = NULL;
    status = user_files_of(app, &args.own, argc, argv, &store, &record, err);
    const plan_user own = {.count = user_store_count(store), .store = store};
    if (status == OST_OK)
        status = plan_make((plan_tier)args.tier, (uint64_t)args.seed, 1, 1, args.only, &own, &p, err);
    if (status == OST_OK)
        status = subjects_find(p.tier, spec, &subjects, err);
    if (status == OST_OK && subjects.count > 1 && !subjects.subjects[1].available)
        status = ost_fail(err, OST_ERR_UNAVAILABLE, "%s", subjects.subjects[1].reason);
    if (status == OST_OK) {
        const campaign_options how = {
            .program = program, .limit_s = (double)args.limit_s, .apart = args.apart, .show = show};
        status = campaign_run(&p, &subjects, &how, &run, err);
        progress_end();
    }
    if (status == OST_OK)
        status = report(app, &run, args.apart, err);
    if (run.plan)
        campaign_free(&run);
    subjects_free(&subjects);
    plan_free(&p);
    json_decref(record);
    user_store_free(store);
    return status;
}
