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

static void say_problem(const derivation *d, const char *name, const char *text)
{
    d->problem(d->user, name, text);
    ++*d->found;
}

static ost_status compare_derived(void *user, const char *name, const void *bytes, size_t size, ost_error *err)
{
    const derivation *d = user;
    char *there;
    size_t there_size;
    ost_error unread = {0};
    (void)err;
    if (bundle_read(d->folder, name, &there, &there_size, &unread) != OST_OK)
        say_problem(d, name, "is missing");
    else if (there_size != size || memcmp(there, bytes, size) != 0) {
        char text[256];
        snprintf(text, sizeof text, "does not follow from %s%s", strcmp(name, REPORT_FILE) == 0 ? "the other files" : "the files that it is made of", d->other_build);
        say_problem(d, name, text);
    }
    free(there);
    return OST_OK;
}

/* What is derived is derived as this build does; another may do it otherwise, and then it is no forgery. */
static void compare_builds(derivation *d)
{
    char *bytes;
    size_t size;
    if (bundle_read(d->folder, TOOLS_FILE, &bytes, &size, NULL) != OST_OK)
        return;
    json_t *tools = json_loadb(bytes, size, JSON_REJECT_DUPLICATES, NULL);
    const char *commit = evidence_text(json_object_get(tools, "build"), "commit");
    if (*commit && strcmp(commit, tools_commit()) != 0)
        snprintf(d->other_build, sizeof d->other_build, "; but it was made by build %.48s and this is %.48s", commit, tools_commit());
    json_decref(tools);
    free(bytes);
}

/* The hash of protocol.json stands in the log before any result. */
static ost_status check_frozen(const derivation *d, const char *protocol, size_t size, ost_error *err)
{
    char *log, hex[OST_DIGEST_HEX];
    size_t log_size;
    ost_digest digest;
    ost_error unread = {0};
    ost_status status = ost_digest_bytes(protocol, size, &digest, err);
    if (status != OST_OK || bundle_read(d->folder, "audit.log", &log, &log_size, &unread) != OST_OK)
        return status;
    ost_digest_hex(&digest, hex);
    const char *frozen = strstr(log, "\tprotocol frozen\t"), *run = strstr(log, "\tresults\t");
    if (!frozen || strncmp(frozen + strlen("\tprotocol frozen\t"), hex, strlen(hex)) != 0)
        say_problem(d, "protocol.json", "is not the one that the log froze");
    else if (!run || run < frozen)
        say_problem(d, "audit.log", "has results before the protocol was frozen, or none");
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
    if (bundle_read(folder, EVIDENCE_PROTOCOL, &protocol_text, &protocol_size, &unread) == OST_OK)
        protocol = json_loadb(protocol_text, protocol_size, JSON_REJECT_DUPLICATES, NULL);
    if (bundle_read(folder, EVIDENCE_CASES, &cases_text, &cases_size, &unread) == OST_OK && evidence_parse_cases(cases_text, cases_size, &cases, &unread) != OST_OK)
        cases = NULL;
    if (!json_is_object(protocol))
        say_problem(&d, EVIDENCE_PROTOCOL, "is missing or no JSON object");
    if (!cases)
        say_problem(&d, EVIDENCE_CASES, cases_text ? unread.text : "is missing");
    if (json_is_object(protocol) && cases) {
        compare_builds(&d);
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
