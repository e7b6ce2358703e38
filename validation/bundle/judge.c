/* SPDX-License-Identifier: Apache-2.0 */
#include "validation/bundle/judge.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include <osteon/digest.h>

#include "validation/bundle/evidence.h"
#include "validation/bundle/limits.h"
#include "validation/subjects.h"

enum { LINE = 160 };

typedef struct judge {
    judge_problem *problem;
    void *user;
    const json_t *one, *backend;
} judge;

static void report(const judge *j, const char *format, ...) OST_PRINTF(2, 3);
static void report(const judge *j, const char *format, ...)
{
    char text[JUDGE_TEXT], what[JUDGE_TEXT], id[PLAN_ID], name[128];
    va_list args;
    va_start(args, format);
    vsnprintf(what, sizeof what, format, args);
    va_end(args);
    limits_printable(evidence_text(j->one, "id"), id, sizeof id);
    limits_printable(evidence_text(j->backend, "name"), name, sizeof name);
    snprintf(text, sizeof text, "%s%s%s: %.300s", id, j->backend ? " on " : "", name, what);
    j->problem(j->user, text);
}

static bool is_digest(const json_t *value)
{
    const char *text = json_string_value(value);
    return text && strlen(text) == OST_DIGEST_HEX - 1 && strspn(text, "0123456789abcdef") == OST_DIGEST_HEX - 1;
}

static bool is_stage(const char *name)
{
    for (int s = 0; s < TRACE_STAGES; s++)
        if (strcmp(name, trace_stage_name((trace_stage)s)) == 0)
            return true;
    return false;
}

static bool leaves_ok(const json_t *leaves)
{
    for (size_t i = 0; i < json_array_size(leaves); i++) {
        const json_t *leaf = json_array_get(leaves, i);
        if (!is_digest(leaf) && !(json_array_size(leaf) == 2 && json_is_integer(json_array_get(leaf, 0)) &&
                                  is_digest(json_array_get(leaf, 1))))
            return false;
    }
    return !leaves || json_is_array(leaves);
}

/*
 * Writes digest line `at` of the reference. Line 0 contains the input's digest; each further line contains the digest
 * of one record. Writes "" if `at` is beyond the last line. Returns false if the input's digest or the record is
 * malformed.
 */
static bool reference_line(const json_t *one, size_t at, char line[LINE])
{
    const json_t *rows = json_object_get(one, "reference"), *row;
    line[0] = '\0';
    if (at == 0) {
        snprintf(line, LINE, "%s 0 %s", trace_stage_name(TRACE_CASE), evidence_text(one, "input_sha256"));
        return json_is_array(rows) && is_digest(json_object_get(one, "input_sha256"));
    }
    if (at > json_array_size(rows))
        return true;
    row = json_array_get(rows, at - 1);
    const json_int_t item = json_integer_value(json_object_get(row, "item"));
    if (!is_stage(evidence_text(row, "stage")) || item < 0 || item > UINT32_MAX ||
        !is_digest(json_object_get(row, "sha256")) || !leaves_ok(json_object_get(row, "leaves")))
        return false;
    snprintf(line, LINE, "%s %lld %s", evidence_text(row, "stage"), (long long)item, evidence_text(row, "sha256"));
    return true;
}

static ost_status add_line(ost_hasher *h, const char *line, ost_error *err)
{
    const ost_status status = ost_hasher_add(h, line, strlen(line), err);
    return status == OST_OK ? ost_hasher_add(h, "\n", 1, err) : status;
}

/* Computes the SHA-256 of the digest lines of the reference's records. Returns false if the rows do not have the form
   of cases.jsonl. */
static bool judge_reference(const json_t *one, ost_digest *out)
{
    char line[LINE];
    ost_hasher *h;
    ost_error none = {0};
    bool ok = true;
    if (ost_hasher_open(&h, &none) != OST_OK)
        return false;
    for (size_t at = 0; ok && at <= json_array_size(json_object_get(one, "reference")); at++)
        ok = reference_line(one, at, line) && add_line(h, line, &none) == OST_OK;
    return ost_hasher_close(h, out, &none) == OST_OK && ok;
}

/* -------------------------------------------------- lines of the backend */

/* Computes the SHA-256 of the digest lines that a backend's result contains. Returns false if there are no lines or
   if a line is malformed. */
static bool own_digest(const json_t *lines, char hex[OST_DIGEST_HEX])
{
    ost_hasher *h;
    ost_digest digest;
    ost_error none = {0};
    bool ok = json_array_size(lines) > 0;
    if (ost_hasher_open(&h, &none) != OST_OK)
        return false;
    for (size_t i = 0; ok && i < json_array_size(lines); i++) {
        const char *line = json_string_value(json_array_get(lines, i));
        ok = line && strlen(line) < LINE && !strchr(line, '\n') && add_line(h, line, &none) == OST_OK;
    }
    ok = ost_hasher_close(h, &digest, &none) == OST_OK && ok;
    ost_digest_hex(&digest, hex);
    return ok;
}

/* Returns true if the line belongs to a record of this stage. */
static bool line_is_of(const char *line, trace_stage stage)
{
    const char *name = trace_stage_name(stage);
    const size_t length = strlen(name);
    return strncmp(line, name, length) == 0 && line[length] == ' ';
}

/*
 * Returns true if this backend's trace may lack the record of a line. These records may be missing:
 *
 *   dump             any record, because a dump contains only the files that its author wrote
 *   plugin, dense    sampling: densities of single voxels and occupancy (perform_sample.c)
 *   dense            in large cases also ticks, collisions and the bone at the end (perform_second)
 *   cpu, ref, cl     none
 */
static bool may_lack(const char *backend, const char *line)
{
    static const trace_stage large[] = {TRACE_COLLIDE, TRACE_TICK, TRACE_FINAL};
    const bool dense = strcmp(backend, SUBJECT_DENSE) == 0;
    if (strncmp(backend, SUBJECT_DUMP, strlen(SUBJECT_DUMP)) == 0)
        return true;
    if (line_is_of(line, TRACE_SAMPLE))
        return dense || strncmp(backend, "plugin:", 7) == 0;
    bool may = false;
    for (size_t i = 0; i < sizeof large / sizeof large[0]; i++)
        may |= dense && line_is_of(line, large[i]);
    return may;
}

/* Returns true for a line such as "tick 3 -". Such a line stands for a record that a dump lacks, or for a
   function that a backend does not implement. */
static bool is_stand_in(const char *line, const char *reference)
{
    const char *digest = strrchr(reference, ' ');
    const size_t head = digest ? (size_t)(digest - reference) : 0;
    return head && strncmp(line, reference, head) == 0 && strcmp(line + head, " -") == 0;
}

/* Returns the index of the first line that differs from the reference's line, or -1 if no line differs. Writes the
   reference's line at this index to `reference`. */
static long first_other(const json_t *one, const json_t *lines, const char *backend, char reference[LINE])
{
    const size_t count = json_array_size(lines), all = 1 + json_array_size(json_object_get(one, "reference"));
    for (size_t at = 0; at < count || at < all; at++) {
        const char *own = at < count ? json_string_value(json_array_get(lines, at)) : "";
        reference_line(one, at, reference);
        if (!own || (strcmp(own, reference) != 0 && !(is_stand_in(own, reference) && may_lack(backend, reference))))
            return (long)at;
    }
    return -1;
}

/* Writes the stage and the item of a difference at line `at`. They are read from the reference's line or, after the
   reference's last line, from the backend's line. */
static void location_of(const char *reference, const json_t *lines, long at, char location[LINE])
{
    const char *line = *reference ? reference : json_string_value(json_array_get(lines, (size_t)at));
    snprintf(location, LINE, "%s", line ? line : "");
    char *last = strrchr(location, ' ');
    if (last)
        *last = '\0';
}

static bool ends_failed(const json_t *lines)
{
    const char *last = json_string_value(json_array_get(lines, json_array_size(lines) - 1));
    const char *name = trace_stage_name(TRACE_FAILED);
    return last && strncmp(last, name, strlen(name)) == 0 && last[strlen(name)] == ' ';
}

/* -------------------------------------------------------------- one result */

static int verdict_named(const char *name)
{
    for (int v = 0; v < CASE_VERDICTS; v++)
        if (strcmp(name, case_verdict_name((case_verdict)v)) == 0)
            return v;
    return -1;
}

/*
 * Judges a result with the backend's own digest lines, which are stored only if they differ from the reference's lines.
 */
static void judge_lines(const judge *j, const json_t *r, case_verdict verdict)
{
    const json_t *lines = json_object_get(r, "records");
    char hex[OST_DIGEST_HEX], reference[LINE], location[LINE], stated[LINE];
    if (!own_digest(lines, hex) || strcmp(hex, evidence_text(r, "sha256")) != 0) {
        report(j, "its records do not give its sha256");
        return;
    }
    const long at = first_other(j->one, lines, evidence_text(j->backend, "name"), reference);
    if (at < 0) {
        if (verdict != CASE_EQUAL)
            report(j, "says '%s', and all digests are the reference's", case_verdict_name(verdict));
        return;
    }
    location_of(reference, lines, at, location);
    const bool failed = ends_failed(lines) && (size_t)at + 1 >= json_array_size(lines);
    const case_verdict derived = failed ? CASE_FAILED : CASE_DIFFERS;
    snprintf(stated, sizeof stated, "%.40s %lld", evidence_text(r, "stage"),
             (long long)json_integer_value(json_object_get(r, "item")));
    if (verdict != derived)
        report(j, "says '%s', and its digests say '%s', first at %s", case_verdict_name(verdict),
               case_verdict_name(derived), location);
    else if (verdict == CASE_DIFFERS && strcmp(stated, location) != 0)
        report(j, "says that %s differs first, and its digests differ first at %s", stated, location);
}

/* Returns true if the result differs in the bounds of a broad phase. Bounds are compared but are not part of any
   digest (trace_word_is_bound). */
static bool differs_in_bound(const json_t *r)
{
    const char *word = evidence_text(r, "word");
    return strcmp(evidence_text(r, "stage"), trace_stage_name(TRACE_STEPS)) == 0 &&
           (strncmp(word, "box ", 4) == 0 || strncmp(word, "whether it reaches", 18) == 0);
}

static void judge_result(const judge *j, const json_t *r, const char *reference)
{
    const char *name = evidence_text(j->backend, "name"), *sha256 = evidence_text(r, "sha256");
    const int verdict = verdict_named(evidence_text(r, "verdict"));
    const bool dump = strncmp(name, SUBJECT_DUMP, strlen(SUBJECT_DUMP)) == 0,
               own = json_object_get(r, "records") != NULL;
    const bool available = json_is_true(json_object_get(j->backend, "available"));
    if (verdict < 0)
        report(j, "has no verdict");
    else if (verdict == CASE_DIFFERS && differs_in_bound(r))
        return; /* Only a bound differs. Bounds are not part of any digest. */
    else if (verdict == CASE_NOT_RUN ? available && !dump : !available)
        report(j, available ? "was not run, although it was available" : "has a result, although it was not available");
    else if (own)
        judge_lines(j, r, (case_verdict)verdict);
    else if (verdict == CASE_EQUAL && !*sha256)
        report(j, "says 'equal' without a digest");
    else if (verdict == CASE_EQUAL && strcmp(sha256, reference) != 0)
        report(j, "says 'equal', and its digest is not the reference's");
    else if (verdict == CASE_DIFFERS)
        report(j, "says 'differs' without the digests of its records");
    else if (verdict != CASE_EQUAL && *sha256)
        report(j, "says '%s', and has the digest of a complete case", case_verdict_name((case_verdict)verdict));
}

void judge_case(const json_t *protocol, const json_t *one, judge_problem *problem, void *user)
{
    const json_t *backends = json_object_get(protocol, "backends"), *results = json_object_get(one, "results");
    judge j = {problem, user, one, NULL};
    ost_digest digest;
    char hex[OST_DIGEST_HEX];
    if (!judge_reference(one, &digest)) {
        report(&j, "its input or a record of the reference has no digest of the form that a bundle has");
        return;
    }
    if (strcmp(ost_digest_hex(&digest, hex), evidence_text(one, "reference_sha256")) != 0)
        report(&j, "the reference's records do not give reference_sha256");
    if (!json_is_object(results) || json_object_size(results) + 1 != json_array_size(backends))
        report(&j, "has %zu results; the protocol has %zu backends besides the reference", json_object_size(results),
               json_array_size(backends) ? json_array_size(backends) - 1 : 0);
    for (size_t s = 1; s < json_array_size(backends); s++) {
        j.backend = json_array_get(backends, s);
        const json_t *r = json_object_get(results, evidence_text(j.backend, "name"));
        if (json_is_object(r))
            judge_result(&j, r, hex);
        else
            report(&j, "has no result");
    }
}
