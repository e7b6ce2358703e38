/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Paths as CSV: exact integers, the way back, each kind of broken file.
 *
 * Covers: AR-POSE-2
 */
#include "harness.h"

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
    assert_true(path.ticks[0].pose.t.x == 1500000000 && path.ticks[0].pose.t.y == -57340000000 && path.ticks[0].pose.t.z == 1);
    assert_int_equal(path.ticks[0].pose.qw, OST_Q30_ONE);
    assert_int_equal(path.ticks[1].pose.qx, -OST_Q30_ONE / 2);
    assert_int_equal(path.ticks[1].tool, 3);
    /* 70710678 * 2^30 / 10^8 = 759250123.72..., by Python's fractions */
    assert_int_equal(path.ticks[2].pose.qw, 759250124);
    ost_path_free(&path);
}

static void what_is_written_reads_back(void **state)
{
    (void)state;
    test_rng rng = rng_seeded("what_is_written_reads_back");
    char name[600];
    snprintf(name, sizeof name, "%s/back.csv", folder);
    for (int round = 0; round < 2; round++) {
        ost_error err = {0};
        ost_path path, back;
        assert_ok(ost_path_init(&path, 5000, &err));
        int64_t t = rng_range(&rng, -1000000000, 1000000000);
        for (size_t i = 0; i < path.count; i++) {
            /* A unit quaternion of random direction, to the last bit of its integers. */
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
                .pose = {{rng_range(&rng, -OST_LENGTH_MAX, OST_LENGTH_MAX), rng_range(&rng, -1000, 1000), rng_range(&rng, -1000000000, 1000000000)},
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
            assert_true(a->t_ns == b->t_ns && a->tool == b->tool);
            assert_true(a->pose.t.x == b->pose.t.x && a->pose.t.y == b->pose.t.y && a->pose.t.z == b->pose.t.z);
            assert_true(a->pose.qw == b->pose.qw && a->pose.qx == b->pose.qx && a->pose.qy == b->pose.qy && a->pose.qz == b->pose.qz);
        }
        char *text = scratch_read(name, NULL);
        assert_int_equal(strncmp(text, round ? "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,tool\n" : "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz\n", 31 + (round ? 5 : 0)), 0);
        free(text);
        ost_path_free(&path);
        ost_path_free(&back);
    }
}

static void broken_paths_are_refused(void **state)
{
    (void)state;
    static const struct {
        const char *text, *says;
        ost_status status;
    } cases[] = {
        {"", ": holds no row in 0 lines", OST_ERR_INPUT},
        {"t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz\n", ": holds no row in 1 lines", OST_ERR_INPUT},
        {"0,0,0,0,1,0,0\n", ":1: 7 columns; expected t_s,x_mm", OST_ERR_INPUT},
        {"0,0,0,0,1,0,0,0,0,0\n", ":1: 10 columns; expected t_s,x_mm", OST_ERR_INPUT},
        {"0,0,0,0,1,0,0,0\n1,0,0,0,1,0,0,0,1\n", ":2: 9 columns, or an empty one; the rows above have 8", OST_ERR_INPUT},
        {"0,0,0,0,1,0,0,0\n1,0,0,0,1,0,0\n", ":2: 7 columns, or an empty one; the rows above have 8", OST_ERR_INPUT},
        {"0,0,,0,1,0,0,0\n", ":1: 2 columns", OST_ERR_INPUT},
        {"t_s,x_mm,y_mm,z_mm,qx,qy,qz,qw\n0,0,0,0,0,0,0,1\n", ":1: column 5 is called 'qx'; expected t_s,x_mm,y_mm,z_mm,qw", OST_ERR_INPUT},
        {"t_s,x_mm,y_mm,z_mm,qw,qx,qy\n", ":1: the header has not the columns", OST_ERR_INPUT},
        {"t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,tool,more\n", ":1: the header has not the columns", OST_ERR_INPUT},
        {"t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz\n0,0,0,0,1,0,0,0,0\n", ":2: 9 columns, or an empty one; the rows above have 8", OST_ERR_INPUT},
        {"0,nan,0,0,1,0,0,0\n", ":1: column 2 (x_mm) is 'nan'; expected a decimal number", OST_ERR_INPUT},
        {"0,0,0,0,1,0,0,0\n1,0,0,0,inf,0,0,0\n", ":2: column 5 (qw) is 'inf'", OST_ERR_INPUT},
        {"0,0,0,0,1,0,0,0\n1,0,0,0,1,0,0,1e\n", ":2: column 8 (qz) is '1e'", OST_ERR_INPUT},
        {"1e10,0,0,0,1,0,0,0\n", ":1: column 1 (t_s) is '1e10'; expected a time", OST_ERR_INPUT},
        {"0,0,0,0,1,0,0,0,1.5\n", ":1: column 9 (tool) is '1.5'; expected a tool's number", OST_ERR_INPUT},
        {"0,0,0,0,1,0,0,0,-1\n", ":1: column 9 (tool) is '-1'; expected a tool's number", OST_ERR_INPUT},
        {"0,0,0,0,1,0,0,0\n0,0,0,0,1,0,0,0\n", ":2: t_s is 0.000000000, not after the row above", OST_ERR_INPUT},
        {"5,0,0,0,1,0,0,0\n4.9999999999,0,0,0,1,0,0,0\n", ":2: t_s is 5.000000000, not after the row above", OST_ERR_INPUT},
        {"0,8000.1,0,0,1,0,0,0\n", ":1: position x", OST_ERR_RANGE},
        {"0,0,0,0,1,0.1,0,0\n", ":1: quaternion", OST_ERR_RANGE},
        {"0,0,0,0,0,0,0,0\n", ":1: quaternion", OST_ERR_RANGE},
        {"0,0,0,0,1e9,0,0,0\n", ":1: quaternion component 0", OST_ERR_RANGE},
        {"0 0 0 1200\n", ":1: 4 columns; expected t_s,x_mm", OST_ERR_INPUT},
        {"\x01\x02\x03\n", ":1: binary bytes", OST_ERR_INPUT},
        {"\xff\xfe" "0\n", ":1: the text is UTF-16", OST_ERR_INPUT},
        {"0,0,0,0,1,0,0,0\r1,0,0,0,1,0,0,0\r", ":1: line ends are CR alone; LF or CR LF expected", OST_ERR_INPUT},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        ost_error err = {0};
        ost_path path;
        ost_status status = read_text(cases[i].text, &path, &err);
        const char *said = strstr(err.text, "p.csv");
        if (status != cases[i].status || !said || strncmp(said + 5, cases[i].says, strlen(cases[i].says)) != 0)
            fail_msg("case %zu: %s '%s', expected '...p.csv%s'", i, ost_status_name(status), err.text, cases[i].says);
        assert_null(path.ticks);
    }
}

/* Up to the last column; a cut inside that one leaves a number that nothing contradicts. */
static void a_row_cut_anywhere(void **state)
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
        cmocka_unit_test(what_is_written_reads_back),
        cmocka_unit_test(broken_paths_are_refused),
        cmocka_unit_test(a_row_cut_anywhere),
    };
    return cmocka_run_group_tests(tests, scratch_set_up, scratch_tear_down);
}
