/* SPDX-License-Identifier: Apache-2.0 */
#include "validation/bundle/impact.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "validation/bundle/bundle.h"
#include "validation/bundle/devices.h"
#include "validation/bundle/difference.h"
#include "validation/bundle/evidence.h"
#include "validation/bundle/manifest.h"
#include "validation/bundle/tools.h"
#include "validation/bundle/trace_table.h"

/* Reads a JSON object. *out is NULL if the file is absent or is not a JSON object. */
static ost_status read_json(const char *folder, const char *name, json_t **out, ost_error *err)
{
    char *bytes;
    size_t size;
    const ost_status status = bundle_find(folder, name, &bytes, &size, err);
    *out = bytes ? json_loadb(bytes, size, JSON_REJECT_DUPLICATES, NULL) : NULL;
    free(bytes);
    return status;
}

ost_status impact_check(const char *old, ost_error *err)
{
    json_t *protocol;
    ost_status status = read_json(old, EVIDENCE_PROTOCOL, &protocol, err);
    if (status == OST_OK && !json_is_object(protocol))
        status = ost_fail(err, OST_ERR_INPUT, "%s: not a bundle: %s is missing or not a JSON object", old,
                          EVIDENCE_PROTOCOL);
    json_decref(protocol);
    return status;
}

/* ------------------------------------------------------------------ rows */

static void add_change(json_t *list, const char *what, const char *a, const char *b)
{
    if (strcmp(a, b) != 0)
        json_array_append_new(list, json_pack("{s:s,s:s,s:s}", "what", what, "old", a, "new", b));
}

/* Adds a row for a key of the protocol, with both values as strings. In the protocol, only the value of the key
   "arithmetic" is a number. */
static void add_protocol(json_t *list, const char *key, const json_t *a, const json_t *b)
{
    const json_t *x = json_object_get(a, key), *y = json_object_get(b, key);
    char old[64], new[64];
    snprintf(old, sizeof old, "%lld", (long long)json_integer_value(x));
    snprintf(new, sizeof new, "%lld", (long long)json_integer_value(y));
    add_change(list, key, json_is_integer(x) ? old : evidence_text(a, key),
               json_is_integer(y) ? new : evidence_text(b, key));
}

/* Converts a list to an object {name: text} with one member for each element of the list. */
static json_t *index_of(const json_t *list, const char *key, const char *value, const char *other)
{
    json_t *o = json_object();
    for (size_t i = 0; i < json_array_size(list); i++) {
        const json_t *one = json_array_get(list, i);
        char text[400];
        snprintf(text, sizeof text, "%s%s%s", evidence_text(one, value), other ? ", " : "",
                 other ? evidence_text(one, other) : "");
        if (*evidence_text(one, key))
            json_object_set_new(o, evidence_text(one, key), json_string(text));
    }
    return o;
}

/* Makes a row for each name that is in only one of the two objects or has different strings in them. Releases both
   objects. */
static json_t *compare_indexes(json_t *a, json_t *b)
{
    json_t *list = json_array(), *text;
    const char *name;
    json_object_foreach(a, name, text)
        add_change(list, name, json_string_value(text), json_object_get(b, name) ? evidence_text(b, name) : "absent");
    json_object_foreach(b, name, text)
        if (!json_object_get(a, name))
            add_change(list, name, "absent", json_string_value(text));
    json_decref(a);
    json_decref(b);
    return list;
}

/* Makes an object that maps each backend in devices.json to a string with its driver, version and fingerprint. */
static json_t *devices_in(const json_t *file)
{
    const json_t *list = json_object_get(json_object_get(file, "opencl"), "devices");
    json_t *o = json_object();
    for (size_t i = 0; i < json_array_size(list); i++) {
        const json_t *one = json_array_get(list, i), *says = json_object_get(one, "driver_says");
        char text[600];
        snprintf(text, sizeof text, "%.150s, %.150s, driver %.60s, %.200s", evidence_text(one, "name"),
                 evidence_text(says, "CL_PLATFORM_VERSION"), evidence_text(says, "CL_DRIVER_VERSION"),
                 evidence_text(one, "fingerprint"));
        json_t *utf8 = json_string(text);
        json_object_set_new(o, evidence_text(one, "backend"), utf8 ? utf8 : json_string("?"));
    }
    return o;
}

/* Parses requirements.csv into a JSON object that maps each identifier to the rest of its line. */
static ost_status requirements_in(const char *folder, json_t **out, ost_error *err)
{
    char *bytes;
    size_t size;
    const ost_status status = bundle_find(folder, REQUIREMENTS_FILE, &bytes, &size, err);
    *out = json_object();
    for (char *at = bytes, *end; at && *at; at = end) {
        end = at + strcspn(at, "\n");
        end += *end == '\n' ? (*end = '\0', 1) : 0;
        char *comma = strchr(at, ',');
        if (comma) {
            *comma = '\0';
            json_object_set_new(*out, at, json_string(comma + 1));
        }
    }
    free(bytes);
    return status;
}

/* Compares the verdicts of all pairs of case and backend that both bundles contain. */
static ost_status verdicts_of(const char *old, const char *now, json_t **out, ost_error *err)
{
    const char *const folders[] = {old, now};
    json_t *cases[2] = {NULL, NULL}, *result;
    ost_status status = OST_OK;
    *out = json_array();
    for (int i = 0; i < 2 && status == OST_OK; i++) {
        json_t *protocol = NULL;
        status = evidence_read(folders[i], &protocol, &cases[i], err);
        json_decref(protocol);
    }
    for (size_t i = 0; i < json_array_size(cases[0]) && status == OST_OK; i++)
        for (size_t k = 0; k < json_array_size(cases[1]); k++) {
            json_t *a = json_array_get(cases[0], i);
            const json_t *b = json_array_get(cases[1], k);
            const char *backend;
            if (strcmp(evidence_text(a, "id"), evidence_text(b, "id")) != 0)
                continue;
            json_object_foreach(json_object_get(a, "results"), backend, result) {
                const char *x = evidence_text(result, "verdict"),
                           *y = evidence_text(json_object_get(json_object_get(b, "results"), backend), "verdict");
                if (*y && strcmp(x, y) != 0)
                    json_array_append_new(*out, json_pack("{s:s,s:s,s:s,s:s}", "case", evidence_text(a, "id"),
                                                          "backend", backend, "old", x, "new", y));
            }
            break;
        }
    json_decref(cases[0]);
    json_decref(cases[1]);
    return status;
}

/* ---------------------------------------------------------------- impact */

typedef struct side {
    json_t *protocol, *tools, *devices, *manifest;
} side;

static ost_status side_read(const char *folder, side *s, ost_error *err)
{
    ost_status status = read_json(folder, EVIDENCE_PROTOCOL, &s->protocol, err);
    if (status == OST_OK)
        status = read_json(folder, TOOLS_FILE, &s->tools, err);
    if (status == OST_OK)
        status = read_json(folder, DEVICES_FILE, &s->devices, err);
    return status == OST_OK ? read_json(folder, MANIFEST_FILE, &s->manifest, err) : status;
}

static void side_free(side *s)
{
    json_decref(s->protocol);
    json_decref(s->tools);
    json_decref(s->devices);
    json_decref(s->manifest);
}

static json_t *causes_of(const side *a, const side *b)
{
    static const char *const protocol[] = {"version", "arithmetic", "tier", "seed", "only", "chosen"},
                             *const build[] = {"commit", "compiler", "cflags"};
    json_t *list = json_array();
    for (size_t i = 0; i < sizeof protocol / sizeof protocol[0]; i++)
        add_protocol(list, protocol[i], a->protocol, b->protocol);
    for (size_t i = 0; i < sizeof build / sizeof build[0]; i++)
        add_change(list, build[i], evidence_text(json_object_get(a->tools, "build"), build[i]),
                   evidence_text(json_object_get(b->tools, "build"), build[i]));
    add_change(list, "program", evidence_text(json_object_get(a->tools, "program"), "sha256"),
               evidence_text(json_object_get(b->tools, "program"), "sha256"));
    return list;
}

/* Returns the number of cases in which one bundle has a record that the other bundle lacks. The results of these cases
   cannot be compared by their digests. */
static json_int_t other_records(const json_t *results)
{
    const json_t *list = json_object_get(results, "differences");
    json_int_t n = 0;
    for (size_t i = 0; i < json_array_size(list); i++)
        n += strcmp(evidence_text(json_array_get(list, i), "what"), DIFFERENCE_NO_RECORD) == 0;
    return n;
}

/* Returns the conclusion. Only cases with equal inputs are compared, so the reference's results may differ only if the
   version of the arithmetic differs. */
static const char *conclusion_of(const json_t *results, const json_t *verdicts, bool same_arithmetic, bool *explained)
{
    const json_int_t different = json_integer_value(json_object_get(results, "different_cases"));
    *explained = different == 0 || !same_arithmetic;
    if (!json_integer_value(json_object_get(results, "compared")))
        return "no case has the same input in both bundles, so no result was compared";
    if (different && different == other_records(results))
        return "cases have records of other stages than in the older bundle, so their results cannot be compared in "
               "full";
    if (different)
        return same_arithmetic ? "the reference's results changed, and the arithmetic's version did not: no known "
                                 "cause explains that"
                               : "the reference's results changed, and so did the arithmetic's version";
    return json_array_size(verdicts) ? "the reference's results are equal; verdicts of backends changed"
                                     : "no result changed among the cases that both bundles have";
}

ost_status impact_of(const char *old, const char *now, json_t **out, ost_error *err)
{
    side a = {.protocol = NULL}, b = {.protocol = NULL};
    json_t *results = NULL, *verdicts = NULL, *ra = NULL, *rb = NULL;
    bool explained;
    *out = NULL;
    ost_status status = side_read(old, &a, err);
    if (status == OST_OK)
        status = side_read(now, &b, err);
    if (status == OST_OK)
        status = bundle_difference(old, now, "the older bundle", "this bundle", &results, err);
    if (status == OST_OK)
        status = verdicts_of(old, now, &verdicts, err);
    if (status == OST_OK)
        status = requirements_in(old, &ra, err);
    if (status == OST_OK)
        status = requirements_in(now, &rb, err);
    if (status == OST_OK) {
        const json_t *x = json_object_get(a.protocol, "arithmetic"), *y = json_object_get(b.protocol, "arithmetic");
        const char *conclusion = conclusion_of(results, verdicts, json_equal(x, y), &explained);
        *out =
            json_pack("{s:{s:s,s:s,s:s},s:O,s:O,s:o,s:o,s:o,s:o,s:b,s:s}", "against", "root",
                      evidence_text(a.manifest, "root"), "results_root", evidence_text(a.manifest, "results_root"),
                      "version", evidence_text(a.protocol, "version"), "results", results, "verdicts", verdicts,
                      "causes", causes_of(&a, &b), "libraries",
                      compare_indexes(index_of(json_object_get(a.tools, "libraries"), "soname", "version", "sha256"),
                                      index_of(json_object_get(b.tools, "libraries"), "soname", "version", "sha256")),
                      "devices", compare_indexes(devices_in(a.devices), devices_in(b.devices)), "requirements",
                      compare_indexes(json_incref(ra), json_incref(rb)), "explained", explained, "conclusion",
                      conclusion);
        if (!*out)
            status = ost_fail(err, OST_ERR_MEMORY, "out of memory for %s", IMPACT_FILE);
    }
    json_decref(results);
    json_decref(verdicts);
    json_decref(ra);
    json_decref(rb);
    side_free(&a);
    side_free(&b);
    return status;
}
