/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests the results of ost_difference_find (counts, box and class) and the arguments that it refuses. The test makes
 * mistakes of a known kind in a grid in which every voxel has a different density. tests/validation/test_locate.c tests
 * all patterns.
 *
 * Covers: REQ-DIFFERENCE
 */
#include "harness.h"

#include <osteon/difference.h>

enum { SIDE = 40 };

static ost_volume grid(int32_t x, int32_t y, int32_t z)
{
    const ost_pm mm = OST_PM_PER_MM;
    ost_volume v = {.voxels = NULL};
    assert_int_equal(OST_OK, ost_volume_init(&v, &(ost_geometry){{x, y, z}, {mm, mm, mm}, {0, 0, 0}}, NULL));
    for (int64_t i = 0; i < ost_dims_count(v.geometry.dims); i++)
        v.voxels[i] = (int16_t)(200 + i % 30011);
    return v;
}

static int16_t *at(ost_volume *v, int32_t x, int32_t y, int32_t z)
{
    return &v->voxels[x + v->geometry.dims.x * (y + v->geometry.dims.y * z)];
}

static void equal_grids(void **state)
{
    (void)state;
    ost_volume a = grid(SIDE, SIDE, SIDE);
    ost_difference d;
    assert_int_equal(OST_OK, ost_difference_find(&a, &a, NULL, &d, NULL));
    assert_int_equal(0, d.voxels);
    assert_null(d.class_name);
    assert_int_equal(0, d.pattern_count);
    ost_volume_free(&a);
}

static void counts_and_class(void **state)
{
    (void)state;
    ost_volume a = grid(SIDE, SIDE, SIDE), b = grid(SIDE, SIDE, SIDE);
    ost_difference d;
    for (int32_t z = 5; z < 8; z++)
        for (int32_t x = 10; x < 30; x++)
            *at(&b, x, 20, z) += 7;
    assert_int_equal(OST_OK, ost_difference_find(&a, &b, NULL, &d, NULL));
    assert_int_equal(3 * 20, d.voxels);
    const ost_voxel_box expected = {{10, 20, 5}, {30, 21, 8}};
    assert_memory_equal(&expected, &d.box, sizeof expected);
    assert_string_equal("offset", d.class_name);
    assert_string_equal("offset", d.patterns[0].name);
    assert_string_equal("every voxel that differs is 7 more", d.patterns[0].text);
    ost_volume_free(&a);
    ost_volume_free(&b);
}

/*
 * Passes the bone before an event and two bones after it. If the event removed nothing in one chunk of one of the two
 * bones, the class is stale-chunk. If the reports also differ, the class is lost-chunk.
 */
static void bone_before_event_is_used(void **state)
{
    (void)state;
    ost_volume before = grid(SIDE, SIDE, SIDE), a = grid(SIDE, SIDE, SIDE), b = grid(SIDE, SIDE, SIDE);
    ost_difference d;
    for (int32_t z = 0; z < SIDE; z++)
        for (int32_t x = 0; x < SIDE; x++) {
            *at(&a, x, 12, z) = 0; /* the event removes a layer of a; in b, the first chunk of the layer remains */
            if (x >= 32 || z >= 32)
                *at(&b, x, 12, z) = 0;
        }
    ost_difference_options with = {.before = &before};
    assert_int_equal(OST_OK, ost_difference_find(&a, &b, &with, &d, NULL));
    assert_string_equal("stale-chunk", d.class_name);
    with.report_differs = true;
    assert_int_equal(OST_OK, ost_difference_find(&a, &b, &with, &d, NULL));
    assert_string_equal("lost-chunk", d.class_name);
    assert_int_equal(32 * 32, d.voxels);
    assert_int_equal(OST_OK, ost_difference_find(&a, &b, NULL, &d, NULL));
    assert_string_not_equal("stale-chunk", d.class_name);
    ost_volume_free(&before);
    ost_volume_free(&a);
    ost_volume_free(&b);
}

static void other_dims(void **state)
{
    (void)state;
    ost_volume a = grid(6, 5, 4), b = grid(4, 5, 6), c = grid(4, 5, 7);
    ost_difference d;
    for (int32_t z = 0; z < 4; z++)
        for (int32_t y = 0; y < 5; y++)
            for (int32_t x = 0; x < 6; x++)
                *at(&b, z, y, x) = *at(&a, x, y, z);
    assert_int_equal(OST_OK, ost_difference_find(&a, &b, NULL, &d, NULL));
    assert_int_equal(0, d.voxels);
    assert_string_equal("axis-swap", d.class_name);
    assert_int_equal(OST_OK, ost_difference_find(&a, &c, NULL, &d, NULL));
    assert_string_equal("unclassified", d.class_name);
    ost_volume_free(&a);
    ost_volume_free(&b);
    ost_volume_free(&c);
}

static void assert_refused(const ost_volume *a, const ost_volume *b, ost_difference_options o, ost_status status,
                           const char *text)
{
    ost_error err = {0};
    ost_difference d;
    assert_int_equal(status, ost_difference_find(a, b, &o, &d, &err));
    assert_non_null(strstr(err.text, text));
}

static void wrong_arguments(void **state)
{
    (void)state;
    ost_volume a = grid(6, 5, 4), b = grid(4, 5, 6), none = {.voxels = NULL};
    assert_refused(&a, &none, (ost_difference_options){0}, OST_ERR_USAGE, "volume b has no voxels");
    assert_refused(&none, &a, (ost_difference_options){0}, OST_ERR_USAGE, "volume a has no voxels");
    assert_refused(&a, &a, (ost_difference_options){.before = &b}, OST_ERR_USAGE, "expected 6 x 5 x 4");
    assert_refused(&a, &a, (ost_difference_options){.before = &none}, OST_ERR_USAGE, "'before'");
    assert_refused(&a, &a, (ost_difference_options){.chunk_size = 8}, OST_ERR_USAGE, "chunk size 8");
    assert_refused(&a, &a, (ost_difference_options){.threshold_a = -1}, OST_ERR_RANGE, "threshold_a -1");
    assert_refused(&a, &a, (ost_difference_options){.threshold_b = 32768}, OST_ERR_RANGE, "threshold_b 32768");
    ost_volume_free(&a);
    ost_volume_free(&b);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(equal_grids),
        cmocka_unit_test(counts_and_class),
        cmocka_unit_test(bone_before_event_is_used),
        cmocka_unit_test(other_dims),
        cmocka_unit_test(wrong_arguments),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
