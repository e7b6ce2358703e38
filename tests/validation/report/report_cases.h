/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The protocol and the cases of a small campaign, written by hand, from which the tests make bundles.
 */
#ifndef OST_TESTS_REPORT_CASES_H
#define OST_TESTS_REPORT_CASES_H

#include "harness.h"

#include "validation/bundle/evidence.h"

#define HOSTILE "<script>alert('x')</script>\"><img src=x onerror=\"y\">&\x01"

typedef struct kind {
    const char *tier, *text, *verdict;
} kind;
static const kind equal_kind = {"standard", "plain", "equal"}, reduced = {"smoke", "plain", "equal"},
                  differing = {"standard", "plain", "differs"}, hostile = {"standard", HOSTILE, "differs"};

static inline json_t *protocol_of(const kind *k)
{
    json_t *p = json_pack("{s:i,s:s,s:i,s:s,s:[i,i],s:s,s:b,s:b,s:s,s:s,s:[s,s],s:[{s:s,s:s,s:b,s:s},{s:s,s:s,s:b,s:s},"
                          "{s:s,s:s,s:b,s:s}]}",
                          "schema", EVIDENCE_FORMAT, "version", k->text, "arithmetic", 1, "tier", k->tier, "shard", 1,
                          1, "only", k == &hostile ? k->text : "", "cpu_only", 0, "opencl", 1, "accept", k->text,
                          "seed", k == &hostile ? k->text : "7", "cases", "session/0", "session/1", "backends", "name",
                          "ref", "what", "the reference", "available", 1, "reason", "", "name", "cpu", "what", k->text,
                          "available", 1, "reason", "", "name", "cl", "what", k->text, "available", 0, "reason",
                          k->text);
    assert_non_null(p);
    return p;
}

static inline json_t *cases_of(const kind *k)
{
    json_t *cases = json_array();
    for (int i = 0; i < 2; i++) {
        const bool plain = i == 0 || strcmp(k->verdict, "equal") == 0;
        json_t *result = plain ? json_pack("{s:s}", "verdict", "equal")
                               : json_pack("{s:s,s:s,s:i,s:i,s:[i,i,i],s:i,s:i}", "verdict", k->verdict, "stage",
                                           "tick", "item", 12, "different_voxels", 3, "voxel", 33, 2, 65, "reference",
                                           -5, "got", 700);
        if (k == &hostile && !plain) {
            json_object_del(result, "voxel");
            json_object_set_new(result, "word", json_string(k->text));
            json_object_set_new(result, "class", json_string(k->text));
            json_object_set_new(result, "stage", json_string(k->text));
        }
        json_array_append_new(cases, json_pack("{s:s,s:s,s:[{s:s,s:i,s:s}],s:{s:o,s:{s:s}}}", "id",
                                               k == &hostile ? k->text
                                               : i           ? "session/1"
                                                             : "session/0",
                                               "input_sha256", "00", "reference", "stage", "tick", "item", 0, "sha256",
                                               "00", "results", "cpu", result, "cl", "verdict", "not run"));
    }
    assert_int_equal(json_array_size(cases), 2);
    return cases;
}

#endif
