/* SPDX-License-Identifier: Apache-2.0 */
#include "validation/bundle/suite.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "validation/bundle/evidence.h"
#include "validation/bundle/limits.h"
#include "validation/bundle/trace_table.h"

/* ------------------------------------------------------------------- tests */

enum { TESTS_MAX = 4096, FIELD_TESTS = 3 };

static int by_text(const void *a, const void *b)
{
    return strcmp(*(char *const *)a, *(char *const *)b);
}

/* Splits the tests field of a line at its semicolons and appends the names to the array `names`. The array has at
   most TESTS_MAX names. */
static void names_of_line(char *line, char **names, size_t *count)
{
    char *field = line, *remainder = NULL;
    for (int i = 0; field && i < FIELD_TESTS; i++) {
        field = strchr(field, ',');
        field = field ? field + 1 : NULL;
    }
    if (!field || *line == ',') /* A row without an identifier is a test that no requirement refers to. */
        return;
    field[strcspn(field, ",")] = '\0';
    for (char *name = strtok_r(field, ";", &remainder); name && *count < TESTS_MAX;
         name = strtok_r(NULL, ";", &remainder))
        names[(*count)++] = name;
}

json_t *suite_tests(const char *requirements)
{
    char *text = strdup(requirements), **names = calloc(TESTS_MAX, sizeof *names), *remainder = NULL;
    json_t *list = text && names ? json_array() : NULL;
    size_t count = 0;
    bool heading = true;
    for (char *line = list ? strtok_r(text, "\n", &remainder) : NULL; line;
         line = strtok_r(NULL, "\n", &remainder), heading = false)
        if (!heading)
            names_of_line(line, names, &count);
    if (count)
        qsort(names, count, sizeof *names, by_text);
    for (size_t i = 0; i < count; i++)
        if ((!i || strcmp(names[i - 1], names[i]) != 0) && json_array_append_new(list, json_string(names[i])) != 0) {
            json_decref(list);
            list = NULL;
            break;
        }
    free(names);
    free(text);
    return list;
}

const char *suite_result(json_int_t status, const char *stopped)
{
    return *stopped ? "failed" : status == 0 ? "passed" : status == SUITE_SKIPPED ? "skipped" : "failed";
}

static const char *const results[] = {"passed", "skipped", "failed"};
enum { RESULTS = sizeof results / sizeof results[0] };

static json_int_t count_of(const json_t *o, const char *result)
{
    const json_t *tests = json_object_get(o, "tests");
    json_int_t n = 0;
    for (size_t i = 0; i < json_array_size(tests); i++)
        n += strcmp(evidence_text(json_array_get(tests, i), "result"), result) == 0;
    return n;
}

void suite_count(json_t *o)
{
    for (int r = 0; r < RESULTS; r++)
        json_object_set_new(o, results[r], json_integer(count_of(o, results[r])));
}

/* ----------------------------------------------------- checking suite.json */

typedef struct check {
    bundle_problem *problem;
    void *user;
    int *found;
} check;

static void report(const check *c, const char *format, ...) OST_PRINTF(2, 3);
static void report(const check *c, const char *format, ...)
{
    char text[400], plain[400];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    c->problem(c->user, BUNDLE_DIFFERENT, SUITE_FILE, limits_printable(text, plain, sizeof plain));
    ++*c->found;
}

static bool is_digest(const char *text)
{
    return strlen(text) == OST_DIGEST_HEX - 1 && strspn(text, "0123456789abcdef") == OST_DIGEST_HEX - 1;
}

static void check_test(const check *c, const json_t *one, const char *expected)
{
    const char *stopped = evidence_text(one, "stopped"), *result = evidence_text(one, "result");
    const json_t *status = json_object_get(one, "status"), *bytes = json_object_get(one, "output_bytes");
    const char *derived = suite_result(json_integer_value(status), stopped);
    if (strcmp(evidence_text(one, "test"), expected) != 0)
        report(c, "has a result of '%.150s' where " REQUIREMENTS_FILE " gives %.150s", evidence_text(one, "test"),
               expected);
    else if (!json_is_integer(status) || !json_is_number(json_object_get(one, "seconds")) || !json_is_integer(bytes) ||
             json_integer_value(bytes) < 0 || !is_digest(evidence_text(one, "output_sha256")))
        report(c, "%.150s: has no status, no seconds, or no size and digest of its output", expected);
    else if (strcmp(result, derived) != 0)
        report(c, "%.150s: says '%.40s', and status %lld%s%.40s gives '%s'", expected, result,
               (long long)json_integer_value(status), *stopped ? ", stopped: " : "", stopped, derived);
    else if (strcmp(derived, "passed") != 0 && !*evidence_text(one, "reason"))
        report(c, "%.150s: is %s without a reason", expected, derived);
}

static void check_all(const check *c, const json_t *suite, const json_t *protocol, const json_t *expected)
{
    const json_t *tests = json_object_get(suite, "tests");
    if (!json_equal(json_object_get(suite, "limit_s"), json_object_get(json_object_get(protocol, "suite"), "limit_s")))
        report(c, "has another limit of time than " EVIDENCE_PROTOCOL);
    if (json_array_size(tests) != json_array_size(expected)) {
        report(c, "has results of %zu tests; " REQUIREMENTS_FILE " names %zu", json_array_size(tests),
               json_array_size(expected));
        return;
    }
    for (size_t i = 0; i < json_array_size(expected); i++)
        check_test(c, json_array_get(tests, i), json_string_value(json_array_get(expected, i)));
    for (int r = 0; r < RESULTS; r++) {
        const json_t *stated = json_object_get(suite, results[r]);
        if (!json_is_integer(stated) || json_integer_value(stated) != count_of(suite, results[r]))
            report(c, "says %lld %s, and its results give %lld", (long long)json_integer_value(stated), results[r],
                   (long long)count_of(suite, results[r]));
    }
}

ost_status suite_check(const char *folder, const json_t *protocol, bundle_problem *problem, void *user, int *found,
                       ost_error *err)
{
    const check c = {problem, user, found};
    const bool needed = json_object_get(protocol, "suite") != NULL;
    json_t *suite = NULL, *expected = NULL;
    char *requirements = NULL;
    size_t size;
    ost_error why = {0};
    ost_status status = bundle_find_json(folder, SUITE_FILE, &suite, &why);
    if (status == OST_ERR_INPUT) {
        report(&c, "is no JSON within the limits of a bundle");
        return OST_OK;
    }
    if (status != OST_OK)
        return ost_fail(err, status, "%s", why.text);
    if (!suite && needed) {
        problem(user, BUNDLE_ABSENT, SUITE_FILE, "is missing");
        ++*found;
    } else if (suite && !needed)
        report(&c, "belongs to no bundle of this protocol");
    else if (suite)
        status = bundle_find(folder, REQUIREMENTS_FILE, &requirements, &size, err);
    if (status == OST_OK && requirements) {
        expected = suite_tests(requirements);
        if (expected)
            check_all(&c, suite, protocol, expected);
        else
            status = ost_fail(err, OST_ERR_MEMORY, "out of memory for the tests of " REQUIREMENTS_FILE);
    }
    free(requirements);
    json_decref(expected);
    json_decref(suite);
    return status;
}
