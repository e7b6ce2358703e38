/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Reports add up; density classes are read and refused.
 * Covers: AR-REM-6, AR-CLS-1, AR-CLS-2
 */
#include "harness.h"

#include <osteon/event.h>

static void totals_are_sums(void **state)
{
    (void)state;
    ost_error err = {0};
    ost_report report = {0};
    for (int i = 0; i < 200; i++) {
        ost_chunk_report chunk = {.chunk = i, .voxels = {1, (uint32_t)i}, .density = {120, -i}};
        assert_ok(ost_report_add(&report, &chunk, &err));
    }
    assert_int_equal(report.count, 200);
    assert_int_equal(report.voxels[0], 200);
    assert_int_equal(report.voxels[1], 199 * 100);
    assert_int_equal(report.density[1], -199 * 100);
    assert_int_equal(report.total_voxels, 200 + 199 * 100);
    assert_int_equal(report.chunks[199].chunk, 199);
    size_t capacity = report.capacity;
    ost_report_clear(&report);
    assert_int_equal(report.total_voxels, 0);
    assert_int_equal(report.capacity, capacity);
    ost_report_free(&report);
}

static void classes_are_parsed(void **state)
{
    (void)state;
    ost_error err = {0};
    ost_density_classes c;
    assert_ok(ost_density_classes_parse("soft:1,bone:250,hard:1000", &c, &err));
    assert_int_equal(c.count, 3);
    assert_string_equal(c.name[2], "hard");
    assert_int_equal(c.border[1], 250);
    static const char *const bad[] = {"", "x", "x:", ":5", "x:0", "x:1.5", "x:40000", "x:5,y:5", "x:5,", "X:5",
                                      "a:1,b:2,c:3,d:4,e:5,f:6,g:7,h:8,i:9", "averyveryverylongnameindeed:5"};
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++)
        if (ost_density_classes_parse(bad[i], &c, NULL) != OST_ERR_USAGE)
            fail_msg("'%s' was taken", bad[i]);
    c = ost_density_classes_default();
    assert_int_equal(c.border[0], 120);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(totals_are_sums),
        cmocka_unit_test(classes_are_parsed),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
