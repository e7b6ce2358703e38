/* SPDX-License-Identifier: Apache-2.0 */
#include "validation/bundle/check.h"

#include <stdio.h>
#include <string.h>

#include "validation/bundle/evidence.h"
#include "validation/bundle/planned.h"
#include "validation/campaign.h"

typedef struct again {
    const json_t *cases;
    const char *spec; /* backend specification; NULL selects only the reference */
    bundle_problem *problem;
    void *user;
    int *found;
} again;

static void report(const again *a, const json_t *one, const char *text)
{
    a->problem(a->user, BUNDLE_DIFFERENT, *evidence_text(one, "id") ? evidence_text(one, "id") : EVIDENCE_CASES, text);
    ++*a->found;
}

/* Compares the reference's digests of a case, including the digests of leaves, with those of the bundle. */
static ost_status compare_reference(const again *a, const campaign *c, int i, const json_t *one, ost_error *err)
{
    json_t *row;
    const ost_status status = evidence_case(c, i, &row, err);
    if (status != OST_OK)
        return status;
    if (strcmp(evidence_text(row, "input_sha256"), evidence_text(one, "input_sha256")) != 0)
        report(a, one, "has another input than the bundle states");
    else if (!json_equal(json_object_get(row, "reference"), json_object_get(one, "reference")))
        report(a, one, "the reference here gives another result than the bundle states");
    json_decref(row);
    return OST_OK;
}

/* Compares the backend's digest with the digest of the bundle's result for this backend or, if there is no such
   result, with the reference's digest. */
static void compare_backend(const again *a, const campaign *c, int i, const json_t *one)
{
    const case_result *r = &c->results[(size_t)i * (size_t)c->subjects->count + 1];
    const json_t *there = json_object_get(json_object_get(one, "results"), a->spec);
    const char *stated = there ? evidence_text(there, "sha256") : evidence_text(one, "reference_sha256");
    char hex[OST_DIGEST_HEX] = "", text[400];
    if (r->has_made)
        ost_digest_hex(&r->made, hex);
    if (strcmp(hex, stated) == 0)
        return;
    snprintf(text, sizeof text, "%.200s gives another result here (%s%s%.100s) than %s", a->spec,
             case_verdict_name(r->verdict), r->text[0] ? ": " : "", r->text,
             there ? "the bundle states" : "the bundle's reference");
    report(a, one, text);
}

static ost_status take_batch(void *user, const campaign *c, int first, int count, ost_error *err)
{
    const again *a = user;
    ost_status status = OST_OK;
    for (int i = first; i < first + count && status == OST_OK; i++) {
        const json_t *one = json_array_get(a->cases, (size_t)i);
        status = compare_reference(a, c, i, one, err);
        if (status == OST_OK && a->spec)
            compare_backend(a, c, i, one);
    }
    return status;
}

ost_status check_again(const char *folder, const check_how *how, bundle_problem *problem, void *user, int *found,
                       ost_error *err)
{
    char file[BUNDLE_PATH + 16];
    json_t *protocol = NULL, *cases = NULL;
    subject_list subjects = {0};
    campaign run = {0};
    plan p = {0};
    ost_status status = evidence_read(folder, &protocol, &cases, err);
    if (status != OST_OK)
        return status;
    again a = {cases, NULL, problem, user, found};
    status = planned_of(protocol, how->own, &p, err);
    if (status == OST_OK && p.file) { /* The workers read the case from this file. */
        snprintf(file, sizeof file, "%.1000s/case.json", folder);
        p.file = file;
    }
    if (status == OST_OK)
        status = subjects_find(p.tier, how->backend ? how->backend : "ref", &subjects, err);
    if (status == OST_OK && how->backend && (subjects.count != 2 || !subjects.subjects[1].available))
        status = ost_fail(
            err, subjects.count == 2 ? OST_ERR_UNAVAILABLE : OST_ERR_USAGE, "--backend %.200s: %s", how->backend,
            subjects.count == 2 ? subjects.subjects[1].reason : "must name one backend other than the reference");
    if (status == OST_OK) {
        a.spec = how->backend ? subjects.subjects[1].spec : NULL;
        const campaign_options options = {.program = how->program,
                                          .limit_s = how->limit_s,
                                          .show = how->show,
                                          .user = how->show_user,
                                          .done = take_batch,
                                          .done_keeper = &a};
        status = campaign_run(&p, &subjects, &options, &run, err);
    }
    campaign_free(&run);
    subjects_free(&subjects);
    plan_free(&p);
    json_decref(protocol);
    json_decref(cases);
    return status;
}
