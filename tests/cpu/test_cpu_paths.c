/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests when the CPU backend uses several threads (src/cpu/share.h). With the option grain=1, even the
 * smallest grids must enter every path of the backend on the requested number of threads, and the results
 * must equal those of the reference. Without this option, small grids must enter only the path of the
 * upload. An event of 2^22 voxels must enter the path of the removal that is divided among threads.
 * Covers: REQ-CPU-PATHS
 */
#include "ref/scene.h"

#include <osteon/phantom.h>

#include "core/backend.h"
#include "cpu/share.h"

enum { PATHS = 16, SHARED = 10, SIDE = 72, SMALL = 40 };

typedef struct seen {
    char name[PATHS + 1][OST_PATH_NAME];
    uint64_t entered[PATHS + 1];
    int count;
} seen;

static void take(void *user, const char *name, uint64_t entered)
{
    seen *s = user;
    assert_true(s->count < PATHS + 1);
    snprintf(s->name[s->count], sizeof s->name[0], "%s", name);
    s->entered[s->count++] = entered;
}

static bool entered(const seen *s, const char *name)
{
    for (int i = 0; i < s->count; i++)
        if (strcmp(s->name[i], name) == 0)
            return s->entered[i] > 0;
    fail_msg("the backend has no path '%s'", name);
    return false;
}

/* Runs every stage once. Returns the bone's digest and stores the backend's path counts in out. */
static ost_digest run_all(const char *spec, int32_t side, int chunk_size, seen *out)
{
    ost_error err = {0};
    ost_backend *backend;
    ost_grid *rect, *cubic;
    ost_bone *bone, *copy;
    ost_mesh mesh = {0};
    ost_snapped_mesh snapped = {0};
    ost_tool *tool;
    ost_digest root, other;
    ost_scatter_report scattered = {0};
    assert_ok(ost_backend_open(spec, &backend, &err));
    const ost_pm s = OST_PM_PER_MM;
    const ost_geometry g = cubic_geometry(side, side, side, s, (ost_pm3){0, 0, 0});
    const size_t count = voxel_count(&g);
    ost_sample *samples = malloc(count * sizeof *samples);
    int16_t *voxels = malloc(count * sizeof *voxels);
    assert_true(samples && voxels);
    for (size_t i = 0; i < count; i++) {
        const int32_t x = (int32_t)(i % (size_t)side), y = (int32_t)(i / (size_t)side % (size_t)side),
                      z = (int32_t)(i / (size_t)side / (size_t)side);
        voxels[i] = (int16_t)(x % 16 == 1 && y % 16 == 1 ? 900 : 100); /* Every chunk has a few high densities. */
        samples[i] = (ost_sample){x * s, y * s, z * s, voxels[i], (uint32_t)i};
    }
    assert_ok(ost_grid_create(backend, &g, &rect, &err));
    assert_ok(ost_grid_upload(rect, 0, side, voxels, &err));
    assert_ok(ost_ct_to_rect(rect, samples, count, 1, OST_DUPLICATES_LAST, &scattered, &err));
    assert_ok(ost_rect_to_cubic(rect, s, OST_RESAMPLE_LINEAR, &cubic, &err));
    assert_ok(ost_grid_download(cubic, 0, side, voxels, &err));
    assert_ok(ost_cubic_to_chunks(cubic, chunk_size, 200, &bone, &err));
    assert_ok(ost_bone_create(backend, &g, chunk_size, 200, &copy, &err));
    assert_ok(ost_bone_upload(copy, 0, side, voxels, &err));
    assert_ok(ost_bone_digest(bone, NULL, &root, &err));
    assert_ok(ost_bone_digest(copy, NULL, &other, &err));
    assert_memory_equal(&root, &other, sizeof root);
    /* Voxelizes a burr, downloads it, and runs one event with it. */
    ost_pm3 lo, hi;
    ost_tool_geometry grid;
    assert_ok(ost_tool_make(OST_TOOL_BURR, &(ost_tool_options){.diameter = 12 * s, .length = 30 * s}, &mesh, &err));
    assert_ok(ost_mesh_bounds(&mesh, &lo, &hi, &err));
    assert_ok(ost_tool_geometry_from_bounds(lo, hi, s, &grid, &err));
    assert_ok(ost_mesh_snap(&mesh, &grid, &snapped, &err));
    ost_voxelize_report solids;
    ost_tool_volume volume;
    assert_ok(ost_voxelize(backend, &snapped, NULL, OST_FILL_WINDING, &solids, &tool, &err));
    assert_ok(ost_tool_download(tool, &volume, &err));
    assert_int_equal(ost_tool_volume_count(&volume, OST_TOOL_CUTTING), solids.cutting_voxels);
    ost_tool_volume_free(&volume);
    const ost_density_classes classes = ost_density_classes_default();
    ost_pose pose = ost_pose_identity();
    pose.t = (ost_pm3){side / 2 * s, side / 2 * s, side / 2 * s};
    ost_map map;
    ost_removal_report report = {0};
    const ost_voxel_box box = {{0, 0, 0}, {side, side, side}};
    assert_ok(ost_map_make(&pose, &g, &grid, &map, &err));
    assert_ok(ost_bone_remove(bone, tool,
                              &(ost_removal_event){.pose_count = 1, .maps = &map, .boxes = &box, .classes = &classes},
                              &report, &err));
    assert_true(report.total_voxels > 0);
    assert_ok(ost_bone_digest(bone, NULL, &root, &err));
    *out = (seen){.count = 0};
    ost_backend_paths(backend, take, out);
    ost_removal_report_free(&report);
    ost_tool_free(tool);
    ost_snapped_mesh_free(&snapped);
    ost_mesh_free(&mesh);
    ost_bone_free(copy);
    ost_bone_free(bone);
    ost_grid_free(cubic);
    ost_grid_free(rect);
    free(samples);
    free(voxels);
    ost_backend_close(backend);
    return root;
}

/* The resulting bone does not depend on the order in which threads process its parts. */
static void bone_does_not_depend_on_the_order(void **state)
{
    (void)state;
    seen none;
    const ost_digest expected = run_all("ref", SIDE, 16, &none);
    for (int order = 1; order <= 4; order++) {
        char spec[64];
        snprintf(spec, sizeof spec, "cpu:threads=3,grain=1,order=%d", order);
        const ost_digest root = run_all(spec, SIDE, 16, &none);
        assert_memory_equal(&root, &expected, sizeof root);
    }
}

static void the_smallest_grain_enters_every_path(void **state)
{
    (void)state;
    /* The grid has 27 leaves and 125 chunks. It is converted in parts of 2 layers of chunks, and each part has 10 rows
       of chunks. This is sufficient work for 7 threads. */
    static const int teams[] = {1, 2, 3, 7};
    seen none, all;
    const ost_digest expected = run_all("ref", SIDE, 16, &none);
    assert_int_equal(none.count, 0);
    for (int t = 0; t < 4; t++) {
        char spec[64];
        snprintf(spec, sizeof spec, "cpu:threads=%d,grain=1", teams[t]);
        const ost_digest root = run_all(spec, SIDE, 16, &all);
        assert_memory_equal(&root, &expected, sizeof root);
        assert_int_equal(all.count, t == 0 ? PATHS - SHARED : PATHS);
        for (int i = 0; i < all.count; i++) {
#if !defined _OPENMP
            if (strstr(all.name[i], " threads"))
                continue;
#endif
            if (!all.entered[i])
                fail_msg("%s: the path '%s' was not entered", spec, all.name[i]);
        }
    }
}

/* An upload of at least 8 slices is divided among threads, so the upload of 40 slices is divided. All other work is
   too small. */
static void small_work_is_not_divided(void **state)
{
    (void)state;
    seen small;
    run_all("cpu:threads=3", SMALL, 16, &small);
    assert_int_equal(small.count, PATHS);
    for (int i = 0; i < small.count; i++)
        if (strcmp(small.name[i], "upload of a bone on 3 threads") != 0 && small.entered[i])
            fail_msg("the path '%s' was entered, although the work is small", small.name[i]);
}

/* Each item of a team's work must be processed exactly once. Empty work has no items. */
static void each_item_is_processed_once(void **state)
{
    (void)state;
    enum { ITEMS = 21 };
    /* Each value of `way` selects one order of the work items: in sequence, in blocks, or one of 16 further orders. */
    for (int way = 0; way < 18; way++)
        for (int64_t count = 0; count <= ITEMS; count++)
            for (int64_t block = 0; block <= 8; block++) {
                ost_cpu_sharing sharing;
                int taken[ITEMS + 1] = {0};
                ost_cpu_sharing_init(&sharing, way > 0, way > 1 ? (uint64_t)way : 0);
                ost_team team = ost_team_of(&sharing, way > 1 ? 3 : 1, OST_PATH_REMOVAL, INT64_MAX, count, block);
                if (way > 1) /* The three members of the team are called one after another. */
                    for (int m = 0; m < 3; m++) {
                        ost_member me = {.next = m, .stride = 3};
                        for (int64_t i; (i = ost_team_next(&team, &me)) >= 0;)
                            taken[i]++;
                    }
                else {
                    ost_member me = ost_team_join(&team);
                    for (int64_t i; (i = ost_team_next(&team, &me)) >= 0;)
                        taken[i]++;
                }
                ost_team_end(&sharing, &team);
                for (int64_t i = 0; i <= ITEMS; i++)
                    assert_int_equal(taken[i], i < count);
            }
}

/* The 3 x 3 x 3 chunks of 64^3 contain 7.1 million voxels, more than 2^22, although the grid has only 2.2 million. */
static void large_removal_is_divided(void **state)
{
    (void)state;
    seen none, large;
    const ost_digest expected = run_all("ref", 130, 64, &none), root = run_all("cpu:threads=3", 130, 64, &large);
    assert_memory_equal(&root, &expected, sizeof root);
#if defined _OPENMP
    static const char *const shared[] = {
        "scatter",          "upload of a grid", "copy of a grid",       "conversion to chunks",
        "upload of a bone", "digest",           "removal and collision"};
    for (size_t i = 0; i < sizeof shared / sizeof shared[0]; i++) {
        char name[OST_PATH_NAME];
        snprintf(name, sizeof name, "%s on 3 threads", shared[i]);
        if (!entered(&large, name))
            fail_msg("the path '%s' was not entered", name);
    }
#endif
    assert_true(entered(&large, "scatter in several blocks"));
    assert_true(entered(&large, "grid in mapped memory"));
    assert_false(entered(&large, "tool written past the caches"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_smallest_grain_enters_every_path),
        cmocka_unit_test(bone_does_not_depend_on_the_order),
        cmocka_unit_test(small_work_is_not_divided),
        cmocka_unit_test(each_item_is_processed_once),
        cmocka_unit_test(large_removal_is_divided),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
