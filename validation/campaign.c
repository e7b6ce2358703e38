/* SPDX-License-Identifier: Apache-2.0 */
#include "validation/campaign.h"

#include <errno.h>
#include <sched.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "validation/bundle/digests.h"
#include "validation/dump.h"
#include "validation/scratch.h"
#include "validation/user_store.h"
#include "validation/verdict.h"

enum { CAMPAIGN_WORDS = 24 }; /* of a worker's command line */

/* A trace of one worker, kept until its batch is done since something in it differs. */
typedef struct kept_trace {
    int whom, from, judged;
    trace got;
    struct kept_trace *next;
} kept_trace;

/* What one backend has still to do in a batch. */
typedef struct task {
    int from; /* next case; the batch's end when all are done */
    bool running;
} task;

typedef struct batch {
    int first, end; /* cases */
    bool open, ready; /* begun; the reference is done */
    trace reference;
    int given;         /* apart: its descriptor, for the workers of the others; else -1 */
    task *tasks;      /* owned; of each subject */
    kept_trace *kept;
} batch;

typedef struct slot {
    worker w;
    int batch, whom, trace; /* trace: its descriptor */
} slot;

enum { ALIVE = 2 }; /* batches at a time: one that is compared, and the next one's reference */

/* The whole of one run. */
typedef struct runner {
    campaign *c;
    const campaign_options *o;
    int batches, begun, done; /* of all batches: those from done to begun are alive */
    batch alive[ALIVE];       /* number n at n % ALIVE */
    int *ends;                /* owned; where each batch ends */
    bool *gone;               /* owned; backends that failed for good: the rest of their cases is judged */
    case_result *last_words;  /* owned; of those */
    slot slots[WORKERS_MAX];
    int running, finished;    /* workers; cells of cases and backends */
} runner;

static batch *batch_of(runner *r, int number)
{
    return &r->alive[number % ALIVE];
}

/* ----------------------------------------------------------------- workers */

static ost_status start(runner *r, int number, int whom, ost_error *err)
{
    const plan *p = r->c->plan;
    batch *b = batch_of(r, number);
    slot *s = &r->slots[r->running];
    char seed[32], shard[32], first[16], end[16], tier[16], trace_path[32], given[64];
    const char *words[CAMPAIGN_WORDS] = {r->o->program, "validate", "--worker", r->c->subjects->subjects[whom].spec, "--trace", trace_path, "--tier", tier,
                                         "--seed", seed, "--shard", shard, "--from", first, "--to", end};
    size_t n = 16;
    snprintf(seed, sizeof seed, "%llu", (unsigned long long)p->seed);
    snprintf(shard, sizeof shard, "%d/%d", p->shard, p->shards);
    snprintf(first, sizeof first, "%d", b->tasks[whom].from);
    snprintf(end, sizeof end, "%d", b->end);
    snprintf(tier, sizeof tier, "%s", plan_tier_name(p->tier));
    snprintf(trace_path, sizeof trace_path, "/dev/fd/%d", WORKER_TRACE);
    if (p->file || p->only) {
        words[n++] = p->file ? "--case" : "--only";
        words[n++] = p->file ? p->file : p->only;
    }
    if (p->user)
        words[n++] = "--user";
    if (b->given >= 0 && whom > 0) {
        snprintf(given, sizeof given, "/proc/%lld/fd/%d", (long long)getpid(), b->given);
        words[n++] = "--given";
        words[n++] = given;
    }
    char *argv[CAMPAIGN_WORDS];
    for (size_t i = 0; i < CAMPAIGN_WORDS; i++)
        argv[i] = (char *)(uintptr_t)words[i];
    const double left = r->o->limit_s - r->c->seconds[whom];
    *s = (slot){.batch = number, .whom = whom};
    ost_status status = scratch_file(&s->trace, err);
    if (status != OST_OK)
        return status;
    status = worker_start(argv, s->trace, user_store_fd(p->user), left > 1 ? left : 1, &s->w, err);
    if (status != OST_OK) {
        close(s->trace);
        return status;
    }
    b->tasks[whom].running = true;
    r->running++;
    if (r->o->show)
        r->o->show(r->o->user, r->c->subjects->subjects[whom].spec, (double)r->finished / ((double)p->count * r->c->subjects->count));
    return OST_OK;
}

/* One worker of a backend at a time: what it has left of its time is known, and a device is asked by one alone. */
static bool busy(const runner *r, int whom)
{
    for (int i = 0; i < r->running; i++)
        if (r->slots[i].whom == whom)
            return true;
    return false;
}

/* The next to start; false when there is nothing to do until a worker ends. */
static bool choose(runner *r, int *number, int *whom)
{
    /* The next reference first, so that nobody has to wait for it. */
    if (r->begun < r->batches && r->begun < r->done + ALIVE && !busy(r, 0)) {
        *number = r->begun;
        *whom = 0;
        return true;
    }
    for (*number = r->done; *number < r->begun; ++*number) {
        const batch *b = batch_of(r, *number);
        /* Devices stand last and take longest: they begin. */
        for (*whom = r->c->subjects->count - 1; b->ready && *whom > 0; --*whom)
            if (b->tasks[*whom].from < b->end && !b->tasks[*whom].running && !busy(r, *whom))
                return true;
    }
    return false;
}

/* ------------------------------------------------------- what a worker left */

/* Keeps the digest of what a backend made of case i, computed from its own trace, and the lines where they differ from the reference's. */
static ost_status keep_digests(runner *r, int i, int whom, const trace *got, ost_error *err)
{
    case_result *one = verdict_of(r->c, i, whom);
    const ost_status status = digests_of_case(got, compare_find(got, (uint32_t)i), &one->lines, &one->made, err);
    if (status != OST_OK)
        return status;
    one->has_made = true;
    if (r->c->lines[i] && strcmp(one->lines, r->c->lines[i]) == 0) {
        free(one->lines);
        one->lines = NULL;
    }
    return OST_OK;
}

/* Takes the times of the cases from `from` on, which the last record but one of a complete trace has. */
static void keep_seconds(const runner *r, int whom, const trace *got, int from)
{
    uint64_t count;
    const uint8_t *words;
    const trace_record *times = got->whole && got->count > 1 ? &got->records[got->count - 2] : NULL;
    if (!times || times->stage != TRACE_END || times->item != TRACE_TIMES || !trace_words(times, &count, &words))
        return;
    for (uint64_t k = 0; k < count && from + (int)k < r->c->plan->count; k++)
        verdict_of(r->c, from + (int)k, whom)->seconds = 1e-6 * (double)trace_word_at(words, k);
}

/* Judges cases [from, until) of a backend's trace; *judged receives how many of them it has complete. */
static ost_status judge(runner *r, const batch *b, int whom, const trace *got, int from, int until, int *judged, bool *differs, ost_error *err)
{
    ost_status status = OST_OK;
    *judged = verdict_judge(r->c, &b->reference, whom, got, from, until, differs);
    r->finished += *judged;
    for (int i = from; i < from + *judged && status == OST_OK; i++)
        status = keep_digests(r, i, whom, got, err);
    return status;
}

/* The rest of a backend's cases in a batch, once it is known to do no more. */
static void give_up(runner *r, batch *b, int whom)
{
    for (; b->tasks[whom].from < b->end; b->tasks[whom].from++, r->finished++)
        *verdict_of(r->c, b->tasks[whom].from, whom) = r->last_words[whom];
}

/* The reference must work; anything else is no campaign. */
static ost_status reference_ended(runner *r, batch *b, trace *got, const worker_result *end, ost_error *err)
{
    campaign *c = r->c;
    size_t at = 0;
    ost_status status = OST_OK;
    if (end->end != WORKER_DONE)
        return ost_fail(err, OST_ERR_INTERNAL, "the reference did not finish: %s",
                        end->end == WORKER_LATE ? "it took too long; --limit gives more time" : end->text[0] ? end->text : "it ended without a word");
    if (!got->whole)
        return ost_fail(err, OST_ERR_INTERNAL, "the reference's trace is not whole");
    keep_seconds(r, 0, got, b->first);
    b->reference = *got;
    *got = (trace){0};
    b->ready = true;
    for (int i = b->first; i < b->end && status == OST_OK; i++) {
        case_result *one = verdict_of(c, i, 0);
        c->ranges[i] = compare_next(&b->reference, &at, (uint32_t)i);
        status = digests_of_case(&b->reference, c->ranges[i], &c->lines[i], &one->made, err);
        one->has_made = status == OST_OK;
    }
    for (size_t i = 0; i < b->reference.count; i++) {
        c->stage_records[b->reference.records[i].stage]++;
        if (b->reference.records[i].stage == TRACE_FAILED) {
            c->refused++;
            verdict_of(c, (int)b->reference.records[i].case_index, 0)->verdict = CASE_FAILED;
        }
    }
    for (int s = 1; s < c->subjects->count; s++)
        if (r->gone[s])
            give_up(r, b, s);
    b->tasks[0].from = b->end;
    r->finished += b->end - b->first;
    return status;
}

static ost_status keep_trace(batch *b, int whom, int from, int judged, trace *got, ost_error *err)
{
    kept_trace *keep = malloc(sizeof *keep);
    if (!keep)
        return ost_fail(err, OST_ERR_MEMORY, "no memory for a list of traces");
    *keep = (kept_trace){whom, from, judged, *got, b->kept};
    *got = (trace){0};
    b->kept = keep;
    return OST_OK;
}

static ost_status subject_ended(runner *r, batch *b, int whom, trace *got, const worker_result *end, ost_error *err)
{
    task *t = &b->tasks[whom];
    bool differs;
    int judged;
    const int from = t->from;
    ost_status status = judge(r, b, whom, got, from, b->end, &judged, &differs, err);
    if (status != OST_OK)
        return status;
    keep_seconds(r, whom, got, from);
    t->from += judged;
    if (differs && keep_trace(b, whom, from, judged, got, err) != OST_OK)
        return err->status;
    if (t->from == b->end)
        return OST_OK;
    /* It ended in this case. */
    case_result *one = verdict_of(r->c, t->from, whom);
    verdict_of_end(end, one);
    t->from++;
    r->finished++;
    if (end->end != WORKER_CRASHED) { /* there is no time left, or it will fail again */
        r->gone[whom] = true;
        r->last_words[whom] = *one;
        for (int n = r->done; n < r->begun; n++)
            if (batch_of(r, n)->ready)
                give_up(r, batch_of(r, n), whom);
    }
    return OST_OK;
}

static void count_bytes(runner *r)
{
    uint64_t bytes = 0;
    struct stat info;
    for (int i = 0; i < r->running; i++)
        bytes += fstat(r->slots[i].trace, &info) == 0 ? (uint64_t)info.st_size : 0;
    for (int n = r->done; n < r->begun; n++) {
        bytes += batch_of(r, n)->reference.size;
        for (const kept_trace *k = batch_of(r, n)->kept; k; k = k->next)
            bytes += k->got.size;
    }
    if (bytes > r->c->trace_bytes)
        r->c->trace_bytes = bytes;
}

/*
 * A worker that got no memory, descriptor or file computed nothing, so that nothing is said about its backend. Neither is it by
 * SIGKILL: this program sends it to a worker that is late (WORKER_LATE), so another one came from outside, mostly from the
 * kernel when memory runs out.
 */
static ost_status resources_left(const char *spec, const worker_result *end, ost_error *err)
{
    enum { LOADER_FAILED = 127 }; /* exit status of a program whose libraries could not be opened */
    if (end->end == WORKER_CRASHED && end->code == SIGKILL)
        return ost_fail(err, OST_ERR_IO, "the worker of %s was ended from outside by SIGKILL, as the kernel does when memory runs out, so that nothing is said about %s; "
                        "fewer --jobs need less memory", spec, spec);
    if (end->end != WORKER_FAILED || (end->code != WORKER_EXIT_RESOURCES && end->code != LOADER_FAILED))
        return OST_OK;
    return ost_fail(err, OST_ERR_IO, "%s was not compared, for lack of memory, descriptors or files: %s; fewer --jobs need less", spec, end->text);
}

/* A full disk is nobody's difference. */
static ost_status room_left(const worker_result *end, ost_error *err)
{
    static const int full[] = {ENOSPC, EDQUOT, EFBIG};
    for (size_t i = 0; i < sizeof full / sizeof full[0] && end->end == WORKER_FAILED; i++)
        if (strstr(end->text, strerror(full[i])))
            return ost_fail(err, OST_ERR_IO, "%s: traces have no room, where TMPDIR says or in /tmp; fewer --jobs need less", strerror(full[i]));
    return OST_OK;
}

static ost_status ended(runner *r, int which, const worker_result *end, ost_error *err)
{
    count_bytes(r);
    const slot s = r->slots[which];
    batch *b = batch_of(r, s.batch);
    char name[SCRATCH_NAME];
    trace got = {0};
    ost_error unread = {0};
    r->slots[which] = r->slots[--r->running];
    r->c->seconds[s.whom] += end->seconds;
    b->tasks[s.whom].running = false;
    scratch_name(s.trace, name);
    const ost_status readable = trace_open(name, &got, &unread);
    if (s.whom == 0 && r->o->apart)
        b->given = s.trace;
    else
        close(s.trace); /* what is mapped stays until it is not */
    if (readable != OST_OK)
        got = (trace){0};
    ost_status status = room_left(end, err);
    if (status == OST_OK)
        status = resources_left(r->c->subjects->subjects[s.whom].spec, end, err);
    if (status == OST_OK && (unread.status == OST_ERR_MEMORY || unread.status == OST_ERR_IO))
        status = ost_fail(err, unread.status, "%s", unread.text);
    if (status == OST_OK && got.whole)
        status = paths_add(&r->c->paths[s.whom], &got.records[got.count - 1], err);
    if (status == OST_OK)
        status = s.whom == 0 ? reference_ended(r, b, &got, end, err) : subject_ended(r, b, s.whom, &got, end, err);
    trace_free(&got);
    return status;
}

/* ------------------------------------------------------------------- dumps */

static const char *dump_of(const campaign *c, int whom)
{
    const char *spec = c->subjects->subjects[whom].spec;
    return strncmp(spec, SUBJECT_DUMP, strlen(SUBJECT_DUMP)) == 0 ? spec + strlen(SUBJECT_DUMP) : NULL;
}

/* Every dump is of this campaign's cases. */
static ost_status know_dumps(const campaign *c, ost_error *err)
{
    const plan *p = c->plan;
    dump_head head;
    for (int s = 1; s < c->subjects->count; s++) {
        if (!dump_of(c, s))
            continue;
        const ost_status status = dump_read_head(dump_of(c, s), &head, err);
        if (status != OST_OK)
            return status;
        if (head.tier != p->tier || head.seed != p->seed)
            return ost_fail(err, OST_ERR_USAGE, "%s: its cases are of tier %s, seed %llu; compared are those of tier %s, seed %llu", dump_of(c, s),
                            plan_tier_name(head.tier), (unsigned long long)head.seed, plan_tier_name(p->tier), (unsigned long long)p->seed);
    }
    return OST_OK;
}

/* A batch of a folder of grids that stands in a backend's place; no worker. */
static ost_status read_dump(runner *r, batch *b, int whom, ost_error *err)
{
    campaign *c = r->c;
    char name[SCRATCH_NAME];
    trace got = {0};
    bool any = false;
    int fd;
    uint64_t *compared = calloc((size_t)c->plan->count, sizeof *compared);
    ost_status status = compared ? scratch_file(&fd, err) : ost_fail(err, OST_ERR_MEMORY, "no memory for %d cases", c->plan->count);
    if (status != OST_OK) {
        free(compared);
        return status;
    }
    scratch_name(fd, name);
    status = dump_trace(dump_of(c, whom), c->plan, b->first, b->end, &b->reference, c->ranges, name, compared, err);
    if (status == OST_OK)
        status = trace_open(name, &got, err);
    close(fd);
    for (int i = b->first; i < b->end && status == OST_OK; i++) {
        case_result *one = verdict_of(c, i, whom);
        bool differs = false;
        int judged;
        if (compared[i])
            status = judge(r, b, whom, &got, i, i + 1, &judged, &differs, err);
        else {
            one->verdict = CASE_NOT_RUN;
            r->finished++;
        }
        any |= differs;
        if (one->verdict == CASE_EQUAL || one->verdict == CASE_NOT_RUN)
            snprintf(one->text, sizeof one->text, "%llu of %zu records are in the dump; reports never are", (unsigned long long)compared[i], c->ranges[i].count - 1);
    }
    b->tasks[whom].from = b->end;
    if (status == OST_OK && any)
        status = keep_trace(b, whom, b->first, b->end - b->first, &got, err);
    trace_free(&got);
    free(compared);
    return status;
}

/* ----------------------------------------------------------------- batches */

static ost_status batch_begin(runner *r, ost_error *err)
{
    const int number = r->begun, count = r->c->subjects->count;
    batch *b = batch_of(r, number);
    *b = (batch){.first = number ? r->ends[number - 1] : 0, .end = r->ends[number], .open = true, .given = -1};
    b->tasks = calloc((size_t)count, sizeof *b->tasks);
    if (!b->tasks)
        return ost_fail(err, OST_ERR_MEMORY, "no memory for a list of backends");
    r->begun++;
    for (int s = 0; s < count; s++) {
        b->tasks[s].from = b->first;
        if (r->c->subjects->subjects[s].available)
            continue;
        for (; b->tasks[s].from < b->end; b->tasks[s].from++, r->finished++)
            verdict_of(r->c, b->tasks[s].from, s)->verdict = CASE_NOT_RUN;
    }
    return OST_OK;
}

static void batch_free(batch *b)
{
    for (kept_trace *k = b->kept, *next; k; k = next) {
        next = k->next;
        trace_free(&k->got);
        free(k);
    }
    trace_free(&b->reference);
    if (b->open && b->given >= 0)
        close(b->given);
    free(b->tasks);
    *b = (batch){0};
}

static bool batch_is_done(const runner *r, const batch *b)
{
    bool done = b->open && b->ready;
    for (int s = 0; s < r->c->subjects->count && done; s++)
        done = b->tasks[s].from == b->end && !b->tasks[s].running;
    return done;
}

/* In an order that does not depend on who was faster. */
static void show_differences(runner *r, const batch *b)
{
    campaign *c = r->c;
    for (int s = 1; s < c->subjects->count; s++)
        for (int i = b->first; i < b->end; i++)
            for (const kept_trace *k = b->kept; k; k = k->next) {
                if (k->whom != s || i < k->from || i >= k->from + k->judged || verdict_of(c, i, s)->verdict != CASE_DIFFERS)
                    continue;
                const compare_range range = compare_find(&k->got, (uint32_t)i);
                case_result *one = verdict_of(c, i, s);
                one->found = finding_of_case(&c->plan->cases[i], &c->reference, c->ranges[i], &k->got, range, &one->difference);
                one->margins = verdict_margins(c, i, &k->got, range, r->o->apart);
                if (r->o->differs)
                    r->o->differs(r->o->keeper, c, i, s, &k->got, range);
            }
}

static ost_status batch_end(runner *r, ost_error *err)
{
    campaign *c = r->c;
    batch *b = batch_of(r, r->done);
    c->reference = b->reference;
    show_differences(r, b);
    ost_status status = r->o->done ? r->o->done(r->o->done_keeper, c, b->first, b->end - b->first, err) : OST_OK;
    c->reference = (trace){0};
    for (int i = b->first; i < b->end; i++) {
        c->ranges[i] = (compare_range){0, 0};
        free(c->lines[i]);
        c->lines[i] = NULL;
    }
    batch_free(b);
    r->done++;
    return status;
}

/* As many cases as their traces are expected to fill BATCH_BYTES with, one at least. */
enum { BATCH_BYTES = 128 << 20 };
static uint64_t cut_batches(runner *r)
{
    const plan *p = r->c->plan;
    uint64_t most = 0;
    for (int i = 0; i < p->count; r->batches++) {
        uint64_t bytes = 0;
        do
            bytes += plan_trace_bytes(&p->cases[i++]);
        while (i < p->count && bytes + plan_trace_bytes(&p->cases[i]) <= BATCH_BYTES);
        r->ends[r->batches] = i;
        most = bytes > most ? bytes : most;
    }
    return most;
}

static ost_status run_all(runner *r, ost_error *err)
{
    ost_status status = OST_OK;
    while (r->done < r->batches && status == OST_OK) {
        int number, whom, which;
        if (r->running < r->c->jobs && choose(r, &number, &whom)) {
            if (whom == 0)
                status = batch_begin(r, err);
            if (status == OST_OK)
                status = dump_of(r->c, whom) ? read_dump(r, batch_of(r, number), whom, err) : start(r, number, whom, err);
            if (!dump_of(r->c, whom))
                continue;
        }
        if (r->running) {
            worker *all[WORKERS_MAX];
            worker_result end;
            for (int i = 0; i < r->running; i++)
                all[i] = &r->slots[i].w;
            status = worker_wait_any(all, r->running, &which, &end, err);
            if (status == OST_OK)
                status = ended(r, which, &end, err);
        }
        while (status == OST_OK && r->done < r->begun && batch_is_done(r, batch_of(r, r->done)))
            status = batch_end(r, err);
    }
    return status;
}

int campaign_cores(void)
{
    cpu_set_t set;
    if (sched_getaffinity(0, sizeof set, &set) == 0)
        return CPU_COUNT(&set);
    return 1;
}

ost_status campaign_run(const plan *p, const subject_list *subjects, const campaign_options *o, campaign *out, ost_error *err)
{
    const size_t count = (size_t)subjects->count, cells = (size_t)p->count * count;
    runner r = {.c = out, .o = o};
    *out = (campaign){.plan = p, .subjects = subjects, .begun = time(NULL), .jobs = o->jobs ? o->jobs : campaign_cores()};
    out->jobs = out->jobs < WORKERS_MAX ? out->jobs : WORKERS_MAX;
    out->results = calloc(cells ? cells : 1, sizeof *out->results);
    out->ranges = calloc((size_t)p->count + 1, sizeof *out->ranges);
    out->lines = calloc((size_t)p->count + 1, sizeof *out->lines);
    out->seconds = calloc(count, sizeof *out->seconds);
    out->paths = calloc(count, sizeof *out->paths);
    r.ends = calloc((size_t)p->count + 1, sizeof *r.ends);
    r.gone = calloc(count, sizeof *r.gone);
    r.last_words = calloc(count, sizeof *r.last_words);
    ost_status status = OST_OK;
    if (!out->results || !out->ranges || !out->lines || !out->seconds || !out->paths || !r.ends || !r.gone || !r.last_words)
        status = ost_fail(err, OST_ERR_MEMORY, "no memory for %zu results", cells);
    if (status == OST_OK)
        status = know_dumps(out, err);
    if (status == OST_OK) /* each worker's, the references' and a little more */
        status = scratch_room(cut_batches(&r) * (uint64_t)(out->jobs + ALIVE), err);
    if (status == OST_OK)
        status = run_all(&r, err);
    for (int i = 0; i < r.running; i++) {
        worker_stop(&r.slots[i].w);
        close(r.slots[i].trace);
    }
    for (int i = 0; i < ALIVE; i++)
        batch_free(&r.alive[i]);
    free(r.ends);
    free(r.gone);
    free(r.last_words);
    if (status != OST_OK) {
        campaign_free(out);
        return status;
    }
    for (int s = 1; s < subjects->count; s++)
        for (int i = 0; i < p->count; i++) {
            const case_verdict verdict = verdict_of(out, i, s)->verdict;
            out->counts[verdict]++;
            out->shown += verdict == CASE_EQUAL && verdict_of(out, i, 0)->verdict == CASE_EQUAL;
        }
    return OST_OK;
}

void campaign_free(campaign *c)
{
    for (int i = 0; c->results && i < c->plan->count * c->subjects->count; i++) {
        free(c->results[i].found);
        free(c->results[i].margins);
        free(c->results[i].lines);
    }
    for (int i = 0; c->lines && i < c->plan->count; i++)
        free(c->lines[i]);
    free(c->lines);
    free(c->results);
    free(c->ranges);
    for (int s = 0; c->paths && s < c->subjects->count; s++)
        paths_free(&c->paths[s]);
    free(c->paths);
    free(c->seconds);
    *c = (campaign){0};
}

bool campaign_equal(const campaign *c)
{
    return c->shown > 0 && !c->counts[CASE_DIFFERS] && !c->counts[CASE_FAILED] && !c->counts[CASE_CRASHED] &&
           !c->counts[CASE_LATE];
}
