/* SPDX-License-Identifier: Apache-2.0 */
/* Reads the dumps of a campaign. A dump is a folder of grids that are compared like the results of a backend. */
#include "validation/campaign_parts.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "validation/dump/dump.h"
#include "validation/scratch.h"

const char *dump_of(const campaign *c, int subject_index)
{
    const char *spec = c->subjects->subjects[subject_index].spec;
    return strncmp(spec, SUBJECT_DUMP, strlen(SUBJECT_DUMP)) == 0 ? spec + strlen(SUBJECT_DUMP) : NULL;
}

ost_status dumps_check(const campaign *c, ost_error *err)
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
            return ost_fail(err, OST_ERR_USAGE,
                            "%s: its cases are of tier %s, seed %llu; compared are those of tier %s, seed %llu",
                            dump_of(c, s), plan_tier_name(head.tier), (unsigned long long)head.seed,
                            plan_tier_name(p->tier), (unsigned long long)p->seed);
    }
    return OST_OK;
}

ost_status dump_to_results(runner *r, batch *b, int subject_index, ost_error *err)
{
    campaign *c = r->c;
    char name[SCRATCH_NAME];
    trace got = {0};
    bool any = false;
    int fd;
    uint64_t *compared = calloc((size_t)c->plan->count, sizeof *compared);
    ost_status status =
        compared ? scratch_file(&fd, err) : ost_fail(err, OST_ERR_MEMORY, "out of memory for %d cases",
                                                     c->plan->count);
    if (status != OST_OK) {
        free(compared);
        return status;
    }
    scratch_name(fd, name);
    status = dump_trace(dump_of(c, subject_index), c->plan, b->first, b->end, &b->reference, c->ranges, name, compared,
                        err);
    if (status == OST_OK)
        status = trace_open(name, &got, err);
    close(fd);
    for (int i = b->first; i < b->end && status == OST_OK; i++) {
        case_result *one = verdict_of(c, i, subject_index);
        bool differs = false;
        int judged;
        if (compared[i])
            status = results_judge(r, b, subject_index, &got, i, i + 1, &judged, &differs, err);
        else {
            one->verdict = CASE_NOT_RUN;
            r->finished++;
        }
        any |= differs;
        if (one->verdict == CASE_EQUAL || one->verdict == CASE_NOT_RUN)
            snprintf(one->text, sizeof one->text, "%llu of %zu records are in the dump; reports never are",
                     (unsigned long long)compared[i], c->ranges[i].count - 1);
    }
    b->tasks[subject_index].from = b->end;
    if (status == OST_OK && any)
        status = batch_store_trace(b, subject_index, b->first, b->end - b->first, &got, err);
    trace_free(&got);
    free(compared);
    return status;
}
