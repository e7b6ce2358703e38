/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Compares removal and collision of the CPU backend with the reference, for every instruction
 * set of this machine and several thread counts: voxels, digests and reports must be
 * bit-identical. Tools, bones and poses are random and include borderline cases: quarter turns,
 * tool voxel centres exactly on bone voxel centres, grids of one voxel, empty tools and bones,
 * and boxes smaller than the region that the tool reaches.
 * Covers: AR-MAP-4, AR-MAP-5, AR-REM-1..6, AR-CHK-3, AR-LAW-1
 */
#include "cpu/team.h"

/* ---------------------------------------------------------------- scenes */

/* Returns a random pose on or near the bone. A third of the poses are rotated by quarter turns, so that the voxels
   of tool and bone are aligned. */
static ost_pose some_pose(test_rng *rng, const ost_geometry *g)
{
    const ost_pm s = g->spacing.x;
    const ost_pm3 hi = {g->dims.x * s, g->dims.y * s, g->dims.z * s};
    ost_pose pose = random_pose(rng, (ost_pm3){-2 * s, -2 * s, -2 * s}, hi);
    const int64_t how = rng_range(rng, 0, 5);
    if (how < 2) {
        const int32_t c = 759250125;
        const ost_pose quarters[] = {{{0}, OST_Q30_ONE, 0, 0, 0},
                                     {{0}, c, c, 0, 0},
                                     {{0}, c, 0, -c, 0},
                                     {{0}, 0, 0, 0, OST_Q30_ONE},
                                     {{0}, OST_Q30_ONE / 2, OST_Q30_ONE / 2, OST_Q30_ONE / 2, OST_Q30_ONE / 2}};
        const ost_pm3 at = pose.t;
        pose = quarters[rng_range(rng, 0, 4)];
        pose.t = at;
    }
    if (how % 2 == 0)
        pose.t = (ost_pm3){pose.t.x / s * s, pose.t.y / s * s, pose.t.z / s * s};
    pose.t.x += g->origin.x;
    pose.t.y += g->origin.y;
    pose.t.z += g->origin.z;
    return pose;
}

/*
 * Returns the box of an event. In two of three cases, the box is the complete grid. In the third case, it is a random
 * box, which may exclude a part of the tool.
 */
static ost_voxel_box some_box(test_rng *rng, const ost_geometry *g)
{
    const int32_t d[3] = {g->dims.x, g->dims.y, g->dims.z};
    ost_voxel_box box;
    const bool complete = rng_range(rng, 0, 2) > 0;
    for (int a = 0; a < 3; a++) {
        box.lo[a] = complete ? 0 : (int32_t)rng_range(rng, -3, d[a]);
        box.hi[a] = complete ? d[a] : (int32_t)rng_range(rng, box.lo[a], d[a] + 5);
    }
    return box;
}

static int16_t *some_bone(test_rng *rng, const ost_geometry *g)
{
    int16_t *voxels = random_densities(rng, g, (int)rng_range(rng, 1, 8));
    if (rng_range(rng, 0, 3) == 0) /* These densities are from the full range of int16. */
        for (size_t i = 0; i < voxel_count(g); i++)
            voxels[i] = (int16_t)rng_range(rng, -32768, 32767);
    if (rng_range(rng, 0, 3) == 0) /* The first half is empty, so that chunks are absent. */
        memset(voxels, 0, voxel_count(g) / 2 * sizeof *voxels);
    return voxels;
}

static const ost_pm bone_voxels[] = {470 * UM, 300 * UM, 1000 * UM};
/*
 * Sizes of tool voxels in thousandths of a bone voxel. They include sizes for windows of 8^3 and of 16^3
 * voxels, with every step that is possible (see src/cpu/remove/shape.h), and sizes for which no windows
 * are made.
 */
static const int64_t tool_voxels[] = {3000, 2128, 1600, 1064, 1064, 1064, 1000, 960, 900, 750, 743,
                                      650,  532,  400,  380,  347,  320,  288,  260, 247, 150, 63};

static void compare_event(const team *t, test_rng *rng, int64_t poses_max)
{
    ost_error err = {0};
    const ost_pm s = bone_voxels[rng_range(rng, 0, 2)];
    const ost_geometry g = cubic_geometry((int32_t)rng_range(rng, 1, 50), (int32_t)rng_range(rng, 1, 70),
                                          (int32_t)rng_range(rng, 1, 50), s,
                                          (ost_pm3){rng_range(rng, -50000, 50000) * UM, 123456789, -s});
    const int n = 16 << rng_range(rng, 0, 2);
    const int64_t share = tool_voxels[rng_range(rng, 0, sizeof tool_voxels / sizeof tool_voxels[0] - 1)];
    ost_tool_volume volume = random_form(rng, s * share / 1000, share < 500 ? 90 : 40);
    int16_t *voxels = some_bone(rng, &g);

    enum { POSES = 6 };
    scene_event e;
    const int poses = (int)rng_range(rng, 1, poses_max);
    ost_pose pose = some_pose(rng, &g);
    for (int k = 0; k < poses; k++) {
        assert_ok(ost_map_make(&pose, &g, &volume.geometry, &e.maps[k], &err));
        e.boxes[k] = some_box(rng, &g);
        pose.t.x += s / 3;
        pose.t.z -= s / 2;
    }
    e.classes = ost_density_classes_default();
    if (rng_range(rng, 0, 2) == 0) {
        e.classes.count = (int)rng_range(rng, 1, OST_CLASS_MAX);
        for (int c = 0; c < e.classes.count; c++)
            e.classes.border[c] = (int16_t)(100 + c * rng_range(rng, 1, 4000));
        for (int c = 1; c < e.classes.count; c++)
            if (e.classes.border[c] <= e.classes.border[c - 1])
                e.classes.border[c] = (int16_t)(e.classes.border[c - 1] + 1);
    }
    e.event = (ost_removal_event){.pose_count = poses, .maps = e.maps, .boxes = e.boxes, .classes = &e.classes};

    ost_bone *expected = bone_of(t->ref, &g, n, voxels);
    ost_tool *tool;
    ost_removal_report expected_touch = {0}, expected_report = {0}, expected_again = {0};
    assert_ok(ost_tool_upload(t->ref, &volume, &tool, &err));
    assert_ok(ost_bone_collide(expected, tool, &e.event, &expected_touch, &err));
    assert_ok(ost_bone_remove(expected, tool, &e.event, &expected_report, &err));
    assert_ok(ost_bone_remove(expected, tool, &e.event, &expected_again, &err));
    int16_t *left = content(expected, &g);
    ost_bone_info expected_info;
    assert_ok(ost_bone_info_get(expected, &expected_info, &err));
    ost_tool_free(tool);

    static int turn;
    turn++;
    for (int i = 0; i < t->count; i++) {
        if (!has_turn(i, turn))
            continue;
        ost_bone *bone = bone_of(t->cpu[i], &g, n, voxels);
        ost_removal_report report = {0};
        ost_bone_info info;
        assert_ok(ost_tool_upload(t->cpu[i], &volume, &tool, &err));
        assert_ok(ost_bone_collide(bone, tool, &e.event, &report, &err));
        assert_same_report(&report, &expected_touch);
        assert_ok(ost_bone_remove(bone, tool, &e.event, &report, &err));
        assert_same_report(&report, &expected_report);
        assert_ok(ost_bone_remove(bone, tool, &e.event, &report, &err));
        assert_same_report(&report, &expected_again);
        int16_t *found = content(bone, &g);
        assert_same_voxels(found, left, &g);
        assert_ok(ost_bone_info_get(bone, &info, &err));
        assert_int_equal(info.active_voxels, expected_info.active_voxels);
        assert_int_equal(info.active_chunks, expected_info.active_chunks);
        assert_int_equal(info.chunk_bytes, expected_info.chunk_bytes);
        free(found);
        ost_removal_report_free(&report);
        ost_tool_free(tool);
        ost_bone_free(bone);
    }
    ost_removal_report_free(&expected_touch);
    ost_removal_report_free(&expected_report);
    ost_removal_report_free(&expected_again);
    ost_bone_free(expected);
    ost_tool_volume_free(&volume);
    free(voxels);
    free(left);
}

static void single_poses(void **state)
{
    test_rng rng = rng_seeded("single poses");
    for (int i = 0; i < 300; i++)
        compare_event(*state, &rng, 1);
}

static void several_poses(void **state)
{
    test_rng rng = rng_seeded("several poses");
    for (int i = 0; i < 60; i++)
        compare_event(*state, &rng, 6);
}

/* Moves a tool through one bone in several events, so that each result depends on the state after earlier events. */
static void several_events_on_one_bone(void **state)
{
    const team *t = *state;
    ost_error err = {0};
    test_rng rng = rng_seeded("a sequence");
    const ost_geometry g = cubic_geometry(75, 66, 70, 470 * UM, (ost_pm3){0});
    int16_t *voxels = random_densities(&rng, &g, 7);
    ost_tool_volume volume;
    const int32_t d[3] = {48, 48, 48};
    assert_ok(ost_tool_volume_init(&volume, &(ost_tool_geometry){{48, 48, 48}, 500 * UM, {-12000 * UM, -12000 * UM, 0}},
                                   &err));
    for (int32_t v = 0; v < 48 * 48 * 48; v++)
        volume.voxels[v] = form_at(HEMISPHERE, &rng, d, v % 48, v / 48 % 48, v / 48 / 48);
    const ost_pose from = random_pose(&rng, (ost_pm3){15000 * UM, 14000 * UM, -9000 * UM},
                                      (ost_pm3){20000 * UM, 18000 * UM, -2000 * UM});
    for (int n = 16; n <= 64; n *= 2) {
        ost_bone *expected = bone_of(t->ref, &g, n, voxels);
        ost_tool *tool;
        ost_bone *bone[BACKENDS_MAX];
        ost_tool *tools[BACKENDS_MAX];
        assert_ok(ost_tool_upload(t->ref, &volume, &tool, &err));
        for (int i = 0; i < t->count; i++) {
            bone[i] = bone_of(t->cpu[i], &g, n, voxels);
            assert_ok(ost_tool_upload(t->cpu[i], &volume, &tools[i], &err));
        }
        ost_pose pose = from;
        for (int tick = 0; tick < 12; tick++) {
            ost_removal_report report = {0}, found = {0};
            pose.t.z += 470 * UM;
            pose.qx += 40000;
            remove_at(expected, &g, tool, &pose, 1, &report);
            for (int i = 0; i < t->count; i++) {
                remove_at(bone[i], &g, tools[i], &pose, 1, &found);
                assert_same_report(&found, &report);
            }
            ost_removal_report_free(&report);
            ost_removal_report_free(&found);
        }
        const ost_digest digest = digest_of(expected);
        for (int i = 0; i < t->count; i++) {
            const ost_digest own = digest_of(bone[i]);
            assert_memory_equal(&own, &digest, sizeof digest);
            ost_bone_free(bone[i]);
            ost_tool_free(tools[i]);
        }
        ost_bone_free(expected);
        ost_tool_free(tool);
    }
    ost_tool_volume_free(&volume);
    free(voxels);
}

/*
 * Tests enough chunks for several threads and many batches. One of the two tools extends through
 * the entire bone, and the tools alternate from event to event.
 */
static void many_chunks(void **state)
{
    const team *t = *state;
    ost_error err = {0};
    test_rng rng = rng_seeded("many chunks");
    const ost_geometry g = cubic_geometry(170, 166, 163, 470 * UM, (ost_pm3){0});
    int16_t *voxels = random_densities(&rng, &g, 2);
    ost_tool_volume volume[2];
    for (int v = 0; v < 2; v++) {
        const int32_t d[3] = {v ? 12 : 180, v ? 200 : 170, v ? 40 : 160};
        const ost_pm voxel = 500 * UM;
        assert_ok(ost_tool_volume_init(
            &volume[v],
            &(ost_tool_geometry){{d[0], d[1], d[2]}, voxel, {-voxel * d[0] / 2, -voxel * d[1] / 2, -voxel * d[2] / 2}},
            &err));
        for (int32_t i = 0; i < d[0] * d[1] * d[2]; i++)
            volume[v].voxels[i] = form_at(v ? SOLID : TOOTHED_SHELL, &rng, d, i % d[0], i / d[0] % d[1],
                                          i / d[0] / d[1]);
    }
    const ost_pose from = random_pose(&rng, (ost_pm3){30000 * UM, 30000 * UM, 30000 * UM},
                                      (ost_pm3){45000 * UM, 45000 * UM, 45000 * UM});
    int turn = (int)rng_range(&rng, 0, THREADS - 1);
    for (int n = 16; n <= 64; n *= 2, turn++) {
        ost_bone *expected = bone_of(t->ref, &g, n, voxels);
        ost_removal_report report[4] = {{0}};
        for (int tick = 0; tick < 4; tick++) {
            ost_tool *tool;
            ost_pose pose = from;
            pose.t.z += tick * 90 * UM;
            assert_ok(ost_tool_upload(t->ref, &volume[tick % 2], &tool, &err));
            remove_at(expected, &g, tool, &pose, 1, &report[tick]);
            ost_tool_free(tool);
        }
        const ost_digest digest = digest_of(expected);
        for (int i = 0; i < t->count; i++) {
            if (!has_turn(i, turn))
                continue;
            ost_bone *bone = bone_of(t->cpu[i], &g, n, voxels);
            ost_tool *tools[2];
            for (int v = 0; v < 2; v++)
                assert_ok(ost_tool_upload(t->cpu[i], &volume[v], &tools[v], &err));
            for (int tick = 0; tick < 4; tick++) {
                ost_removal_report found = {0};
                ost_pose pose = from;
                pose.t.z += tick * 90 * UM;
                remove_at(bone, &g, tools[tick % 2], &pose, 1, &found);
                assert_same_report(&found, &report[tick]);
                ost_removal_report_free(&found);
            }
            const ost_digest own = digest_of(bone);
            assert_memory_equal(&own, &digest, sizeof digest);
            for (int v = 0; v < 2; v++)
                ost_tool_free(tools[v]);
            ost_bone_free(bone);
        }
        for (int tick = 0; tick < 4; tick++)
            ost_removal_report_free(&report[tick]);
        ost_bone_free(expected);
    }
    for (int v = 0; v < 2; v++)
        ost_tool_volume_free(&volume[v]);
    free(voxels);
}

/* Uploads slices that overlap, in random order. */
static void overlapping_uploads(void **state)
{
    const team *t = *state;
    ost_error err = {0};
    test_rng rng = rng_seeded("slabs of slices");
    for (int round = 0; round < 60; round++) {
        const ost_geometry g = cubic_geometry((int32_t)rng_range(&rng, 1, 70), (int32_t)rng_range(&rng, 1, 40),
                                              (int32_t)rng_range(&rng, 1, 70), 470 * UM, (ost_pm3){0});
        const int n = 16 << rng_range(&rng, 0, 2);
        const size_t slice = (size_t)g.dims.x * (size_t)g.dims.y;
        ost_bone *bone[BACKENDS_MAX + 1];
        for (int i = 0; i <= t->count; i++)
            assert_ok(ost_bone_create(i ? t->cpu[i - 1] : t->ref, &g, n, 120, &bone[i], &err));
        for (int slab = 0; slab < 5; slab++) {
            int16_t *voxels = some_bone(&rng, &g);
            const int32_t z0 = (int32_t)rng_range(&rng, 0, g.dims.z - 1),
                          count = (int32_t)rng_range(&rng, 0, g.dims.z - z0);
            for (int i = 0; i <= t->count; i++)
                assert_ok(ost_bone_upload(bone[i], z0, count, voxels + slice * (size_t)z0, &err));
            free(voxels);
        }
        const ost_digest digest = digest_of(bone[0]);
        int16_t *left = content(bone[0], &g);
        ost_bone_info expected;
        assert_ok(ost_bone_info_get(bone[0], &expected, &err));
        for (int i = 1; i <= t->count; i++) {
            int16_t *found = content(bone[i], &g);
            assert_same_voxels(found, left, &g);
            const ost_digest own = digest_of(bone[i]);
            assert_memory_equal(&own, &digest, sizeof digest);
            ost_bone_info info;
            assert_ok(ost_bone_info_get(bone[i], &info, &err));
            assert_int_equal(info.active_voxels, expected.active_voxels);
            assert_int_equal(info.active_chunks, expected.active_chunks);
            free(found);
        }
        free(left);
        for (int i = 0; i <= t->count; i++)
            ost_bone_free(bone[i]);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(overlapping_uploads),
        cmocka_unit_test(single_poses),
        cmocka_unit_test(several_poses),
        cmocka_unit_test(several_events_on_one_bone),
        cmocka_unit_test(many_chunks),
    };
    return cmocka_run_group_tests(tests, open_team, close_team);
}
