/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests files of tool grids. A written tool must be read back unchanged, even if its corner needs many decimals. Files
 * of other programs must be read if they are valid, and refused otherwise.
 *
 * Covers: AR-FILE-3
 */
#include "written_volumes.h"

/* Compares the fields one by one, because the struct has padding. */
static void assert_tool_geometry(const ost_tool_geometry *a, const ost_tool_geometry *b)
{
    assert_memory_equal(&a->dims, &b->dims, sizeof a->dims);
    assert_int_equal(a->voxel, b->voxel);
    assert_memory_equal(&a->corner, &b->corner, sizeof a->corner);
}

static void written_tools_are_restored(void **state)
{
    (void)state;
    static const char *const voxels[] = {"0.5", "0.75", "1", "0.000000001", "0.333333333"};
    ost_error err = {0};
    for (size_t i = 0; i < sizeof voxels / sizeof voxels[0]; i++) {
        ost_tool_volume tool, back;
        const ost_tool_geometry g = {
            .dims = {3, 4, 2}, .voxel = pm(voxels[i]), .corner = {pm("-18.5"), pm("0.123456789"), 0}};
        if (g.voxel < OST_TOOL_VOXEL_MIN)
            continue;
        assert_ok(ost_tool_volume_init(&tool, &g, &err));
        for (int n = 0; n < 24; n++)
            tool.voxels[n] = (uint8_t)(n % 3);
        assert_ok(ost_tool_volume_write(at("t.nrrd"), &tool, &err));
        assert_ok(ost_tool_volume_read(at("t.nrrd"), &back, &err));
        assert_tool_geometry(&back.geometry, &g);
        assert_memory_equal(back.voxels, tool.voxels, 24);
        assert_string_equal(ost_meta_get(&back.meta, OST_META_KIND), "tool");
        ost_tool_volume_free(&tool);
        ost_tool_volume_free(&back);
    }
}

/*
 * The tool's voxels have a size of 1 um + 1 pm. The origin, which is half a voxel from the corner,
 * therefore needs ten decimal places. The expected text is computed by hand.
 */
static void tool_with_long_decimals(void **state)
{
    (void)state;
    ost_error err = {0};
    uint8_t voxel = 1;
    size_t size;
    const ost_tool_volume tool = {
        .geometry = {.dims = {1, 1, 1}, .voxel = 1000001, .corner = {-1000000, 0, 2000000000}}, .voxels = &voxel};
    assert_ok(ost_tool_volume_write(at("odd.nrrd"), &tool, &err));
    char *file = read_all(at("odd.nrrd"), &size);
    assert_non_null(strstr(file, "space origin: (-0.0004999995,0.0005000005,2.0005000005)\n"));
    assert_non_null(strstr(file, "osteon_tool_corner_mm:=-0.001 0 2\n"));
    assert_non_null(strstr(file, "encoding: gzip\n"));
    free(file);
    ost_tool_volume back;
    assert_ok(ost_tool_volume_read(at("odd.nrrd"), &back, &err));
    assert_tool_geometry(&back.geometry, &tool.geometry);
    ost_tool_volume_free(&back);
}

static void write_tool(const char *fields, const char *values)
{
    static bytes file;
    file.size = 0;
    put_text(&file, "NRRD0005\ndimension: 3\nsizes: 2 1 1\nencoding: text\n");
    put_text(&file, fields);
    put_text(&file, "\n");
    put_text(&file, values);
    write_file("t.nrrd", file.data, file.size);
}

static void tools_of_other_programs(void **state)
{
    (void)state;
    ost_error err = {0};
    ost_tool_volume tool;
    write_tool("type: uint8\nspacings: 0.5 0.5 0.5\nspace: LPS\nspace origin: (1,2,3)\n", "1 2");
    assert_ok(ost_tool_volume_read(at("t.nrrd"), &tool, &err));
    assert_int_equal(tool.geometry.corner.x, pm("0.75"));
    assert_int_equal(tool.geometry.corner.z, pm("2.75"));
    assert_int_equal(tool.voxels[1], OST_TOOL_NONCUTTING);
    ost_tool_volume_free(&tool);
    /*
     * A corner that differs by 1 pm (1e-9 mm) from origin - voxel / 2 is accepted; a difference
     * of 2 pm is refused below.
     */
    write_tool("type: uint8\nspacings: 1 1 1\nosteon_tool_corner_mm:=-0.500000001 -0.499999999 -0.5\n", "1 2");
    assert_ok(ost_tool_volume_read(at("t.nrrd"), &tool, &err));
    assert_int_equal(tool.geometry.corner.x, -500000001);
    assert_int_equal(tool.geometry.corner.y, -499999999);
    ost_tool_volume_free(&tool);
    static const struct {
        const char *fields, *values, *words;
    } bad[] = {
        {"type: uint8\nspacings: 1 1 1\nosteon_tool_corner_mm:=-0.500000002 -0.5 -0.5\n", "1 1", "half a voxel before"},
        {"type: uint8\nspacings: 1 1 1\nosteon_tool_corner_mm:=-0.5 -0.5 -0.499999998\n", "1 1", "half a voxel before"},
        {"type: uint8\nspacings: 1 1 1\n", "1 3", "voxel (1, 0, 0) is 3"},
        {"type: int16\nspacings: 1 1 1\n", "1 1", "uint8"},
        {"type: uint8\nspacings: 1 1 0.5\n", "1 1", "cubic"},
        {"type: uint8\nspacings: 1 1 1\nosteon_tool_corner_mm:=0 0 0\n", "1 1", "half a voxel before"},
        {"type: uint8\nspacings: 1 1 1\nosteon_tool_corner_mm:=-0.5 -0.5\n", "1 1", "three lengths"},
        {"type: uint8\nspacings: 1 1 1\nosteon_tool_corner_mm:=-0.5 -0.5 -0.5 1\n", "1 1", "three lengths"},
        {"type: uint8\nspacings: 1 1 1\n", "1", "at least 3"},
    };
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        write_tool(bad[i].fields, bad[i].values);
        assert_int_equal(ost_tool_volume_read(at("t.nrrd"), &tool, &err), OST_ERR_INPUT);
        if (!strstr(err.text, bad[i].words))
            fail_msg("the error '%s' does not contain '%s'", err.text, bad[i].words);
        assert_null(tool.voxels);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(written_tools_are_restored),
        cmocka_unit_test(tool_with_long_decimals),
        cmocka_unit_test(tools_of_other_programs),
    };
    return cmocka_run_group_tests(tests, make_scratch, drop_scratch);
}
