/* SPDX-License-Identifier: Apache-2.0 */
/* Starts the workers of a campaign, and reads their traces. */
#include "validation/campaign_parts.h"

#include <errno.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "validation/scratch.h"
#include "validation/user_store.h"

enum { CAMPAIGN_WORDS = 24 }; /* maximum number of words on a worker's command line */

ost_status runner_start(runner *r, int number, int subject_index, ost_error *err)
{
    const plan *p = r->c->plan;
    batch *b = batch_of(r, number);
    slot *s = &r->slots[r->running];
    char seed[32], shard[32], first[16], end[16], tier[16], trace_path[32], given[64];
    const char *words[CAMPAIGN_WORDS] = {
        r->o->program, "validate", "--worker", r->c->subjects->subjects[subject_index].spec,
        "--trace",     trace_path, "--tier",   tier,
        "--seed",      seed,       "--shard",  shard,
        "--from",      first,      "--to",     end};
    size_t n = 16;
    snprintf(seed, sizeof seed, "%llu", (unsigned long long)p->seed);
    snprintf(shard, sizeof shard, "%d/%d", p->shard, p->shards);
    snprintf(first, sizeof first, "%d", b->tasks[subject_index].from);
    snprintf(end, sizeof end, "%d", b->end);
    snprintf(tier, sizeof tier, "%s", plan_tier_name(p->tier));
    snprintf(trace_path, sizeof trace_path, "/dev/fd/%d", WORKER_TRACE);
    if (p->file || p->only) {
        words[n++] = p->file ? "--case" : "--only";
        words[n++] = p->file ? p->file : p->only;
    }
    if (p->user)
        words[n++] = "--user";
    if (b->given >= 0 && subject_index > 0) {
        snprintf(given, sizeof given, "/proc/%lld/fd/%d", (long long)getpid(), b->given);
        words[n++] = "--given";
        words[n++] = given;
    }
    char *argv[CAMPAIGN_WORDS];
    for (size_t i = 0; i < CAMPAIGN_WORDS; i++)
        argv[i] = (char *)(uintptr_t)words[i];
    const double left = r->o->limit_s - r->c->seconds[subject_index];
    *s = (slot){.batch = number, .subject_index = subject_index};
    ost_status status = scratch_file(&s->trace, err);
    if (status != OST_OK)
        return status;
    status = worker_start(argv, s->trace, user_store_fd(p->user), left > 1 ? left : 1, &s->w, err);
    if (status != OST_OK) {
        close(s->trace);
        return status;
    }
    b->tasks[subject_index].running = true;
    r->running++;
    if (r->o->show)
        r->o->show(r->o->user, r->c->subjects->subjects[subject_index].spec,
                   (double)r->finished / ((double)p->count * r->c->subjects->count));
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
        for (const stored_trace *k = batch_of(r, n)->stored_traces; k; k = k->next)
            bytes += k->got.size;
    }
    if (bytes > r->c->trace_bytes)
        r->c->trace_bytes = bytes;
}

/*
 * Fails if the way in which a worker ended says nothing about its backend: the worker could not allocate
 * memory or open a descriptor or a file, or SIGKILL ended it. This program sends SIGKILL only to a worker
 * that exceeded its time limit (WORKER_LATE). Any other SIGKILL came from another process or from the kernel,
 * usually because memory was exhausted.
 */
static ost_status resources_left(const char *spec, const worker_result *end, ost_error *err)
{
    enum { LOADER_FAILED = 127 }; /* exit status of a program that the dynamic loader could not start */
    if (end->end == WORKER_CRASHED && end->code == SIGKILL)
        return ost_fail(err, OST_ERR_IO,
                        "the worker of %s was ended from outside by SIGKILL, as the kernel does when memory runs out, "
                        "so that nothing is said about %s; "
                        "fewer --jobs need less memory",
                        spec, spec);
    if (end->end != WORKER_FAILED || (end->code != WORKER_EXIT_RESOURCES && end->code != LOADER_FAILED))
        return OST_OK;
    return ost_fail(err, OST_ERR_IO,
                    "%s was not compared, for lack of memory, descriptors or files: %s; fewer --jobs need less", spec,
                    end->text);
}

/* Fails if the disk is full, because a full disk must not be counted as a difference. */
static ost_status check_space_left(const worker_result *end, ost_error *err)
{
    static const int full[] = {ENOSPC, EDQUOT, EFBIG};
    for (size_t i = 0; i < sizeof full / sizeof full[0] && end->end == WORKER_FAILED; i++)
        if (strstr(end->text, strerror(full[i])))
            return ost_fail(err, OST_ERR_IO,
                            "%s: traces have no room, where TMPDIR says or in /tmp; fewer --jobs need less",
                            strerror(full[i]));
    return OST_OK;
}

slot runner_take(runner *r, int which, const worker_result *end)
{
    count_bytes(r);
    const slot s = r->slots[which];
    r->slots[which] = r->slots[--r->running];
    r->c->seconds[s.subject_index] += end->seconds;
    r->judged = s.subject_index;
    return s;
}

ost_status runner_judge(runner *r, const slot *ended, const worker_result *end, ost_error *err)
{
    const int subject_index = ended->subject_index;
    batch *b = batch_of(r, ended->batch);
    char name[SCRATCH_NAME];
    trace got = {0};
    ost_error unread = {0};
    b->tasks[subject_index].running = false;
    r->judged = NOBODY;
    scratch_name(ended->trace, name);
    const ost_status readable = trace_open(name, &got, &unread);
    if (subject_index == 0 && r->o->apart)
        b->given = ended->trace;
    else
        close(ended->trace); /* Closing the descriptor does not end the mapping of the file. */
    if (readable != OST_OK)
        got = (trace){0};
    ost_status status = check_space_left(end, err);
    if (status == OST_OK)
        status = resources_left(r->c->subjects->subjects[subject_index].spec, end, err);
    if (status == OST_OK && (unread.status == OST_ERR_MEMORY || unread.status == OST_ERR_IO))
        status = ost_fail(err, unread.status, "%s", unread.text);
    if (status == OST_OK && got.complete)
        status = paths_add(&r->c->paths[subject_index], &got.records[got.count - 1], err);
    if (status == OST_OK)
        status = subject_index == 0 ? results_of_reference(r, b, &got, end, err)
                                    : results_of_subject(r, b, subject_index, &got, end, err);
    trace_free(&got);
    return status;
}
