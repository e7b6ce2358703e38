/* SPDX-License-Identifier: Apache-2.0 */
#include "validation/bundle/difference.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "validation/bundle/bundle.h"
#include "validation/bundle/evidence.h"
#include "validation/scene.h"

typedef struct side {
    json_t *protocol, *cases;
} side;

static void side_free(side *s)
{
    json_decref(s->protocol);
    json_decref(s->cases);
}

static ost_status side_read(const char *folder, side *out, ost_error *err)
{
    *out = (side){.protocol = NULL};
    return evidence_read(folder, &out->protocol, &out->cases, err);
}

static const json_t *case_of(const side *s, const char *id)
{
    for (size_t i = 0; i < json_array_size(s->cases); i++)
        if (strcmp(evidence_text(json_array_get(s->cases, i), "id"), id) == 0)
            return json_array_get(s->cases, i);
    return NULL;
}

/* -------------------------------------------------------------- one record */

/* Finds the number and the digest of element i in a list of leaves. In the list of a complete grid, the number is i.
   In the list of a tick, each element is a pair of number and digest. */
static bool leaf_at(const json_t *leaves, size_t i, json_int_t *number, const char **digest)
{
    const json_t *one = json_array_get(leaves, i);
    const json_t *hex = json_is_array(one) ? json_array_get(one, 1) : one;
    *number = json_is_array(one) ? json_integer_value(json_array_get(one, 0)) : (json_int_t)i;
    *digest = json_string_value(hex);
    return *digest != NULL;
}

/* Returns the lowest leaf number for which the digests differ or only one of the lists has a digest; -1 if there is no
   such leaf. */
static json_int_t first_leaf(const json_t *a, const json_t *b)
{
    size_t i = 0, j = 0;
    json_int_t m = 0, n = 0;
    const char *x = NULL, *y = NULL;
    for (;;) {
        const bool has_a = leaf_at(a, i, &m, &x), has_b = leaf_at(b, j, &n, &y);
        if (!has_a && !has_b)
            return -1;
        if (!has_b || (has_a && m < n))
            return m;
        if (!has_a || n < m)
            return n;
        if (strcmp(x, y) != 0)
            return m;
        i++;
        j++;
    }
}

/* Reads the dims [x, y, z] of a protocol. Returns false if one number is missing or out of range. */
static bool dims_in(const json_t *list, ost_dims *out)
{
    json_int_t n[3];
    for (size_t a = 0; a < 3; a++) {
        n[a] = json_integer_value(json_array_get(list, a));
        if (n[a] < 1 || n[a] > OST_DIM_MAX)
            return false;
    }
    *out = (ost_dims){(int32_t)n[0], (int32_t)n[1], (int32_t)n[2]};
    return true;
}

/* Finds the dims of a grid for a case of the user's own files. The protocol contains these dims. If only a part of a
   case was run (--case), the dims are unknown, and the function returns false. */
static bool own_dims(const json_t *protocol, const char *id, const char *stage, json_int_t item, ost_dims *out)
{
    const json_t *user = json_object_get(protocol, "user"), *cases = json_object_get(user, "cases");
    if (json_object_get(protocol, "case"))
        return false;
    if (strcmp(stage, trace_stage_name(TRACE_TOOL)) == 0)
        return item >= 0 &&
               dims_in(json_object_get(json_array_get(json_object_get(user, "tools"), (size_t)item), "dims"), out);
    for (size_t i = 0; i < json_array_size(cases); i++)
        if (strcmp(evidence_text(json_array_get(cases, i), "id"), id) == 0)
            return dims_in(json_object_get(json_array_get(cases, i), strcmp(stage, trace_stage_name(TRACE_RECT)) == 0
                                                                         ? "rect_dims"
                                                                         : "cubic_dims"),
                           out);
    return false;
}

/* Finds the dims of a grid for a generated case. If this program generates a different case with this name, the dims
   are unknown, and the function returns false. */
static bool generated_dims(const json_t *protocol, const json_t *one, const char *stage, json_int_t item, ost_dims *out)
{
    const char *tier = evidence_text(protocol, "tier");
    plan_case c;
    scene s;
    ost_digest digest;
    ost_error none = {0};
    char hex[OST_DIGEST_HEX];
    int t = 0;
    while (t < PLAN_TIERS && strcmp(tier, plan_tier_name((plan_tier)t)) != 0)
        t++;
    if (t == PLAN_TIERS ||
        !plan_find((plan_tier)t, strtoull(evidence_text(protocol, "seed"), NULL, 10), evidence_text(one, "id"), NULL,
                   &c) ||
        scene_make(&c, &s, &none) != OST_OK)
        return false;
    bool known = scene_digest(&s, &digest, &none) == OST_OK &&
                 strcmp(ost_digest_hex(&digest, hex), evidence_text(one, "input_sha256")) == 0;
    *out = s.rect.dims;
    if (strcmp(stage, trace_stage_name(TRACE_TOOL)) == 0) {
        known &= item >= 0 && item < s.tool_count;
        *out = known ? s.tools[item].cutting.grid.dims : *out;
    } else if (strcmp(stage, trace_stage_name(TRACE_RECT)) != 0 && s.cubic > 0) {
        out->x = (int32_t)((out->x * s.rect.spacing.x + s.cubic - 1) / s.cubic);
        out->y = (int32_t)((out->y * s.rect.spacing.y + s.cubic - 1) / s.cubic);
        out->z = (int32_t)((out->z * s.rect.spacing.z + s.cubic - 1) / s.cubic);
    }
    scene_free(&s);
    return known;
}

/* Computes the number of leaves along each axis in the stage's grid. Returns false if the grid's dims are unknown. */
static bool leaf_dims(const json_t *protocol, const json_t *one, const char *stage, json_int_t item, ost_dims *out)
{
    const char *id = evidence_text(one, "id");
    ost_dims grid;
    const bool known = strncmp(id, "user/", 5) == 0 ? own_dims(protocol, id, stage, item, &grid)
                                                    : generated_dims(protocol, one, stage, item, &grid);
    if (known)
        *out = ost_leaf_dims(grid);
    return known;
}

static json_t *record_difference(const json_t *protocol, const json_t *one, const json_t *ra, const json_t *rb)
{
    const char *stage = evidence_text(ra, "stage"), *what = "what was reported differs; the voxels' digests are equal";
    const json_int_t item = json_integer_value(json_object_get(ra, "item"));
    const json_int_t leaf = first_leaf(json_object_get(ra, "leaves"), json_object_get(rb, "leaves"));
    ost_dims n;
    if (leaf >= 0)
        what = "voxels differ";
    json_t *o = json_pack("{s:s,s:s,s:I,s:s}", "case", evidence_text(one, "id"), "stage", stage, "item", item, "what",
                          what);
    if (leaf >= 0)
        json_object_set_new(o, "leaf", json_integer(leaf));
    if (leaf >= 0 && leaf < INT32_MAX && leaf_dims(protocol, one, stage, item, &n) && leaf < ost_dims_count(n))
        json_object_set_new(o, "chunk",
                            json_pack("[i,i,i]", (int)(leaf % n.x), (int)(leaf / n.x % n.y), (int)(leaf / n.x / n.y)));
    return o;
}

/* Returns the first difference between the results of a case in two bundles; NULL if they are equal. */
static json_t *case_difference(const json_t *protocol, const json_t *a, const json_t *b)
{
    const json_t *la = json_object_get(a, "reference"), *lb = json_object_get(b, "reference");
    for (size_t i = 0; i < json_array_size(la) || i < json_array_size(lb); i++) {
        const json_t *ra = json_array_get(la, i), *rb = json_array_get(lb, i);
        const json_t *there = ra ? ra : rb;
        if (!ra || !rb || strcmp(evidence_text(ra, "stage"), evidence_text(rb, "stage")) != 0 ||
            json_integer_value(json_object_get(ra, "item")) != json_integer_value(json_object_get(rb, "item")))
            return json_pack("{s:s,s:s,s:I,s:s}", "case", evidence_text(a, "id"), "stage",
                             evidence_text(there, "stage"), "item", json_integer_value(json_object_get(there, "item")),
                             "what", DIFFERENCE_NO_RECORD);
        if (!*evidence_text(ra, "sha256") || strcmp(evidence_text(ra, "sha256"), evidence_text(rb, "sha256")) != 0)
            return record_difference(protocol, a, ra, rb);
    }
    return NULL;
}

/* ------------------------------------------------------------- two bundles */

static void add_line(json_t *list, const char *format, ...) OST_PRINTF(2, 3);
static void add_line(json_t *list, const char *format, ...)
{
    char text[400];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    json_t *line = json_string(text);
    json_array_append_new(list, line ? line : json_string("a name that is no text"));
}

static json_t *notes_of(const side *a, const side *b)
{
    static const char *const keys[] = {"version", "arithmetic", "tier", "seed", "only"};
    json_t *notes = json_array();
    for (size_t k = 0; k < sizeof keys / sizeof keys[0]; k++) {
        const json_t *x = json_object_get(a->protocol, keys[k]), *y = json_object_get(b->protocol, keys[k]);
        if (json_equal(x, y))
            continue;
        if (json_is_integer(x) && json_is_integer(y))
            add_line(notes, "%s %lld against %lld", keys[k], (long long)json_integer_value(x),
                     (long long)json_integer_value(y));
        else
            add_line(notes, "%s '%.60s' against '%.60s'", keys[k], evidence_text(a->protocol, keys[k]),
                     evidence_text(b->protocol, keys[k]));
    }
    return notes;
}

ost_status bundle_difference(const char *folder_a, const char *folder_b, const char *name_a, const char *name_b,
                             json_t **out, ost_error *err)
{
    side a, b = {.protocol = NULL};
    ost_status status = side_read(folder_a, &a, err);
    if (status == OST_OK)
        status = side_read(folder_b, &b, err);
    if (status == OST_OK) {
        json_t *differences = json_array(), *not_compared = json_array();
        json_int_t compared = 0;
        for (size_t i = 0; i < json_array_size(a.cases); i++) {
            const json_t *one = json_array_get(a.cases, i);
            const char *id = evidence_text(one, "id");
            const json_t *other = *id ? case_of(&b, id) : NULL;
            if (!other)
                add_line(not_compared, "%.60s: only in %.200s", id, name_a);
            else if (!*evidence_text(one, "input_sha256") ||
                     strcmp(evidence_text(one, "input_sha256"), evidence_text(other, "input_sha256")) != 0)
                add_line(not_compared,
                         "%.60s: its input is another one (another seed, tier or version makes other cases)", id);
            else if (!json_array_size(json_object_get(one, "reference")) &&
                     !json_array_size(json_object_get(other, "reference")))
                add_line(not_compared, "%.60s: neither has a record of it", id);
            else {
                json_t *d = case_difference(a.protocol, one, other);
                compared++;
                if (d)
                    json_array_append_new(differences, d);
            }
        }
        for (size_t i = 0; i < json_array_size(b.cases); i++) {
            const char *id = evidence_text(json_array_get(b.cases, i), "id");
            if (!case_of(&a, id))
                add_line(not_compared, "%.60s: only in %.200s", id, name_b);
        }
        *out = json_pack("{s:s,s:b,s:I,s:I,s:o,s:o,s:o}", "kind", "bundles", "equal",
                         compared > 0 && !json_array_size(differences) && !json_array_size(not_compared), "compared",
                         compared, "different_cases", (json_int_t)json_array_size(differences), "differences",
                         differences, "not_compared", not_compared, "notes", notes_of(&a, &b));
        if (!*out)
            status = ost_fail(err, OST_ERR_MEMORY, "out of memory for the comparison of bundles");
    }
    side_free(&a);
    side_free(&b);
    return status;
}
