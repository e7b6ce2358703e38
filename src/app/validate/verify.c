/* SPDX-License-Identifier: Apache-2.0 */
#include "app/validate/verify.h"

#include <stdio.h>

#include "app/common/print.h"
#include "app/common/progress.h"
#include "app/common/result.h"
#include "validation/bundle/check.h"
#include "validation/bundle/sign.h"
#include "validation/bundle/suite.h"
#include "validation/worker.h"

#define PROTOCOL "protocol.json"
enum { LIMIT_S = 36000 }; /* time limit for each backend of --rerun, in seconds */

typedef struct listing {
    const app_state *app;
    json_t *problems;
    int absent;
    char first[200]; /* name of the first file that is missing */
} listing;

static void list_problem(void *user, bundle_problem_kind kind, const char *file, const char *problem)
{
    listing *l = user;
    if (kind == BUNDLE_ABSENT && l->absent++ == 0)
        snprintf(l->first, sizeof l->first, "%s", file);
    json_t *o = json_object();
    put_text(o, "file", file);
    put_text(o, "problem", problem);
    put_text(o, "kind", kind == BUNDLE_ABSENT ? "absent" : "different");
    append(l->problems, o);
    print_line(l->app, "  %s %s", file, problem);
}

static void show(void *user, const char *what, double share)
{
    (void)user;
    progress_show(NULL, what, share);
}

/*
 * Reads the record of the user's own files in the bundle. If the bundle has no such record, *out is NULL. The caller
 * owns *out.
 */
static ost_status record_of(const char *folder, json_t **out, ost_error *err)
{
    json_t *protocol;
    const ost_status status = bundle_read_json(folder, PROTOCOL, &protocol, err);
    *out = json_incref(json_object_get(protocol, "user"));
    json_decref(protocol);
    return status;
}

/* Runs the cases of the bundle again. The user's files are read first, because no case can be run without them. */
static ost_status rerun_all(app_state *app, const verify_args *args, listing *l, int *found, ost_error *err)
{
    json_t *record, *again = NULL;
    user_store *store = NULL;
    ost_status status = record_of(args->folder, &record, err);
    if (status == OST_OK && record)
        status = user_files_again(app, &args->own, record, &store, &again, err);
    else if (status == OST_OK && user_files_given(&args->own))
        status = ost_fail(err, OST_ERR_USAGE,
                          "%s: the bundle has no cases of user files; omit --ct, --tool and --path", args->folder);
    if (status == OST_OK && record && !json_equal(record, again)) {
        list_problem(l, BUNDLE_DIFFERENT, PROTOCOL,
                     "its record of the user's files differs from the record that these files give here");
        ++*found;
    }
    const plan_user user = {.count = user_store_count(store), .store = store};
    char program[BUNDLE_PATH];
    if (status == OST_OK)
        status = worker_program(program, sizeof program, err);
    if (status == OST_OK) {
        const check_how how = {.program = program,
                               .own = store ? &user : NULL,
                               .backend = args->backend,
                               .limit_s = LIMIT_S,
                               .show = show};
        status = check_again(args->folder, &how, list_problem, l, found, err);
        progress_end();
    }
    user_store_free(store);
    json_decref(again);
    json_decref(record);
    return status;
}

static const char *text_of(const json_t *o, const char *key)
{
    const char *text = json_string_value(json_object_get(o, key));
    return text ? text : "";
}

static void print_signature(const app_state *app, const json_t *one)
{
    const char *by = text_of(one, "by"), *stamp = text_of(one, "time_stamp");
    const json_t *keys = json_object_get(one, "keys");
    const bool checked = json_is_true(json_object_get(one, "checked"));
    print_line(app, "  %s %s%s%s on %s (claimed): %s", checked ? "signed" : "NOT CHECKED: signature",
               *by ? "by " : "without a name", by, checked ? "" : ",", text_of(one, "claimed_time"),
               text_of(one, "meaning"));
    for (size_t k = 0; k < json_array_size(keys); k++)
        print_line(app, "    key %s", json_string_value(json_array_get(keys, k)));
    if (*stamp)
        print_line(app, "    time stamp of the authority: %s", stamp);
    else if (json_is_true(json_object_get(one, "stamped")))
        print_line(app, "    its time stamp was not checked: pass --timestamp-ca FILE");
}

static ost_status check_signatures(app_state *app, const verify_args *args, listing *l, int *found, ost_error *err)
{
    sign_trust *trust = NULL;
    json_t *list = NULL;
    ost_status status = args->trust.count
                            ? sign_trust_open(args->trust.value, args->trust.count, args->authority, &trust, err)
                            : OST_OK;
    if (status == OST_OK)
        status = sign_check(args->folder, trust, list_problem, l, found, &list, err);
    if (status == OST_OK) {
        for (size_t i = 0; i < json_array_size(list); i++)
            print_signature(app, json_array_get(list, i));
        put_bool(app->result, "signatures_checked", trust != NULL);
        put(app->result, "signatures", json_incref(list));
    }
    json_decref(list);
    sign_trust_free(trust);
    return status;
}

/* Returns the part of the last output line that is about the signatures. */
static const char *about_signatures(const app_state *app, const verify_args *args)
{
    const size_t n = json_array_size(json_object_get(app->result, "signatures"));
    if (args->trust.count)
        return n == 1 ? "; its signature is by a trusted key" : "; its signatures are by trusted keys";
    return n ? "; signatures were not checked (--trust KEYS)" : "; it is not signed";
}

/*
 * Reports the counts of the test suite. A bundle may be valid although tests failed. Failures are therefore printed,
 * but are not treated as problems of the bundle.
 */
static ost_status print_suite(app_state *app, const char *folder, ost_error *err)
{
    json_t *suite;
    const ost_status status = bundle_find_json(folder, SUITE_FILE, &suite, err);
    if (!suite)
        return status;
    const json_int_t failed = json_integer_value(json_object_get(suite, "failed"));
    json_t *counts = json_object();
    static const char *const keys[] = {"passed", "failed", "skipped"};
    for (size_t k = 0; k < sizeof keys / sizeof keys[0]; k++)
        put_integer(counts, keys[k], json_integer_value(json_object_get(suite, keys[k])));
    put(app->result, "suite", counts);
    print_line(app, "  the test suite%s: %lld passed, %lld failed, %lld were skipped", failed ? " FAILED" : "",
               (long long)json_integer_value(json_object_get(suite, "passed")), (long long)failed,
               (long long)json_integer_value(json_object_get(suite, "skipped")));
    json_decref(suite);
    return status;
}

static void print_verdict(const app_state *app, const verify_args *args, const json_t *summary)
{
    print_line(app, "%s: valid%s; it says %s, %lld case%s%s%s", args->folder,
               !args->rerun    ? ""
               : args->backend ? ", and the reference and the backend give the same here"
                               : ", and the reference gives the same here",
               json_string_value(json_object_get(summary, "verdict")),
               (long long)json_integer_value(json_object_get(summary, "cases")),
               json_integer_value(json_object_get(summary, "cases")) == 1 ? "" : "s",
               json_is_true(json_object_get(summary, "evidence")) ? "" : " (a reduced run: no evidence)",
               about_signatures(app, args));
}

ost_status verify_bundle(app_state *app, const verify_args *args, ost_error *err)
{
    json_t *summary;
    int found = 0;
    listing l = {.app = app, .problems = json_array()};
    ost_status status = check_bundle(args->folder, list_problem, &l, &found, &summary, err);
    if (status == OST_OK)
        status = check_signatures(app, args, &l, &found, err);
    if (status == OST_OK && args->rerun && found == 0)
        status = rerun_all(app, args, &l, &found, err);
    put(app->result, "problems", l.problems);
    if (status != OST_OK) {
        json_decref(summary);
        return status;
    }
    put_bool(app->result, "rerun", args->rerun);
    if (args->backend)
        put_text(app->result, "rerun_on", args->backend);
    put_bool(app->result, "valid", found == 0);
    put_text(app->result, "bundle", args->folder);
    if (summary)
        json_object_update_missing(app->result, summary);
    if (found == 0) {
        print_verdict(app, args, summary);
        status = print_suite(app, args->folder, err);
    }
    json_decref(summary);
    if (status != OST_OK)
        return status;
    if (l.absent)
        return ost_fail(err, OST_ERR_INPUT, "%s: %s is missing%s; an incomplete bundle cannot be verified",
                        args->folder, l.first, found > 1 ? " (see the list for further problems)" : "");
    if (found)
        return ost_fail(err, OST_ERR_DIFFER, "%s: %d problem%s: the bundle was changed after it was written",
                        args->folder, found, found == 1 ? "" : "s");
    return OST_OK;
}
