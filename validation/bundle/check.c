/* SPDX-License-Identifier: Apache-2.0 */
#include "validation/bundle/check.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "validation/bundle/evidence.h"
#include "validation/bundle/folder.h"
#include "validation/bundle/judge.h"
#include "validation/bundle/limits.h"
#include "validation/bundle/log.h"
#include "validation/bundle/planned.h"
#include "validation/bundle/record.h"
#include "validation/bundle/suite.h"
#include "validation/bundle/tools.h"
#include "validation/report/report.h"

enum { PROBLEMS_MAX = 1000 };

typedef struct derivation {
    const char *folder;
    bundle_problem *problem;
    void *user;
    int *found;
    /* text that is appended to a problem: a note that another build made the bundle, or "" if this build made it */
    char other_build[160];
} derivation;

static void report_problem(const derivation *d, bundle_problem_kind kind, const char *name, const char *text)
{
    d->problem(d->user, kind, name, text);
    ++*d->found;
}

static ost_status compare_derived(void *user, const char *name, const void *bytes, size_t size, ost_error *err)
{
    const derivation *d = user;
    bool absent, same;
    if (strcmp(name, EVIDENCE_CASES) == 0) /* cases.jsonl has already been compared line by line, while it was read. */
        return OST_OK;
    const ost_status status = folder_compare(d->folder, name, bytes, size, &absent, &same, err);
    if (status != OST_OK)
        return status;
    if (absent)
        report_problem(d, BUNDLE_ABSENT, name, "is missing");
    else if (!same) {
        char text[256];
        snprintf(text, sizeof text, "does not match %s%s",
                 strcmp(name, REPORT_FILE) == 0 ? "the other files" : "the files that it is computed from",
                 d->other_build);
        report_problem(d, BUNDLE_DIFFERENT, name, text);
    }
    return OST_OK;
}

/* Stores a note in d->other_build if another build made the bundle. That build may derive the files by different rules,
   so a difference does not prove that the files were forged. */
static ost_status compare_builds(derivation *d, ost_error *err)
{
    json_t *tools;
    ost_error why = {0};
    char plain[64];
    const ost_status status = bundle_find_json(d->folder, TOOLS_FILE, &tools, &why);
    if (status != OST_OK)
        return status == OST_ERR_INPUT
                   ? OST_OK
                   /* linked_check reports invalid JSON, so this error is ignored here. */
                   : ost_fail(err, status, "%s", why.text);
    const char *commit = evidence_text(json_object_get(tools, "build"), "commit");
    if (*commit && strcmp(commit, tools_commit()) != 0)
        snprintf(d->other_build, sizeof d->other_build, "; but it was made by build %.48s and this is %.48s",
                 limits_printable(commit, plain, sizeof plain), tools_commit());
    json_decref(tools);
    return OST_OK;
}

static void report_verdict(void *user, const char *text)
{
    const derivation *d = user;
    if (*d->found < PROBLEMS_MAX)
        report_problem(d, BUNDLE_DIFFERENT, EVIDENCE_CASES, text);
}

/* Reads protocol.json into *out. If the file is absent or not valid, reports a problem and sets *out to NULL. */
static ost_status read_protocol(const derivation *d, json_t **out, ost_error *err)
{
    ost_error why = {0};
    ost_status status = bundle_find_json(d->folder, EVIDENCE_PROTOCOL, out, &why);
    if (status == OST_ERR_INPUT || (status == OST_OK && !json_is_object(*out))) {
        report_problem(d, status == OST_OK && !*out ? BUNDLE_ABSENT : BUNDLE_DIFFERENT, EVIDENCE_PROTOCOL,
                       status == OST_OK && !*out ? "is missing" : "is no JSON object within the limits of a bundle");
        json_decref(*out);
        *out = NULL;
        return OST_OK;
    }
    /* A bundle may contain any JSON file as protocol.json, so the format number is checked. */
    if (status == OST_OK && !json_is_integer(json_object_get(*out, "schema"))) {
        report_problem(d, BUNDLE_DIFFERENT, EVIDENCE_PROTOCOL, "has no number of a format ('schema')");
        json_decref(*out);
        *out = NULL;
        return OST_OK;
    }
    return status == OST_OK ? evidence_check_format(d->folder, *out, err) : ost_fail(err, status, "%s", why.text);
}

static ost_status read_cases(const derivation *d, json_t **out, ost_error *err)
{
    ost_error why = {0};
    bool absent, same;
    ost_status status = folder_compare(d->folder, EVIDENCE_CASES, "", 0, &absent, &same, err);
    *out = NULL;
    if (status == OST_OK && absent)
        report_problem(d, BUNDLE_ABSENT, EVIDENCE_CASES, "is missing");
    if (status != OST_OK || absent)
        return status;
    status = evidence_read_cases(d->folder, false, out, &why);
    if (status == OST_ERR_INPUT) {
        report_problem(d, BUNDLE_DIFFERENT, EVIDENCE_CASES, why.text);
        return OST_OK;
    }
    return status == OST_OK ? OST_OK : ost_fail(err, status, "%s", why.text);
}

/* Recomputes every file that is derived from the protocol and the cases, and compares it. */
static ost_status check_evidence(derivation *d, const json_t *protocol, const json_t *cases, json_t **summary,
                                 ost_error *err)
{
    ost_status status = compare_builds(d, err);
    if (status == OST_OK)
        status = planned_check(protocol, cases, d->problem, d->user, d->found, err);
    for (size_t i = 0; i < json_array_size(cases) && status == OST_OK; i++)
        judge_case(protocol, json_array_get(cases, i), report_verdict, d);
    if (status == OST_OK)
        status = linked_check(d->folder, protocol, d->problem, d->user, d->found, err);
    if (status == OST_OK)
        status = suite_check(d->folder, protocol, d->problem, d->user, d->found, err);
    if (status == OST_OK)
        status = evidence_summary(protocol, cases, summary, err);
    if (status == OST_OK)
        status = log_check(d->folder, protocol, *summary, d->problem, d->user, d->found, err);
    if (status == OST_OK)
        status = evidence_write(protocol, cases, compare_derived, d, err);
    if (status == OST_OK)
        status = record_derive(d->folder, protocol, cases, compare_derived, d, err);
    return status == OST_OK ? report_write(d->folder, protocol, cases, compare_derived, d, err) : status;
}

ost_status check_bundle(const char *folder, bundle_problem *problem, void *user, int *found, json_t **summary,
                        ost_error *err)
{
    derivation d = {folder, problem, user, found, ""};
    json_t *protocol = NULL, *cases = NULL;
    *summary = NULL;
    *found = 0;
    folder_files files;
    ost_status status = folder_list(folder, &files, problem, user, found, err);
    if (status != OST_OK)
        return status;
    folder_free(&files);
    if (*found) /* the folder contains files that are not allowed in a bundle, so no file is read */
        return OST_OK;
    status = read_protocol(&d, &protocol, err);
    if (status == OST_OK)
        status = bundle_check(folder, problem, user, found, err);
    if (status == OST_OK)
        status = read_cases(&d, &cases, err);
    if (status == OST_OK && protocol && cases)
        status = check_evidence(&d, protocol, cases, summary, err);
    json_decref(protocol);
    json_decref(cases);
    return status;
}
