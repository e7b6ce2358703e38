/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests paths in text files. The tests cover exact integers, writing and reading back, positions in metres,
 * compressed files, rows without a pose, gaps in time and space, and each type of broken file.
 *
 * Covers: AR-POSE-2, AR-PATH-1, AR-PATH-2, AR-PATH-3, AR-PATH-4, AR-PATH-5
 */
#include "harness.h"

#include <zlib.h>

#include <osteon/io.h>

#include "io/scratch_group.h"

static ost_status read_text(const char *text, ost_path *out, ost_error *err)
{
    return ost_path_read_csv(scratch_write(folder, "p.csv", text, strlen(text)), out, err);
}

static void rows_are_exact(void **state)
{
    (void)state;
    ost_error err = {0};
    ost_path path;
    assert_ok(read_text("# made by hand\r\n"
                        "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,tool\r\n"
                        "0,1.5,-57.34,0.000000001,1,0,0,0,0\r\n"
                        "\r\n"
                        "0.001, 1.5 ,-57.34,8000,0.5,-0.5,0.5,-0.5,3 # turned\r\n"
                        "1.0000000005,0,0,0,0.70710678,0,0.70710678,0,0",
                        &path, &err));
    assert_int_equal(path.count, 3);
    assert_true(path.ticks[0].t_ns == 0 && path.ticks[1].t_ns == 1000000 && path.ticks[2].t_ns == 1000000000);
    assert_true(path.ticks[0].pose.t.x == 1500000000 && path.ticks[0].pose.t.y == -57340000000 &&
                path.ticks[0].pose.t.z == 1);
    assert_int_equal(path.ticks[0].pose.qw, OST_Q30_ONE);
    assert_int_equal(path.ticks[1].pose.qx, -OST_Q30_ONE / 2);
    assert_int_equal(path.ticks[1].tool, 3);
    /* 70710678 * 2^30 / 10^8 = 759250123.72..., computed with Python's fractions */
    assert_int_equal(path.ticks[2].pose.qw, 759250124);
    ost_path_free(&path);
}

static void written_path_is_restored(void **state)
{
    (void)state;
    test_rng rng = rng_seeded("written_path_is_restored");
    char name[600];
    snprintf(name, sizeof name, "%s/back.csv", folder);
    for (int round = 0; round < 2; round++) {
        ost_error err = {0};
        ost_path path, back;
        assert_ok(ost_path_init(&path, 5000, &err));
        int64_t t = rng_range(&rng, -1000000000, 1000000000);
        for (size_t i = 0; i < path.count; i++) {
            /* Makes a unit quaternion of random direction. Its components are exact integers. */
            double q[4], norm = 0;
            for (int a = 0; a < 4; a++) {
                q[a] = (double)rng_range(&rng, -1000000, 1000000);
                norm += q[a] * q[a];
            }
            double root = norm > 1 ? norm : 1;
            for (int n = 0; n < 60; n++)
                root = 0.5 * (root + norm / root);
            path.ticks[i] = (ost_tick){
                .t_ns = t += rng_range(&rng, 1, 3000000),
                .tool = round ? (int32_t)rng_range(&rng, 0, 3) : 0,
                .rpm = (int32_t)rng_range(&rng, OST_RPM_ON, OST_RPM_MAX),
                .lifted = i > 0 && rng_range(&rng, 0, 9) == 0,
                .pose = {{rng_range(&rng, -OST_LENGTH_MAX, OST_LENGTH_MAX), rng_range(&rng, -1000, 1000),
                          rng_range(&rng, -1000000000, 1000000000)},
                         (int32_t)(q[0] / root * OST_Q30_ONE),
                         (int32_t)(q[1] / root * OST_Q30_ONE),
                         (int32_t)(q[2] / root * OST_Q30_ONE),
                         (int32_t)(q[3] / root * OST_Q30_ONE)},
            };
        }
        assert_ok(ost_path_write_csv(name, &path, &err));
        assert_ok(ost_path_read_csv(name, &back, &err));
        assert_int_equal(back.count, path.count);
        for (size_t i = 0; i < path.count; i++) {
            const ost_tick *a = &path.ticks[i], *b = &back.ticks[i];
            assert_true(a->t_ns == b->t_ns && a->tool == b->tool && a->lifted == b->lifted && a->rpm == b->rpm);
            assert_true(a->pose.t.x == b->pose.t.x && a->pose.t.y == b->pose.t.y && a->pose.t.z == b->pose.t.z);
            assert_true(a->pose.qw == b->pose.qw && a->pose.qx == b->pose.qx && a->pose.qy == b->pose.qy &&
                        a->pose.qz == b->pose.qz);
        }
        char *text = scratch_read(name, NULL);
        assert_int_equal(strncmp(text,
                                 round ? "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,tool,lifted,rpm\n"
                                       : "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,lifted,rpm\n",
                                 42 + (round ? 5 : 0)),
                         0);
        free(text);
        ost_path_free(&path);
        ost_path_free(&back);
    }
}

static void reads_tool_numbers_and_extreme_times(void **state)
{
    (void)state;
    ost_error err = {0};
    ost_path path;
    assert_ok(read_text("-4e9 0 0 0 1 0 0 0 0.0\n-1 0 0 0 1 0 0 0 +0\n0 0 0 0 1 0 0 0 -0\n1 0 0 0 1 0 0 0 1e0\n"
                        "4000000000 0 0 0 1 0 0 0 2147483647\n", &path, &err));
    static const int32_t tools[] = {0, 0, 0, 1, INT32_MAX};
    assert_int_equal(path.count, 5);
    for (int i = 0; i < 5; i++)
        assert_int_equal(path.ticks[i].tool, tools[i]);
    assert_true(path.ticks[0].t_ns == INT64_C(-4000000000000000000) &&
                path.ticks[4].t_ns == INT64_C(4000000000000000000));
    ost_path_free(&path);
}

/* Reads a path from a tracker in several forms: in metres, compressed, with additional columns, and written by hand. */
static void reads_tracker_files(void **state)
{
    (void)state;
    static const char rows[] = "t_s,x_m,y_m,z_m,qw,qx,qy,qz,movement,lifted,tool,note\n"
                               "0,nan,0,0,1,0,0,0,0,0,0,a\n"
                               "0.0035,0.0947715,-0.562,1.2237091234567,1,0,0,0,0,0,+3\n"
                               "0.007,0,0,0,nan,NaN,nan,NAN,0,0,0,;,;\n"
                               "0.0105,0.0947715,-0.562,1.2,1,0,0,0,1,0,3,x y z # seen again\n"
                               "0.0140,0.0947715,-0.562,1.2,1,0,0,0,1,0,3,\n"
                               "0.0175,0.0947715,-0.562,1.2,1,0,0,0,1,1,3,\n"
                               "0.021,1,nan,1,1,0,0,0,1,0,3,\n";
    ost_error err = {0};
    char name[600];
    snprintf(name, sizeof name, "%s/t.csv.gz", folder);
    gzFile gz = gzopen(name, "wb");
    assert_non_null(gz);
    assert_int_equal(gzwrite(gz, rows, sizeof rows - 1), (int)sizeof rows - 1);
    assert_int_equal(gzclose(gz), Z_OK);
    ost_file_kind kind;
    assert_ok(ost_file_kind_find(name, &kind, &err));
    assert_int_equal(kind, OST_FILE_PATH_CSV);
    for (int packed = 0; packed < 2; packed++) {
        ost_path path;
        ost_path_report report;
        assert_ok(ost_path_read(packed ? name : scratch_write(folder, "t.csv", rows, sizeof rows - 1), NULL, &path,
                                &report, &err));
        assert_int_equal(path.count, 4);
        static const bool lifted[] = {false, true, false, true};
        for (int i = 0; i < 4; i++) {
            assert_int_equal(path.ticks[i].tool, 3);
            assert_int_equal(path.ticks[i].lifted, lifted[i]);
        }
        assert_true(path.ticks[0].pose.t.x == INT64_C(94771500000) && path.ticks[0].pose.t.y == INT64_C(-562000000000));
        assert_true(path.ticks[0].pose.t.z == INT64_C(1223709123457)); /* z is rounded to the picometre */
        assert_true(report.rows == 7 && report.lost_rows == 3 && report.gaps == 2);
        assert_true(report.begin_ns == 0 && report.end_ns == 21000000);
        ost_path_free(&path);
    }
    /* A truncated file must be refused. */
    size_t size;
    char *bytes = scratch_read(name, &size);
    ost_path path;
    assert_int_equal(ost_path_read_csv(scratch_write(folder, "cut.csv.gz", bytes, size - 12), &path, &err),
                     OST_ERR_INPUT);
    assert_non_null(strstr(err.text, "cut.csv.gz: the gzip data are damaged or cut off"));
    free(bytes);
}

/* Times (ms) and positions (mm) of rows, and for each row whether it must be lifted. */
typedef struct gap_case {
    const char *header;
    ost_path_options options;
    int count;
    double ms[8], mm[8];
    bool lifted[8];
} gap_case;

static void gaps_between_rows_are_detected(void **state)
{
    (void)state;
    static const gap_case cases[] = {
        /* the example of docs/spec/arithmetic.md, with intervals of 3.5 ms and one interval of 98 ms */
        {"", {0}, 6, {0, 3.5, 7, 10.5, 108.5, 112}, {0}, {[4] = true}},
        /* With a usual interval of one second, an interval is a gap if it is longer than ten seconds. */
        {"", {0}, 5, {0, 1000, 2000, 3000, 13000}, {0}, {false}},
        {"", {0}, 5, {0, 1000, 2000, 3000, 13000.001}, {0}, {[4] = true}},
        {"", {0}, 2, {0, 60000}, {0, 300}, {false}},
        /* An interval of at most 50 ms is never a gap. */
        {"", {0}, 5, {0, 1, 2, 52, 102.001}, {0}, {[4] = true}},
        /* A gap in space is a distance that is greater than 5 mm and greater than ten times the usual distance. */
        {"", {0}, 5, {0, 1, 2, 3, 4}, {0, 0.01, 0.02, 5.02, 10.021}, {[4] = true}},
        {"", {0}, 5, {0, 1, 2, 3, 4}, {0, 1, 2, 12, 22.001}, {[4] = true}},
        {"", {0}, 4, {0, 1, 2, 3}, {0, 20, 40, 60}, {false}},
        /* Options set a limit of time only, limits of both time and distance, or no limit. */
        {"", {10000000, 0}, 4, {0, 10, 20.001, 30}, {0, 1, 2, 3}, {[2] = true}},
        {"", {10000000, OST_PM_PER_MM / 2}, 4, {0, 1, 2, 13}, {0, 0.5, 1.001, 1}, {[2] = true, [3] = true}},
        {"", {OST_PATH_NO_GAPS, OST_PATH_NO_GAPS}, 4, {0, 1, 2, 900}, {0, 1, 2, 3000}, {false}},
        /* If a file has a `lifted` column, the reader searches for gaps only if an option sets a limit. */
        {"t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,tool,lifted\n", {0}, 4, {0, 1, 2, 900}, {0, 1, 2, 3000}, {false}},
        {"t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,tool,lifted\n",
         {100000000, 0},
         4,
         {0, 1, 2, 900},
         {0, 1, 2, 3000},
         {[3] = true}},
    };
    for (size_t c = 0; c < sizeof cases / sizeof cases[0]; c++) {
        const gap_case *g = &cases[c];
        char text[1000];
        size_t used = (size_t)snprintf(text, sizeof text, "%s", g->header), gaps = 0;
        for (int i = 0; i < g->count; i++)
            used += (size_t)snprintf(text + used, sizeof text - used, "%.6f,%.4f,0,0,1,0,0,0%s\n", g->ms[i] * 1e-3,
                                     g->mm[i], *g->header ? ",0,0" : "");
        ost_error err = {0};
        ost_path path;
        ost_path_report report;
        assert_ok(ost_path_read(scratch_write(folder, "g.csv", text, used), &g->options, &path, &report, &err));
        for (int i = 0; i < g->count; i++) {
            gaps += g->lifted[i];
            if (path.ticks[i].lifted != g->lifted[i])
                fail_msg("case %zu: lifted of row %d is %d, expected %d", c, i, path.ticks[i].lifted, g->lifted[i]);
        }
        assert_int_equal(report.gaps, gaps);
        ost_path_free(&path);
    }
    /* The reader does not search for gaps between rows of different tools. */
    ost_error err = {0};
    ost_path path;
    assert_ok(read_text("0 0 0 0 1 0 0 0 0\n0.001 0 0 0 1 0 0 0 0\n0.002 99 0 0 1 0 0 0 1\n", &path, &err));
    assert_false(path.ticks[2].lifted);
    ost_path_free(&path);
}

static void broken_paths_are_refused(void **state)
{
    (void)state;
    static const struct {
        const char *text, *message;
        ost_status status;
    } cases[] = {
        {"", ": file is empty; expected t_s,x_mm", OST_ERR_INPUT},
        {"t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz\n", ": no rows of values; expected t_s", OST_ERR_INPUT},
        {"0,0,0,0,1,0,0\n", ":1: 7 columns; expected t_s,x_mm", OST_ERR_INPUT},
        {"0,0,0,0,1,0,0,0,0,0\n", ":1: 10 columns; expected t_s,x_mm", OST_ERR_INPUT},
        {"0,0,0,0,1,0,0,0\n1,0,0,0,1,0,0,0,1\n", ":2: 9 values; expected 8, as in the rows above",
         OST_ERR_INPUT},
        {"0,0,0,0,1,0,0,0\n1,0,0,0,1,0,0\n", ":2: 7 values; expected 8, as in the rows above", OST_ERR_INPUT},
        {"0,0,,0,1,0,0,0\n", ":1: 2 columns", OST_ERR_INPUT},
        {"0,0,0,0,1,0,0,0\n1,0,0,0,,0,0,0\n", ":2: column 5 is empty; expected 8 values", OST_ERR_INPUT},
        {"t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz\n0,0,0,,1,0,0,0\n", ":2: column 4 is empty; expected 8 values",
         OST_ERR_INPUT},
        {"t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz\n0,-150,-19\n", ":2: 3 values; the header requires 8", OST_ERR_INPUT},
        {"t_s,x_mm,y_m,z_mm,qw,qx,qy,qz\n0,0,0,0,1,0,0,0\n",
         ":1: column 3 is 'y_m', but column 2 is 'x_mm'; expected the same unit", OST_ERR_INPUT},
        {"t_s,x_mm,y_mm,z_mm,qw,banana,qy,qz\n0,0,0,0,1,0,0,0\n", ":1: column 6 is named 'banana'; expected t_s,x_mm",
         OST_ERR_INPUT},
        {"t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,lifted\n0,0,0,0,1,0,0,0,maybe\n",
         ":2: column 9 (lifted) is 'maybe'; expected 0 or 1", OST_ERR_INPUT},
        {"t_s,x_mm,y_mm,z_mm,qx,qy,qz,qw\n0,0,0,0,0,0,0,1\n",
         ":1: column 5 is named 'qx'; expected t_s,x_mm,y_mm,z_mm,qw", OST_ERR_INPUT},
        {"t_s,x_m,y_mm,z_mm,qw,qx,qy,qz\n0,0,0,0,1,0,0,0\n", ":1: column 3 is 'y_mm', but column 2 is 'x_m'; expected",
         OST_ERR_INPUT},
        {"T_S,X_MM,Y_MM,Z_MM,QW,QX,QY,QZ\n0,0,0,0,1,0,0,0\n", ":1: column 1 is named 'T_S'; expected t_s",
         OST_ERR_INPUT},
        {"t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,tool,more,tool\n0,0,0,0,1,0,0,0,1,2,3\n", ":1: column 11 is a second 'tool'",
         OST_ERR_INPUT},
        {"t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,more,tool\n0,0,0,0,1,0,0,0,1\n",
         ":2: 9 values; the header requires 10", OST_ERR_INPUT},
        {"t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,lifted\n0,0,0,0,1,0,0,0,2\n", ":2: column 9 (lifted) is '2'; expected 0 or 1",
         OST_ERR_INPUT},
        {"t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,lifted\n0,0,0,0,1,0,0,0,0.5\n",
         ":2: column 9 (lifted) is '0.5'; expected 0 or 1", OST_ERR_INPUT},
        {"t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,rpm\n0,0,0,0,1,0,0,0,3001\n",
         ":2: column 9 (rpm) is '3001'; expected revolutions per minute from 0 to 3000, -1", OST_ERR_INPUT},
        {"t_s,x_m,y_m,z_m,qw,qx,qy,qz\n0,8.0001,0,0,1,0,0,0\n", ":2: position x", OST_ERR_RANGE},
        {"nan,0,0,0,1,0,0,0\n", ":1: column 1 (t_s) is 'nan'; expected a decimal number", OST_ERR_INPUT},
        {"0,nan,0,0,1,0,0,0\n1,0,0,0,nan,0,0,0\n",
         ": no row has a pose; rows with nan in a column of the pose: 2", OST_ERR_INPUT},
        {"1,nan,0,0,1,0,0,0\n1,0,0,0,1,0,0,0\n", ":2: t_s is 1.000000000, not after the row above", OST_ERR_INPUT},
        {"0,-nan,0,0,1,0,0,0\n", ":1: column 2 (x_mm) is '-nan'; expected a decimal number or nan", OST_ERR_INPUT},
        {"4000000000.000000001,0,0,0,1,0,0,0\n", ":1: column 1 (t_s) is '4000000000.000000001'; expected a time",
         OST_ERR_INPUT},
        {"9223372036.854775807,0,0,0,1,0,0,0\n", ":1: column 1 (t_s) is '9223372036.854775807'; expected a time",
         OST_ERR_INPUT},
        {"-9223372036.854775808,0,0,0,1,0,0,0\n", ":1: column 1 (t_s) is '-9223372036.854775808'; expected a time",
         OST_ERR_INPUT},
        {"t_s,x_mm,y_mm,z_mm,qw,qx,qy\n", ":1: missing columns in the header", OST_ERR_INPUT},
        {"0,0,0,0,1,0,0,0\n1,0,0,0,inf,0,0,0\n", ":2: column 5 (qw) is 'inf'", OST_ERR_INPUT},
        {"0,0,0,0,1,0,0,0\n1,0,0,0,1,0,0,1e\n", ":2: column 8 (qz) is '1e'", OST_ERR_INPUT},
        {"1e10,0,0,0,1,0,0,0\n", ":1: column 1 (t_s) is '1e10'; expected a time", OST_ERR_INPUT},
        {"0,0,0,0,1,0,0,0,1.5\n", ":1: column 9 (tool) is '1.5'; expected a tool's number", OST_ERR_INPUT},
        {"0,0,0,0,1,0,0,0,-1\n", ":1: column 9 (tool) is '-1'; expected a tool's number", OST_ERR_INPUT},
        {"0,0,0,0,1,0,0,0\n0,0,0,0,1,0,0,0\n", ":2: t_s is 0.000000000, not after the row above", OST_ERR_INPUT},
        {"5,0,0,0,1,0,0,0\n4.9999999999,0,0,0,1,0,0,0\n", ":2: t_s is 5.000000000, not after the row above",
         OST_ERR_INPUT},
        {"0,8000.1,0,0,1,0,0,0\n", ":1: position x", OST_ERR_RANGE},
        {"0,0,0,0,1,0.1,0,0\n", ":1: quaternion", OST_ERR_RANGE},
        {"0,0,0,0,0,0,0,0\n", ":1: quaternion", OST_ERR_RANGE},
        {"0,0,0,0,1e9,0,0,0\n", ":1: quaternion component qw", OST_ERR_RANGE},
        {"0 0 0 1200\n", ":1: 4 columns; expected t_s,x_mm", OST_ERR_INPUT},
        {"\x01\x02\x03\n", ":1: binary data", OST_ERR_INPUT},
        {"\xff\xfe"
         "0\n",
         ":1: the text is UTF-16", OST_ERR_INPUT},
        {"0,0,0,0,1,0,0,0\r1,0,0,0,1,0,0,0\r", ":1: line ends are CR alone; LF or CR LF expected", OST_ERR_INPUT},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        ost_error err = {0};
        ost_path path;
        ost_status status = read_text(cases[i].text, &path, &err);
        const char *found = strstr(err.text, "p.csv");
        if (status != cases[i].status || !found || strncmp(found + 5, cases[i].message, strlen(cases[i].message)) != 0)
            fail_msg("case %zu: %s '%s', expected '...p.csv%s'", i, ost_status_name(status), err.text,
                     cases[i].message);
        assert_null(path.ticks);
    }
}

/*
 * Truncates the row at every position before the last column. A row truncated inside the last
 * column still has a valid number there.
 */
static void refuses_truncated_rows(void **state)
{
    (void)state;
    static const char rows[] = "0,0,0,0,1,0,0,0\n0.5,10.25,-3.125,7,0.70710678,0.70710678,0,0";
    const size_t first = 16, last = sizeof rows - 2;
    for (size_t cut = first + 1; cut <= last; cut++) {
        ost_error err = {0};
        ost_path path;
        assert_int_not_equal(ost_path_read_csv(scratch_write(folder, "cut.csv", rows, cut), &path, &err), OST_OK);
        assert_non_null(strstr(err.text, "cut.csv:2: "));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rows_are_exact),
        cmocka_unit_test(written_path_is_restored),
        cmocka_unit_test(reads_tool_numbers_and_extreme_times),
        cmocka_unit_test(reads_tracker_files),
        cmocka_unit_test(gaps_between_rows_are_detected),
        cmocka_unit_test(broken_paths_are_refused),
        cmocka_unit_test(refuses_truncated_rows),
    };
    return cmocka_run_group_tests(tests, scratch_set_up, scratch_tear_down);
}
