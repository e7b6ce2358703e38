/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests that reports are summed correctly, that density classes are parsed, and that invalid density
 * classes are refused.
 * Covers: AR-REM-6, AR-CLS-1, AR-CLS-2
 */
#include "harness.h"

#include <osteon/event.h>

static void totals_are_sums(void **state)
{
    (void)state;
    ost_error err = {0};
    ost_removal_report report = {0};
    for (int i = 0; i < 200; i++) {
        ost_chunk_report chunk = {.chunk = i, .voxels = {1, (uint32_t)i}, .density = {120, -i}};
        assert_ok(ost_removal_report_add(&report, &chunk, &err));
    }
    assert_int_equal(report.count, 200);
    assert_int_equal(report.voxels[0], 200);
    assert_int_equal(report.voxels[1], 199 * 100);
    assert_int_equal(report.density[1], -199 * 100);
    assert_int_equal(report.total_voxels, 200 + 199 * 100);
    for (int i = 0; i < 200; i++)
        assert_int_equal(report.chunks[i].chunk, i);
    size_t capacity = report.capacity;
    const ost_chunk_report *chunks = report.chunks;
    report.touched_voxels = 5;
    ost_removal_report_clear(&report);
    assert_ptr_equal(report.chunks, chunks);
    assert_int_equal(report.capacity, capacity);
    const ost_removal_report empty = {.chunks = report.chunks, .capacity = capacity};
    assert_int_equal(report.count, 0);
    assert_int_equal(report.total_voxels, 0);
    assert_int_equal(report.touched_voxels, 0);
    assert_memory_equal(report.voxels, empty.voxels, sizeof empty.voxels);
    assert_memory_equal(report.density, empty.density, sizeof empty.density);
    ost_removal_report_free(&report);
    assert_null(report.chunks);
    ost_removal_report_free(NULL);
}

/*
 * In chunk i, class c has (i + 1)(c + 1) voxels with a density sum of -3 (i + 1)(c + 1) c. The
 * sums over three chunks are 6 (c + 1) voxels and a density sum of -18 (c + 1) c; there are 6 * 36
 * voxels in total.
 */
static void every_class_has_its_own_sum(void **state)
{
    (void)state;
    ost_error err = {0};
    ost_removal_report report = {0};
    for (int i = 0; i < 3; i++) {
        ost_chunk_report chunk = {.chunk = i};
        for (int c = 0; c < OST_CLASS_MAX; c++) {
            chunk.voxels[c] = (uint32_t)((i + 1) * (c + 1));
            chunk.density[c] = -3 * (i + 1) * (c + 1) * c;
        }
        assert_ok(ost_removal_report_add(&report, &chunk, &err));
    }
    for (int c = 0; c < OST_CLASS_MAX; c++) {
        assert_int_equal(report.voxels[c], 6 * (c + 1));
        assert_int_equal(report.density[c], -18 * (c + 1) * c);
    }
    assert_int_equal(report.total_voxels, 6 * 36);
    assert_int_equal(report.count, 3);
    ost_removal_report_free(&report);
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
            fail_msg("'%s' was accepted as density classes", bad[i]);
    /* AR-CLS-1 */
    c = ost_density_classes_default();
    assert_int_equal(c.count, 3);
    assert_int_equal(c.border[0], 120);
    assert_int_equal(c.border[1], 150);
    assert_int_equal(c.border[2], 650);
    assert_string_equal(c.name[0], "cartilage");
    assert_string_equal(c.name[1], "cancellous");
    assert_string_equal(c.name[2], "cortical");
}

/* By AR-CLS-1 the density of an active voxel is at least 1, so a class below 1 would always be empty. */
static void class_border_below_one_is_refused(void **state)
{
    (void)state;
    ost_error err = {0};
    ost_density_classes c = {.count = 2, .border = {1, 2}};
    assert_ok(ost_density_classes_check(&c, &err));
    for (int16_t border = 0; border >= -1; border--) {
        c.border[0] = border;
        assert_int_equal(ost_density_classes_check(&c, &err), OST_ERR_USAGE);
        assert_non_null(strstr(err.text, "an active voxel has 1 or more"));
    }
    c.border[0] = 2;
    assert_int_equal(ost_density_classes_check(&c, &err), OST_ERR_USAGE);
    c.count = 0;
    assert_int_equal(ost_density_classes_check(&c, &err), OST_ERR_USAGE);
    c.count = OST_CLASS_MAX + 1;
    assert_int_equal(ost_density_classes_check(&c, &err), OST_ERR_USAGE);
}

/* A value at a documented limit is accepted. A value beyond a limit is refused and changes nothing. */
static void documented_class_limits_apply(void **state)
{
    (void)state;
    ost_error err = {0};
    ost_density_classes c;
    assert_ok(ost_density_classes_parse("a:1,b:2,c:3,d:4,e:5,f:6,g:7,h:32767", &c, &err));
    assert_int_equal(c.count, OST_CLASS_MAX);
    assert_int_equal(c.border[0], 1);
    assert_int_equal(c.border[7], 32767);
    assert_string_equal(c.name[7], "h");
    assert_int_equal(ost_density_classes_parse("a:32768", &c, NULL), OST_ERR_USAGE);
    assert_int_equal(ost_density_classes_parse("a:-1", &c, NULL), OST_ERR_USAGE);
    assert_int_equal(ost_density_classes_parse("a:5,b:4", &c, NULL), OST_ERR_USAGE);
    assert_int_equal(ost_density_classes_parse("a:5,b:5", &c, NULL), OST_ERR_USAGE);
    assert_int_equal(c.count, OST_CLASS_MAX);
    char name[OST_CLASS_NAME + 8];
    memset(name, 'n', sizeof name);
    memcpy(name + OST_CLASS_NAME - 1, ":5", 3); /* the longest possible name */
    assert_ok(ost_density_classes_parse(name, &c, &err));
    assert_int_equal(strlen(c.name[0]), OST_CLASS_NAME - 1);
    memset(name, 'n', sizeof name);
    memcpy(name + OST_CLASS_NAME, ":5", 3);
    assert_int_equal(ost_density_classes_parse(name, &c, NULL), OST_ERR_USAGE);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(totals_are_sums),
        cmocka_unit_test(every_class_has_its_own_sum),
        cmocka_unit_test(classes_are_parsed),
        cmocka_unit_test(class_border_below_one_is_refused),
        cmocka_unit_test(documented_class_limits_apply),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
