/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests the path counts of a backend. A worker passes them to its parent in the end record of a trace, and
 * the parent adds the counts of all workers by name. A damaged record must not add false counts.
 * Covers: REQ-VAL-PATHS
 */
#include "harness.h"

#include "core/backend.h"
#include "io/scratch_group.h"
#include "validation/paths.h"

enum { PATH = 4200 };

static uint64_t given[3];
static const char *const names[3] = {"kernel one", "the last part of a row", "a fallback"};

static void visit_given(const ost_backend *backend, ost_path_visit *visit, void *user)
{
    (void)backend;
    for (int i = 0; i < 3; i++)
        visit(user, names[i], given[i]);
}

/* Returns a trace that consists only of an end record with these counts. */
static trace trace_with_counts(const char *name, uint64_t a, uint64_t b, uint64_t c)
{
    static const ost_backend_ops table = {.name = "test", .paths = visit_given};
    const ost_backend backend = {.ops = &table};
    ost_error err = {0};
    char path[PATH];
    trace_writer *w;
    trace t;
    given[0] = a, given[1] = b, given[2] = c;
    snprintf(path, sizeof path, "%s/%s", folder, name);
    assert_ok(trace_create(path, &w, &err));
    trace_begin(w, TRACE_END, 1, 0);
    paths_write(&backend, w);
    assert_ok(trace_end(w, &err));
    assert_ok(trace_close(w, &err));
    assert_ok(trace_open(path, &t, &err));
    assert_true(t.complete);
    return t;
}

static void counts_are_summed(void **state)
{
    (void)state;
    ost_error err = {0};
    path_list list = {0};
    trace one = trace_with_counts("one", 5, 0, 0), two = trace_with_counts("two", 7, 1, 0);
    assert_ok(paths_add(&list, &one.records[one.count - 1], &err));
    assert_ok(paths_add(&list, &two.records[two.count - 1], &err));
    assert_int_equal(list.count, 3);
    assert_string_equal(list.paths[0].name, names[0]);
    assert_int_equal(list.paths[0].entered, 12);
    assert_int_equal(list.paths[1].entered, 1);
    json_t *entered, *missing;
    paths_json(&list, &entered, &missing);
    assert_int_equal(json_object_size(entered), 2);
    assert_int_equal(json_integer_value(json_object_get(entered, names[0])), 12);
    assert_int_equal(json_array_size(missing), 1);
    assert_string_equal(json_string_value(json_array_get(missing, 0)), names[2]);
    json_decref(entered);
    json_decref(missing);
    paths_free(&list);
    trace_free(&one);
    trace_free(&two);
}

/*
 * For every prefix of the record's body, the complete entries must be added and nothing may be
 * read beyond the prefix.
 */
static void damaged_counts_are_not_added(void **state)
{
    (void)state;
    ost_error err = {0};
    trace t = trace_with_counts("whole", 1, 2, 3);
    for (uint64_t bytes = 0; bytes < t.records[0].body_bytes; bytes++) {
        path_list list = {0};
        trace_record r = t.records[0];
        uint8_t *body = malloc(bytes + 1);
        assert_non_null(body);
        memcpy(body, r.body, bytes);
        r.body = body;
        r.body_bytes = bytes;
        assert_ok(paths_add(&list, &r, &err));
        assert_true(list.count < 3);
        paths_free(&list);
        free(body);
    }
    trace_free(&t);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(counts_are_summed),
        cmocka_unit_test(damaged_counts_are_not_added),
    };
    return cmocka_run_group_tests(tests, scratch_set_up, scratch_tear_down);
}
