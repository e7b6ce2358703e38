/* SPDX-License-Identifier: Apache-2.0 */
#include "validation/campaign.h"

#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "validation/dump.h"

const char *case_verdict_name(case_verdict verdict)
{
    static const char *const names[CASE_VERDICTS] = {"equal", "differs", "failed", "crashed", "timed out", "not run"};
    return names[verdict];
}

enum { PATH = 1024 };

/* Runs one backend from a case on; its trace is at `path`. */
static ost_status run_worker(const plan *p, const campaign_options *o, const char *spec, int from, const char *path, double limit_s,
                             worker_result *out, ost_error *err)
{
    char seed[32], shard[32], first[16], tier[16];
    snprintf(seed, sizeof seed, "%llu", (unsigned long long)p->seed);
    snprintf(shard, sizeof shard, "%d/%d", p->shard, p->shards);
    snprintf(first, sizeof first, "%d", from);
    snprintf(tier, sizeof tier, "%s", plan_tier_name(p->tier));
    const char *const words[] = {o->program, "validate",   "--worker", spec,   "--trace", path,   "--tier", tier,
                                 "--seed",   seed,         "--shard",  shard,  "--from",  first,  p->file ? "--case" : p->only ? "--only" : NULL, p->file ? p->file : p->only, NULL};
    char *argv[sizeof words / sizeof words[0]];
    for (size_t i = 0; i < sizeof words / sizeof words[0]; i++)
        argv[i] = (char *)(uintptr_t)words[i];
    worker w;
    ost_status status = worker_start(argv, &w, err);
    return status == OST_OK ? worker_wait(&w, limit_s, out, err) : status;
}

static const char *file_of(const campaign_options *o, int whom, int part, char path[PATH])
{
    snprintf(path, PATH, "%s/trace-%d-%d", o->folder, whom, part);
    return path;
}

static case_result *result_of(campaign *c, int case_index, int whom)
{
    return &c->results[(size_t)case_index * (size_t)c->subjects->count + (size_t)whom];
}

static uint64_t bytes_of(const trace *t, compare_range r)
{
    uint64_t bytes = 0;
    for (size_t i = 0; i < r.count; i++)
        bytes += t->records[r.first + i].body_bytes;
    return bytes;
}

/* The line of a stage that failed. */
static void tell_failed(const trace_record *failed, case_result *r)
{
    size_t at = 0;
    trace_block_view block;
    if (trace_next_block(failed, &at, &block) && block.voxel_bytes == 1)
        snprintf(r->text, sizeof r->text, "%.*s", block.dims.x < 190 ? (int)block.dims.x : 190, (const char *)block.voxels);
}

/* How near each differing voxel was; NULL where that cannot be said. */
static margins *measure(const campaign *c, int i, const trace *got, compare_range range)
{
    scene s;
    margins *m = malloc(sizeof *m);
    if (!m || scene_make(&c->plan->cases[i], &s, NULL) != OST_OK) {
        free(m);
        return NULL;
    }
    const ost_status status = margins_of(&s, &c->reference, c->ranges[i], got, range, false, m, NULL);
    scene_free(&s);
    if (status == OST_OK)
        return m;
    free(m);
    return NULL;
}

/* What one part of a backend's trace says about cases from..; how many of them it has whole. */
static int judge(campaign *c, const campaign_options *o, int whom, const trace *got, int from, int until)
{
    int judged = 0;
    for (int i = from; i < until; i++, judged++) {
        const compare_range range = compare_find(got, (uint32_t)i);
        /* Whole: the next case began, or the list ended. */
        const bool last = range.count && range.first + range.count == got->count;
        if (!range.count || (last && !got->whole))
            break;
        case_result *r = result_of(c, i, whom);
        compare_case(&c->reference, c->ranges[i], got, range, &r->difference);
        r->verdict = r->difference.kind == COMPARE_EQUAL ? CASE_EQUAL : CASE_DIFFERS;
        if (r->verdict == CASE_DIFFERS && got->records[range.first + range.count - 1].stage == TRACE_FAILED &&
            r->difference.kind == COMPARE_MISSING)
            r->verdict = CASE_FAILED;
        if (r->verdict == CASE_DIFFERS)
            r->found = finding_of_case(&c->plan->cases[i], &c->reference, c->ranges[i], got, range, &r->difference);
        if (r->verdict == CASE_FAILED)
            tell_failed(&got->records[range.first + range.count - 1], r);
        if (r->verdict == CASE_DIFFERS)
            r->margins = measure(c, i, got, range);
        if (r->verdict == CASE_DIFFERS && o->differs)
            o->differs(o->keeper, c, i, whom, got, range);
        c->records += r->difference.records;
        if (r->verdict == CASE_EQUAL)
            c->bytes += bytes_of(got, range);
    }
    return judged;
}

/* A folder of grids in a backend's place. */
static ost_status run_dump(campaign *c, int whom, const campaign_options *o, ost_error *err)
{
    const plan *p = c->plan;
    const char *folder = c->subjects->subjects[whom].spec + strlen(SUBJECT_DUMP);
    char path[PATH];
    dump_head head;
    trace got = {0};
    uint64_t *compared = calloc((size_t)p->count + 1, sizeof *compared);
    ost_status status = compared ? dump_read_head(folder, &head, err) : ost_fail(err, OST_ERR_MEMORY, "no memory for %d cases", p->count);
    if (status == OST_OK && (head.tier != p->tier || head.seed != p->seed))
        status = ost_fail(err, OST_ERR_USAGE, "%s: its cases are of tier %s, seed %llu; compared are those of tier %s, seed %llu", folder,
                          plan_tier_name(head.tier), (unsigned long long)head.seed, plan_tier_name(p->tier), (unsigned long long)p->seed);
    if (status == OST_OK)
        status = dump_trace(folder, p, &c->reference, c->ranges, file_of(o, whom, 0, path), compared, err);
    if (status == OST_OK)
        status = trace_open(path, &got, err);
    for (int i = 0; i < p->count && status == OST_OK; i++) {
        case_result *r = result_of(c, i, whom);
        if (compared[i])
            judge(c, o, whom, &got, i, i + 1);
        else
            r->verdict = CASE_NOT_RUN;
        if (r->verdict == CASE_EQUAL || r->verdict == CASE_NOT_RUN)
            snprintf(r->text, sizeof r->text, "%llu of %zu records are in the dump; reports never are", (unsigned long long)compared[i], c->ranges[i].count - 1);
    }
    trace_free(&got);
    if (compared)
        unlink(file_of(o, whom, 0, path));
    free(compared);
    return status;
}

static ost_status run_subject(campaign *c, int whom, const campaign_options *o, ost_error *err)
{
    const plan *p = c->plan;
    double left = o->limit_s;
    if (strncmp(c->subjects->subjects[whom].spec, SUBJECT_DUMP, strlen(SUBJECT_DUMP)) == 0)
        return run_dump(c, whom, o, err);
    for (int from = 0, part = 0; from < p->count; part++) {
        char path[PATH];
        worker_result end;
        trace got = {0};
        file_of(o, whom, part, path);
        ost_status status = run_worker(p, o, c->subjects->subjects[whom].spec, from, path, left > 1 ? left : 1, &end, err);
        if (status != OST_OK)
            return status;
        left -= end.seconds;
        c->seconds[whom] += end.seconds;
        ost_error unread = {0};
        const bool readable = access(path, F_OK) == 0 && trace_open(path, &got, &unread) == OST_OK;
        const int judged = readable ? judge(c, o, whom, &got, from, p->count) : 0;
        trace_free(&got);
        unlink(path);
        from += judged;
        if (from >= p->count)
            break;
        /* It ended in case `from`. */
        case_result *r = result_of(c, from, whom);
        r->verdict = end.end == WORKER_LATE ? CASE_LATE : end.end == WORKER_CRASHED ? CASE_CRASHED : CASE_FAILED;
        if (end.end == WORKER_CRASHED)
            snprintf(r->text, sizeof r->text, "ended by signal %d (%s)%s%.120s", end.code, strsignal(end.code), end.text[0] ? ": " : "", end.text);
        else if (end.end == WORKER_LATE)
            snprintf(r->text, sizeof r->text, "stopped after %.0f s", end.seconds);
        else
            snprintf(r->text, sizeof r->text, "%.190s", end.text[0] ? end.text : "it ended without a word");
        from++;
        if (end.end != WORKER_CRASHED) { /* there is no time left, or it will fail again */
            for (; from < p->count; from++)
                *result_of(c, from, whom) = *r;
        }
    }
    return OST_OK;
}

/* The reference must work; anything else is no campaign. */
static ost_status run_reference(campaign *c, const campaign_options *o, ost_error *err)
{
    char path[PATH];
    worker_result end;
    ost_status status = run_worker(c->plan, o, "ref", 0, file_of(o, 0, 0, path), o->limit_s, &end, err);
    if (status != OST_OK)
        return status;
    c->seconds[0] = end.seconds;
    if (end.end != WORKER_DONE) {
        unlink(path);
        return ost_fail(err, OST_ERR_INTERNAL, "the reference did not finish: %s", end.text[0] ? end.text : "it ended without a word");
    }
    status = trace_open(path, &c->reference, err);
    unlink(path); /* mapped: it goes when the campaign does */
    if (status == OST_OK && !c->reference.whole)
        status = ost_fail(err, OST_ERR_INTERNAL, "the reference's trace is not whole");
    for (int i = 0; i < c->plan->count && status == OST_OK; i++)
        c->ranges[i] = compare_find(&c->reference, (uint32_t)i);
    for (size_t i = 0; i < c->reference.count && status == OST_OK; i++)
        c->stage_records[c->reference.records[i].stage]++;
    return status;
}

ost_status campaign_run(const plan *p, const subject_list *subjects, const campaign_options *o, campaign *out, ost_error *err)
{
    const size_t cells = (size_t)p->count * (size_t)subjects->count;
    *out = (campaign){.plan = p, .subjects = subjects};
    out->results = calloc(cells ? cells : 1, sizeof *out->results);
    out->ranges = calloc((size_t)p->count + 1, sizeof *out->ranges);
    out->seconds = calloc((size_t)subjects->count, sizeof *out->seconds);
    ost_status status = OST_OK;
    if (!out->results || !out->ranges || !out->seconds)
        status = ost_fail(err, OST_ERR_MEMORY, "no memory for %zu results", cells);
    if (status == OST_OK && o->show)
        o->show(o->user, "ref", 0);
    if (status == OST_OK)
        status = run_reference(out, o, err);
    for (int s = 1; s < subjects->count && status == OST_OK; s++) {
        if (o->show)
            o->show(o->user, subjects->subjects[s].spec, (double)s / subjects->count);
        if (subjects->subjects[s].available)
            status = run_subject(out, s, o, err);
        else
            for (int i = 0; i < p->count; i++)
                result_of(out, i, s)->verdict = CASE_NOT_RUN;
    }
    if (status != OST_OK) {
        campaign_free(out);
        return status;
    }
    for (int s = 1; s < subjects->count; s++)
        for (int i = 0; i < p->count; i++)
            out->counts[result_of(out, i, s)->verdict]++;
    return OST_OK;
}

void campaign_free(campaign *c)
{
    for (int i = 0; c->results && i < c->plan->count * c->subjects->count; i++) {
        free(c->results[i].found);
        free(c->results[i].margins);
    }
    free(c->results);
    free(c->ranges);
    free(c->seconds);
    trace_free(&c->reference);
    *c = (campaign){0};
}

bool campaign_equal(const campaign *c)
{
    return c->counts[CASE_EQUAL] > 0 && !c->counts[CASE_DIFFERS] && !c->counts[CASE_FAILED] && !c->counts[CASE_CRASHED] && !c->counts[CASE_LATE];
}
