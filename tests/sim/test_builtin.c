/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests built-in paths: the motion and speed of the tool's working face, and the removed bone. Further tests
 * check that the glenoid's position is read from the facts of a grid.
 */
#include "ref/scene.h"

#include <math.h>
#include <osteon/motor.h>
#include <osteon/sim.h>

/*
 * A tool of 36 x 36 x 20 mm with z as its axis. The built-in paths assume that its lowest point is at
 * corner + 3/2 voxels, which is z = 0 for this tool.
 */
static const ost_tool_geometry reamer = {{73, 73, 42}, OST_PM_PER_MM / 2, {-18250000000, -18250000000, -750000000}};

static void rotate(const double q[4], const double v[3], double out[3])
{
    const double w = q[0], x = q[1], y = q[2], z = q[3];
    out[0] = (1 - 2 * (y * y + z * z)) * v[0] + 2 * (x * y - w * z) * v[1] + 2 * (x * z + w * y) * v[2];
    out[1] = 2 * (x * y + w * z) * v[0] + (1 - 2 * (x * x + z * z)) * v[1] + 2 * (y * z - w * x) * v[2];
    out[2] = 2 * (x * z - w * y) * v[0] + 2 * (y * z + w * x) * v[1] + (1 - 2 * (x * x + y * y)) * v[2];
}

static void paths_follow_axis(void **state)
{
    (void)state;
    ost_error err = {0};
    static const double axes[][3] = {{0, 0, 1},   {0, 0, -1},      {1, 0, 0},  {0, -1, 0},         {-3, 4, 0},
                                     {1, 1, 1},   {-1, 1e-9, 1e3}, {-1, -2, -3}, {1e-300, 0, 1e-300}, {5, -7, 0.001}};
    for (size_t i = 0; i < sizeof axes / sizeof axes[0]; i++)
        for (int which = 0; which < OST_BUILTIN_GLENOID_PRESS; which++) {
            ost_glenoid glenoid = {.at = {-117800 * UM, 196500 * UM, -159000 * UM},
                                   .axis = {axes[i][0], axes[i][1], axes[i][2]}};
            ost_path path;
            assert_ok(ost_builtin_path((ost_builtin)which, &glenoid, &reamer, 3, &path, &err));
            const bool slow = which == OST_BUILTIN_GLENOID_SLOW;
            assert_true(slow ? path.count > 60000 && path.count < 61000 : path.count >= 2000 && path.count <= 6000);
            double scale = fmax(fabs(axes[i][0]), fmax(fabs(axes[i][1]), fabs(axes[i][2])));
            double u[3] = {axes[i][0] / scale, axes[i][1] / scale, axes[i][2] / scale};
            double length = sqrt(u[0] * u[0] + u[1] * u[1] + u[2] * u[2]);
            double last = 0, deepest = -100, before[4] = {1, 0, 0, 0};
            for (size_t k = 0; k < path.count; k++) {
                const ost_tick *tick = &path.ticks[k];
                assert_int_equal(tick->t_ns, (int64_t)k * 1000000);
                assert_int_equal(tick->tool, 3);
                assert_int_equal(tick->rpm, OST_RPM_OF_DEVICE);
                double t[3], q[4], down[3];
                ost_pose_to_doubles(&tick->pose, t, q);
                assert_true(fabs(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3] - 1) < 1e-8);
                rotate(q, (double[3]){0, 0, -1}, down);
                double depth = 0, off = 0;
                for (int a = 0; a < 3; a++) {
                    assert_true(fabs(down[a] - u[a] / length) < 1e-7);
                    depth += (t[a] - (double[]){-117.8, 196.5, -159}[a]) * u[a] / length;
                }
                for (int a = 0; a < 3; a++)
                    off += fabs(t[a] - (double[]){-117.8, 196.5, -159}[a] - depth * u[a] / length);
                /* The tip is the origin of the tool's frame, so the translation t lies on the axis. */
                assert_true(off < 1e-6);
                if (k > 0) {
                    assert_true(fabs(depth - last) < 0.0201);
                    assert_memory_equal(q, before, sizeof q); /* The motor rotates the tool; the path does not. */
                }
                last = depth;
                deepest = depth > deepest ? depth : deepest;
                memcpy(before, q, sizeof before);
            }
            assert_true(fabs(last + (slow ? 2 : 8)) < 1e-6);
            assert_true(which == OST_BUILTIN_PEG_HOLE ? deepest > 19.99 && deepest < 25.01
                                                      : deepest > 1.99 && deepest < 3.2);
            ost_path_free(&path);
        }
}

/*
 * The path simulates a hand that presses. The tip moves from 2 mm outside the face to 12 mm
 * inside in half a second. Then it moves to a depth of 24 mm at 0.15 mm/s, and oscillates by 1.5
 * mm along the axis. The tip is at most 6 mm from the axis, and the tool's own axis is tilted by
 * at most 3 degrees. The lateral motion begins gradually and moves the tip to all sides of the axis. A
 * longer path must begin with the ticks of a shorter path.
 */
static void path_of_pressing_hand(void **state)
{
    (void)state;
    ost_error err = {0};
    const ost_glenoid glenoid = {.at = {10 * OST_PM_PER_MM, 0, 0}, .axis = {0, 0, -1}};
    ost_path path, longer;
    assert_ok(ost_builtin_path(OST_BUILTIN_GLENOID_PRESS, &glenoid, &reamer, 2, &path, &err));
    assert_int_equal(path.count, 60000);
    assert_ok(ost_builtin_press(&glenoid, &reamer, 2, 100000, &longer, &err));
    assert_memory_equal(path.ticks, longer.ticks, path.count * sizeof *path.ticks);
    double deepest = 0, leaned = 0, sideways[4] = {0};
    for (size_t k = 0; k < longer.count; k++) {
        double t[3], q[4], down[3];
        assert_int_equal(longer.ticks[k].tool, 2);
        ost_pose_to_doubles(&longer.ticks[k].pose, t, q);
        rotate(q, (double[3]){0, 0, -1}, down);
        const double depth = -t[2], x = t[0] - 10, y = t[1],
                     wish = k < 500 ? -2.0 + 14.0 * (double)k / 500 : fmin(24, 12 + 1.5e-4 * (double)(k - 500));
        assert_true(fabs(depth - wish) <= 1.5 + 1e-6);
        assert_true(sqrt(x * x + y * y) <= 6 + 1e-6);
        assert_true(down[2] <= -cos(3.01 * 3.14159265 / 180));
        if (k < 500)
            assert_true(fabs(depth - wish) < 1e-6 && fabs(x) + fabs(y) < 1e-6 && down[2] < -1 + 1e-9);
        deepest = fmax(deepest, depth);
        leaned = fmax(leaned, 1 + down[2]);
        sideways[0] = fmax(sideways[0], x);
        sideways[1] = fmax(sideways[1], -x);
        sideways[2] = fmax(sideways[2], y);
        sideways[3] = fmax(sideways[3], -y);
    }
    assert_true(deepest > 25.4 && leaned > 1 - cos(2.9 * 3.14159265 / 180));
    assert_true(sideways[0] > 3.9 && sideways[1] > 3.9 && sideways[2] > 5.9 && sideways[3] > 5.9);
    ost_path_free(&path);
    ost_path_free(&longer);
    assert_int_equal(ost_builtin_press(&glenoid, &reamer, 0, 0, &path, &err), OST_ERR_USAGE);
    assert_int_equal(ost_builtin_press(&glenoid, &reamer, 0, (size_t)OST_PATH_TICKS_MAX + 1, &path, &err),
                     OST_ERR_USAGE);
}

static void events_have_one_pose(void **state)
{
    /* No corner moves by more than half of the thesis' voxel size per tick, so every event has one pose. */
    (void)state;
    ost_error err = {0};
    ost_glenoid glenoid = {.axis = {0.9, 0.1, -0.2}};
    static const ost_tool_geometry tools[] = {
        {{73, 73, 42}, OST_PM_PER_MM / 2, {-18250000000, -18250000000, -750000000}},
        {{14, 14, 62}, OST_PM_PER_MM / 2, {-3500000000, -3500000000, -1000000000}},
        {{3, 3, 3}, OST_PM_PER_MM / 2, {-750000000, -750000000, 0}},
        /* The axis of the frame lies outside this grid. */
        {{40, 40, 10}, OST_PM_PER_MM / 2, {100 * OST_PM_PER_MM, 50 * OST_PM_PER_MM, 0}},
    };
    for (size_t i = 0; i < 4; i++)
        for (int which = 0; which < OST_BUILTIN_COUNT; which++) {
            ost_path path;
            assert_ok(ost_builtin_path((ost_builtin)which, &glenoid, &tools[i], 0, &path, &err));
            for (size_t k = 1; k < path.count; k++) {
                int n = 0;
                assert_ok(ost_sweep_count(&path.ticks[k - 1].pose, &path.ticks[k].pose, &tools[i], 470 * UM, &n, &err));
                assert_int_equal(n, 1);
            }
            ost_path_free(&path);
        }
}

static void built_in_paths_remove_planned_depth(void **state)
{
    /*
     * The face of the block is at z = 0 and faces +z. Below the face there are 2 mm of cartilage, 1.9 mm of
     * plate, and then cancellous bone. The reamer reaches a depth of 3 mm, the peg 22 mm.
     */
    ost_error err = {0};
    const ost_pm s = 500 * UM;
    ost_geometry g = cubic_geometry(90, 90, 60, s, (ost_pm3){-22250 * UM, -22250 * UM, -29900 * UM});
    int16_t *voxels = malloc(voxel_count(&g) * sizeof *voxels);
    for (size_t i = 0; i < voxel_count(&g); i++) {
        int64_t depth = -(g.origin.z + (int64_t)(i / 8100) * s);
        voxels[i] = depth < 2000 * UM ? 130 : depth < 3900 * UM ? 1200 : 300;
    }
    ost_glenoid glenoid = {.axis = {0, 0, -1}};
    /* The tools have flat ends. The path uses z = corner + 3/2 voxels = 0 as the working face. */
    const struct {
        ost_tool_geometry g;
        ost_builtin which;
        int layers;
    } tools[] = {
        {{{21, 21, 42}, OST_PM_PER_MM / 2, {-5250000000, -5250000000, -750000000}}, OST_BUILTIN_GLENOID_REAM, 5},
        {{{9, 9, 62}, OST_PM_PER_MM / 2, {-2250000000, -2250000000, -750000000}}, OST_BUILTIN_PEG_HOLE, 43}};
    for (int i = 0; i < 2; i++) {
        ost_bone *bone = bone_of(*state, &g, 32, voxels);
        ost_tool_volume volume;
        assert_ok(ost_tool_volume_init(&volume, &tools[i].g, &err));
        int32_t nx = tools[i].g.dims.x, nz = tools[i].g.dims.z;
        for (int32_t z = 2; z < nz; z++) /* The cutting part begins at z = -0.75 + 2 * 0.5 = 0.25 mm. */
            memset(volume.voxels + (size_t)z * (size_t)nx * (size_t)nx, OST_TOOL_CUTTING, (size_t)nx * (size_t)nx);
        ost_tool *tool;
        assert_ok(ost_tool_upload(*state, &volume, &tool, &err));
        ost_tool_volume_free(&volume);
        ost_world *world;
        ost_path path;
        assert_ok(ost_world_create(bone, NULL, &world, &err));
        assert_ok(ost_world_add_tool(world, "tool", tool, NULL, &err));
        assert_ok(ost_builtin_path(tools[i].which, &glenoid, &tools[i].g, 0, &path, &err));
        ost_step_result r;
        /* The tick has no motor speed, like a tick from a device, so it must be refused. */
        assert_int_equal(ost_world_step(world, &path.ticks[0], &r, &err), OST_ERR_USAGE);
        assert_ok(ost_motor_path(&path, OST_RPM_REAMER, &(ost_motor){0}, &err));
        /* For this test, it is sufficient to execute one pose per hundredth of a second. */
        for (size_t k = 0; k < path.count; k += 10) {
            assert_ok(ost_world_step(world, &path.ticks[k], &r, &err));
        }
        ost_world_totals totals;
        ost_world_totals_get(world, &totals);
        assert_true(totals.removed_by_class[0] > 0);
        assert_true(totals.removed_by_class[2] > 0);
        if (tools[i].which == OST_BUILTIN_GLENOID_REAM)
            assert_int_equal(totals.removed_by_class[1], 0);
        else
            assert_true(totals.removed_by_class[1] > totals.removed_by_class[0]);
        /*
         * In the middle, the centres of voxels are at depths of 0.4, 0.9, ... mm. They are removed down to
         * a depth of 3 or 22 mm, minus the 0.25 mm before the tool's first cutting layer.
         */
        int16_t *after = content(bone, &g);
        int gone = 0;
        for (int z = 0; z < 60; z++)
            gone += after[45 + 90 * (45 + 90 * (size_t)z)] == 0;
        assert_int_equal(gone, tools[i].layers);
        free(after);
        ost_path_free(&path);
        ost_world_free(world);
        ost_tool_free(tool);
        ost_bone_free(bone);
    }
    free(voxels);
}

static void invalid_paths_are_refused(void **state)
{
    (void)state;
    ost_error err = {0};
    ost_path path;
    ost_glenoid glenoid = {.axis = {0, 0, 0}};
    assert_int_equal(ost_builtin_path(OST_BUILTIN_PEG_HOLE, &glenoid, &reamer, 0, &path, &err), OST_ERR_USAGE);
    glenoid.axis[1] = NAN;
    assert_int_equal(ost_builtin_path(OST_BUILTIN_PEG_HOLE, &glenoid, &reamer, 0, &path, &err), OST_ERR_USAGE);
    glenoid.axis[1] = 1;
    assert_int_equal(ost_builtin_path(OST_BUILTIN_COUNT, &glenoid, &reamer, 0, &path, &err), OST_ERR_USAGE);
    glenoid.at.x = OST_LENGTH_MAX;
    glenoid.axis[0] = 1;
    assert_int_equal(ost_builtin_path(OST_BUILTIN_PEG_HOLE, &glenoid, &reamer, 0, &path, &err), OST_ERR_RANGE);
    assert_null(path.ticks);
    assert_string_equal(ost_builtin_name(OST_BUILTIN_PEG_HOLE), "peg-hole");
    assert_string_equal(ost_builtin_name(OST_BUILTIN_GLENOID_REAM), "glenoid-ream");
    assert_string_equal(ost_builtin_name(OST_BUILTIN_GLENOID_SLOW), "glenoid-slow");
    assert_string_equal(ost_builtin_name(OST_BUILTIN_GLENOID_PRESS), "glenoid-press");
}

static ost_meta *meta_of(const char *at, const char *axis, const char *side)
{
    ost_error err = {0};
    ost_meta *meta = calloc(1, sizeof *meta);
    if (at)
        assert_ok(ost_meta_set(meta, OST_META_GLENOID_AT, at, &err));
    if (axis)
        assert_ok(ost_meta_set(meta, OST_META_GLENOID_AXIS, axis, &err));
    if (side)
        assert_ok(ost_meta_set(meta, OST_META_SIDE, side, &err));
    return meta;
}

static void glenoid_is_read_from_facts(void **state)
{
    (void)state;
    ost_error err = {0};
    ost_glenoid g;
    ost_meta *meta = meta_of("-117.8 196.5 -159", "-1 0 -0.25", "left");
    assert_ok(ost_glenoid_from_meta(meta, &g, &err));
    free(meta);
    assert_int_equal(g.at.x, -117800 * UM);
    assert_int_equal(g.at.y, 196500 * UM);
    assert_int_equal(g.at.z, -159000 * UM);
    assert_true(g.axis[0] == -1 && g.axis[1] == 0 && g.axis[2] == -0.25);
    assert_true(g.left);
    const struct {
        const char *at, *axis, *side, *text;
        ost_status status;
    } cases[] = {
        {NULL, "1 0 0", "left", OST_META_GLENOID_AT, OST_ERR_USAGE},
        {"1 2 3", NULL, "left", OST_META_GLENOID_AXIS, OST_ERR_USAGE},
        {"1 2 3", "0.2 1 0", NULL, "the side is not set", OST_ERR_USAGE},
        {"1 2 3", "1 0 0", "left", "correct the side or the axis", OST_ERR_INPUT},
        {"1 2 3", "-0.5 -0.5 0", "right", "points into a left glenoid", OST_ERR_INPUT},
        {"1 2", "-1 0 0", "left", "1 2", OST_ERR_INPUT},
        {"1 2 3 4", "1 0 0", "left", "1 2 3 4", OST_ERR_INPUT},
        {"1 2 x", "1 0 0", "left", "1 2 x", OST_ERR_INPUT},
        {"1 2 9001", "1 0 0", "left", "9001", OST_ERR_RANGE},
        {"1 2 3", "0 0 0", "left", "0 0 0", OST_ERR_INPUT},
        {"1 2 3", "1e30 0 0", "left", "1e30", OST_ERR_INPUT},
        {"1 2 3", "1 0 0", "up", "up", OST_ERR_INPUT},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        meta = meta_of(cases[i].at, cases[i].axis, cases[i].side);
        assert_int_equal(ost_glenoid_from_meta(meta, &g, &err), cases[i].status);
        assert_non_null(strstr(err.text, cases[i].text));
        free(meta);
    }
}

/*
 * A left glenoid faces left, toward +x, so its inward axis has x < 0. If the axis is within 15
 * degrees of the sagittal plane, the side is unknown.
 */
static void side_follows_from_axis(void **state)
{
    (void)state;
    ost_error err = {0};
    test_rng rng = rng_seeded("sides");
    for (int n = 0; n < 500; n++) {
        const double angle = (double)rng_range(&rng, -8999, 8999) / 100, about = (double)rng_range(&rng, 0, 359),
                     size = (double)rng_range(&rng, 1, 1000) / 10;
        const double pi = 3.14159265358979323846, across = cos(angle * pi / 180) * size;
        const double axis[3] = {sin(angle * pi / 180) * size, across * cos(about * pi / 180),
                                across * sin(about * pi / 180)};
        const ost_side expected = fabs(angle) < 15 ? OST_SIDE_UNKNOWN : angle < 0 ? OST_SIDE_LEFT : OST_SIDE_RIGHT;
        bool left;
        if (fabs(fabs(angle) - 15) < 0.001)
            continue;
        assert_int_equal(ost_side_of_axis(axis), expected);
        for (int stated = OST_SIDE_UNKNOWN; stated <= OST_SIDE_RIGHT; stated++) {
            const ost_status status = ost_glenoid_side(axis, (ost_side)stated, &left, &err);
            if (!stated && !expected)
                assert_int_equal(status, OST_ERR_USAGE);
            else if (stated && expected && stated != (int)expected)
                assert_int_equal(status, OST_ERR_INPUT);
            else
                assert_true(status == OST_OK && left == (stated ? stated == OST_SIDE_LEFT : expected == OST_SIDE_LEFT));
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(paths_follow_axis),
        cmocka_unit_test(path_of_pressing_hand),
        cmocka_unit_test(events_have_one_pose),
        cmocka_unit_test(built_in_paths_remove_planned_depth),
        cmocka_unit_test(invalid_paths_are_refused),
        cmocka_unit_test(glenoid_is_read_from_facts),
        cmocka_unit_test(side_follows_from_axis),
    };
    return run_on_backends(tests, open_test_backend, close_test_backend);
}
