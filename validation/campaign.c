/* SPDX-License-Identifier: Apache-2.0 */
#include "validation/campaign_parts.h"

#include <sched.h>
#include <stdlib.h>
#include <unistd.h>

#include "validation/scratch.h"

/* Returns true if a worker of this backend is running or its trace is being judged. At most one worker per backend
   runs at a time, so that the backend's remaining time is well defined and only one process uses a device. */
static bool busy(const runner *r, int subject_index)
{
    for (int i = 0; i < r->running; i++)
        if (r->slots[i].subject_index == subject_index)
            return true;
    return r->judged == subject_index;
}

/* Chooses the next worker. Returns false if no worker can start before another one ends. */
static bool choose(runner *r, int *number, int *subject_index)
{
    /* The reference's next batch has priority, because all other backends are compared with the reference's trace. */
    if (r->begun < r->batches && r->begun < r->done + ALIVE && !busy(r, 0)) {
        *number = r->begun;
        *subject_index = 0;
        return true;
    }
    for (*number = r->done; *number < r->begun; ++*number) {
        const batch *b = batch_of(r, *number);
        /*
         * The search begins at the end of the list, because the backends of devices are last and take the longest
         * time.
         */
        for (*subject_index = r->c->subjects->count - 1; b->ready && *subject_index > 0; --*subject_index)
            if (b->tasks[*subject_index].from < b->end && !b->tasks[*subject_index].running && !busy(r, *subject_index))
                return true;
    }
    return false;
}

/* Divides the cases into batches. The estimated size of the traces of a batch is at most BATCH_BYTES, unless the batch
   has only one case. Returns the largest estimated size of a batch. */
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

static ost_status start_workers(runner *r, ost_error *err)
{
    ost_status status = OST_OK;
    int number, subject_index;
    while (status == OST_OK && r->running < r->c->jobs && choose(r, &number, &subject_index)) {
        if (subject_index == 0)
            status = batch_begin(r, err);
        if (status == OST_OK)
            status = dump_of(r->c, subject_index) ? dump_to_results(r, batch_of(r, number), subject_index, err)
                                                  : runner_start(r, number, subject_index, err);
    }
    return status;
}

static ost_status run_all(runner *r, ost_error *err)
{
    ost_status status = OST_OK;
    while (r->done < r->batches && status == OST_OK) {
        status = start_workers(r, err);
        if (status == OST_OK && r->running) {
            worker *all[WORKERS_MAX];
            worker_result end;
            int which;
            for (int i = 0; i < r->running; i++)
                all[i] = &r->slots[i].w;
            status = worker_wait_any(all, r->running, &which, &end, err);
            if (status == OST_OK) {
                const slot ended = runner_take(r, which, &end);
                /* Starts the next worker before judging, so that it runs while the finished trace is judged. */
                status = start_workers(r, err);
                if (status == OST_OK)
                    status = runner_judge(r, &ended, &end, err);
                else
                    close(ended.trace);
            }
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

ost_status campaign_run(const plan *p, const subject_list *subjects, const campaign_options *o, campaign *out,
                        ost_error *err)
{
    const size_t count = (size_t)subjects->count, cells = (size_t)p->count * count;
    runner r = {.c = out, .o = o, .judged = NOBODY};
    *out = (campaign){
        .plan = p, .subjects = subjects, .begun = time(NULL), .jobs = o->jobs ? o->jobs : campaign_cores()};
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
    if (!out->results || !out->ranges || !out->lines || !out->seconds || !out->paths || !r.ends || !r.gone ||
        !r.last_words)
        status = ost_fail(err, OST_ERR_MEMORY, "out of memory for %zu results", cells);
    if (status == OST_OK)
        status = dumps_check(out, err);
    /* the disk must have space for the traces of all workers and of the references, with a reserve */
    if (status == OST_OK)
        status = scratch_check_space(cut_batches(&r) * (uint64_t)(out->jobs + ALIVE), err);
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
