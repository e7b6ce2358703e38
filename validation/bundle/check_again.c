/* SPDX-License-Identifier: Apache-2.0 */
#include "validation/bundle/check.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "validation/bundle/evidence.h"
#include "validation/locate/case_file.h"
#include "validation/perform.h"
#include "validation/scene.h"
#include "validation/scratch.h"

/* A case's plan entry from what the protocol and its line say; false when there is no such case. out->cut is the caller's. */
static bool case_of(const json_t *protocol, size_t number, const char *id, const plan_user *own, plan_case *out)
{
    const char *tier = json_string_value(json_object_get(protocol, "tier")), *seed = json_string_value(json_object_get(protocol, "seed"));
    const json_t *file = json_object_get(protocol, "case"), *list = json_object_get(file, "cases");
    ost_error none = {0};
    if (file)
        return case_of_json(list ? json_array_get(list, number) : file, "case", own, out, &none) == OST_OK && id && strcmp(out->id, id) == 0;
    for (int t = 0; tier && seed && id && t < PLAN_TIERS; t++)
        if (strcmp(tier, plan_tier_name((plan_tier)t)) == 0)
            return plan_find((plan_tier)t, strtoull(seed, NULL, 10), id, own, out);
    return false;
}

static ost_status trace_case(ost_backend *ref, const scene *s, const char *path, trace *out, ost_error *err)
{
    trace_writer *w;
    ost_error why;
    ost_status status = trace_create(path, &w, err);
    if (status != OST_OK)
        return status;
    status = perform(ref, s, 0, w, NULL, NULL, &why, err);
    ost_status closed = trace_close(w, err);
    status = status != OST_OK ? status : closed;
    return status == OST_OK ? trace_open(path, out, err) : status;
}

static ost_status check_case(ost_backend *ref, const json_t *protocol, size_t number, const json_t *line, const plan_user *own, const char *path, const char **problem, ost_error *err)
{
    const char *id = json_string_value(json_object_get(line, "id")), *input = json_string_value(json_object_get(line, "input_sha256"));
    plan_case c = {.cut = NULL};
    scene s;
    trace t = {0};
    ost_digest digest;
    char hex[OST_DIGEST_HEX];
    *problem = NULL;
    if (!case_of(protocol, number, id, own, &c)) {
        free(c.cut);
        *problem = "is a case that this version does not have";
        return OST_OK;
    }
    ost_status status = scene_make(&c, &s, err);
    free(c.cut);
    if (status != OST_OK)
        return status;
    status = scene_digest(&s, &digest, err);
    if (status == OST_OK && (!input || strcmp(ost_digest_hex(&digest, hex), input) != 0))
        *problem = "has another input than the bundle says";
    if (status == OST_OK && !*problem)
        status = trace_case(ref, &s, path, &t, err);
    if (status == OST_OK && !*problem) {
        json_t *records;
        status = evidence_records(&t, compare_find(&t, 0), &records, err);
        if (status == OST_OK && !json_equal(records, json_object_get(line, "reference")))
            *problem = "comes out otherwise on the reference here than the bundle says";
        json_decref(records);
    }
    trace_free(&t);
    scene_free(&s);
    return status;
}

ost_status check_again(const char *folder, const plan_user *own, bundle_problem *problem, void *user, int *found, void (*show)(void *user, const char *what, double share),
                       void *show_user, ost_error *err)
{
    char *protocol_text = NULL, *cases_text = NULL, path[SCRATCH_NAME];
    int fd = -1;
    size_t protocol_size, cases_size;
    json_t *protocol = NULL, *cases = NULL;
    ost_backend *ref = NULL;
    ost_status status = bundle_read(folder, EVIDENCE_PROTOCOL, &protocol_text, &protocol_size, err);
    if (status == OST_OK)
        status = bundle_read(folder, EVIDENCE_CASES, &cases_text, &cases_size, err);
    if (status == OST_OK && !(protocol = json_loadb(protocol_text, protocol_size, JSON_REJECT_DUPLICATES, NULL)))
        status = ost_fail(err, OST_ERR_INPUT, "%s/%s: no JSON", folder, EVIDENCE_PROTOCOL);
    if (status == OST_OK)
        status = evidence_parse_cases(cases_text, cases_size, &cases, err);
    if (status == OST_OK)
        status = ost_backend_open("ref", &ref, err);
    if (status == OST_OK)
        status = scratch_file(&fd, err);
    if (status == OST_OK) {
        scratch_name(fd, path);
        for (size_t i = 0; i < json_array_size(cases) && status == OST_OK; i++) {
            const json_t *line = json_array_get(cases, i);
            const char *what, *id = json_string_value(json_object_get(line, "id"));
            if (show)
                show(show_user, id ? id : "", (double)i / (double)json_array_size(cases));
            status = check_case(ref, protocol, i, line, own, path, &what, err);
            if (status == OST_OK && what) {
                problem(user, BUNDLE_DIFFERENT, id ? id : EVIDENCE_CASES, what);
                ++*found;
            }
        }
    }
    if (fd >= 0)
        close(fd);
    ost_backend_close(ref);
    json_decref(protocol);
    json_decref(cases);
    free(protocol_text);
    free(cases_text);
    return status;
}
