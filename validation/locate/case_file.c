/* SPDX-License-Identifier: Apache-2.0 */
#include "validation/locate/case_file.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/file.h"

/* Maximum size in bytes of a case file, and maximum number of cases in it. */
enum { FILE_MAX = 1 << 22, CASES_MAX = 1024 };

static ost_status bad(const char *where, ost_error *err, const char *what)
{
    return ost_fail(err, OST_ERR_INPUT, "%.200s: %s", where, what);
}

static bool number_in(const json_t *v, json_int_t least, json_int_t most, int64_t *out)
{
    if (!json_is_integer(v) || json_integer_value(v) < least || json_integer_value(v) > most)
        return false;
    *out = json_integer_value(v);
    return true;
}

/* Appends the range [from, to) to the list. Returns false if the range is invalid. */
static bool add_range(const json_t *from, const json_t *to, cut_list *list)
{
    int64_t a, b;
    const int64_t least = list->count ? list->range[list->count - 1][1] : 0;
    list->some = true;
    if (list->count == CUT_RANGES || !number_in(from, least, INT32_MAX, &a) || !number_in(to, a + 1, INT32_MAX, &b))
        return false;
    list->range[list->count][0] = (uint32_t)a;
    list->range[list->count++][1] = (uint32_t)b;
    return true;
}

static bool read_list(const json_t *v, cut_list *list)
{
    if (!v)
        return true;
    if (!json_is_array(v))
        return false;
    list->some = true;
    for (size_t i = 0; i < json_array_size(v); i++) {
        const json_t *one = json_array_get(v, i);
        if (json_array_size(one) != 2 || !add_range(json_array_get(one, 0), json_array_get(one, 1), list))
            return false;
    }
    return true;
}

static bool read_crop(const json_t *v, scene_cut *cut)
{
    if (!v)
        return true;
    cut->cropped = true;
    if (json_array_size(v) != 2)
        return false;
    for (size_t end = 0; end < 2; end++)
        for (size_t a = 0; a < 3; a++) {
            int64_t at;
            if (json_array_size(json_array_get(v, end)) != 3 ||
                !number_in(json_array_get(json_array_get(v, end), a), 0, OST_DIM_MAX, &at))
                return false;
            (end ? cut->hi : cut->lo)[a] = (int32_t)at;
        }
    return cut->lo[0] < cut->hi[0] && cut->lo[1] < cut->hi[1] && cut->lo[2] < cut->hi[2];
}

static bool read_tools(const json_t *v, scene_cut *cut)
{
    for (size_t i = 0; i < json_array_size(v); i++) {
        int64_t tool;
        if (!number_in(json_array_get(v, i), 0, SCENE_TOOLS_MAX - 1, &tool))
            return false;
        cut->no_tools |= 1u << tool;
    }
    return !v || json_is_array(v);
}

static bool read_triangles(const json_t *v, scene_cut *cut)
{
    for (size_t i = 0; i < json_array_size(v); i++) {
        const json_t *one = json_array_get(v, i);
        int64_t tool, part;
        if (json_array_size(one) != 4 || !number_in(json_array_get(one, 0), 0, SCENE_TOOLS_MAX - 1, &tool) ||
            !number_in(json_array_get(one, 1), 0, 1, &part) ||
            !add_range(json_array_get(one, 2), json_array_get(one, 3), &cut->triangles[tool][part]))
            return false;
    }
    return !v || json_is_array(v);
}

static ost_status read_cut(const json_t *cut_json, const char *where, scene_cut *cut, ost_error *err)
{
    static const char *const keys[] = {"ct", "collide", "crop", "samples", "ticks", "no_tools", "triangles"};
    const char *key;
    json_t *value;
    if (!json_is_object(cut_json))
        return bad(where, err, "'keep' is no object");
    json_object_foreach((json_t *)(uintptr_t)cut_json, key, value) {
        size_t k = 0;
        while (k < sizeof keys / sizeof keys[0] && strcmp(key, keys[k]) != 0)
            k++;
        if (k == sizeof keys / sizeof keys[0])
            return ost_fail(err, OST_ERR_INPUT, "%.200s: 'keep' has '%.40s', which this version does not know", where,
                            key);
        if (k < 2 && !json_is_boolean(value))
            return ost_fail(err, OST_ERR_INPUT, "%.200s: '%s' is neither true nor false", where, key);
    }
    cut->no_ct = json_is_false(json_object_get(cut_json, "ct"));
    cut->no_collide = json_is_false(json_object_get(cut_json, "collide"));
    if (!read_crop(json_object_get(cut_json, "crop"), cut))
        return bad(where, err, "'crop' must be [[x, y, z], [x, y, z]], the second beyond the first");
    if (!read_list(json_object_get(cut_json, "samples"), &cut->samples) ||
        !read_list(json_object_get(cut_json, "ticks"), &cut->ticks))
        return bad(where, err, "'samples' and 'ticks' must be [[from, to], ...], ascending, at most 64 of them");
    if (!read_tools(json_object_get(cut_json, "no_tools"), cut))
        return bad(where, err, "'no_tools' must be numbers of tools");
    if (!read_triangles(json_object_get(cut_json, "triangles"), cut))
        return bad(where, err, "'triangles' must be [[tool, part, from, to], ...], ascending, at most 64 of a part");
    return OST_OK;
}

ost_status case_of_json(const json_t *o, const char *where, const plan_user *user, plan_case *out, ost_error *err)
{
    const char *id = json_string_value(json_object_get(o, "id")), *tier = json_string_value(json_object_get(o, "tier")),
               *seed = json_string_value(json_object_get(o, "seed"));
    char *end = NULL;
    int t = 0;
    if (json_integer_value(json_object_get(o, "osteon_case")) != 1)
        return bad(where, err, "no case of osteon, or one of a later version: 'osteon_case' is not 1");
    while (t < PLAN_TIERS && (!tier || strcmp(tier, plan_tier_name((plan_tier)t)) != 0))
        t++;
    if (t == PLAN_TIERS)
        return bad(where, err, "'tier' is none of smoke, standard and full");
    errno = 0;
    const unsigned long long number = seed && *seed >= '0' && *seed <= '9' ? strtoull(seed, &end, 10) : 0;
    if (!end || *end || errno)
        return bad(where, err, "'seed' must be a number, as text");
    if (id && strncmp(id, "user/", 5) == 0 && !user)
        return ost_fail(err, OST_ERR_INPUT,
                        "%.200s: case '%.40s' is made of the user's own files: give them with --ct, --tool and --path",
                        where, id);
    if (!id || !plan_find((plan_tier)t, number, id, user, out))
        return ost_fail(err, OST_ERR_INPUT, "%.200s: tier %s has no case '%.40s'", where, tier, id ? id : "");
    const json_t *cut_json = json_object_get(o, "keep");
    if (!cut_json)
        return OST_OK;
    scene_cut *cut = calloc(1, sizeof *cut);
    if (!cut)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a case");
    ost_status status = read_cut(cut_json, where, cut, err);
    if (status == OST_OK)
        out->cut = cut;
    else
        free(cut);
    return status;
}

/* ----------------------------------------------------------- writing a case */

static json_t *list_json(const cut_list *list)
{
    json_t *o = json_array();
    for (int i = 0; i < list->count; i++)
        json_array_append_new(o, json_pack("[i,i]", (int)list->range[i][0], (int)list->range[i][1]));
    return o;
}

json_t *case_to_json(const plan_case *c, const scene_cut *cut)
{
    json_t *cut_json = json_object(), *no_tools = json_array(), *triangles = json_array();
    if (cut->no_ct)
        json_object_set_new(cut_json, "ct", json_false());
    if (cut->no_collide)
        json_object_set_new(cut_json, "collide", json_false());
    if (cut->cropped)
        json_object_set_new(
            cut_json, "crop",
            json_pack("[[i,i,i],[i,i,i]]", cut->lo[0], cut->lo[1], cut->lo[2], cut->hi[0], cut->hi[1], cut->hi[2]));
    if (cut->samples.some)
        json_object_set_new(cut_json, "samples", list_json(&cut->samples));
    if (cut->ticks.some)
        json_object_set_new(cut_json, "ticks", list_json(&cut->ticks));
    for (int t = 0; t < SCENE_TOOLS_MAX; t++) {
        if (cut->no_tools >> t & 1)
            json_array_append_new(no_tools, json_integer(t));
        for (int part = 0; part < 2; part++)
            for (int i = 0; i < cut->triangles[t][part].count; i++)
                json_array_append_new(triangles,
                                      json_pack("[i,i,i,i]", t, part, (int)cut->triangles[t][part].range[i][0],
                                                (int)cut->triangles[t][part].range[i][1]));
    }
    if (json_array_size(no_tools))
        json_object_set(cut_json, "no_tools", no_tools);
    if (json_array_size(triangles))
        json_object_set(cut_json, "triangles", triangles);
    json_decref(no_tools);
    json_decref(triangles);
    json_t *o = json_pack("{s:i,s:s,s:s,s:o}", "osteon_case", 1, "id", c->id, "tier", plan_tier_name(c->tier), "keep",
                          cut_json);
    if (o)
        json_object_set_new(o, "seed", json_sprintf("%llu", (unsigned long long)c->seed));
    return o;
}

/* ----------------------------------------------------------- reading a case */

static ost_status load(const char *path, json_t **out, ost_error *err)
{
    json_error_t where;
    char *bytes;
    size_t size;
    *out = NULL;
    ost_status status = ost_file_read(path, FILE_MAX, &bytes, &size, NULL, err);
    if (status == OST_OK && !(*out = json_loadb(bytes, size, JSON_REJECT_DUPLICATES, &where)))
        status = ost_fail(err, OST_ERR_INPUT, "%.200s:%d: %.100s", path, where.line, where.text);
    free(bytes);
    return status;
}

ost_status case_file_read(const char *path, const plan_user *user, plan *out, json_t **document, ost_error *err)
{
    json_t *o;
    *out = (plan){.shard = 1, .shards = 1, .file = path, .user = user ? user->store : NULL};
    ost_status status = load(path, &o, err);
    if (status != OST_OK)
        return status;
    const json_t *list = json_object_get(o, "cases");
    const size_t count = list ? json_array_size(list) : 1;
    if (count < 1 || count > CASES_MAX)
        status = bad(path, err, "'cases' must be a list of 1 to 1024 cases");
    else if (!(out->cases = calloc(count, sizeof *out->cases)))
        status = ost_fail(err, OST_ERR_MEMORY, "out of memory for %zu cases", count);
    for (size_t i = 0; i < count && status == OST_OK; i++) {
        status = case_of_json(list ? json_array_get(list, i) : o, path, user, &out->cases[i], err);
        if (status == OST_OK)
            out->total = ++out->count;
    }
    if (status == OST_OK) {
        out->tier = out->cases[0].tier;
        out->seed = out->cases[0].seed;
        if (document)
            *document = json_incref(o);
    } else
        plan_free(out);
    json_decref(o);
    return status;
}
