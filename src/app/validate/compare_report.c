/* SPDX-License-Identifier: Apache-2.0 */
#include "app/validate/compare.h"

#include <stdio.h>

#include "app/common/print.h"
#include "app/common/result.h"
#include "app/validate/validate.h"
#include "validation/bundle/evidence.h"

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

ost_status compare_report(app_state *app, const campaign *c, bool apart, ost_error *err)
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
