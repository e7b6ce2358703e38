/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests that the limits of a geometry are enforced and that the metadata of a volume accept only well-formed facts.
 * Covers: AR-GRID-1, AR-GRID-2, AR-GRID-3, AR-TOOL-1
 */
#include "harness.h"

#include <osteon/grid.h>
#include <osteon/path.h>
#include <osteon/tool.h>

static ost_geometry plain(void)
{
    return (ost_geometry){{4, 5, 6}, {470000000, 470000000, OST_PM_PER_MM}, {0, 0, 0}};
}

static void bounds_are_exact(void **state)
{
    (void)state;
    ost_geometry g = plain();
    assert_int_equal(ost_geometry_check(&g, "grid", NULL), OST_OK);
    g.dims.x = OST_DIM_MAX;
    assert_int_equal(ost_geometry_check(&g, "grid", NULL), OST_OK);
    g.dims.x = OST_DIM_MAX + 1;
    assert_int_equal(ost_geometry_check(&g, "grid", NULL), OST_ERR_RANGE);
    g.dims.x = 0;
    assert_int_equal(ost_geometry_check(&g, "grid", NULL), OST_ERR_RANGE);
    g = plain();
    g.spacing.y = OST_SPACING_MIN;
    assert_int_equal(ost_geometry_check(&g, "grid", NULL), OST_OK);
    g.spacing.y--;
    assert_int_equal(ost_geometry_check(&g, "grid", NULL), OST_ERR_RANGE);
    g = plain();
    g.origin.z = OST_LENGTH_MAX - 5 * g.spacing.z;
    assert_int_equal(ost_geometry_check(&g, "grid", NULL), OST_OK);
    g.origin.z++;
    assert_int_equal(ost_geometry_check(&g, "grid", NULL), OST_ERR_RANGE);
    g = plain();
    g.dims = (ost_dims){8192, 8192, 1025};
    g.spacing = (ost_pm3){OST_SPACING_MIN, OST_SPACING_MIN, OST_SPACING_MIN};
    assert_int_equal(ost_geometry_check(&g, "grid", NULL), OST_ERR_RANGE);
}

static void error_contains_axis_and_value(void **state)
{
    (void)state;
    ost_error err = {0};
    ost_geometry g = plain();
    g.spacing.y = 0;
    ost_geometry_check(&g, "rect grid", &err);
    assert_string_equal(err.text, "rect grid: spacing of 0 mm along y; expected 0.001 to 100 mm");
}

static void new_volume_is_zero(void **state)
{
    (void)state;
    ost_error err = {0};
    ost_geometry g = plain();
    ost_volume v;
    assert_ok(ost_volume_init(&v, &g, &err));
    for (int64_t i = 0; i < ost_dims_count(g.dims); i++)
        assert_int_equal(v.voxels[i], 0);
    ost_volume_free(&v);
    ost_volume_free(&v);
}

static void facts_are_replaced_and_refused(void **state)
{
    (void)state;
    ost_error err = {0};
    ost_meta meta = {0};
    assert_ok(ost_meta_set(&meta, OST_META_SIDE, "left", &err));
    assert_ok(ost_meta_set(&meta, OST_META_SIDE, "right", &err));
    assert_int_equal(meta.count, 1);
    assert_string_equal(ost_meta_get(&meta, OST_META_SIDE), "right");
    assert_null(ost_meta_get(&meta, "kind"));
    assert_int_equal(ost_meta_set(&meta, "Kind", "x", NULL), OST_ERR_RANGE);
    assert_int_equal(ost_meta_set(&meta, "", "x", NULL), OST_ERR_RANGE);
    assert_int_equal(ost_meta_set(&meta, "kind", "a\nb", NULL), OST_ERR_RANGE);
    char longer[OST_META_VALUE + 1];
    memset(longer, 'v', sizeof longer);
    longer[OST_META_VALUE] = 0;
    assert_int_equal(ost_meta_set(&meta, "kind", longer, NULL), OST_ERR_RANGE);
    longer[OST_META_VALUE - 1] = 0;
    assert_int_equal(ost_meta_set(&meta, "kind", longer, NULL), OST_OK);
    for (int i = meta.count; i < OST_META_MAX; i++) {
        char key[16];
        snprintf(key, sizeof key, "k%d", i);
        assert_ok(ost_meta_set(&meta, key, "v", &err));
    }
    assert_int_equal(ost_meta_set(&meta, "onemore", "v", NULL), OST_ERR_RANGE);
}

static void tool_and_path_limits(void **state)
{
    (void)state;
    ost_error err = {0};
    ost_tool_geometry g = {{3, 4, 5}, OST_PM_PER_MM / 2, {0, 0, 0}};
    ost_tool_volume tool;
    assert_ok(ost_tool_volume_init(&tool, &g, &err));
    tool.voxels[7] = OST_TOOL_CUTTING;
    assert_int_equal(ost_tool_volume_count(&tool, OST_TOOL_CUTTING), 1);
    assert_int_equal(ost_tool_volume_count(&tool, OST_TOOL_VOID), 59);
    ost_tool_volume_free(&tool);
    g.dims.z = OST_TOOL_DIM_MAX + 1;
    assert_int_equal(ost_tool_geometry_check(&g, NULL), OST_ERR_RANGE);
    g.dims = (ost_dims){4096, 4096, 513};
    g.voxel = OST_TOOL_VOXEL_MIN;
    assert_int_equal(ost_tool_geometry_check(&g, NULL), OST_ERR_RANGE);
    ost_path path;
    assert_int_equal(ost_path_init(&path, (size_t)OST_PATH_TICKS_MAX + 1, NULL), OST_ERR_RANGE);
    ost_path_free(&path);
}

static void values_at_the_limits_are_accepted(void **state)
{
    (void)state;
    ost_geometry g = {.dims = {4096, 4096, 4096}, .spacing = {OST_SPACING_MIN, OST_SPACING_MIN, OST_SPACING_MIN}};
    assert_int_equal(ost_geometry_check(&g, "grid", NULL), OST_OK); /* 2^36 voxels */
    g.dims.z++;
    assert_int_equal(ost_geometry_check(&g, "grid", NULL), OST_ERR_RANGE);
    g = (ost_geometry){.dims = {2, 2, 2}, .spacing = {OST_SPACING_MAX, OST_SPACING_MAX, OST_SPACING_MAX}};
    assert_int_equal(ost_geometry_check(&g, "grid", NULL), OST_OK);
    g.spacing.y++;
    assert_int_equal(ost_geometry_check(&g, "grid", NULL), OST_ERR_RANGE);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bounds_are_exact),
        cmocka_unit_test(error_contains_axis_and_value),
        cmocka_unit_test(new_volume_is_zero),
        cmocka_unit_test(facts_are_replaced_and_refused),
        cmocka_unit_test(tool_and_path_limits),
        cmocka_unit_test(values_at_the_limits_are_accepted),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
