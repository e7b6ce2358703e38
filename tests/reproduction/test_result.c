/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests the results of `osteon reproduce`. JSON must be read back without a change, and broken JSON must be refused.
 * Further tests check the merging of results of several machines, and CSV files.
 *
 * Covers: REQ-REPRODUCE-FILES, REQ-REPRODUCE-MERGE
 */
#include "harness.h"

#include <unistd.h>

#include "reproduction/write.h"
#include "reproduction/write_json.h"

static const result_machine machine = {.label = "m, \"1\"",
                                       .cpu = "cpu",
                                       .backend = "cpu",
                                       .isa = "avx2",
                                       .compiler = "gcc",
                                       .version = "0.1",
                                       .threads = 2,
                                       .processors = 4,
                                       .memory_gb = 8.5};

static void fill_random(test_rng *rng, result *r)
{
    result_init(r, "table-9.9", "a title", &machine);
    const int name = result_add_column(r, "name", "name", "text");
    const int time = result_add_column(r, "time_us", "time", "us");
    const int size = result_add_column(r, "size", "size", "");
    const int64_t rows = rng_range(rng, 1, 40);
    for (int64_t i = 0; i < rows; i++) {
        result_add_row(r);
        result_set_text(r, name, "row %d, \"q\" <%d>", (int)i, (int)rng_range(rng, 0, 99));
        if (rng_range(rng, 0, 3))
            result_set(r, time, (double)rng_range(rng, 1, INT64_C(1) << 40) / 1024);
        if (rng_range(rng, 0, 1))
            result_set_thesis(r, time, (double)rng_range(rng, 1, 1000) / 7);
        result_set(r, size, (double)rng_range(rng, 0, 1000000));
    }
    result_add_remark(r, "a remark with %d", 7);
    result_add_finding(r, RESULT_CONTRADICTED, "section 1", "A claim.", "A reason: %d.", 3);
    result_plot *p = result_add_plot(r, RESULT_PLOT_LINES, "plot", "size", "time (us)");
    p->x = size;
    p->group = name;
    p->value[p->values++] = time;
    p->log_y = true;
    char *bytes = malloc(3);
    assert_non_null(bytes);
    memcpy(bytes, "abc", 3);
    result_add_picture(r, "table-9.9.png", "a picture", (uint8_t *)bytes, 3);
    assert_false(r->out_of_memory);
}

static void test_json_round_trip(void **state)
{
    (void)state;
    test_rng rng = rng_seeded("json");
    for (int i = 0; i < 100; i++) {
        ost_error err = {0};
        result a, b;
        fill_random(&rng, &a);
        char *text = write_json_text(&a);
        assert_non_null(text);
        result_init(&b, "", "", NULL);
        assert_ok(write_json_parse(text, strlen(text), "a.json", &b, &err));
        assert_int_equal(b.row_count, a.row_count);
        assert_int_equal(b.machine[0].threads, 2);
        for (size_t r = 0; r < a.row_count; r++) {
            assert_string_equal(b.row[r].cell[0].text, a.row[r].cell[0].text);
            assert_int_equal(b.row[r].cell[1].known, a.row[r].cell[1].known);
            assert_int_equal(b.row[r].cell[1].stated, a.row[r].cell[1].stated);
        }
        char *again = write_json_text(&b);
        assert_string_equal(again, text);
        free(again);
        free(text);
        result_free(&a);
        result_free(&b);
    }
}

static void test_broken_json(void **state)
{
    (void)state;
    test_rng rng = rng_seeded("broken json");
    result a;
    fill_random(&rng, &a);
    char *text = write_json_text(&a);
    const size_t size = strlen(text);
    /* A truncated text must be refused. A text with one changed byte must be refused or read without a crash. */
    for (size_t length = 0; length < size - 2; length += 7) {
        ost_error err = {0};
        result b;
        result_init(&b, "", "", NULL);
        assert_int_equal(write_json_parse(text, length, "a.json", &b, &err), OST_ERR_INPUT);
        assert_non_null(strstr(err.text, "a.json"));
        result_free(&b);
    }
    for (int i = 0; i < 2000; i++) {
        ost_error err = {0};
        result b;
        char *changed = strdup(text);
        assert_non_null(changed);
        changed[rng_range(&rng, 0, (int64_t)size - 1)] = (char)rng_range(&rng, ' ', '~');
        result_init(&b, "", "", NULL);
        const ost_status status = write_json_parse(changed, size, "a.json", &b, &err);
        assert_true(status == OST_OK || status == OST_ERR_INPUT);
        result_free(&b);
        free(changed);
    }
    /* A picture's name that contains a folder must be refused, because the picture would be read from that folder. */
    char *name = strstr(text, "table-9.9.png");
    assert_non_null(name);
    memcpy(name, "/etc/passwd.p", 13);
    ost_error err = {0};
    result b;
    result_init(&b, "", "", NULL);
    assert_int_equal(write_json_parse(text, size, "a.json", &b, &err), OST_ERR_INPUT);
    result_free(&b);
    free(text);
    result_free(&a);
}

static void test_merge(void **state)
{
    (void)state;
    test_rng rng = rng_seeded("merge");
    ost_error err = {0};
    result a, b, c;
    fill_random(&rng, &a);
    fill_random(&rng, &b);
    const size_t rows = a.row_count, more = b.row_count;
    assert_ok(result_merge(&a, &b, &err));
    assert_int_equal(a.machine_count, 2);
    assert_string_equal(a.machine[1].label, "m, \"1\" (2)");
    assert_int_equal(a.row_count, rows + more);
    for (size_t i = 0; i < a.row_count; i++)
        assert_int_equal(a.row[i].machine, i >= rows);
    assert_int_equal(a.finding_count, 2);
    assert_int_equal(a.finding[1].machine, 1);
    assert_int_equal(a.remark_count, 1); /* equal remarks are stated once */
    assert_int_equal(a.picture_count, 1);
    assert_ok(result_merge(&a, &b, &err));
    assert_string_equal(a.machine[2].label, "m, \"1\" (3)");
    result_init(&c, "table-9.9", "other columns", &machine);
    result_add_column(&c, "other", "other", "us");
    assert_int_equal(result_merge(&a, &c, &err), OST_ERR_INPUT);
    result_free(&a);
    result_free(&b);
    result_free(&c);
}

static void test_files(void **state)
{
    (void)state;
    test_rng rng = rng_seeded("files");
    ost_error err = {0};
    write_files files;
    result a, b;
    bool absent = false;
    char folder[] = "/tmp/osteon-test-XXXXXX", path[WRITE_PATH];
    assert_non_null(mkdtemp(folder));
    fill_random(&rng, &a);
    assert_ok(write_result(folder, &a, &files, &err));
    assert_int_equal(files.count, 4); /* the files are a CSV, an SVG, a PNG and a JSON */
    assert_ok(write_read(folder, "table-9.9", &b, &absent, &err));
    assert_int_equal(b.picture[0].size, 3);
    assert_memory_equal(b.picture[0].bytes, "abc", 3);
    result_free(&b);
    assert_int_not_equal(write_read(folder, "table-1.1", &b, &absent, &err), OST_OK);
    assert_true(absent);
    result_free(&b);
    for (int i = 0; i < files.count; i++) {
        assert_ok(write_path(path, folder, files.name[i], &err));
        assert_int_equal(unlink(path), 0);
    }
    assert_int_equal(rmdir(folder), 0); /* the folder is empty, so no other file was written */
    result_free(&a);
}

static void test_values(void **state)
{
    (void)state;
    char text[WRITE_VALUE];
    assert_string_equal(write_value(text, 0), "0");
    assert_string_equal(write_value(text, 1234567), "1,234,567");
    assert_string_equal(write_value(text, -1234), "-1,234");
    assert_string_equal(write_value(text, 0.012), "0.01200");
    assert_string_equal(write_value(text, 0.405), "0.405");
    assert_string_equal(write_value(text, 38.314), "38.31");
    assert_int_equal(result_order(100, 104, 0.05), 0);
    assert_int_equal(result_order(100, 106, 0.05), -1);
    assert_int_equal(result_order(106, 100, 0.05), 1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_json_round_trip),
        cmocka_unit_test(test_broken_json),
        cmocka_unit_test(test_merge),
        cmocka_unit_test(test_files),
        cmocka_unit_test(test_values),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
