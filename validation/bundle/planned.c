/* SPDX-License-Identifier: Apache-2.0 */
#include "validation/bundle/planned.h"

#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "validation/bundle/evidence.h"
#include "validation/bundle/limits.h"
#include "validation/locate/case_file.h"
#include "validation/scene.h"
#include "validation/user_store.h"

enum { SHARDS_MAX = 999999, CASES_MAX = 1024, BACKENDS_MAX = 4096 };

static bool tier_of(const json_t *protocol, plan_tier *out)
{
    for (int t = 0; t < PLAN_TIERS; t++)
        if (strcmp(evidence_text(protocol, "tier"), plan_tier_name((plan_tier)t)) == 0) {
            *out = (plan_tier)t;
            return true;
        }
    return false;
}

static bool seed_of(const json_t *protocol, uint64_t *out)
{
    const char *text = evidence_text(protocol, "seed");
    char *end;
    errno = 0;
    *out = strtoull(text, &end, 10);
    return *text >= '0' && *text <= '9' && !*end && !errno;
}

/* Makes a plan of the cases in a case file (--case), in the order of the file. */
static ost_status plan_of_file(const json_t *file, const plan_user *user, plan *out, ost_error *err)
{
    const json_t *list = json_object_get(file, "cases");
    const size_t count = list ? json_array_size(list) : 1;
    *out = (plan){.shard = 1, .shards = 1, .file = "case.json", .user = user ? user->store : NULL};
    if (count < 1 || count > CASES_MAX)
        return ost_fail(err, OST_ERR_INPUT, "'case' must have 1 to %d cases", CASES_MAX);
    if (!(out->cases = calloc(count, sizeof *out->cases)))
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for %zu cases", count);
    for (size_t i = 0; i < count; i++) {
        const ost_status status = case_of_json(list ? json_array_get(list, i) : file, "case", user, &out->cases[i],
                                               err);
        if (status != OST_OK) {
            plan_free(out);
            return status;
        }
        out->total = ++out->count;
    }
    out->tier = out->cases[0].tier;
    out->seed = out->cases[0].seed;
    return OST_OK;
}

ost_status planned_of(const json_t *protocol, const plan_user *user, plan *out, ost_error *err)
{
    const json_t *shard = json_object_get(protocol, "shard"), *file = json_object_get(protocol, "case");
    const json_int_t i = json_integer_value(json_array_get(shard, 0)), n = json_integer_value(json_array_get(shard, 1));
    const size_t own = json_array_size(json_object_get(json_object_get(protocol, "user"), "cases"));
    const char *only = evidence_text(protocol, "only");
    const plan_user names = {.count = (int)(own <= USER_CASES_MAX ? own : 0)};
    plan_tier tier;
    uint64_t seed;
    if (!tier_of(protocol, &tier) || !seed_of(protocol, &seed))
        return ost_fail(err, OST_ERR_INPUT, "has no tier or no seed that osteon knows");
    if (file)
        return plan_of_file(file, user ? user : &names, out, err);
    if (json_array_size(shard) != 2 || n < 1 || n > SHARDS_MAX || i < 1 || i > n || own > USER_CASES_MAX)
        return ost_fail(err, OST_ERR_INPUT,
                        "has no shard [I, N] with 1 <= I <= N, or more than %d cases of the user's own files",
                        USER_CASES_MAX);
    return plan_make(tier, seed, (int)i, (int)n, *only ? only : NULL, user ? user : &names, out, err);
}

/* --------------------------------------------------------------- reporting */

typedef struct check {
    bundle_problem *problem;
    void *user;
    int *found;
} check;

static void report(const check *c, const char *file, const char *format, ...) OST_PRINTF(3, 4);
static void report(const check *c, const char *file, const char *format, ...)
{
    char text[512], plain[512];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    c->problem(c->user, BUNDLE_DIFFERENT, file, limits_printable(text, plain, sizeof plain));
    ++*c->found;
}

/* ---------------------------------------------------------------- protocol */

/* Reads the backends of a protocol. Returns false if there are none or too many, if two have the same name, if the
   first one is not "ref", or if memory is exhausted. */
static bool subjects_in(const json_t *protocol, subject_list *out)
{
    const json_t *backends = json_object_get(protocol, "backends");
    const size_t count = json_array_size(backends);
    *out = (subject_list){.subjects = count && count <= BACKENDS_MAX ? calloc(count, sizeof *out->subjects) : NULL};
    if (!out->subjects)
        return false;
    for (size_t s = 0; s < count; s++) {
        const json_t *one = json_array_get(backends, s);
        subject *to = &out->subjects[out->count++];
        to->available = json_is_true(json_object_get(one, "available"));
        snprintf(to->spec, sizeof to->spec, "%s", evidence_text(one, "name"));
        snprintf(to->what, sizeof to->what, "%s", evidence_text(one, "what"));
        snprintf(to->reason, sizeof to->reason, "%s", evidence_text(one, "reason"));
        for (size_t k = 0; k < s; k++)
            if (strcmp(out->subjects[k].spec, to->spec) == 0)
                return false;
    }
    out->opencl = json_is_true(json_object_get(protocol, "opencl"));
    snprintf(out->no_opencl, sizeof out->no_opencl, "%s", evidence_text(protocol, "no_opencl"));
    return strcmp(out->subjects[0].spec, "ref") == 0;
}

/* Checks that the bundle's protocol equals the protocol that this program writes for the same plan, options and
   backends. */
static ost_status check_protocol(const check *c, const json_t *protocol, const plan *p, ost_error *err)
{
    subject_list subjects;
    json_t *again = NULL, *value;
    const char *key, *only = evidence_text(protocol, "only");
    if (!subjects_in(protocol, &subjects)) {
        report(c, EVIDENCE_PROTOCOL, "has no list of backends that begins with 'ref' and names each once");
        subjects_free(&subjects);
        return OST_OK;
    }
    plan named = *p;
    named.only = *only ? only : NULL;
    ost_status status = evidence_protocol(&named, &subjects, evidence_text(protocol, "chosen"),
                                          json_is_true(json_object_get(protocol, "cpu_only")), &again, err);
    subjects_free(&subjects);
    if (status != OST_OK)
        return status;
    /* Keys that are checked elsewhere: "case" by planned_of, "user" by comparison with the files (--rerun), and
       "suite" by suite_check. */
    static const char *const given[] =
        {"case", "user", "suite"};
    for (size_t k = 0; k < sizeof given / sizeof given[0]; k++)
        if (json_object_get(protocol, given[k]))
            json_object_set(again, given[k], json_object_get(protocol, given[k]));
    json_object_foreach((json_t *)(uintptr_t)protocol, key, value) {
        const json_t *expected = json_object_get(again, key);
        if (!expected)
            report(c, EVIDENCE_PROTOCOL, "has '%.40s', which no protocol has", key);
        else if (!json_equal(value, expected))
            report(c, EVIDENCE_PROTOCOL, "'%.40s' is not what tier, seed and options give%s%s", key,
                   strcmp(key, "version") == 0 ? "; this is osteon " : "",
                   strcmp(key, "version") == 0 ? ost_version() : "");
    }
    json_object_foreach(again, key, value)
        if (!json_object_get(protocol, key))
            report(c, EVIDENCE_PROTOCOL, "has no '%.40s'", key);
    json_decref(again);
    return OST_OK;
}

/* ------------------------------------------------------------------- cases */

static ost_status check_input(const check *c, const plan_case *planned, const json_t *one, ost_error *err)
{
    scene s;
    ost_digest digest;
    char hex[OST_DIGEST_HEX];
    ost_status status = scene_make(planned, &s, err);
    if (status != OST_OK)
        return status;
    status = scene_digest(&s, &digest, err);
    scene_free(&s);
    if (status == OST_OK && strcmp(ost_digest_hex(&digest, hex), evidence_text(one, "input_sha256")) != 0)
        report(c, EVIDENCE_CASES, "%s: its input is not the one that tier and seed give", planned->id);
    return status;
}

static ost_status check_cases(const check *c, const plan *p, const json_t *cases, ost_error *err)
{
    ost_status status = OST_OK;
    if (json_array_size(cases) != (size_t)p->count)
        report(c, EVIDENCE_CASES, "has %zu cases; tier, seed and options give %d", json_array_size(cases), p->count);
    for (int i = 0; i < p->count && status == OST_OK; i++) {
        const json_t *one = json_array_get(cases, (size_t)i);
        if (strcmp(evidence_text(one, "id"), p->cases[i].id) != 0) {
            report(c, EVIDENCE_CASES, "line %d is case '%.31s'; tier, seed and options give %s", i + 1,
                   evidence_text(one, "id"), p->cases[i].id);
            break;
        }
        if (p->cases[i].family != PLAN_USER)
            status = check_input(c, &p->cases[i], one, err);
    }
    return status;
}

ost_status planned_check(const json_t *protocol, const json_t *cases, bundle_problem *problem, void *user, int *found,
                         ost_error *err)
{
    const check c = {problem, user, found};
    ost_error why = {0};
    plan p;
    ost_status status = planned_of(protocol, NULL, &p, &why);
    if (status == OST_ERR_MEMORY)
        return ost_fail(err, status, "%s", why.text);
    if (status != OST_OK) {
        report(&c, EVIDENCE_PROTOCOL, "%s", why.text);
        return OST_OK;
    }
    status = check_protocol(&c, protocol, &p, err);
    if (status == OST_OK)
        status = check_cases(&c, &p, cases, err);
    plan_free(&p);
    return status;
}
