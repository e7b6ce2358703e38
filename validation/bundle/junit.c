/* SPDX-License-Identifier: Apache-2.0 */
#include "validation/bundle/junit.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/memory_stream.h"

typedef struct page {
    FILE *to;
    const json_t *protocol, *cases, *times, *environment;
} page;

/* Writes text with XML escapes. Characters that XML does not allow become '?'. */
static void put_xml(FILE *to, const char *text)
{
    for (; *text; text++)
        switch (*text) {
        case '&': fputs("&amp;", to); break;
        case '<': fputs("&lt;", to); break;
        case '>': fputs("&gt;", to); break;
        case '"': fputs("&quot;", to); break;
        default: fputc((unsigned char)*text < ' ' ? '?' : *text, to);
        }
}

static bool is_verdict(const json_t *result, case_verdict verdict)
{
    return strcmp(evidence_text(result, "verdict"), case_verdict_name(verdict)) == 0;
}

/* ------------------------------------------------------------ the machine */

/* Returns the running time of a backend in seconds. In a merged bundle, this is the sum over all shards. */
static double seconds_of_backend(const page *p, const char *backend)
{
    const json_t *one;
    double sum = 0;
    for (size_t i = 0; (one = evidence_part(p->times, "seconds", i)); i++)
        sum += json_number_value(json_object_get(json_object_get(one, "seconds"), backend));
    return sum;
}

/* Finds the running time of a backend in a case, in seconds. Returns false if it was not measured. */
static bool seconds_of_case(const page *p, const char *id, const char *backend, double *seconds)
{
    const json_t *one, *found;
    for (size_t i = 0; (one = evidence_part(p->times, "seconds", i)); i++)
        if ((found = json_object_get(json_object_get(json_object_get(one, "cases"), id), backend))) {
            *seconds = json_number_value(found);
            return true;
        }
    return false;
}

/* Returns the smallest value of a key in the parts of a file, or "" if there is none. For a time, this is the
   earliest time. */
static const char *least(const json_t *file, const char *key)
{
    const json_t *one;
    const char *text = "";
    for (size_t i = 0; (one = evidence_part(file, key, i)); i++)
        if (!*text || strcmp(evidence_text(one, key), text) < 0)
            text = evidence_text(one, key);
    return text;
}

static void put_attribute(FILE *to, const char *name, const char *value)
{
    fprintf(to, " %s=\"", name);
    put_xml(to, value);
    fputc('"', to);
}

static void put_machine(const page *p)
{
    char begun[32];
    snprintf(begun, sizeof begun, "%.31s", least(p->times, "begun"));
    begun[strcspn(begun, "Z")] = '\0'; /* JUnit's time stamps contain no time zone */
    put_attribute(p->to, "timestamp", begun);
    put_attribute(p->to, "hostname", least(p->environment, "host"));
}

static void put_case(const page *p, const json_t *one, const json_t *backend)
{
    const char *name = evidence_text(backend, "name"), *id = evidence_text(one, "id");
    const json_t *r = json_object_get(json_object_get(one, "results"), name);
    const char *skip = evidence_skipped(one, r, backend);
    char text[EVIDENCE_DESCRIPTION];
    double seconds;
    fputs("  <testcase", p->to);
    put_attribute(p->to, "classname", name);
    put_attribute(p->to, "name", id);
    if (seconds_of_case(p, id, name, &seconds))
        fprintf(p->to, " time=\"%.6f\"", seconds);
    if (is_verdict(r, CASE_EQUAL) && !skip) {
        fputs("/>\n", p->to);
        return;
    }
    evidence_describe(r, text);
    fputs(skip ? "><skipped" : "><failure", p->to);
    put_attribute(p->to, "message", skip ? skip : text);
    fputs("/></testcase>\n", p->to);
}

static void put_suite(const page *p, const json_t *backend)
{
    int failures = 0, skipped = 0;
    for (size_t i = 0; i < json_array_size(p->cases); i++) {
        const json_t *one = json_array_get(p->cases, i),
                     *r = json_object_get(json_object_get(one, "results"), evidence_text(backend, "name"));
        skipped += evidence_skipped(one, r, backend) != NULL;
        failures += !is_verdict(r, CASE_NOT_RUN) && !is_verdict(r, CASE_EQUAL);
    }
    fputs(" <testsuite", p->to);
    put_attribute(p->to, "name", evidence_text(backend, "name"));
    fprintf(p->to, " tests=\"%zu\" failures=\"%d\" errors=\"0\" skipped=\"%d\" time=\"%.6f\"",
            json_array_size(p->cases), failures, skipped, seconds_of_backend(p, evidence_text(backend, "name")));
    put_machine(p);
    fputs(">\n", p->to);
    for (size_t i = 0; i < json_array_size(p->cases); i++)
        put_case(p, json_array_get(p->cases, i), backend);
    fputs(" </testsuite>\n", p->to);
}

static void put_nothing(const page *p)
{
    fputs(" <testsuite name=\"campaign\" tests=\"1\" failures=\"1\" errors=\"0\" skipped=\"0\" time=\"0\"", p->to);
    put_machine(p);
    fputs(">\n  <testcase classname=\"campaign\" name=\"something was compared\" time=\"0\"><failure "
          "message=\"" EVIDENCE_NOTHING "\"/></testcase>\n </testsuite>\n",
          p->to);
}

ost_status junit_write(const json_t *protocol, const json_t *cases, const json_t *times, const json_t *environment,
                       evidence_sink *sink, void *user, ost_error *err)
{
    const json_t *backends = json_object_get(protocol, "backends");
    ost_memory_stream made;
    json_t *summary;
    ost_status status = evidence_summary(protocol, cases, &summary, err);
    if (status != OST_OK)
        return status;
    const page p = {ost_memory_stream_open(&made), protocol, cases, times, environment};
    if (!p.to) {
        json_decref(summary);
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for " JUNIT_FILE);
    }
    fputs("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites name=\"osteon validate\">\n", p.to);
    if (json_integer_value(json_object_get(summary, "compared")) == 0)
        put_nothing(&p);
    for (size_t s = 1; s < json_array_size(backends); s++)
        put_suite(&p, json_array_get(backends, s));
    fputs("</testsuites>\n", p.to);
    json_decref(summary);
    if (!ost_memory_stream_close(p.to, &made))
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for " JUNIT_FILE);
    status = sink(user, JUNIT_FILE, made.bytes, made.size, err);
    free(made.bytes);
    return status;
}
