/* SPDX-License-Identifier: Apache-2.0 */
#include "validation/bundle/evidence.h"

#include <stdio.h>
#include <string.h>

#include "core/memory_stream.h"
#include "validation/bundle/digests.h"
#include "validation/locate/causes.h"
#include "validation/scene.h"


#define ACCEPTANCE                                                                                                     \
    "Every record of every case, voxels and reports, is byte for byte the scalar reference's: 0 differing bytes. A "   \
    "backend that fails, "                                                                                             \
    "crashes or takes too long where the reference does not is a failure."

static ost_status no_memory(ost_error *err)
{
    return ost_fail(err, OST_ERR_MEMORY, "out of memory for the evidence");
}

ost_status evidence_protocol(const plan *p, const subject_list *subjects, const char *chosen, bool cpu_only,
                             json_t **out, ost_error *err)
{
    json_t *cases = json_array(), *backends = json_array(), *families = json_object();
    for (int i = 0; i < p->count; i++)
        json_array_append_new(cases, json_string(p->cases[i].id));
    for (int f = 0; f < PLAN_FAMILIES; f++)
        json_object_set_new(families, plan_family_name((plan_family)f), json_string(plan_family_about((plan_family)f)));
    for (int s = 0; s < subjects->count; s++) {
        const subject *one = &subjects->subjects[s];
        json_array_append_new(backends, json_pack("{s:s,s:s,s:b,s:s}", "name", one->spec, "what", one->what,
                                                  "available", one->available, "reason", one->reason));
    }
    *out = json_pack("{s:i,s:s,s:i,s:s,s:s,s:s,s:s,s:[i,i],s:s,s:b,s:b,s:s,s:o,s:o,s:o}", "schema", EVIDENCE_FORMAT,
                     "version", ost_version(), "arithmetic", OST_ARITHMETIC_VERSION, "title",
                     "Backend equivalence verification", "scope",
                     "code verification: that all backends compute the same grids; not clinical validation", "tier",
                     plan_tier_name(p->tier), "seed_text", "see seed", "shard", p->shard, p->shards, "only",
                     p->only ? p->only : "", "cpu_only", cpu_only, "opencl", subjects->opencl, "accept", ACCEPTANCE,
                     "cases", cases, "backends", backends, "families", families);
    if (!*out)
        return no_memory(err);
    json_object_del(*out, "seed_text");
    /* The seed is a string, because some JSON readers round large integers. */
    json_object_set_new(*out, "seed", json_sprintf("%llu", (unsigned long long)p->seed));
    json_object_set_new(*out, "chosen", json_string(chosen));
    json_object_set_new(*out, "no_opencl", json_string(subjects->opencl ? "" : subjects->no_opencl));
    return OST_OK;
}

/* ------------------------------------------------------------------- cases */

/* Adds the chunk, the class of the difference, and the operands of the first voxel that differs. */
static void put_finding(json_t *o, const finding *f)
{
    char hint[CAUSES_TEXT];
    causes_text(f->class, hint);
    if (f->chunk_size) {
        json_object_set_new(o, "chunk", json_pack("[i,i,i]", f->chunk[0], f->chunk[1], f->chunk[2]));
        json_object_set_new(o, "chunk_size", json_integer(f->chunk_size));
    }
    if (f->class) {
        json_object_set_new(o, "class", json_string(f->class));
        json_object_set_new(o, "class_text", json_string(f->text));
        json_object_set_new(o, "class_hint", json_string(hint));
    }
    if (f->reproduce[0]) {
        json_object_set_new(o, "reproduce", json_string(f->reproduce));
        json_object_set_new(o, "small_case", json_string(f->small));
    }
    if (!f->operands.count)
        return;
    json_t *list = json_array();
    for (int i = 0; i < f->operands.count; i++)
        json_array_append_new(
            list, json_pack("{s:s,s:s}", "name", f->operands.lines[i].name, "value", f->operands.lines[i].value));
    json_object_set_new(o, "operands", list);
}

static json_t *lines_json(const char *lines)
{
    json_t *list = json_array();
    for (; *lines; lines += strcspn(lines, "\n") + 1)
        json_array_append_new(list, json_stringn(lines, strcspn(lines, "\n")));
    return list;
}

json_t *evidence_result(const case_result *r)
{
    const compare_difference *d = &r->difference;
    char name[TRACE_WORD], hex[OST_DIGEST_HEX];
    json_t *o = json_pack("{s:s}", "verdict", case_verdict_name(r->verdict));
    if (r->text[0])
        json_object_set_new(o, "text", json_string(r->text));
    if (r->has_made)
        json_object_set_new(o, "sha256", json_string(ost_digest_hex(&r->made, hex)));
    if (r->lines)
        json_object_set_new(o, "records", lines_json(r->lines));
    if (r->own_steps)
        json_object_set_new(o, "own_steps", json_integer(r->own_steps));
    if (r->verdict != CASE_DIFFERS)
        return o;
    json_object_set_new(o, "stage", json_string(trace_stage_name(d->stage)));
    json_object_set_new(o, "item", json_integer(d->item));
    if (d->kind == COMPARE_VOXEL) {
        json_object_set_new(o, "different_voxels", json_integer((json_int_t)d->voxels));
        json_object_set_new(o, "voxel", json_pack("[i,i,i]", d->voxel[0], d->voxel[1], d->voxel[2]));
        json_object_set_new(o, "reference", json_integer(d->voxel_ref));
        json_object_set_new(o, "got", json_integer(d->voxel_got));
    } else if (d->kind == COMPARE_WORD) {
        json_object_set_new(o, "word", json_string(trace_word_name(d->stage, d->word, d->line_words, name)));
        json_object_set_new(o, "reference", json_integer((json_int_t)d->word_ref));
        json_object_set_new(o, "got", json_integer((json_int_t)d->word_got));
    } else
        json_object_set_new(o, "text",
                            json_string(d->kind == COMPARE_MISSING ? "the record is missing"
                                                                   : "its blocks are not those of the reference"));
    if (r->found)
        put_finding(o, r->found);
    if (r->margins)
        json_object_set_new(o, "margins", margins_json(r->margins));
    return o;
}

/* Writes the digest of a case's input, as the worker of the reference recorded it. */
static void input_of(const campaign *c, int case_index, char hex[OST_DIGEST_HEX])
{
    ost_digest digest = {{0}};
    uint64_t count = 0;
    const uint8_t *words;
    const compare_range range = c->ranges[case_index];
    if (range.count && trace_words(&c->reference.records[range.first], &count, &words) &&
        count >= sizeof digest.bytes / 8)
        memcpy(digest.bytes, words, sizeof digest.bytes);
    ost_digest_hex(&digest, hex);
}

/* Makes the digests of a case's records in the form of cases.jsonl. On failure, *out is NULL. The caller owns *out. */
static ost_status evidence_records(const trace *t, compare_range range, json_t **out, ost_error *err)
{
    ost_dims bone = {1, 1, 1};
    ost_status status = OST_OK;
    *out = json_array();
    for (size_t k = 0; k < range.count && status == OST_OK; k++) {
        const trace_record *r = &t->records[range.first + k];
        size_t at = 0;
        trace_block_view block;
        json_t *row;
        if (r->stage == TRACE_CASE)
            continue;
        if (r->stage == TRACE_CHUNKS && trace_next_block(r, &at, &block))
            bone = block.dims;
        status = digests_of_record(r, bone, &row, err);
        if (status == OST_OK && json_array_append_new(*out, row) != 0)
            status = no_memory(err);
    }
    if (status != OST_OK) {
        json_decref(*out);
        *out = NULL;
    }
    return status;
}

ost_status evidence_case(const campaign *c, int i, json_t **out, ost_error *err)
{
    char input[OST_DIGEST_HEX], made[OST_DIGEST_HEX];
    json_t *records = NULL;
    input_of(c, i, input);
    ost_status status = evidence_records(&c->reference, c->ranges[i], &records, err);
    *out = status == OST_OK
               ? json_pack("{s:s,s:s,s:s,s:O}", "id", c->plan->cases[i].id, "input_sha256", input, "reference_sha256",
                           ost_digest_hex(&c->results[(size_t)i * (size_t)c->subjects->count].made, made), "reference",
                           records)
               : NULL;
    json_decref(records);
    return status != OST_OK || *out ? status : no_memory(err);
}

ost_status evidence_results(const campaign *c, json_t *cases, ost_error *err)
{
    for (int i = 0; i < c->plan->count; i++) {
        json_t *results = json_object();
        for (int s = 1; s < c->subjects->count; s++)
            json_object_set_new(results, c->subjects->subjects[s].spec,
                                evidence_result(&c->results[(size_t)i * (size_t)c->subjects->count + (size_t)s]));
        if (json_object_set_new(json_array_get(cases, (size_t)i), "results", results) != 0)
            return no_memory(err);
    }
    return OST_OK;
}

/* ----------------------------------------------------------------- summary */

const char *evidence_text(const json_t *o, const char *key)
{
    const char *text = json_string_value(json_object_get(o, key));
    return text ? text : "";
}

const json_t *evidence_part(const json_t *file, const char *key, size_t number)
{
    const char *name;
    json_t *value;
    size_t i = 0;
    if (json_object_get(file, key))
        return number == 0 ? file : NULL;
    json_object_foreach((json_t *)(uintptr_t)file, name, value)
        if (i++ == number)
            return value;
    return NULL;
}

char *evidence_own_options(const json_t *protocol, bool how)
{
    const json_t *user = json_object_get(protocol, "user"), *files = json_object_get(user, "files"),
                 *words = json_object_get(user, "how");
    ost_memory_stream made;
    FILE *to = ost_memory_stream_open(&made);
    if (!to)
        return NULL;
    for (size_t i = 0; i < json_array_size(files); i++) {
        const char *builtin = evidence_text(json_array_get(files, i), "builtin");
        if (!*builtin)
            fprintf(to, " --%s FILE", evidence_text(json_array_get(files, i), "option"));
        else if (how)
            fprintf(to, " --%s builtin:%s", evidence_text(json_array_get(files, i), "option"), builtin);
    }
    for (size_t i = 0; how && i < json_array_size(words); i++) {
        const char *word = json_string_value(json_array_get(words, i));
        fprintf(to, " %s", word ? word : "");
    }
    return ost_memory_stream_close(to, &made) ? made.bytes : NULL;
}

static void add_sentence(json_t *list, const char *text)
{
    json_array_append_new(list, json_string(text));
}

bool evidence_refused(const json_t *one)
{
    const json_t *records = json_object_get(one, "reference");
    for (size_t k = 0; k < json_array_size(records); k++)
        if (strcmp(evidence_text(json_array_get(records, k), "stage"), trace_stage_name(TRACE_FAILED)) == 0)
            return true;
    return false;
}

/* Writes a sentence about sweep, map, boxes, poses and snapping. These steps are computed once for all backends, so
   only the second implementation can show that they are right. */
static const char *second_implementation(const json_t *protocol, const json_t *cases, char *text, size_t size)
{
    const json_t *backends = json_object_get(protocol, "backends");
    bool ran = false;
    json_int_t ticks = 0, tools = 0;
    for (size_t s = 0; s < json_array_size(backends); s++)
        ran |= strcmp(evidence_text(json_array_get(backends, s), "name"), SUBJECT_DENSE) == 0;
    for (size_t i = 0; i < json_array_size(cases) && ran; i++) {
        const json_t *one = json_array_get(cases, i), *records = json_object_get(one, "reference");
        const char *verdict = evidence_text(json_object_get(json_object_get(one, "results"), SUBJECT_DENSE), "verdict");
        for (size_t k = 0; k < json_array_size(records) && strcmp(verdict, case_verdict_name(CASE_EQUAL)) == 0; k++) {
            const char *stage = evidence_text(json_array_get(records, k), "stage");
            ticks += strcmp(stage, trace_stage_name(TRACE_STEPS)) == 0;
            tools += strcmp(stage, trace_stage_name(TRACE_SNAP)) == 0;
        }
    }
    if (ran)
        snprintf(text, size,
                 "src/core and src/sim compute sweep, map, boxes, poses and snapping for every backend, so comparing "
                 "backends does not verify these steps. "
                 "Backend " SUBJECT_DENSE
                 " has a second implementation of them, whose results were equal in %lld ticks and for %lld tools.",
                 (long long)ticks, (long long)tools);
    else
        snprintf(text, size,
                 "src/core and src/sim compute sweep, map, boxes, poses and snapping for every backend; the second "
                 "implementation of these steps, backend " SUBJECT_DENSE ", was not compared.");
    return text;
}

static bool makes_steps(const json_t *cases, const char *backend)
{
    for (size_t i = 0; i < json_array_size(cases); i++)
        if (json_integer_value(json_object_get(
                json_object_get(json_object_get(json_array_get(cases, i), "results"), backend), "own_steps")) > 0)
            return true;
    return false;
}

/* Returns sentences about properties that the campaign does not show, although a reader might expect it to. */
static json_t *not_shown(const json_t *protocol, const json_t *cases, json_int_t refused, json_int_t compared)
{
    json_t *list = json_array();
    char text[512];
    const json_t *backends = json_object_get(protocol, "backends");
    if (!compared)
        add_sentence(
            list, "Nothing was compared: no backend other than the reference ran a case that the reference accepted.");
    if (refused) {
        snprintf(text, sizeof text,
                 "The reference refused the input of %lld of %zu cases; a backend that refuses the same input is not "
                 "counted as equal.",
                 (long long)refused, json_array_size(cases));
        add_sentence(list, text);
    }
    if (strcmp(evidence_text(protocol, "tier"), "smoke") == 0)
        add_sentence(list, "The smoke tier has few and small cases and is meant for frequent runs. It is not evidence; "
                           "the standard tier is.");
    if (json_integer_value(json_array_get(json_object_get(protocol, "shard"), 1)) > 1)
        add_sentence(list, "This is one shard of a campaign; the cases of the other shards were not run here.");
    if (json_object_get(protocol, "case"))
        add_sentence(list, "Only the cases of one file were run (case.json).");
    if (*evidence_text(protocol, "only"))
        add_sentence(list, "Only some of the tier's cases were selected.");
    if (*evidence_text(protocol, "chosen")) {
        snprintf(text, sizeof text, "Only these backends were selected: %.300s.", evidence_text(protocol, "chosen"));
        add_sentence(list, text);
    }
    if (!json_is_true(json_object_get(protocol, "opencl"))) {
        snprintf(text, sizeof text, "No OpenCL device was compared: %.300s.",
                 json_is_true(json_object_get(protocol, "cpu_only")) ? "only variants of the CPU backend were selected"
                                                                     : evidence_text(protocol, "no_opencl"));
        add_sentence(list, text);
    }
    for (size_t s = 0; s < json_array_size(backends); s++) {
        const json_t *one = json_array_get(backends, s);
        if (json_is_true(json_object_get(one, "available")))
            continue;
        snprintf(text, sizeof text, "%.120s was not run: %.300s.", evidence_text(one, "name"),
                 evidence_text(one, "reason"));
        add_sentence(list, text);
    }
    if (json_array_size(json_object_get(protocol, "cases")) != json_array_size(cases))
        add_sentence(list, "Some cases of the protocol are missing.");
    add_sentence(list, second_implementation(protocol, cases, text, sizeof text));
    for (size_t s = 0; s < json_array_size(backends); s++) {
        const char *name = evidence_text(json_array_get(backends, s), "name");
        if ((strncmp(name, "plugin:", 7) != 0 && strncmp(name, SUBJECT_DUMP, strlen(SUBJECT_DUMP)) != 0) ||
            makes_steps(cases, name))
            continue;
        snprintf(text, sizeof text,
                 "%.300s received sweep, map, boxes, poses and snapping from src/core; its own computation of "
                 "these steps was not compared.",
                 name);
        add_sentence(list, text);
    }
    add_sentence(list,
                 json_object_get(protocol, "user")
                     ? "All inputs are generated, except those of the cases user/1 and following, which are the "
                       "user's own files and are not in the bundle. All backends share the code that reads files "
                       "and that converts the floats of meshes and devices to integers; this comparison does not "
                       "verify that code."
                     : "All inputs are generated; none is a patient's. All backends share the code that reads files "
                       "and that converts the floats of meshes and devices to integers; this comparison does not "
                       "verify that code.");
    add_sentence(list, "A mistake that the reference and a backend have in common cannot be detected by comparing the "
                       "two; the checks in common.json detect some of these mistakes.");
    add_sentence(
        list,
        "This comparison does not show that the simulation predicts real bone, tools or patients correctly: that would "
        "be validation.");
    return list;
}

/* maximum number of differing results in results.json */
enum { LISTED = 100 };
static json_t *findings_of(const json_t *protocol, const json_t *cases)
{
    const json_t *backends = json_object_get(protocol, "backends");
    json_t *list = json_array();
    for (size_t i = 0; i < json_array_size(cases); i++)
        for (size_t s = 1; s < json_array_size(backends) && json_array_size(list) < LISTED; s++) {
            const json_t *one = json_array_get(cases, i);
            const char *name = evidence_text(json_array_get(backends, s), "name");
            const json_t *r = json_object_get(json_object_get(one, "results"), name);
            const char *verdict = evidence_text(r, "verdict");
            if (!json_is_object(r) || strcmp(verdict, case_verdict_name(CASE_EQUAL)) == 0 ||
                strcmp(verdict, case_verdict_name(CASE_NOT_RUN)) == 0)
                continue;
            json_t *row = json_copy((json_t *)(uintptr_t)r);
            json_object_del(row, "records"); /* The records are omitted here, because cases.jsonl contains them. */
            json_object_set_new(row, "case", json_string(evidence_text(one, "id")));
            json_object_set_new(row, "backend", json_string(name));
            json_array_append_new(list, row);
        }
    return list;
}

ost_status evidence_summary(const json_t *protocol, const json_t *cases, json_t **out, ost_error *err)
{
    json_int_t counts[CASE_VERDICTS] = {0}, records = 0, refused = 0, same = 0;
    for (size_t i = 0; i < json_array_size(cases); i++) {
        const char *spec;
        json_t *result, *results = json_object_get(json_array_get(cases, i), "results");
        const bool no = evidence_refused(json_array_get(cases, i));
        refused += no;
        records += (json_int_t)json_array_size(json_object_get(json_array_get(cases, i), "reference"));
        json_object_foreach(results, spec, result)
            for (int v = 0; v < CASE_VERDICTS; v++)
                if (strcmp(evidence_text(result, "verdict"), case_verdict_name((case_verdict)v)) == 0) {
                    counts[v]++;
                    same += v == CASE_EQUAL && !no;
                }
    }
    const json_int_t bad = counts[CASE_DIFFERS] + counts[CASE_FAILED] + counts[CASE_CRASHED] + counts[CASE_LATE],
                     compared = same + bad;
    const bool complete = json_array_size(cases) > 0 &&
                          json_array_size(cases) == json_array_size(json_object_get(protocol, "cases"));
    const bool equal = complete && same > 0 && !bad;
    const bool entire = complete && strcmp(evidence_text(protocol, "tier"), "smoke") != 0 &&
                        !json_object_get(protocol, "case") &&
                        json_integer_value(json_array_get(json_object_get(protocol, "shard"), 1)) == 1 &&
                        !*evidence_text(protocol, "only") && compared > 0;
    json_t *verdicts = json_object();
    for (int v = 0; v < CASE_VERDICTS; v++)
        json_object_set_new(verdicts, case_verdict_name((case_verdict)v), json_integer(counts[v]));
    *out = json_pack("{s:s,s:I,s:I,s:b,s:b,s:I,s:I,s:I,s:o,s:o,s:o}", "verdict",
                     bad     ? "NOT EQUAL"
                     : equal ? "EQUAL"
                     : same  ? "NOT COMPLETE"
                             : "NOT COMPARED",
                     "compared", compared, "refused", refused, "equal", equal, "evidence", entire, "cases",
                     (json_int_t)json_array_size(cases), "backends",
                     (json_int_t)json_array_size(json_object_get(protocol, "backends")), "reference_records", records,
                     "results", verdicts, "not_shown", not_shown(protocol, cases, refused, compared), "findings",
                     findings_of(protocol, cases));
    return *out ? OST_OK : no_memory(err);
}
