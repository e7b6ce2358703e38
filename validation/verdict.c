/* SPDX-License-Identifier: Apache-2.0 */
#include "validation/verdict.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const char *case_verdict_name(case_verdict verdict)
{
    static const char *const names[CASE_VERDICTS] = {"equal", "differs", "failed", "crashed", "timed out", "not run"};
    return names[verdict];
}

case_result *verdict_of(campaign *c, int case_index, int subject_index)
{
    return &c->results[(size_t)case_index * (size_t)c->subjects->count + (size_t)subject_index];
}

static uint64_t bytes_of(const trace *t, compare_range r)
{
    uint64_t bytes = 0;
    for (size_t i = 0; i < r.count; i++)
        bytes += t->records[r.first + i].body_bytes;
    return bytes;
}

/* Stores the error line of a failed stage. */
static void describe_failure(const trace_record *failed, case_result *one)
{
    size_t at = 0;
    trace_block_view block;
    if (trace_next_block(failed, &at, &block) && block.voxel_bytes == 1)
        snprintf(one->text, sizeof one->text, "%.*s", block.dims.x < 190 ? (int)block.dims.x : 190,
                 (const char *)block.voxels);
}

margins *verdict_margins(const campaign *c, int i, const trace *got, compare_range range, bool apart)
{
    scene s;
    margins *m = malloc(sizeof *m);
    if (!m || scene_make(&c->plan->cases[i], &s, NULL) != OST_OK) {
        free(m);
        return NULL;
    }
    const ost_status status = margins_of(&s, &c->reference, c->ranges[i], got, range, apart, m, NULL);
    scene_free(&s);
    if (status == OST_OK)
        return m;
    free(m);
    return NULL;
}

int verdict_judge(campaign *c, const trace *reference, int subject_index, const trace *got, int from, int until,
                  bool *differs)
{
    int judged = 0;
    size_t at = 0;
    *differs = false;
    for (int i = from; i < until; i++, judged++) {
        const compare_range range = compare_next(got, &at, (uint32_t)i);
        /* A case is complete in a trace if records of the next case or the trace's end record follow. */
        const bool last = range.count && range.first + range.count == got->count;
        if (!range.count || (last && !got->complete))
            break;
        case_result *one = verdict_of(c, i, subject_index);
        compare_case(reference, c->ranges[i], got, range, &one->difference);
        one->verdict = one->difference.kind == COMPARE_EQUAL ? CASE_EQUAL : CASE_DIFFERS;
        if (one->verdict == CASE_DIFFERS && got->records[range.first + range.count - 1].stage == TRACE_FAILED &&
            one->difference.kind == COMPARE_MISSING)
            one->verdict = CASE_FAILED;
        if (one->verdict == CASE_FAILED)
            describe_failure(&got->records[range.first + range.count - 1], one);
        *differs |= one->verdict == CASE_DIFFERS;
        c->records += one->difference.records;
        for (size_t k = 0; k < range.count; k++)
            one->own_steps += (got->records[range.first + k].flags & TRACE_MADE) != 0;
        if (one->verdict == CASE_EQUAL)
            c->bytes += bytes_of(got, range);
    }
    return judged;
}

void verdict_of_end(const worker_result *end, case_result *out)
{
    out->verdict = end->end == WORKER_LATE ? CASE_LATE : end->end == WORKER_CRASHED ? CASE_CRASHED : CASE_FAILED;
    if (end->end == WORKER_CRASHED)
        snprintf(out->text, sizeof out->text, "ended by signal %d (%s)%s%.120s", end->code, strsignal(end->code),
                 end->text[0] ? ": " : "", end->text);
    else if (end->end == WORKER_LATE)
        snprintf(out->text, sizeof out->text, "stopped after %.0f s", end->seconds);
    else
        snprintf(out->text, sizeof out->text, "%.190s", end->text[0] ? end->text : "it ended without a word");
}
