/* SPDX-License-Identifier: Apache-2.0 */
#include "validation/bundle/trace_table.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/memory_stream.h"
#include "validation/bundle/csv.h"
#include "validation/bundle/requirement_lines.h"
#include "validation/bundle/suite.h"

char *trace_requirements(void)
{
    size_t size = 1;
    for (size_t i = 0; i < sizeof requirement_lines / sizeof requirement_lines[0]; i++)
        size += strlen(requirement_lines[i]) + 1;
    char *text = malloc(size), *to = text;
    for (size_t i = 0; text && i < sizeof requirement_lines / sizeof requirement_lines[0]; i++)
        to += sprintf(to, "%s\n", requirement_lines[i]);
    return text;
}

/* The stages that cover each group of rules. A group consists of the rules whose identifiers have the prefix
   `begins`. */
static const struct {
    const char *begins, *stages;
} bearing[] = {
    {"AR-CT-", "rect"},          {"AR-CUB-", "cubic"},
    {"AR-CHK-", "chunks final"}, {"AR-TOOL-1", "snap tool"},
    {"AR-TOOL-2", "snap tool"},  {"AR-TOOL-", "tool"},
    {"AR-VOX-", "tool"},         {"AR-MESH-3", "snap tool"},
    {"AR-MESH-4", "snap tool"},  {"AR-SWEEP-", "steps tick"},
    {"AR-POSE-4", "steps tick"}, {"AR-MOTOR-", "steps tick"},
    {"AR-MAP-", "steps tick collide"}, {"AR-REM-3", "collide"},
    {"AR-REM-", "tick final"},   {"AR-CLS-", "tick collide"},
    {"AR-DIG-2", "rect cubic chunks tool tick final"},
    {"AR-LAW-1", "rect cubic chunks tool collide tick final"},
    {"REQ-CHUNKS", "chunks"},    {"REQ-VOXELIZE", "tool"},
    {"REQ-REMOVE", "tick"},      {"REQ-TOOL-SWITCH", "tick"},
    {"REQ-BUILTIN", "tick"},     {"REQ-CPU", "rect cubic chunks tool collide tick final"},
    {"REQ-CL", "rect cubic chunks tool collide tick final"}, {"REQ-BAD-INPUT", "failed"},
};

static const char *stages_of(const char *id)
{
    for (size_t i = 0; i < sizeof bearing / sizeof bearing[0]; i++)
        if (strncmp(id, bearing[i].begins, strlen(bearing[i].begins)) == 0 &&
            (strcmp(id, bearing[i].begins) == 0 || bearing[i].begins[strlen(bearing[i].begins) - 1] == '-'))
            return bearing[i].stages;
    return "";
}

static bool has_word(const char *words, const char *word)
{
    const size_t n = strlen(word);
    for (const char *at = words; (at = strstr(at, word)); at += n)
        if ((at == words || at[-1] == ' ') && (at[n] == ' ' || !at[n]))
            return true;
    return false;
}

/* ---------------------------------------------------------------- results */

typedef struct outcome {
    /* number of records in the cases in which a backend equals the reference, summed over all backends */
    json_int_t equal;
    json_int_t different; /* number of cases in which this stage is the first one that differs */
    json_int_t known;     /* number of records in the trace of the reference */
} outcome;

typedef struct outcomes {
    outcome of[TRACE_STAGES];
    json_int_t failed; /* number of results with another verdict: failed, crashed, timed out, ... */
} outcomes;

static int stage_of(const char *name)
{
    for (int s = 0; s < TRACE_STAGES; s++)
        if (strcmp(name, trace_stage_name((trace_stage)s)) == 0)
            return s;
    return -1;
}

static outcomes count(const json_t *cases)
{
    outcomes all = {.failed = 0};
    for (size_t i = 0; i < json_array_size(cases); i++) {
        const json_t *one = json_array_get(cases, i), *records = json_object_get(one, "reference");
        json_int_t here[TRACE_STAGES] = {0};
        const char *name;
        json_t *result;
        for (size_t k = 0; k < json_array_size(records); k++) {
            const int s = stage_of(evidence_text(json_array_get(records, k), "stage"));
            if (s >= 0) {
                here[s]++;
                all.of[s].known++;
            }
        }
        json_object_foreach(json_object_get(one, "results"), name, result) {
            const char *verdict = evidence_text(result, "verdict");
            const int at = stage_of(evidence_text(result, "stage"));
            if (strcmp(verdict, case_verdict_name(CASE_EQUAL)) == 0)
                for (int s = 0; s < TRACE_STAGES; s++)
                    all.of[s].equal += here[s];
            else if (strcmp(verdict, case_verdict_name(CASE_DIFFERS)) == 0 && at >= 0)
                all.of[at].different++;
            else if (strcmp(verdict, case_verdict_name(CASE_NOT_RUN)) != 0)
                all.failed++;
        }
    }
    return all;
}

/* ------------------------------------------------------------------- rows */

enum { FIELDS = 5, LINE = 4096 };

/* Splits a line of requirements.csv at its commas. No field of this file contains a comma. */
static bool fields_of(char *line, char *field[FIELDS])
{
    for (int i = 0; i < FIELDS; i++) {
        field[i] = line;
        line = strchr(line, ',');
        if (!line)
            return i == FIELDS - 1;
        *line++ = '\0';
    }
    return false;
}

/* Returns the entry of a test in the suite, or NULL if there is none. The entries are sorted by test. */
static const json_t *result_of(const json_t *suite, const char *test)
{
    const json_t *list = json_object_get(suite, "tests");
    size_t low = 0, high = json_array_size(list);
    while (low < high) {
        const size_t middle = low + (high - low) / 2;
        const int order = strcmp(test, evidence_text(json_array_get(list, middle), "test"));
        if (order == 0)
            return json_array_get(list, middle);
        if (order < 0)
            high = middle;
        else
            low = middle + 1;
    }
    return NULL;
}

static void add_text(char *to, size_t size, const char *format, ...) OST_PRINTF(3, 4);
static void add_text(char *to, size_t size, const char *format, ...)
{
    const size_t used = strlen(to);
    va_list args;
    va_start(args, format);
    vsnprintf(to + used, size - used, format, args);
    va_end(args);
}

/*
 * Appends "the test suite" to `shown` and a string such as "tests: 2 passed; tests/x.sh FAILED: ..." to `result`. In
 * `tests`, the paths are separated by semicolons. `also` must be true if another part of this bundle covers the row.
 * Returns true if a test passed or failed. A skipped test is no evidence.
 */
static bool put_tests(char *tests, const json_t *suite, bool also, char *shown, size_t shown_size, char *result,
                      size_t result_size)
{
    char *remainder = NULL, others[1024] = "";
    int passed = 0, failed = 0;
    for (char *test = suite ? strtok_r(tests, ";", &remainder) : NULL; test; test = strtok_r(NULL, ";", &remainder)) {
        const json_t *one = result_of(suite, test);
        const char *is = evidence_text(one, "result");
        passed += strcmp(is, "passed") == 0;
        failed += strcmp(is, "failed") == 0;
        if (strcmp(is, "passed") != 0)
            add_text(others, sizeof others, "; %.120s %s: %.120s", test,
                     strcmp(is, "failed") == 0 ? "FAILED" : "skipped", one ? evidence_text(one, "reason") : "not run");
    }
    const bool tested = passed + failed > 0;
    if (!suite)
        return false;
    if (tested)
        add_text(shown, shown_size, "%sthe test suite", also ? "; " : "");
    add_text(result, result_size, "%s", also ? "; " : tested ? "" : "not by this bundle; ");
    add_text(result, result_size, "tests: %d passed%s", passed, others);
    return tested;
}

/* Writes a string such as "rect: 1234 records equal" for each stage, and the results of the checks that list the
   requirement. */
static void put_shown(FILE *to, const char *id, char *tests, const outcomes *o, const json_t *common,
                      const json_t *suite, bool used[TRACE_STAGES])
{
    char shown[1024] = "", result[2048] = "", files[64] = "";
    size_t a = 0, b = 0;
    const char *stages = stages_of(id);
    for (int s = 0; s < TRACE_STAGES; s++) {
        const char *name = trace_stage_name((trace_stage)s);
        if (!has_word(stages, name))
            continue;
        used[s] = true;
        if (!o->of[s].known)
            continue;
        a += (size_t)snprintf(shown + a, sizeof shown - a, "%sstage %s", a ? "; " : "", name);
        if (o->of[s].different)
            b += (size_t)snprintf(result + b, sizeof result - b, "%s%s differs in %lld results", b ? "; " : "", name,
                                  (long long)o->of[s].different);
        else
            b += (size_t)snprintf(result + b, sizeof result - b, "%s%s: %lld records equal", b ? "; " : "", name,
                                  (long long)o->of[s].equal);
        snprintf(files, sizeof files, EVIDENCE_CASES);
    }
    const json_t *checks = json_object_get(common, "checks");
    for (size_t i = 0; i < json_array_size(checks); i++) {
        const json_t *one = json_array_get(checks, i);
        if (!has_word(evidence_text(one, "requirements"), id) || a + 100 > sizeof shown || b + 100 > sizeof result)
            continue;
        a += (size_t)snprintf(shown + a, sizeof shown - a, "%scheck %.60s", a ? "; " : "", evidence_text(one, "name"));
        b += (size_t)snprintf(result + b, sizeof result - b, "%s%.60s: %s", b ? "; " : "", evidence_text(one, "name"),
                              json_is_true(json_object_get(one, "passed")) ? "passed" : "FAILED");
        if (!strstr(files, "common.json"))
            snprintf(files + strlen(files), sizeof files - strlen(files), "%scommon.json", *files ? " " : "");
    }
    const bool tested = put_tests(tests, suite, a > 0, shown, sizeof shown, result, sizeof result);
    if (tested)
        snprintf(files + strlen(files), sizeof files - strlen(files), "%s" SUITE_FILE, *files ? " " : "");
    put_csv(to, shown, ',');
    put_csv(to,
            a || tested || suite ? result
                                 : "not by this bundle; the test suite's own results are not in it (--with-suite)",
            ',');
    put_csv(to, files, '\n');
}

static void write_rows(FILE *to, const char *requirements, const json_t *cases, const json_t *common,
                       const json_t *suite)
{
    const outcomes all = count(cases);
    bool used[TRACE_STAGES] = {[TRACE_CASE] = true};
    int number = 0;
    fputs("kind,id,requirement,source,tests,shown in this bundle by,result,files\n", to);
    for (int orphans = 0; orphans < 2; orphans++) {
        number = 0;
        for (const char *at = requirements; *at; number++) {
            char line[LINE], *field[FIELDS];
            const size_t n = strcspn(at, "\n");
            snprintf(line, sizeof line, "%.*s", (int)(n < sizeof line ? n : sizeof line - 1), at);
            at += n + (at[n] == '\n');
            if (!number || !fields_of(line, field))
                continue;
            const bool orphan_test = !*field[0], orphan = orphan_test || !*field[3];
            if (orphan != (orphans == 1))
                continue;
            fputs(orphan_test ? "orphan test," : orphan ? "orphan requirement," : "requirement,", to);
            put_csv(to, field[0], ',');
            put_csv(to, orphan_test ? field[4] : field[2], ',');
            put_csv(to, field[1], ',');
            put_csv(to, *field[3] ? field[3] : field[4], ',');
            if (orphan_test)
                fputs("\"\",\"\",\"\"\n", to);
            else
                put_shown(to, field[0], field[3], &all, common, suite, used);
        }
    }
    for (int s = 0; s < TRACE_STAGES; s++)
        if (all.of[s].known && !used[s])
            fprintf(to,
                    "orphan result,\"\",\"no requirement is about stage %s\",\"\",\"\",\"stage %s\",\"%lld records "
                    "equal\",\"" EVIDENCE_CASES "\"\n",
                    trace_stage_name((trace_stage)s), trace_stage_name((trace_stage)s), (long long)all.of[s].equal);
    const json_t *checks = json_object_get(common, "checks");
    for (size_t i = 0; i < json_array_size(checks); i++)
        if (!*evidence_text(json_array_get(checks, i), "requirements")) {
            fputs("orphan result,\"\",\"no requirement is about this check\",\"\",\"\",", to);
            put_csv(to, evidence_text(json_array_get(checks, i), "name"), ',');
            put_csv(to, json_is_true(json_object_get(json_array_get(checks, i), "passed")) ? "passed" : "FAILED", ',');
            fputs("\"common.json\"\n", to);
        }
    if (all.failed)
        fprintf(to,
                "orphan result,\"\",\"results that are no comparison\",\"\",\"\",\"failed, crashed or timed "
                "out\",\"%lld\",\"" EVIDENCE_CASES "\"\n",
                (long long)all.failed);
}

ost_status trace_table_write(const char *requirements, const json_t *cases, const json_t *common, const json_t *suite,
                             evidence_sink *sink, void *user, ost_error *err)
{
    ost_memory_stream made;
    FILE *to = ost_memory_stream_open(&made);
    if (!to)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for " TRACE_FILE);
    write_rows(to, requirements, cases, common, suite);
    if (!ost_memory_stream_close(to, &made))
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for " TRACE_FILE);
    const ost_status status = sink(user, TRACE_FILE, made.bytes, made.size, err);
    free(made.bytes);
    return status;
}
