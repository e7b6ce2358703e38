/* SPDX-License-Identifier: Apache-2.0 */
#include "validation/bundle/check.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "validation/bundle/evidence.h"
#include "validation/bundle/record.h"
#include "validation/bundle/tools.h"
#include "validation/report/report.h"

typedef struct derivation {
    const char *folder;
    bundle_problem *problem;
    void *user;
    int *found;
    char other_build[160]; /* "; ..." when the bundle was made by another build than this: it may write files otherwise */
} derivation;

static void say_problem(const derivation *d, bundle_problem_kind kind, const char *name, const char *text)
{
    d->problem(d->user, kind, name, text);
    ++*d->found;
}

static ost_status compare_derived(void *user, const char *name, const void *bytes, size_t size, ost_error *err)
{
    const derivation *d = user;
    char *there;
    size_t there_size;
    const ost_status status = bundle_find(d->folder, name, &there, &there_size, err);
    if (status != OST_OK)
        return status;
    if (!there)
        say_problem(d, BUNDLE_ABSENT, name, "is missing");
    else if (there_size != size || memcmp(there, bytes, size) != 0) {
        char text[256];
        snprintf(text, sizeof text, "does not follow from %s%s", strcmp(name, REPORT_FILE) == 0 ? "the other files" : "the files that it is made of", d->other_build);
        say_problem(d, BUNDLE_DIFFERENT, name, text);
    }
    free(there);
    return OST_OK;
}

/* What is derived is derived as this build does; another may do it otherwise, and then it is no forgery. */
static ost_status compare_builds(derivation *d, ost_error *err)
{
    char *bytes;
    size_t size;
    const ost_status status = bundle_find(d->folder, TOOLS_FILE, &bytes, &size, err);
    if (!bytes)
        return status;
    json_t *tools = json_loadb(bytes, size, JSON_REJECT_DUPLICATES, NULL);
    const char *commit = evidence_text(json_object_get(tools, "build"), "commit");
    if (*commit && strcmp(commit, tools_commit()) != 0)
        snprintf(d->other_build, sizeof d->other_build, "; but it was made by build %.48s and this is %.48s", commit, tools_commit());
    json_decref(tools);
    free(bytes);
    return OST_OK;
}

/* The hash of protocol.json stands in the log before any result. */
static ost_status check_frozen(const derivation *d, const char *protocol, size_t size, ost_error *err)
{
    char *log, hex[OST_DIGEST_HEX];
    size_t log_size;
    ost_digest digest;
    ost_status status = ost_digest_bytes(protocol, size, &digest, err);
    if (status == OST_OK)
        status = bundle_find(d->folder, "audit.log", &log, &log_size, err);
    if (status != OST_OK || !log)
        return status;
    ost_digest_hex(&digest, hex);
    const char *frozen = strstr(log, "\tprotocol frozen\t"), *run = strstr(log, "\tresults\t");
    if (!frozen || strncmp(frozen + strlen("\tprotocol frozen\t"), hex, strlen(hex)) != 0)
        say_problem(d, BUNDLE_DIFFERENT, "protocol.json", "is not the one that the log froze");
    else if (!run || run < frozen)
        say_problem(d, BUNDLE_DIFFERENT, "audit.log", "has results before the protocol was frozen, or none");
    free(log);
    return OST_OK;
}

ost_status check_bundle(const char *folder, bundle_problem *problem, void *user, int *found, json_t **summary, ost_error *err)
{
    derivation d = {folder, problem, user, found, ""};
    char *protocol_text = NULL, *cases_text = NULL;
    size_t protocol_size = 0, cases_size = 0;
    json_t *protocol = NULL, *cases = NULL;
    ost_error unread = {0};
    *summary = NULL;
    ost_status status = bundle_check(folder, problem, user, found, err);
    if (status != OST_OK)
        return status;
    status = bundle_find(folder, EVIDENCE_PROTOCOL, &protocol_text, &protocol_size, err);
    if (status == OST_OK)
        status = bundle_find(folder, EVIDENCE_CASES, &cases_text, &cases_size, err);
    if (status == OST_OK && protocol_text)
        protocol = json_loadb(protocol_text, protocol_size, JSON_REJECT_DUPLICATES, NULL);
    if (status == OST_OK && cases_text && evidence_parse_cases(cases_text, cases_size, &cases, &unread) != OST_OK)
        cases = NULL;
    if (unread.status == OST_ERR_MEMORY)
        status = ost_fail(err, unread.status, "%s", unread.text);
    if (status == OST_OK && !json_is_object(protocol))
        say_problem(&d, protocol_text ? BUNDLE_DIFFERENT : BUNDLE_ABSENT, EVIDENCE_PROTOCOL, protocol_text ? "is no JSON object" : "is missing");
    if (status == OST_OK && !cases)
        say_problem(&d, cases_text ? BUNDLE_DIFFERENT : BUNDLE_ABSENT, EVIDENCE_CASES, cases_text ? unread.text : "is missing");
    if (status == OST_OK && json_is_object(protocol) && cases) {
        status = compare_builds(&d, err);
        if (status == OST_OK)
            status = check_frozen(&d, protocol_text, protocol_size, err);
        if (status == OST_OK)
            status = evidence_write(protocol, cases, compare_derived, &d, err);
        if (status == OST_OK)
            status = record_derive(folder, cases, compare_derived, &d, err);
        if (status == OST_OK)
            status = report_write(folder, protocol, cases, compare_derived, &d, err);
        if (status == OST_OK)
            status = evidence_summary(protocol, cases, summary, err);
    }
    json_decref(protocol);
    json_decref(cases);
    free(protocol_text);
    free(cases_text);
    return status;
}
