/* SPDX-License-Identifier: Apache-2.0 */
/* Begins and ends the batches of a campaign, in an order that does not depend on the speed of the workers. */
#include "validation/campaign_parts.h"

#include <stdlib.h>
#include <unistd.h>

batch *batch_of(runner *r, int number)
{
    return &r->alive[number % ALIVE];
}

ost_status batch_begin(runner *r, ost_error *err)
{
    const int number = r->begun, count = r->c->subjects->count;
    batch *b = batch_of(r, number);
    *b = (batch){.first = number ? r->ends[number - 1] : 0, .end = r->ends[number], .open = true, .given = -1};
    b->tasks = calloc((size_t)count, sizeof *b->tasks);
    if (!b->tasks)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a list of backends");
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

ost_status batch_store_trace(batch *b, int subject_index, int from, int judged, trace *got, ost_error *err)
{
    stored_trace *stored = malloc(sizeof *stored);
    if (!stored)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a list of traces");
    *stored = (stored_trace){subject_index, from, judged, *got, b->stored_traces};
    *got = (trace){0};
    b->stored_traces = stored;
    return OST_OK;
}

void batch_free(batch *b)
{
    for (stored_trace *k = b->stored_traces, *next; k; k = next) {
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

bool batch_is_done(const runner *r, const batch *b)
{
    bool done = b->open && b->ready;
    for (int s = 0; s < r->c->subjects->count && done; s++)
        done = b->tasks[s].from == b->end && !b->tasks[s].running;
    return done;
}

/* Locates each difference and calls options->differs for it, in order of backend and then of case. */
static void show_differences(runner *r, const batch *b)
{
    campaign *c = r->c;
    for (int s = 1; s < c->subjects->count; s++)
        for (int i = b->first; i < b->end; i++)
            for (const stored_trace *k = b->stored_traces; k; k = k->next) {
                if (k->subject_index != s || i < k->from || i >= k->from + k->judged ||
                    verdict_of(c, i, s)->verdict != CASE_DIFFERS)
                    continue;
                const compare_range range = compare_find(&k->got, (uint32_t)i);
                case_result *one = verdict_of(c, i, s);
                one->found = finding_of_case(&c->plan->cases[i], &c->reference, c->ranges[i], &k->got, range,
                                             &one->difference);
                one->margins = verdict_margins(c, i, &k->got, range, r->o->apart);
                if (r->o->differs)
                    r->o->differs(r->o->keeper, c, i, s, &k->got, range);
            }
}

ost_status batch_end(runner *r, ost_error *err)
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
