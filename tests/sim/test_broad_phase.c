/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests that the broad phase only skips work. Worlds with and without the broad phase must give the same
 * results, for random poses and for poses at which boxes just touch. The broad phase must skip some poses.
 * Covers: AR-REM-5
 */
#include "ref/scene.h"

#include <osteon/sim.h>

#include "sim/box.h"

typedef struct twin {
    ost_geometry g;
    ost_bone *bone[2];
    ost_world *world[2]; /* world[0] has the broad phase, and world[1] does not */
    int64_t t;
} twin;

static twin make_twin(ost_backend *backend, const ost_geometry *g, const int16_t *voxels, const ost_tool *tool)
{
    ost_error err = {0};
    twin w = {.g = *g};
    for (int i = 0; i < 2; i++) {
        ost_world_options options = {.broad_phase_off = i == 1, .sweep_off = true};
        w.bone[i] = bone_of(backend, g, i ? 16 : 32, voxels);
        assert_ok(ost_world_create(w.bone[i], &options, &w.world[i], &err));
        assert_ok(ost_world_add_tool(w.world[i], "tool", tool, NULL, &err));
    }
    return w;
}

/* Performs one tick in both worlds, compares the results, and returns the result of the first world. */
static ost_step_result step_both(twin *w, const ost_pose *pose)
{
    ost_error err = {0};
    ost_step_result r[2];
    ost_tick tick = {.t_ns = ++w->t, .rpm = OST_RPM_ON, .pose = *pose};
    for (int i = 0; i < 2; i++)
        assert_ok(ost_world_step(w->world[i], &tick, &r[i], &err));
    if (r[0].report->total_voxels != r[1].report->total_voxels ||
        r[0].report->touched_voxels != r[1].report->touched_voxels)
        fail_msg("t = (%lld, %lld, %lld), q = (%d, %d, %d, %d): with the broad phase %llu voxels removed and %llu "
                 "touched, without it %llu and %llu",
                 (long long)pose->t.x, (long long)pose->t.y, (long long)pose->t.z, pose->qw, pose->qx, pose->qy,
                 pose->qz, (unsigned long long)r[0].report->total_voxels,
                 (unsigned long long)r[0].report->touched_voxels, (unsigned long long)r[1].report->total_voxels,
                 (unsigned long long)r[1].report->touched_voxels);
    assert_memory_equal(r[0].report->density, r[1].report->density, sizeof r[0].report->density);
    /* The reported range of chunks must contain all chunks that were hit. */
    int n = 32;
    int32_t cx = (w->g.dims.x + n - 1) / n, cy = (w->g.dims.y + n - 1) / n;
    for (size_t i = 0; i < r[0].report->count; i++) {
        int32_t c = r[0].report->chunks[i].chunk;
        const int32_t at[3] = {c % cx, c / cx % cy, c / cx / cy};
        for (int a = 0; a < 3; a++)
            assert_true(at[a] >= r[0].chunk_lo[a] && at[a] < r[0].chunk_hi[a]);
    }
    return r[0];
}

static void free_twin(twin *w)
{
    ost_digest a = digest_of(w->bone[0]), b = digest_of(w->bone[1]);
    assert_true(ost_digest_equal(&a, &b));
    for (int i = 0; i < 2; i++) {
        ost_world_free(w->world[i]);
        ost_bone_free(w->bone[i]);
    }
}

static void random_poses(void **state)
{
    test_rng rng = rng_seeded("broad phase");
    static const ost_pm tool_voxels[] = {470 * UM, 235 * UM, 30 * UM, 3000 * UM};
    int met = 0, hit = 0, steps = 0;
    for (int round = 0; round < test_rounds(32); round++) {
        ost_geometry g = cubic_geometry((int32_t)rng_range(&rng, 1, 45), (int32_t)rng_range(&rng, 1, 40),
                                        (int32_t)rng_range(&rng, 1, 35), 470 * UM,
                                        (ost_pm3){rng_range(&rng, -99, 99) * UM, -57340 * UM, 3});
        int16_t *voxels = random_densities(&rng, &g, (int)rng_range(&rng, 4, 8));
        ost_tool_geometry t = {
            {(int32_t)rng_range(&rng, 1, 12), (int32_t)rng_range(&rng, 1, 12), (int32_t)rng_range(&rng, 1, 60)},
            tool_voxels[round % 4],
            {rng_range(&rng, -9000, 9000) * UM, rng_range(&rng, -9000, 0) * UM, rng_range(&rng, -20000, 0) * UM}};
        ost_tool *tool = random_tool(*state, &rng, t);
        twin w = make_twin(*state, &g, voxels, tool);
        const ost_pm reach = 12000 * UM;
        ost_pm3 lo = {g.origin.x - reach, g.origin.y - reach, g.origin.z - reach};
        ost_pm3 hi = {g.origin.x + g.dims.x * g.spacing.x + reach, g.origin.y + g.dims.y * g.spacing.x + reach,
                      g.origin.z + g.dims.z * g.spacing.x + reach};
        for (int i = 0; i < 100; i++, steps++) {
            ost_pose pose = random_pose(&rng, lo, hi);
            ost_step_result r = step_both(&w, &pose);
            met += r.boxes_meet;
            hit += r.report->total_voxels > 0;
        }
        free_twin(&w);
        ost_tool_free(tool);
        free(voxels);
    }
    printf("# %d poses: the boxes met at %d of them, and voxels were removed at %d\n", steps, met, hit);
    assert_true(hit > steps / 40 && met < steps);
}

static void boxes_that_just_touch(void **state)
{
    /*
     * The bone consists of one voxel. A tool of 2 x 3 x 4 voxels, in several quarter turns, moves past
     * the bone along each axis. The tool moves in steps of 2^-21 of a tool voxel around the positions
     * where the centre of the bone's voxel meets the tool's faces.
     */
    const ost_pm v = INT64_C(1) << 30, unit = 1024;
    ost_geometry g = cubic_geometry(1, 1, 1, v, (ost_pm3){0, 0, 0});
    const int16_t one = 500;
    static const int32_t c = 759250125, h = OST_Q30_ONE / 2;
    static const int32_t quats[][4] = {{OST_Q30_ONE, 0, 0, 0}, {c, c, 0, 0},           {c, 0, c, 0},
                                       {c, 0, 0, c},           {0, OST_Q30_ONE, 0, 0}, {h, h, h, h},
                                       {h, -h, h, -h},         {0, c, c, 0},           {0, 0, c, -c}};
    static const int32_t extent[3] = {2, 3, 4};
    ost_tool *tool = solid_tool(*state, (ost_tool_geometry){{2, 3, 4}, v, {0, 0, 0}}, OST_TOOL_CUTTING);
    int removed = 0, kept = 0;
    for (size_t q = 0; q < sizeof quats / sizeof quats[0]; q++)
        for (int axis = 0; axis < 3; axis++)
            for (int sign = -1; sign <= 1; sign += 2)
                for (int32_t face = 0; face <= extent[axis]; face += extent[axis])
                    for (int64_t off = -30; off <= 30; off++) {
                        /*
                         * This pose puts the centre of the voxel at a distance of `off` steps from
                         * the face along the tool's axis. On the other axes, the centre is in the
                         * middle between the tool's faces.
                         */
                        ost_pm p[3] = {v, 3 * v / 2, 2 * v};
                        p[axis] = face * v + sign * off * unit / 2;
                        ost_pose turn = {.qw = quats[q][0], .qx = quats[q][1], .qy = quats[q][2], .qz = quats[q][3]};
                        ost_map map;
                        assert_int_equal(ost_map_make(&turn, &g, ost_tool_geometry_get(tool), &map, NULL), OST_OK);
                        /*
                         * Computes R * p from the steps of the map. The voxels of bone and tool have the same size, so
                         * the steps are R scaled by 2^20. For quarter turns the result is exact.
                         */
                        ost_pose pose = turn;
                        ost_pm *t[3] = {&pose.t.x, &pose.t.y, &pose.t.z};
                        for (int b = 0; b < 3; b++)
                            for (int a = 0; a < 3; a++)
                                *t[b] -= map.step[b][a] / (1 << 20) * p[a];
                        twin w = make_twin(*state, &g, &one, tool);
                        ost_step_result r = step_both(&w, &pose);
                        removed += r.report->total_voxels == 1;
                        kept += r.report->total_voxels == 0;
                        free_twin(&w);
                    }
    assert_true(removed > 1000 && kept > 1000);
    ost_tool_free(tool);
}

static void corners_that_just_touch(void **state)
{
    /*
     * Tests the farthest voxel of a block of 16^3, where the computed coordinates are least accurate. The
     * voxel is placed at each corner of a tool's grid, in random rotations, at most two units of 2^-20
     * inside or outside the grid. According to the rules, some of these voxels are removed although their
     * centres lie outside the grid. Boxes are inflated for this reason.
     */
    test_rng rng = rng_seeded("corners");
    const ost_pm v = INT64_C(1) << 30;
    ost_geometry g = cubic_geometry(16, 16, 16, v, (ost_pm3){0, 0, 0});
    int16_t *voxels = calloc(voxel_count(&g), sizeof *voxels);
    voxels[voxel_count(&g) - 1] = 500;
    ost_tool *tool = solid_tool(*state, (ost_tool_geometry){{3, 2, 4}, v, {0, 0, 0}}, OST_TOOL_CUTTING);
    static const int extent[3] = {3, 2, 4};
    int outside = 0;
    for (int round = 0; round < test_rounds(300); round++)
        for (int corner = 0; corner < 8; corner++) {
            ost_pose pose = random_pose(&rng, (ost_pm3){0, 0, 0}, (ost_pm3){0, 0, 0});
            const double w = pose.qw, x = pose.qx, y = pose.qy, z = pose.qz, n = w * w + x * x + y * y + z * z;
            const double r[3][3] = {
                {(w * w + x * x - y * y - z * z) / n, 2 * (x * y - w * z) / n, 2 * (x * z + w * y) / n},
                {2 * (x * y + w * z) / n, (w * w - x * x + y * y - z * z) / n, 2 * (y * z - w * x) / n},
                {2 * (x * z - w * y) / n, 2 * (y * z + w * x) / n, (w * w - x * x - y * y + z * z) / n}};
            int64_t beyond = rng_range(&rng, 0, 4);
            double c[3];
            for (int a = 0; a < 3; a++)
                c[a] = corner >> a & 1 ? (double)(extent[a] * v + (beyond - 2) * 1024) : (double)((2 - beyond) * 1024);
            ost_pm *t[3] = {&pose.t.x, &pose.t.y, &pose.t.z};
            for (int b = 0; b < 3; b++)
                *t[b] = 15 * v - (ost_pm)(r[b][0] * c[0] + r[b][1] * c[1] + r[b][2] * c[2]);
            twin w2 = make_twin(*state, &g, voxels, tool);
            ost_step_result result = step_both(&w2, &pose);
            outside += beyond > 2 && result.report->total_voxels == 1;
            free_twin(&w2);
        }
    printf("# %d voxels were removed although their centres lie outside the grid\n", outside);
    assert_true(outside > 10);
    ost_tool_free(tool);
    free(voxels);
}

static void separating_axes_separate(void **state)
{
    /*
     * The bone is a cube of 10 mm, measured between voxel centres, at the origin. The tool is a cube of 10
     * mm that is rotated by 45 degrees about z, so that a face points along the bone's diagonal. The bounds
     * of the tool overlap the bone at distances at which the tool does not.
     */
    (void)state;
    ost_geometry g = cubic_geometry(11, 11, 11, OST_PM_PER_MM,
                                    (ost_pm3){-5 * OST_PM_PER_MM, -5 * OST_PM_PER_MM, -5 * OST_PM_PER_MM});
    ost_tool_geometry t = {{8, 8, 8}, OST_PM_PER_MM, {-4 * OST_PM_PER_MM, -4 * OST_PM_PER_MM, -4 * OST_PM_PER_MM}};
    ost_box bone = ost_box_of_bone(&g), tool = ost_box_of_tool(&t); /* 10 mm wide, including the inflation by a voxel */
    ost_pose pose = {.qw = 992008094, .qz = 410903207};            /* cos and sin of 22.5 degrees */
    /*
     * Along the diagonal, an edge of the bone meets a face of the tool. The edge is 5 sqrt(2) mm
     * from the centre of the bone, and the face is 5 mm from the centre of the tool. Therefore the
     * boxes separate at 5 sqrt(2) + 5 = 12.0711 mm.
     */
    const double diagonal = 0.7071067811865476;
    pose.t.x = pose.t.y = (ost_pm)(12.07 * diagonal * 1e9);
    assert_true(ost_boxes_meet(&bone, &tool, &pose));
    pose.t.x = pose.t.y = (ost_pm)(12.0722 * diagonal * 1e9);
    assert_false(ost_boxes_meet(&bone, &tool, &pose));
    ost_voxel_box box = ost_box_voxels(&g, &tool, &pose);
    assert_true(ost_voxel_box_holds(&box)); /* The bounds alone would not exclude this pose. */

    /*
     * At the pose q = (2, 0, 1, -2) / 3 and t = k (-4, -11, 11) mm, an edge of one cube meets an edge of
     * the other. Along the normals of their faces the boxes overlap by more than 2 mm. The cross product of
     * the first axes of the boxes is a separating axis for k > 10/11 (computed with fractions).
     */
    ost_pose q = {.qw = 715827883, .qy = 357913941, .qz = -715827883};
    q.t = (ost_pm3){-4 * 910 * UM, -11 * 910 * UM, 11 * 910 * UM};
    assert_false(ost_boxes_meet(&bone, &tool, &q));
    q.t = (ost_pm3){-4 * 909 * UM, -11 * 909 * UM, 11 * 909 * UM};
    assert_true(ost_boxes_meet(&bone, &tool, &q));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(random_poses),
        cmocka_unit_test(boxes_that_just_touch),
        cmocka_unit_test(corners_that_just_touch),
        cmocka_unit_test(separating_axes_separate),
    };
    return run_on_backends(tests, open_test_backend, close_test_backend);
}
