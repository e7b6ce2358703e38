/* SPDX-License-Identifier: Apache-2.0 */
#include "validation/bundle/merge.h"

#include <dirent.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "validation/bundle/check.h"
#include "validation/bundle/environment.h"
#include "validation/bundle/evidence.h"
#include "validation/bundle/faults.h"
#include "validation/bundle/suite.h"

enum { SHARDS_MAX = 4096 };

static void remember_problem(void *user, bundle_problem_kind kind, const char *file, const char *problem)
{
    char *first = user;
    (void)kind;
    if (!first[0])
        snprintf(first, 256, "%.80s %.160s", file, problem);
}

/* Returns a copy of the protocol without the keys in which shards may differ. */
static json_t *common_part(const json_t *protocol)
{
    json_t *o = json_deep_copy(protocol);
    json_object_del(o, "shard");
    json_object_del(o, "cases");
    json_object_del(o, "suite"); /* Only the first shard runs the test suite, so only its protocol has this key. */
    return o;
}

static bool is_bundle(const char *folder)
{
    char path[BUNDLE_PATH];
    return snprintf(path, sizeof path, "%s/%s", folder, EVIDENCE_PROTOCOL) < (int)sizeof path &&
           access(path, F_OK) == 0;
}

/* Adds the cases of one bundle to the table `by_id`, and its environment and times to *m. */
static ost_status take_shard(const char *folder, merged *m, json_t *by_id, ost_error *err)
{
    char problem[256] = "", name[32];
    int found = 0;
    json_t *summary = NULL, *protocol = NULL, *environment = NULL, *times = NULL, *cases = NULL;
    ost_status status = check_bundle(folder, remember_problem, problem, &found, &summary, err);
    json_decref(summary);
    if (status == OST_OK && found)
        status = ost_fail(err, OST_ERR_INPUT, "%s: %s", folder, problem);
    if (status == OST_OK)
        status = evidence_read(folder, &protocol, &cases, err);
    if (status == OST_OK)
        status = bundle_read_json(folder, ENVIRONMENT_FILE, &environment, err);
    if (status == OST_OK)
        status = bundle_read_json(folder, TIMES_FILE, &times, err);
    if (status == OST_OK) {
        const json_t *shard = json_object_get(protocol, "shard");
        const int i = (int)json_integer_value(json_array_get(shard, 0)),
                  n = (int)json_integer_value(json_array_get(shard, 1));
        json_t *common = common_part(protocol);
        snprintf(name, sizeof name, "%d/%d", i, n);
        if (n < 1 || n > SHARDS_MAX || i < 1 || i > n)
            status = ost_fail(err, OST_ERR_INPUT, "%s: shard %d of %d", folder, i, n);
        else if (!m->protocol) {
            m->protocol = json_incref(common);
            m->shards = n;
        } else if (n != m->shards || !json_equal(common, m->protocol))
            status = ost_fail(err, OST_ERR_INPUT, "%s: belongs to another campaign than the others there", folder);
        if (status == OST_OK && json_object_get(m->environment, name))
            status = ost_fail(err, OST_ERR_INPUT, "%s: shard %s is there twice", folder, name);
        json_decref(common);
    }
    /* A bundle of selected cases contains no FAULTS_FILE. */
    if (status == OST_OK && strncmp(name, "1/", 2) == 0)
        status = bundle_find_json(folder, FAULTS_FILE, &m->faults, err);
    if (status == OST_OK && strncmp(name, "1/", 2) == 0 && json_object_get(protocol, "suite")) {
        m->suite_limit = json_incref(json_object_get(protocol, "suite"));
        status = bundle_find_json(folder, SUITE_FILE, &m->suite, err);
    }
    if (status == OST_OK) {
        json_object_set(m->environment, name, environment);
        json_object_set(m->times, name, times);
        for (size_t i = 0; i < json_array_size(cases); i++) {
            json_t *one = json_array_get(cases, i);
            const char *id = json_string_value(json_object_get(one, "id"));
            if (id)
                json_object_set(by_id, id, one);
        }
    }
    json_decref(cases);
    json_decref(times);
    json_decref(environment);
    json_decref(protocol);
    return status;
}

/* Sorts the cases into the order of the complete plan. Returns OST_ERR_INPUT if a case of the plan is in no shard. */
static ost_status put_in_order(const char *folder, merged *m, const json_t *by_id, ost_error *err)
{
    const char *tier_name = json_string_value(json_object_get(m->protocol, "tier")),
               *seed = json_string_value(json_object_get(m->protocol, "seed"));
    const char *only = json_string_value(json_object_get(m->protocol, "only"));
    int tier = 0;
    plan all_cases;
    while (tier < PLAN_TIERS && (!tier_name || strcmp(tier_name, plan_tier_name((plan_tier)tier)) != 0))
        tier++;
    if (tier == PLAN_TIERS || !seed)
        return ost_fail(err, OST_ERR_INPUT, "%s: a protocol without tier or seed", folder);
    const plan_user user = {
        .count = (int)json_array_size(json_object_get(json_object_get(m->protocol, "user"), "cases"))};
    ost_status status = plan_make((plan_tier)tier, strtoull(seed, NULL, 10), 1, 1, only && *only ? only : NULL, &user,
                                  &all_cases, err);
    if (status != OST_OK)
        return status;
    json_t *ids = json_array();
    m->cases = json_array();
    for (int i = 0; i < all_cases.count && status == OST_OK; i++) {
        json_t *one = json_object_get(by_id, all_cases.cases[i].id);
        if (!one)
            status = ost_fail(err, OST_ERR_INPUT, "%s: no shard has case %s", folder, all_cases.cases[i].id);
        json_array_append(m->cases, one);
        json_array_append_new(ids, json_string(all_cases.cases[i].id));
    }
    json_object_set_new(m->protocol, "cases", ids);
    json_object_set_new(m->protocol, "shard", json_pack("[i,i]", 1, 1));
    plan_free(&all_cases);
    return status;
}

ost_status merge_read(const char *folder, merged *out, ost_error *err)
{
    *out = (merged){.environment = json_object(), .times = json_object()};
    json_t *by_id = json_object();
    DIR *dir = opendir(folder);
    int count = 0;
    ost_status status = dir ? OST_OK : ost_fail(err, OST_ERR_INPUT, "%s: cannot open: %s", folder, strerror(errno));
    if (status == OST_OK && is_bundle(folder))
        status = ost_fail(err, OST_ERR_INPUT, "%s: is a bundle; expected a folder that contains one bundle per shard",
                          folder);
    for (struct dirent *e; status == OST_OK && (status = bundle_next_entry(dir, folder, &e, err)) == OST_OK && e;) {
        char path[BUNDLE_PATH];
        if (e->d_name[0] == '.' || strstr(e->d_name, ".part-"))
            continue;
        if (snprintf(path, sizeof path, "%s/%s", folder, e->d_name) >= (int)sizeof path)
            status = ost_fail(err, OST_ERR_INPUT, "%s: a name in it is too long", folder);
        else
            status = take_shard(path, out, by_id, err);
        count++;
    }
    if (dir)
        closedir(dir);
    if (status == OST_OK && !out->protocol)
        status = ost_fail(err, OST_ERR_INPUT, "%s: contains no bundle; expected one folder per shard", folder);
    if (status == OST_OK && count != out->shards)
        status = ost_fail(err, OST_ERR_INPUT, "%s: contains bundles of %d of %d shards", folder, count, out->shards);
    if (status == OST_OK)
        status = put_in_order(folder, out, by_id, err);
    if (status == OST_OK && out->suite_limit)
        json_object_set(out->protocol, "suite", out->suite_limit);
    json_decref(by_id);
    if (status != OST_OK)
        merge_free(out);
    return status;
}

void merge_free(merged *m)
{
    json_decref(m->protocol);
    json_decref(m->cases);
    json_decref(m->environment);
    json_decref(m->times);
    json_decref(m->faults);
    json_decref(m->suite);
    json_decref(m->suite_limit);
    *m = (merged){0};
}
