/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests the verdict of a campaign in which nothing was compared, or in which a case was refused. No file of the bundle
 * may report such a campaign or case as equal or as a success.
 *
 * Covers: REQ-VALIDATE
 */
#include "report_cases.h"

#include "validation/bundle/junit.h"
#include "validation/report/report.h"

typedef struct written {
    char verdict[16], junit[2048], tap[2048];
} written;

/*
 * Receives a file of a bundle in which nothing was compared. README.md and the page must not contain the word EQUAL.
 * Stores the texts of junit.xml and results.tap.
 */
static ost_status receive_file(void *user, const char *name, const void *bytes, size_t size, ost_error *err)
{
    written *w = user;
    (void)err;
    if (strcmp(name, "README.md") == 0 || strcmp(name, REPORT_FILE) == 0)
        assert_null(strstr(bytes, "EQUAL"));
    if (strcmp(name, "junit.xml") == 0)
        snprintf(w->junit, sizeof w->junit, "%.*s", (int)size, (const char *)bytes);
    if (strcmp(name, "results.tap") == 0)
        snprintf(w->tap, sizeof w->tap, "%.*s", (int)size, (const char *)bytes);
    return OST_OK;
}

static void write_all(const json_t *protocol, const json_t *cases, written *w)
{
    ost_error err = {0};
    json_t *summary;
    assert_ok(evidence_summary(protocol, cases, &summary, &err));
    snprintf(w->verdict, sizeof w->verdict, "%s", evidence_text(summary, "verdict"));
    assert_int_equal(json_is_true(json_object_get(summary, "equal")), strcmp(w->verdict, "EQUAL") == 0);
    if (strcmp(w->verdict, "NOT COMPARED") == 0) {
        assert_int_equal(json_integer_value(json_object_get(summary, "compared")), 0);
        assert_false(json_is_true(json_object_get(summary, "evidence")));
    }
    json_decref(summary);
    assert_ok(evidence_write(protocol, cases, receive_file, w, &err));
    assert_ok(junit_write(protocol, cases, NULL, NULL, receive_file, w, &err));
    assert_ok(report_write(NULL, protocol, cases, receive_file, w, &err));
}

/*
 * If all cases were refused, if only the reference ran, or if no backend was available, nothing
 * may be reported as equal.
 */
static void nothing_compared_is_not_equal(void **state)
{
    enum { REFUSED, ALONE, NOT_RUN, WAYS };
    (void)state;
    for (int way = 0; way < WAYS; way++) {
        written w = {0};
        json_t *protocol = protocol_of(&equal_kind), *cases = cases_of(&equal_kind);
        json_t *backends = json_object_get(protocol, "backends");
        if (way == ALONE)
            while (json_array_size(backends) > 1)
                json_array_remove(backends, 1);
        if (way == NOT_RUN)
            json_object_set_new(json_array_get(backends, 1), "available", json_false());
        for (size_t i = 0; i < json_array_size(cases); i++) {
            json_t *one = json_array_get(cases, i), *results = json_object_get(one, "results");
            if (way == REFUSED)
                json_object_set_new(json_array_get(json_object_get(one, "reference"), 0), "stage",
                                    json_string("failed"));
            if (way == ALONE)
                json_object_clear(results);
            if (way == NOT_RUN)
                json_object_set_new(json_object_get(results, "cpu"), "verdict", json_string("not run"));
        }
        write_all(protocol, cases, &w);
        assert_string_equal(w.verdict, "NOT COMPARED");
        assert_non_null(strstr(w.tap, "not ok 1 - something was compared\n"));
        assert_non_null(strstr(w.tap, way == ALONE ? "\n1..1\n" : "\n1..5\n"));
        assert_non_null(strstr(w.junit, "failures=\"1\""));
        assert_non_null(strstr(w.junit, "<failure message=\"nothing was compared with the reference\"/>"));
        assert_null(strstr(w.junit, "\"/>\n")); /* junit.xml must not contain a case that passed */
        json_decref(protocol);
        json_decref(cases);
    }
}

/*
 * If one of two cases was refused, the verdict comes from the other case. A refused case must not be reported as a
 * success.
 */
static void refused_case_is_no_success(void **state)
{
    ost_error err = {0};
    json_t *summary, *protocol = protocol_of(&equal_kind), *cases = cases_of(&equal_kind);
    (void)state;
    json_object_set_new(json_array_get(json_object_get(json_array_get(cases, 0), "reference"), 0), "stage",
                        json_string("failed"));
    assert_ok(evidence_summary(protocol, cases, &summary, &err));
    assert_string_equal(evidence_text(summary, "verdict"), "EQUAL");
    assert_int_equal(json_integer_value(json_object_get(summary, "compared")), 1);
    assert_int_equal(json_integer_value(json_object_get(summary, "refused")), 1);
    json_decref(summary);
    json_array_remove(cases, 0);
    assert_ok(evidence_summary(protocol, cases, &summary, &err));
    assert_string_equal(evidence_text(summary, "verdict"), "NOT COMPLETE");
    assert_false(json_is_true(json_object_get(summary, "equal")));
    json_decref(summary);
    json_decref(protocol);
    json_decref(cases);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(nothing_compared_is_not_equal),
        cmocka_unit_test(refused_case_is_no_success),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
