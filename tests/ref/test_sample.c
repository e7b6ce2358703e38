/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests reading single voxels, as the force computation does in each tick: between removals, after a chunk was emptied,
 * after an upload of slices, and after an event that changes many chunks. The expected densities are obtained by a
 * download.
 * Covers: REQ-SAMPLE
 */
#include "ref/scene.h"

enum { COUNT = 700 };

/* Samples voxels inside the grid and up to 3 voxels beyond its borders, and compares them with the bone's download. */
static void assert_samples(const ost_bone *bone, const ost_geometry *g, test_rng *rng)
{
    ost_error err = {0};
    int32_t x[COUNT], y[COUNT], z[COUNT];
    int16_t got[COUNT];
    const int32_t *const at[3] = {x, y, z};
    for (int i = 0; i < COUNT; i++) {
        x[i] = (int32_t)rng_range(rng, -3, g->dims.x + 2);
        y[i] = (int32_t)rng_range(rng, -3, g->dims.y + 2);
        z[i] = (int32_t)rng_range(rng, -3, g->dims.z + 2);
    }
    assert_ok(ost_bone_sample(bone, COUNT, at, got, &err));
    int16_t *expected = content(bone, g);
    for (int i = 0; i < COUNT; i++) {
        const bool inside = x[i] >= 0 && y[i] >= 0 && z[i] >= 0 && x[i] < g->dims.x && y[i] < g->dims.y &&
                            z[i] < g->dims.z;
        const int16_t density = inside ? expected[x[i] + g->dims.x * (y[i] + (int64_t)g->dims.y * z[i])] : 0;
        if (got[i] != density)
            fail_msg("voxel (%d, %d, %d): %d, expected %d", x[i], y[i], z[i], got[i], density);
    }
    free(expected);
}

/*
 * Removes a cube from a bone with voxels of 1 mm. The cube has a side of `size` mm, and its corner is at (x, y, z) mm.
 */
static uint64_t remove_cube(ost_backend *backend, ost_bone *bone, const ost_geometry *g, int32_t size, int32_t x,
                            int32_t y, int32_t z)
{
    ost_removal_report report = {0};
    ost_tool *tool = solid_tool(backend, (ost_tool_geometry){{size, size, size}, 1000 * UM, {0, 0, 0}},
                                OST_TOOL_CUTTING);
    ost_pose pose = ost_pose_identity();
    pose.t = (ost_pm3){1000 * UM * x, 1000 * UM * y, 1000 * UM * z};
    remove_at(bone, g, tool, &pose, 1, &report);
    const uint64_t removed = report.total_voxels;
    ost_removal_report_free(&report);
    ost_tool_free(tool);
    return removed;
}

static void samples_equal_the_download(void **state)
{
    skip_without_samples(*state);
    test_rng rng = rng_seeded("samples");
    ost_error err = {0};
    for (int chunk = 16; chunk <= 64; chunk *= 2) {
        const ost_geometry g = cubic_geometry(70, 37, 41, 1000 * UM, (ost_pm3){0, 0, 0});
        const size_t slice = (size_t)g.dims.x * (size_t)g.dims.y;
        int16_t *voxels = random_densities(&rng, &g, 3);
        ost_bone *bone = bone_of(*state, &g, chunk, voxels);
        ost_tool *tool = random_tool(*state, &rng, (ost_tool_geometry){{9, 8, 7}, 1000 * UM, {0, 0, 0}});
        uint64_t removed = 0;
        for (int round = 0; round < 12; round++) {
            /* Before the samples are taken, up to three events occur. */
            for (int64_t events = rng_range(&rng, 0, 3); events > 0; events--) {
                ost_removal_report report = {0};
                const ost_pose pose = random_pose(&rng, (ost_pm3){0, 0, 0},
                                                  (ost_pm3){70000 * UM, 37000 * UM, 41000 * UM});
                remove_at(bone, &g, tool, &pose, 1, &report);
                removed += report.total_voxels;
                ost_removal_report_free(&report);
            }
            assert_samples(bone, &g, &rng);
        }
        assert_true(removed > 0);
        /* The first chunk is emptied; an upload fills its first slices again, and removals continue. */
        assert_true(remove_cube(*state, bone, &g, chunk, 0, 0, 0) > 0);
        assert_samples(bone, &g, &rng);
        assert_ok(ost_bone_upload(bone, 0, 9, voxels + slice, &err));
        assert_samples(bone, &g, &rng);
        assert_true(remove_cube(*state, bone, &g, 8, 3, 4, 2) > 0);
        assert_samples(bone, &g, &rng);
        ost_tool_free(tool);
        ost_bone_free(bone);
        free(voxels);
    }
}

/* One event changes 27 chunks of 64^3 voxels. Their occupancy takes 864 KiB. */
static void samples_after_a_large_event(void **state)
{
    skip_without_samples(*state);
    test_rng rng = rng_seeded("many chunks");
    const ost_geometry g = cubic_geometry(140, 135, 130, 1000 * UM, (ost_pm3){0, 0, 0});
    int16_t *voxels = random_densities(&rng, &g, 1);
    ost_bone *bone = bone_of(*state, &g, 64, voxels);
    assert_samples(bone, &g, &rng);
    assert_true(remove_cube(*state, bone, &g, 70, 60, 60, 60) > 0);
    assert_samples(bone, &g, &rng);
    ost_bone_free(bone);
    free(voxels);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(samples_equal_the_download),
        cmocka_unit_test(samples_after_a_large_event),
    };
    return run_on_backends(tests, open_test_backend, close_test_backend);
}
