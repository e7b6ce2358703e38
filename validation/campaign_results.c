/* SPDX-License-Identifier: Apache-2.0 */
/* Computes the results of a campaign from the trace of each worker and the way in which the worker ended. */
#include "validation/campaign_parts.h"

#include <stdlib.h>
#include <string.h>

#include "validation/bundle/digests.h"

/* Stores the digest of a backend's results of case i, computed from the backend's trace. If the digest lines differ
   from those of the reference, stores these lines as well. */
static ost_status store_digests(runner *r, int i, int subject_index, const trace *got, ost_error *err)
{
    case_result *one = verdict_of(r->c, i, subject_index);
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

/* Stores the running times of the cases in a complete trace, which begins with case `from`. The times are in the last
   record but one. */
static void store_seconds(const runner *r, int subject_index, const trace *got, int from)
{
    uint64_t count;
    const uint8_t *words;
    const trace_record *times = got->complete && got->count > 1 ? &got->records[got->count - 2] : NULL;
    if (!times || times->stage != TRACE_END || times->item != TRACE_TIMES || !trace_words(times, &count, &words))
        return;
    for (uint64_t k = 0; k < count && from + (int)k < r->c->plan->count; k++)
        verdict_of(r->c, from + (int)k, subject_index)->seconds = 1e-6 * (double)trace_word_at(words, k);
}

ost_status results_judge(runner *r, const batch *b, int subject_index, const trace *got, int from, int until,
                         int *judged, bool *differs, ost_error *err)
{
    ost_status status = OST_OK;
    *judged = verdict_judge(r->c, &b->reference, subject_index, got, from, until, differs);
    r->finished += *judged;
    for (int i = from; i < from + *judged && status == OST_OK; i++)
        status = store_digests(r, i, subject_index, got, err);
    return status;
}

/* After a permanent failure of a backend, stores the result of this failure for the remaining cases of a batch. */
static void give_up(runner *r, batch *b, int subject_index)
{
    for (; b->tasks[subject_index].from < b->end; b->tasks[subject_index].from++, r->finished++)
        *verdict_of(r->c, b->tasks[subject_index].from, subject_index) = r->last_words[subject_index];
}

ost_status results_of_reference(runner *r, batch *b, trace *got, const worker_result *end, ost_error *err)
{
    campaign *c = r->c;
    size_t at = 0;
    ost_status status = OST_OK;
    if (end->end != WORKER_DONE)
        return ost_fail(err, OST_ERR_INTERNAL, "the reference did not finish: %s",
                        end->end == WORKER_LATE ? "it took too long; --limit gives more time"
                        : end->text[0]          ? end->text
                                                : "it ended without a word");
    if (!got->complete)
        return ost_fail(err, OST_ERR_INTERNAL, "the reference's trace is not whole");
    store_seconds(r, 0, got, b->first);
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

ost_status results_of_subject(runner *r, batch *b, int subject_index, trace *got, const worker_result *end,
                              ost_error *err)
{
    task *t = &b->tasks[subject_index];
    bool differs;
    int judged;
    const int from = t->from;
    ost_status status = results_judge(r, b, subject_index, got, from, b->end, &judged, &differs, err);
    if (status != OST_OK)
        return status;
    store_seconds(r, subject_index, got, from);
    t->from += judged;
    if (differs && batch_store_trace(b, subject_index, from, judged, got, err) != OST_OK)
        return err->status;
    if (t->from == b->end)
        return OST_OK;
    /* t->from is the case that was running when the worker ended. */
    case_result *one = verdict_of(r->c, t->from, subject_index);
    verdict_of_end(end, one);
    t->from++;
    r->finished++;
    /* after a timeout no time is left for further cases, and after a failure the backend would fail again */
    if (end->end != WORKER_CRASHED) {
        r->gone[subject_index] = true;
        r->last_words[subject_index] = *one;
        for (int n = r->done; n < r->begun; n++)
            if (batch_of(r, n)->ready)
                give_up(r, batch_of(r, n), subject_index);
    }
    return OST_OK;
}
