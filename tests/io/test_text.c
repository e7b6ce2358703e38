/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests CT text: valid texts, and the error for each kind of broken file.
 *
 * Covers: AR-CT-1, AR-CT-2, AR-CT-8
 */
#include "harness.h"

#include "io/text/scan.h"
#include "io/scratch_group.h"

/* Reads the rows of a text, at most `capacity` of them. */
static ost_status read_rows(const char *text, size_t size, ost_text_row *rows, size_t capacity, size_t *count,
                            ost_error *err)
{
    const char *path = scratch_write(folder, "ct.txt", text, size);
    ost_text_source source;
    ost_status status = ost_text_source_open(&source, path, err);
    size_t got = 1;
    *count = 0;
    while (status == OST_OK && got > 0) {
        status = ost_text_source_next(&source, rows + *count, capacity - *count, &got, err);
        *count += got;
        if (*count == capacity)
            break;
    }
    ost_text_source_close(&source);
    return status;
}

static void values_are_exact(void **state)
{
    (void)state;
    static const struct {
        const char *line;
        int64_t x, y, z;
        int density;
        int places[3];
    } cases[] = {
        {"1 2 3 4", 1000000000, 2000000000, 3000000000, 4, {0, 0, 0}},
        {"-57.34 0.48828125 +1.5 -1000", -57340000000, 488281250, 1500000000, -1000, {2, 8, 1}},
        {"0.4700,0.9400,1.4100,120", 470000000, 940000000, 1410000000, 120, {4, 4, 4}},
        {"  1\t2 ;3 ,\t4  # note", 1000000000, 2000000000, 3000000000, 4, {0, 0, 0}},
        {"1;2;3;4#note", 1000000000, 2000000000, 3000000000, 4, {0, 0, 0}},
        {"4.7e-1 47E-2 0.0047e+2 1.2e2", 470000000, 470000000, 470000000, 120, {2, 2, 2}},
        {"1. .5 -.25 120.000", 1000000000, 500000000, -250000000, 120, {0, 1, 2}},
        {"-0 -0.0 0 -0", 0, 0, 0, 0, {0, 1, 0}},
        {"8000 -8000 7999.999999999 32767", 8000000000000, -8000000000000, 7999999999999, 32767, {0, 0, 9}},
        /* the first two positions are ties, which are rounded to the even number */
        {"0.0000000005 0.0000000015 0.00000000051 -32768", 0, 2, 1, -32768, {9, 9, 9}},
        {"00000000000000000000001 2 3 4.00000000000000000000000000", 1000000000, 2000000000, 3000000000, 4, {0, 0, 0}},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        for (int ending = 0; ending < 3; ending++) {
            ost_error err = {0};
            ost_text_row row[2];
            size_t count;
            char text[256];
            int size = snprintf(text, sizeof text, "%s%s", cases[i].line,
                                ending == 0   ? "\n"
                                : ending == 1 ? "\r\n"
                                              : "");
            assert_ok(read_rows(text, (size_t)size, row, 2, &count, &err));
            assert_int_equal(count, 1);
            assert_true(row[0].position[0] == cases[i].x);
            assert_true(row[0].position[1] == cases[i].y);
            assert_true(row[0].position[2] == cases[i].z);
            assert_int_equal(row[0].density, cases[i].density);
            for (int a = 0; a < 3; a++)
                assert_int_equal(row[0].places[a], cases[i].places[a]);
            assert_int_equal(row[0].rounded, strstr(cases[i].line, "0.00000000051") ? 7 : 0);
        }
    }
}

static void comments_and_blank_lines_are_skipped(void **state)
{
    (void)state;
    static const char text[] = "\xef\xbb\xbf# made by hand\r\n"
                               "\r\n"
                               "x [mm],y [mm],z [mm],density\r\n"
                               "1,2,3,4\r\n"
                               "   # between\r\n"
                               "\t\r\n"
                               "5,6,7,8";
    ost_error err = {0};
    ost_text_row rows[4];
    size_t count;
    assert_ok(read_rows(text, sizeof text - 1, rows, 4, &count, &err));
    assert_int_equal(count, 2);
    assert_int_equal(rows[0].line, 4);
    assert_int_equal(rows[1].line, 7);
    assert_int_equal(rows[1].density, 8);
}

/* The text of the error must contain `ct.txt` followed by these words. */
static void broken_texts_are_refused(void **state)
{
    (void)state;
    static const struct {
        const char *text;
        const char *message;
    } cases[] = {
        /* The text is truncated at every kind of position. */
        {"1 2 3 4\n1", ":2: 1 value; expected 4"},
        {"1 2 3 4\n1 2", ":2: 2 values; expected 4"},
        {"1 2 3 4\n1 2 3", ":2: 3 values; expected 4"},
        {"1 2 3 4\n1 2 3 ", ":2: 3 values; expected 4"},
        {"1,2,3,4\n1,2,3,", ":2: value 4 is empty"},
        {"1 2 3 4\n1 2 -", ":2: column 3 (z) is '-'; expected a decimal number"},
        {"1 2 3 4\n1 2 3.", ":2: 3 values; expected 4"},
        {"1 2 3 4\n1 2 3 1e", ":2: column 4 (density) is '1e'; expected a decimal number"},
        {"1 2 3 4\n1 2 3 1e+", ":2: column 4 (density) is '1e+'; expected a decimal number"},
        /* not numbers */
        {"nan 2 3 4\n", ":1: column 1 (x) is 'nan'; expected a decimal number"},
        {"1 2 NaN 4\n", ":1: column 3 (z) is 'NaN'"},
        {"1 2 3 nan(0x1)\n", ":1: column 4 (density) is 'nan(0x1)'"},
        {"-inf 2 3 4\n", ":1: column 1 (x) is '-inf'"},
        {"Infinity 2 3 4\n", ":1: column 1 (x) is 'Infinity'"},
        {"0x10 2 3 4\n", ":1: column 1 (x) is '0x10'"},
        {"1 2 3 4\n1 2 3 1_000\n", ":2: column 4 (density) is '1_000'"},
        {"1 2 3 4\n1 2 3 --4\n", ":2: column 4 (density) is '--4'"},
        {"1 2 3 4\n1 2 3 1.2.3\n", ":2: column 4 (density) is '1.2.3'"},
        {"1 2 3 4\n1 2 three 4\n", ":2: column 3 (z) is 'three'"},
        {"1 2 3 4\nx y z density\n", ":2: column 1 (x) is 'x'"},
        {"x y z d\na b c d\n", ":2: column 1 (x) is 'a'"},
        {"1 2 3 '4'\n", ":1: column 4 (density) is ''4''"},
        {"1 2 3 \xe2\x88\x92"
         "4\n",
         ":1: column 4 (density) is '\xe2\x88\x92"
         "4'"}, /* the sign is a typographic minus */
        /* values out of range */
        {"1 2 3 4\n8000.000000001 2 3 4\n",
         ":2: column 1 (x) is '8000.000000001'; expected a position within 8000 mm of 0"},
        {"1 -1e9 3 4\n", ":1: column 2 (y) is '-1e9'; expected a position"},
        {"1 2 1e9999 4\n", ":1: column 3 (z) is '1e9999'; expected a position"},
        {"1 2 1e99999 4\n", ":1: column 3 (z) is '1e99999'; expected a decimal number"},
        {"1 2 99999999999999999999999999 4\n", ":1: column 3 (z)"},
        {"1 2 3 32768\n", ":1: column 4 (density) is '32768'; expected a density from -32768 to 32767"},
        {"1 2 3 -32769\n", ":1: column 4 (density) is '-32769'"},
        {"1 2 3 1e40\n", ":1: column 4 (density) is '1e40'; expected a density from -32768"},
        {"1 2 3 4.5\n", ":1: column 4 (density) is '4.5'; expected a density without decimals"},
        {"1 2 3 1e-1\n", ":1: column 4 (density) is '1e-1'; expected a density without decimals"},
        {"1 2 3 4.00000000000000000000000001\n", ":1: column 4 (density)"},
        /* wrong number of columns */
        {"1 2 3 4 5\n", ":1: 5 values; expected 4"},
        {"1,,3,4\n", ":1: value 2 is empty"},
        {",1,2,3\n", ":1: value 1 is empty"},
        {"1,2,3,4,\n", ":1: value 5 is empty"},
        {"1;2,;3;4\n", ":1: value 3 is empty"},
        {"0,47 0,94 1,41 120\n", ":1: 7 values; expected 4: x y z density (the decimal sign is a point, not a comma)"},
        /* files of other kinds */
        {"", ": file is empty"},
        {"\n\n\n", ": no line is a sample"},
        {"# only a comment\n", ": no line is a sample"},
        {"x y z density\n", ": no line is a sample"},
        {"<html><body>404</body></html>\n1 2 3 4 5\n", ":2: 5 values"},
        {"\xff\xfe"
         "1\n",
         ":1: the text is UTF-16"},
        {"1 2 3 4\r5 6 7 8\r", ":1: line ends are CR alone; LF or CR LF expected"},
        {"\xef\xbb\xbfx y z d\r1 2 3 4", ":1: line ends are CR alone"},
        {"1 2 3 4\r5 6 7 8\n", ":1: binary bytes"},
        {"\x01\r1 2 3 4\r", ":1: binary bytes"},
        {"1 2 3 4\n\x01\x02\x03\n", ":2: binary bytes"},
        {"\x7f"
         "ELF\x02\n",
         ":1: binary bytes"},
        /* facts of the text */
        {"# osteon spacing_mm: 1 1\n1 2 3 4\n", ":1: fact 'spacing_mm' is '1 1'; expected three lengths"},
        {"# osteon spacing_mm: 1 1 0\n1 2 3 4\n", ":1: fact 'spacing_mm'"},
        {"# osteon spacing_mm: 1 1 nan\n1 2 3 4\n", ":1: fact 'spacing_mm'"},
        {"# osteon origin_mm: 1 1 x\n1 2 3 4\n", ":1: fact 'origin_mm'"},
        {"# osteon dims: 1 1 16385\n1 2 3 4\n", ":1: fact 'dims'"},
        {"# osteon dims: 1 1 1.5\n1 2 3 4\n", ":1: fact 'dims'"},
        {"# osteon dims: 2 1 1\n1 2 3 4\n", ":2: ends after 1 samples; line 1 says 2 x 1 x 1, which are 2"},
        {"# osteon dims: 1 1 1\n1 2 3 4", ":2: the last line has no line end: the file is truncated"},
        {"# osteon KIND: bone\n1 2 3 4\n", ":1: 'KIND' is not a key"},
        {"# osteon dims: 1 1 1\n1 2 3 4\n# osteon dims: 1 1 2\n",
         ":3: fact 'dims' is '1 1 2', but line 1 gives another"},
        {"# osteon spacing_mm: 1 1 1\n# osteon spacing_mm: 1 1 1.000000001\n1 2 3 4\n",
         ":2: fact 'spacing_mm' is '1 1 1.000000001', but line 1 gives another"},
        {"# osteon origin_mm: 1 2 3\n#osteon\torigin_mm: 1 2 3.5\n1 2 3 4\n",
         ":2: fact 'origin_mm' is '1 2 3.5', but line 1"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        ost_error err = {0};
        ost_text_source source;
        ost_text_summary summary;
        const char *path = scratch_write(folder, "ct.txt", cases[i].text, strlen(cases[i].text));
        assert_ok(ost_text_source_open(&source, path, &err));
        ost_status status = ost_text_scan(&source, (ost_pm3){0, 0, 0}, NULL, NULL, NULL, &summary, &err);
        ost_text_summary_free(&summary);
        ost_text_source_close(&source);
        const char *found = strstr(err.text, "ct.txt");
        if (status != OST_ERR_INPUT || !found || strncmp(found + 6, cases[i].message, strlen(cases[i].message)) != 0)
            fail_msg("case %zu: %s '%s', expected '...ct.txt%s'", i, ost_status_name(status), err.text,
                     cases[i].message);
    }
}

/*
 * AR-CT-8: a fact that determines the grid may be repeated with equal values in any notation. For
 * other facts the last value counts.
 */
static void facts_may_be_repeated(void **state)
{
    (void)state;
    static const char text[] =
        "# osteon dims: 1 1 1\n# osteon spacing_mm: 0.5 1 2\n# osteon note: first\n# osteon made: 1998\n"
        "#osteon dims:\t1.0,10e-1;1 \n1 2 3 4\n\t# osteon spacing_mm: 0.50 1.0,2e0\n# osteon origin_mm: 1 2 3\n"
        "# osteon note: last\n# osteon origin_mm: 1.0 2.0 3.0\n# osteon was here: 1998\n# osteon ab : 3\n";
    ost_error err = {0};
    ost_text_source source;
    ost_text_summary summary;
    ost_geometry g;
    bool inferred[3];
    const char *path = scratch_write(folder, "ct.txt", text, sizeof text - 1);
    assert_ok(ost_text_source_open(&source, path, &err));
    assert_ok(ost_text_scan(&source, (ost_pm3){0, 0, 0}, NULL, NULL, NULL, &summary, &err));
    assert_ok(ost_text_geometry(path, &summary, &g, inferred, &err));
    assert_true(g.spacing.x == 500000000 && g.spacing.y == 1000000000 && g.spacing.z == 2000000000);
    assert_int_equal(summary.meta.count, 2);
    assert_string_equal(summary.meta.entry[0].key, "note");
    assert_string_equal(summary.meta.entry[0].value, "last");
    assert_string_equal(summary.meta.entry[1].key, "made");
    ost_text_summary_free(&summary);
    ost_text_source_close(&source);
}

/* A fact that is too long must be refused and never truncated to another number. */
static void long_facts_are_refused(void **state)
{
    (void)state;
    static const char *const keys[] = {"spacing_mm", "origin_mm", "dims", "note"};
    for (size_t k = 0; k < sizeof keys / sizeof keys[0]; k++) {
        for (int digits = 190; digits < 400; digits += 15) {
            ost_error err = {0};
            ost_text_source source;
            ost_text_summary summary;
            char text[512];
            int size = snprintf(text, sizeof text, "# osteon %s: 1 1 1.%0*d\n1 1 1 4\n", keys[k], digits, 0);
            /* the lengths are 4 for "1 1 ", 2 for "1." and `digits` for the zeros */
            bool fits = 4 + 2 + digits <= 200;
            assert_ok(ost_text_source_open(&source, scratch_write(folder, "ct.txt", text, (size_t)size), &err));
            ost_status status = ost_text_scan(&source, (ost_pm3){0, 0, 0}, NULL, NULL, NULL, &summary, &err);
            assert_int_equal(status, fits ? OST_OK : OST_ERR_INPUT);
            ost_text_summary_free(&summary);
            ost_text_source_close(&source);
        }
    }
}

/* A zero byte at any position must be refused. Such texts are not C strings, so they are tested separately. */
static void zero_bytes_are_refused(void **state)
{
    (void)state;
    static const char line[] = "# a comment\n1 2 3 4 # note\n5 6 7 8\n";
    for (size_t at = 0; at < sizeof line - 1; at++) {
        ost_error err = {0};
        ost_text_row rows[4];
        size_t count;
        char text[sizeof line];
        memcpy(text, line, sizeof line);
        text[at] = 0;
        ost_status status = read_rows(text, sizeof line - 1, rows, 4, &count, &err);
        assert_int_equal(status, OST_ERR_INPUT);
        assert_non_null(strstr(err.text, "ct.txt:"));
    }
}

static void overlong_lines_are_refused(void **state)
{
    (void)state;
    static const size_t sizes[] = {OST_TEXT_LINE_MAX + 1, OST_TEXT_BUFFER - 1, OST_TEXT_BUFFER, 3 * OST_TEXT_BUFFER};
    for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; i++) {
        ost_error err = {0};
        ost_text_row rows[4];
        size_t count;
        char *text = malloc(sizes[i] + 8);
        assert_non_null(text);
        memcpy(text, "1 2 3 4\n", 8);
        memset(text + 8, '1', sizes[i]);
        assert_int_equal(read_rows(text, sizes[i] + 8, rows, 4, &count, &err), OST_ERR_INPUT);
        assert_non_null(strstr(err.text, ":2: the line is longer than 4096 bytes"));
        free(text);
    }
}

/*
 * Reads a text of 60,000 lines of random lengths, so that some lines cross the end of the read buffer. The rows must
 * depend neither on where the buffer ends nor on the size of the portions in which they are read.
 */
static void rows_do_not_depend_on_the_read_buffer(void **state)
{
    (void)state;
    test_rng rng = rng_seeded("rows_do_not_depend_on_the_read_buffer");
    enum { LINES = 60000 };
    char *text = malloc(LINES * 32), *p = text;
    assert_non_null(text);
    for (int i = 0; i < LINES; i++)
        p += sprintf(p, "%d.%0*d %d %d %d\n", i % 7, 1 + (int)rng_range(&rng, 0, 5), i % 9, i % 11, i % 13, i % 3000);
    const char *path = scratch_write(folder, "ct.txt", text, (size_t)(p - text));
    ost_error err = {0};
    ost_text_source source;
    assert_ok(ost_text_source_open(&source, path, &err));
    ost_text_row rows[1000];
    size_t count;
    int seen = 0;
    for (;;) {
        assert_ok(ost_text_source_next(&source, rows, (size_t)rng_range(&rng, 1, 1000), &count, &err));
        if (count == 0)
            break;
        for (size_t i = 0; i < count; i++, seen++) {
            assert_int_equal(rows[i].line, seen + 1);
            assert_int_equal(rows[i].density, seen % 3000);
            assert_true(rows[i].position[1] == seen % 11 * OST_PM_PER_MM);
        }
    }
    assert_int_equal(seen, LINES);
    ost_text_source_close(&source);
    free(text);
}

static void refuses_unreadable_files(void **state)
{
    (void)state;
    ost_error err = {0};
    ost_text_source source;
    char path[512];
    assert_int_equal(ost_text_source_open(&source, folder, &err), OST_ERR_IO);
    assert_non_null(strstr(err.text, "is a folder"));
    snprintf(path, sizeof path, "%s/absent", folder);
    assert_int_equal(ost_text_source_open(&source, path, &err), OST_ERR_IO);
    assert_non_null(strstr(err.text, "cannot open"));
    snprintf(path, sizeof path, "%s/pipe", folder);
    assert_int_equal(mkfifo(path, 0600), 0);
    assert_int_equal(ost_text_source_open(&source, path, &err), OST_ERR_IO);
    assert_non_null(strstr(err.text, "save it to a file first"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(values_are_exact),
        cmocka_unit_test(comments_and_blank_lines_are_skipped),
        cmocka_unit_test(broken_texts_are_refused),
        cmocka_unit_test(facts_may_be_repeated),
        cmocka_unit_test(long_facts_are_refused),
        cmocka_unit_test(zero_bytes_are_refused),
        cmocka_unit_test(overlong_lines_are_refused),
        cmocka_unit_test(rows_do_not_depend_on_the_read_buffer),
        cmocka_unit_test(refuses_unreadable_files),
    };
    return cmocka_run_group_tests(tests, scratch_set_up, scratch_tear_down);
}
