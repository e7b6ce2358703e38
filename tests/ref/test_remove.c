/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Compares removal with results for small grids computed by hand, and then checks the laws AR-LAW.
 *
 * The file has more than 500 lines, because all tests describe one operation. The tests of the laws compare results
 * only with each other, so they depend on the tests whose results are computed by hand.
 *
 * Covers: AR-REM-1..6, AR-CLS-1, AR-LAW-1, AR-LAW-2, AR-LAW-3, AR-LAW-5, AR-LAW-6
 */
#include "ref/scene.h"

static const int sizes[] = {16, 32, 64};

/* -------------------------------------------- results computed by hand */

static void assert_removed(const int16_t *voxels, const ost_geometry *g, const int32_t lo[3], const int32_t hi[3])
{
    for (int32_t z = 0; z < g->dims.z; z++)
        for (int32_t y = 0; y < g->dims.y; y++)
            for (int32_t x = 0; x < g->dims.x; x++) {
                bool gone = x >= lo[0] && x < hi[0] && y >= lo[1] && y < hi[1] && z >= lo[2] && z < hi[2];
                if ((voxels[x + g->dims.x * (y + g->dims.y * z)] == 0) != gone)
                    fail_msg("voxel (%d, %d, %d) was %s", x, y, z, gone ? "not removed" : "removed, but must remain");
            }
}

static void cube_removes_the_expected_voxels(void **state)
{
    /*
     * Bone voxels of 1 mm have their centres on integer millimetres. The tool is a cube of 2 mm. The tool's
     * grid is half-open in the tool's frame: at t = 2 the tool covers the centres 2 and 3, and at t = 2.5
     * the centres 3 and 4. After a quarter turn about z, the tool's y axis points along the bone's -x.
     * Therefore at t.x = 4 the tool covers -2 < x - 4 <= 0, which are the centres 3 and 4.
     */
    ost_error err = {0};
    const int32_t q = 759250125;
    const struct {
        ost_pose pose;
        int32_t lo[3], hi[3];
    } cases[] = {
        {{{2000 * UM, 3000 * UM, 4000 * UM}, OST_Q30_ONE, 0, 0, 0}, {2, 3, 4}, {4, 5, 6}},
        {{{2500 * UM, 3500 * UM, 4500 * UM}, OST_Q30_ONE, 0, 0, 0}, {3, 4, 5}, {5, 6, 7}},
        {{{4000 * UM, 3000 * UM, 4000 * UM}, q, 0, 0, q}, {3, 3, 4}, {5, 5, 6}},
        /* The tool extends across two borders of the bone. */
        {{{-1000 * UM, 7000 * UM, 0}, OST_Q30_ONE, 0, 0, 0}, {0, 7, 0}, {1, 8, 2}},
        {{{8000 * UM, 0, 0}, OST_Q30_ONE, 0, 0, 0}, {0, 0, 0}, {0, 0, 0}},
    };
    ost_geometry g = cubic_geometry(8, 8, 8, OST_PM_PER_MM, (ost_pm3){0, 0, 0});
    int16_t full[512];
    for (int i = 0; i < 512; i++)
        full[i] = 500;
    for (int voxels = 1; voxels <= 4; voxels *= 2) { /* The same cube has 1, 2 or 4 tool voxels per millimetre. */
        ost_tool *tool = solid_tool(
            *state, (ost_tool_geometry){{2 * voxels, 2 * voxels, 2 * voxels}, OST_PM_PER_MM / voxels, {0, 0, 0}},
            OST_TOOL_CUTTING);
        for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
            ost_bone *bone = bone_of(*state, &g, 16, full);
            ost_removal_report report = {0};
            remove_at(bone, &g, tool, &cases[i].pose, 1, &report);
            int16_t *after = content(bone, &g);
            assert_removed(after, &g, cases[i].lo, cases[i].hi);
            ost_bone_info info;
            assert_ok(ost_bone_info_get(bone, &info, &err));
            assert_int_equal(512 - info.active_voxels, report.total_voxels);
            free(after);
            ost_removal_report_free(&report);
            ost_bone_free(bone);
        }
        ost_tool_free(tool);
    }
}

static void counts_by_class_and_touched_voxels(void **state)
{
    /*
     * Five voxels in a row lie under three cutting tool voxels, one non-cutting voxel and one empty voxel.
     * The densities 150 and 650 lie exactly on class borders; 149 lies just below one.
     */
    ost_error err = {0};
    ost_geometry g = cubic_geometry(5, 1, 1, OST_PM_PER_MM, (ost_pm3){0, 0, 0});
    const int16_t voxels[] = {149, 150, 650, 700, 700};
    const uint8_t classes[] = {1, 1, 1, 2, 0};
    ost_tool_volume volume;
    assert_ok(ost_tool_volume_init(
        &volume, &(ost_tool_geometry){{5, 1, 1}, OST_PM_PER_MM, {-500 * UM, -500 * UM, -500 * UM}}, &err));
    memcpy(volume.voxels, classes, sizeof classes);
    ost_tool *tool;
    assert_ok(ost_tool_upload(*state, &volume, &tool, &err));
    ost_tool_volume_free(&volume);
    ost_pose poses[2] = {ost_pose_identity(), ost_pose_identity()};

    ost_bone *bone = bone_of(*state, &g, 32, voxels);
    ost_removal_report report = {0};
    remove_at(bone, &g, tool, poses, 1, &report);
    assert_int_equal(report.count, 1);
    assert_int_equal(report.chunks[0].chunk, 0);
    for (int c = 0; c < 3; c++)
        assert_int_equal(report.voxels[c], 1);
    assert_int_equal(report.density[0], 149);
    assert_int_equal(report.density[1], 150);
    assert_int_equal(report.density[2], 650);
    assert_int_equal(report.total_voxels, 3);
    assert_int_equal(report.touched_voxels, 1);
    int16_t *after = content(bone, &g);
    static const int16_t expected[] = {0, 0, 0, 700, 700};
    assert_memory_equal(after, expected, sizeof expected);
    free(after);
    ost_bone_free(bone);

    /*
     * The second pose is moved by one voxel. It cuts voxel 3, which therefore no longer counts as touched.
     * It touches voxel 4, which was under the empty voxel in the first pose.
     */
    poses[1].t.x = OST_PM_PER_MM;
    bone = bone_of(*state, &g, 32, voxels);
    remove_at(bone, &g, tool, poses, 2, &report);
    assert_int_equal(report.total_voxels, 4);
    assert_int_equal(report.touched_voxels, 1);
    ost_bone_free(bone);
    ost_removal_report_free(&report);
    ost_tool_free(tool);
}

static void emptied_chunk_is_freed(void **state)
{
    ost_error err = {0};
    ost_geometry g = cubic_geometry(40, 4, 4, OST_PM_PER_MM, (ost_pm3){0, 0, 0});
    int16_t voxels[40 * 16];
    for (int i = 0; i < 40 * 16; i++)
        voxels[i] = 200;
    ost_bone *bone = bone_of(*state, &g, 16, voxels);
    ost_tool *tool = solid_tool(*state, (ost_tool_geometry){{16, 16, 16}, OST_PM_PER_MM, {0, 0, 0}}, OST_TOOL_CUTTING);
    ost_pose pose = ost_pose_identity();
    pose.t = (ost_pm3){16 * OST_PM_PER_MM, -OST_PM_PER_MM, -OST_PM_PER_MM};
    ost_removal_report report = {0};
    remove_at(bone, &g, tool, &pose, 1, &report);
    ost_bone_info info;
    assert_ok(ost_bone_info_get(bone, &info, &err));
    assert_int_equal(info.active_chunks, 2);
    assert_int_equal(info.active_voxels, 24 * 16);
    assert_int_equal(report.count, 1);
    assert_int_equal(report.chunks[0].chunk, 1);
    assert_int_equal(report.chunks[0].voxels[1], 256);
    remove_at(bone, &g, tool, &pose, 1, &report);
    assert_int_equal(report.count, 0);
    ost_removal_report_free(&report);
    ost_tool_free(tool);
    ost_bone_free(bone);
}

/* -------------------------------------------------------- random scenes */

/* A bone of 70 x 37 x 41 voxels of 0.47 mm, and a random tool. The tool's positions lie between the opposite corners lo
   and hi of the bone's grid. */
typedef struct scene {
    ost_geometry g;
    int16_t *voxels;
    ost_tool *tool;
    ost_pm3 lo, hi;
} scene;

static scene make_scene(ost_backend *backend, test_rng *rng)
{
    static const ost_pm tool_voxels[] = {470 * UM, 235 * UM, 500 * UM, 30 * UM, 1000 * UM};
    scene s = {.g = cubic_geometry(70, 37, 41, 470 * UM, (ost_pm3){-57340 * UM, 3 * UM, 7})};
    ost_tool_geometry t = {
        {(int32_t)rng_range(rng, 1, 40), (int32_t)rng_range(rng, 1, 40), (int32_t)rng_range(rng, 1, 40)},
        tool_voxels[rng_range(rng, 0, 4)],
        {rng_range(rng, -9000, 0) * UM, rng_range(rng, -9000, 0) * UM, rng_range(rng, -9000, 0) * UM}};
    s.voxels = random_densities(rng, &s.g, (int)rng_range(rng, 1, 8));
    s.tool = random_tool(backend, rng, t);
    s.lo = s.g.origin;
    s.hi = (ost_pm3){s.lo.x + 70 * 470 * UM, s.lo.y + 37 * 470 * UM, s.lo.z + 41 * 470 * UM};
    return s;
}

static void free_scene(scene *s)
{
    ost_tool_free(s->tool);
    free(s->voxels);
}

static void chunk_size_does_not_change_the_result(void **state)
{
    test_rng rng = rng_seeded("chunk size");
    for (int round = 0; round < test_rounds(30); round++) {
        scene s = make_scene(*state, &rng);
        ost_pose poses[3];
        for (int k = 0; k < 3; k++)
            poses[k] = random_pose(&rng, s.lo, s.hi);
        ost_digest digests[3];
        int16_t *contents[3];
        ost_removal_report reports[3] = {0};
        for (int i = 0; i < 3; i++) {
            ost_bone *bone = bone_of(*state, &s.g, sizes[i], s.voxels);
            remove_at(bone, &s.g, s.tool, poses, 3, &reports[i]);
            digests[i] = digest_of(bone);
            contents[i] = content(bone, &s.g);
            ost_bone_free(bone);
        }
        for (int i = 1; i < 3; i++) {
            assert_true(ost_digest_equal(&digests[0], &digests[i]));
            assert_same_voxels(contents[i], contents[0], &s.g);
            assert_int_equal(reports[0].touched_voxels, reports[i].touched_voxels);
            assert_memory_equal(reports[0].voxels, reports[i].voxels, sizeof reports[0].voxels);
            assert_memory_equal(reports[0].density, reports[i].density, sizeof reports[0].density);
        }
        for (int i = 0; i < 3; i++) {
            free(contents[i]);
            ost_removal_report_free(&reports[i]);
        }
        free_scene(&s);
    }
}

static void report_equals_the_difference(void **state)
{
    test_rng rng = rng_seeded("report");
    const ost_density_classes classes = ost_density_classes_default();
    uint64_t removed = 0;
    for (int round = 0; round < test_rounds(30); round++) {
        scene s = make_scene(*state, &rng);
        int n = sizes[round % 3];
        ost_dims chunks = {(70 + n - 1) / n, (37 + n - 1) / n, (41 + n - 1) / n};
        ost_pose pose = random_pose(&rng, s.lo, s.hi);
        ost_bone *bone = bone_of(*state, &s.g, n, s.voxels);
        int16_t *before = content(bone, &s.g);
        ost_removal_report report = {0}, expected = {0};
        remove_at(bone, &s.g, s.tool, &pose, 1, &report);
        int16_t *after = content(bone, &s.g);
        ost_chunk_report *all = calloc((size_t)ost_dims_count(chunks), sizeof *all);
        for (size_t v = 0; v < voxel_count(&s.g); v++) {
            if (before[v] == after[v])
                continue;
            assert_int_equal(after[v], 0);
            int x = (int)(v % 70), y = (int)(v / 70 % 37), z = (int)(v / 70 / 37), c = 0;
            for (int k = 1; k < classes.count; k++)
                c += before[v] >= classes.border[k];
            ost_chunk_report *chunk = &all[x / n + chunks.x * (y / n + chunks.y * (z / n))];
            chunk->voxels[c]++;
            chunk->density[c] += before[v];
        }
        for (int32_t i = 0; i < (int32_t)ost_dims_count(chunks); i++) {
            all[i].chunk = i;
            if (all[i].voxels[0] || all[i].voxels[1] || all[i].voxels[2])
                assert_int_equal(ost_removal_report_add(&expected, &all[i], NULL), OST_OK);
        }
        expected.touched_voxels = report.touched_voxels;
        assert_same_report(&report, &expected);
        removed += report.total_voxels;
        free(all);
        free(before);
        free(after);
        ost_removal_report_free(&report);
        ost_removal_report_free(&expected);
        ost_bone_free(bone);
        free_scene(&s);
    }
    assert_true(removed > 0);
}

static void collision_report_equals_removal_report(void **state)
{
    ost_error err = {0};
    test_rng rng = rng_seeded("collide");
    for (int round = 0; round < test_rounds(30); round++) {
        scene s = make_scene(*state, &rng);
        ost_pose poses[2] = {random_pose(&rng, s.lo, s.hi), random_pose(&rng, s.lo, s.hi)};
        ost_bone *bone = bone_of(*state, &s.g, sizes[round % 3], s.voxels);
        ost_digest before = digest_of(bone);
        ost_removal_report collided = {0}, removed = {0};
        scene_event e;
        assert_ok(ost_bone_collide(bone, s.tool, event_of(&e, &s.g, s.tool, poses, 2), &collided, &err));
        ost_digest still = digest_of(bone);
        assert_true(ost_digest_equal(&before, &still));
        assert_ok(ost_bone_remove(bone, s.tool, &e.event, &removed, &err));
        assert_same_report(&collided, &removed);
        ost_digest after = digest_of(bone);
        assert_int_equal(ost_digest_equal(&before, &after), removed.total_voxels == 0);
        /* Removal must be idempotent: the touched voxels are still present, and the removed voxels are not. */
        assert_ok(ost_bone_remove(bone, s.tool, &e.event, &collided, &err));
        assert_int_equal(collided.count, 0);
        assert_int_equal(collided.total_voxels, 0);
        assert_int_equal(collided.touched_voxels, removed.touched_voxels);
        ost_digest again = digest_of(bone);
        assert_true(ost_digest_equal(&after, &again));
        ost_removal_report_free(&collided);
        ost_removal_report_free(&removed);
        ost_bone_free(bone);
        free_scene(&s);
    }
}

static void event_equals_separate_poses(void **state)
{
    test_rng rng = rng_seeded("sweep");
    ost_error err = {0};
    for (int round = 0; round < test_rounds(15); round++) {
        scene s = make_scene(*state, &rng);
        ost_pose a = random_pose(&rng, s.lo, s.hi), b = a;
        b.t.x += rng_range(&rng, -3000, 3000) * UM;
        b.t.z += rng_range(&rng, -3000, 3000) * UM;
        b.qx += (int32_t)rng_range(&rng, -400000, 400000);
        int n;
        assert_ok(ost_sweep_count(&a, &b, ost_tool_geometry_get(s.tool), s.g.spacing.x, &n, &err));
        assert_true(n <= SCENE_POSES);
        ost_pose poses[SCENE_POSES];
        for (int k = 1; k <= n; k++)
            poses[k - 1] = ost_sweep_pose(&a, &b, k, n);
        ost_bone *together = bone_of(*state, &s.g, 32, s.voxels), *single = bone_of(*state, &s.g, 32, s.voxels);
        ost_removal_report complete = {0}, part = {0};
        uint64_t voxels = 0;
        int64_t density = 0;
        remove_at(together, &s.g, s.tool, poses, n, &complete);
        for (int k = 0; k < n; k++) {
            remove_at(single, &s.g, s.tool, &poses[k], 1, &part);
            voxels += part.total_voxels;
            density += part.density[0] + part.density[1] + part.density[2];
        }
        ost_digest d1 = digest_of(together), d2 = digest_of(single);
        assert_true(ost_digest_equal(&d1, &d2));
        assert_int_equal(complete.total_voxels, voxels);
        assert_int_equal(complete.density[0] + complete.density[1] + complete.density[2], density);
        ost_removal_report_free(&complete);
        ost_removal_report_free(&part);
        ost_bone_free(together);
        ost_bone_free(single);
        free_scene(&s);
    }
}

static void events_commute_and_add_no_voxels(void **state)
{
    test_rng rng = rng_seeded("commute");
    for (int round = 0; round < test_rounds(20); round++) {
        scene s = make_scene(*state, &rng);
        ost_pose p = random_pose(&rng, s.lo, s.hi), q = random_pose(&rng, s.lo, s.hi);
        /* The second bone has fewer active voxels. Its remaining voxels must also remain in the first bone. */
        int16_t *fewer = malloc(voxel_count(&s.g) * sizeof *fewer);
        for (size_t i = 0; i < voxel_count(&s.g); i++)
            fewer[i] = rng_range(&rng, 0, 1) ? s.voxels[i] : 0;
        ost_bone *pq = bone_of(*state, &s.g, 16, s.voxels), *qp = bone_of(*state, &s.g, 64, s.voxels),
                 *sub = bone_of(*state, &s.g, 32, fewer);
        ost_removal_report report = {0};
        int16_t *start = content(pq, &s.g);
        remove_at(pq, &s.g, s.tool, &p, 1, &report);
        remove_at(sub, &s.g, s.tool, &p, 1, &report);
        int16_t *middle = content(pq, &s.g), *below = content(sub, &s.g);
        for (size_t i = 0; i < voxel_count(&s.g); i++) {
            assert_true(middle[i] == start[i] || middle[i] == 0);
            assert_true(below[i] == 0 || below[i] == middle[i]);
        }
        remove_at(pq, &s.g, s.tool, &q, 1, &report);
        remove_at(qp, &s.g, s.tool, &q, 1, &report);
        remove_at(qp, &s.g, s.tool, &p, 1, &report);
        ost_digest a = digest_of(pq), b = digest_of(qp);
        assert_true(ost_digest_equal(&a, &b));
        free(start);
        free(middle);
        free(below);
        free(fewer);
        ost_removal_report_free(&report);
        ost_bone_free(pq);
        ost_bone_free(qp);
        ost_bone_free(sub);
        free_scene(&s);
    }
}

static void translation_does_not_change_the_result(void **state)
{
    /*
     * Moving the bone's origin and the pose by the same vector must not change the result. Moving the
     * voxels within the grid by complete blocks, together with the tool, must give the same result at the
     * new position.
     */
    test_rng rng = rng_seeded("moved");
    for (int round = 0; round < test_rounds(20); round++) {
        scene s = make_scene(*state, &rng);
        ost_pose pose = random_pose(&rng, s.lo, s.hi);
        ost_removal_report here = {0}, there = {0};
        ost_bone *bone = bone_of(*state, &s.g, 32, s.voxels);
        remove_at(bone, &s.g, s.tool, &pose, 1, &here);
        int16_t *expected = content(bone, &s.g);

        ost_geometry g = s.g;
        ost_pose moved = pose;
        const ost_pm3 by = {rng_range(&rng, -1000000, 1000000), rng_range(&rng, -OST_PM_PER_MM, OST_PM_PER_MM), 1};
        g.origin = (ost_pm3){g.origin.x + by.x, g.origin.y + by.y, g.origin.z + by.z};
        moved.t = (ost_pm3){pose.t.x + by.x, pose.t.y + by.y, pose.t.z + by.z};
        ost_bone *other = bone_of(*state, &g, 32, s.voxels);
        remove_at(other, &g, s.tool, &moved, 1, &there);
        int16_t *found = content(other, &g);
        assert_same_voxels(found, expected, &g);
        assert_same_report(&here, &there);
        free(found);
        ost_bone_free(other);

        const int32_t bx = 16 * (int32_t)rng_range(&rng, 0, 2), by16 = 16 * (int32_t)rng_range(&rng, 0, 2), bz = 16;
        g = cubic_geometry(70 + bx, 37 + by16, 41 + bz, s.g.spacing.x, s.g.origin);
        int16_t *shifted = calloc(voxel_count(&g), sizeof *shifted);
        for (int32_t z = 0; z < 41; z++)
            for (int32_t y = 0; y < 37; y++)
                memcpy(shifted + bx + g.dims.x * (y + by16 + g.dims.y * (z + bz)), s.voxels + 70 * (y + 37 * z),
                       70 * sizeof *shifted);
        moved = pose;
        moved.t = (ost_pm3){pose.t.x + bx * g.spacing.x, pose.t.y + by16 * g.spacing.x, pose.t.z + bz * g.spacing.x};
        other = bone_of(*state, &g, 64, shifted);
        remove_at(other, &g, s.tool, &moved, 1, &there);
        found = content(other, &g);
        for (int32_t z = 0; z < 41; z++)
            for (int32_t y = 0; y < 37; y++)
                assert_memory_equal(found + bx + g.dims.x * (y + by16 + g.dims.y * (z + bz)),
                                    expected + 70 * (y + 37 * z), 70 * sizeof *found);
        assert_int_equal(here.total_voxels, there.total_voxels);
        assert_int_equal(here.touched_voxels, there.touched_voxels);
        free(found);
        free(shifted);
        free(expected);
        ost_bone_free(other);
        ost_bone_free(bone);
        ost_removal_report_free(&here);
        ost_removal_report_free(&there);
        free_scene(&s);
    }
}

/*
 * Returns the pose p rotated by a quarter turn about `axis`, with the translation t. The rotation
 * of p must be one of the 24 rotations of a cube.
 */
static ost_pose quarter_turned(const ost_pose *p, int axis, ost_pm3 t)
{
    const int64_t q[4] = {p->qw, p->qx, p->qy, p->qz};
    /* u is the quarter turn (1 + k) / sqrt(2) without the factor 1 / sqrt(2). The product is scaled below. */
    int64_t u[4] = {1, 0, 0, 0}, r[4];
    u[1 + axis] = 1;
    r[0] = u[0] * q[0] - u[1] * q[1] - u[2] * q[2] - u[3] * q[3];
    r[1] = u[0] * q[1] + u[1] * q[0] + u[2] * q[3] - u[3] * q[2];
    r[2] = u[0] * q[2] - u[1] * q[3] + u[2] * q[0] + u[3] * q[1];
    r[3] = u[0] * q[3] + u[1] * q[2] - u[2] * q[1] + u[3] * q[0];
    /*
     * All nonzero components of such a quaternion have the same magnitude. The number of nonzero
     * components determines it.
     */
    int nonzero = 0;
    for (int c = 0; c < 4; c++)
        nonzero += r[c] != 0;
    int64_t unit = nonzero == 1 ? OST_Q30_ONE : nonzero == 2 ? 759250125 : OST_Q30_ONE / 2;
    for (int c = 0; c < 4; c++)
        r[c] = r[c] == 0 ? 0 : r[c] > 0 ? unit : -unit;
    return (ost_pose){t, (int32_t)r[0], (int32_t)r[1], (int32_t)r[2], (int32_t)r[3]};
}

static void quarter_turns_rotate_the_result(void **state)
{
    /*
     * A cube of 24^3 voxels around the frame's origin is rotated together with the tool by nine quarter turns,
     * about each axis in turn. The centres of the bone voxels of 1 mm are at odd multiples of 1/2 mm.
     * The borders of the tool voxels of 1/2 mm are at multiples of 1/2 mm relative to the pose. The
     * translation t consists of odd multiples of 1/4 mm, so that each centre is 1/4 mm from the nearest
     * border. This distance is far greater than the error of the map (AR-MAP-6).
     */
    enum { N = 24 };
    test_rng rng = rng_seeded("quarter turns");
    ost_geometry g = cubic_geometry(N, N, N, OST_PM_PER_MM, (ost_pm3){-11500 * UM, -11500 * UM, -11500 * UM});
    int16_t *voxels = random_densities(&rng, &g, 5), *turned = malloc(voxel_count(&g) * sizeof *turned);
    ost_tool *tool = random_tool(*state, &rng,
                                 (ost_tool_geometry){{17, 24, 30}, 500 * UM, {-3000 * UM, -4500 * UM, -2000 * UM}});
    ost_pose pose = ost_pose_identity();
    pose.t = (ost_pm3){rng_range(&rng, -10, 10) * 500 * UM + 250 * UM, rng_range(&rng, -10, 10) * 500 * UM + 250 * UM,
                       rng_range(&rng, -10, 10) * 500 * UM + 250 * UM};
    uint64_t total = 0;
    for (int step = 0; step < 9; step++) {
        int axis = step % 3, a = (axis + 1) % 3, b = (axis + 2) % 3;
        ost_bone *bone = bone_of(*state, &g, 16, voxels);
        ost_removal_report before = {0}, after = {0};
        remove_at(bone, &g, tool, &pose, 1, &before);
        int16_t *left = content(bone, &g);

        /* The turn maps axis a to b, and b to -a. The voxel with the coordinates (i_a, i_b) moves to (N - 1 - i_b,
           i_a). */
        int16_t *left_turned = malloc(voxel_count(&g) * sizeof *left_turned);
        for (int v = 0; v < N * N * N; v++) {
            int at[3] = {v % N, v / N % N, v / N / N}, to[3];
            to[axis] = at[axis];
            to[b] = at[a];
            to[a] = N - 1 - at[b];
            turned[to[0] + N * (to[1] + N * to[2])] = voxels[v];
            left_turned[to[0] + N * (to[1] + N * to[2])] = left[v];
        }
        const int64_t t[3] = {pose.t.x, pose.t.y, pose.t.z};
        int64_t moved[3];
        moved[axis] = t[axis];
        moved[b] = t[a];
        moved[a] = -t[b];
        pose = quarter_turned(&pose, axis, (ost_pm3){moved[0], moved[1], moved[2]});

        ost_bone *other = bone_of(*state, &g, 32, turned);
        remove_at(other, &g, tool, &pose, 1, &after);
        int16_t *found = content(other, &g);
        assert_same_voxels(found, left_turned, &g);
        assert_int_equal(before.total_voxels, after.total_voxels);
        assert_int_equal(before.touched_voxels, after.touched_voxels);
        total += before.total_voxels;
        memcpy(voxels, turned, voxel_count(&g) * sizeof *voxels);
        free(found);
        free(left);
        free(left_turned);
        ost_removal_report_free(&before);
        ost_removal_report_free(&after);
        ost_bone_free(bone);
        ost_bone_free(other);
    }
    assert_true(total > 0);
    ost_tool_free(tool);
    free(turned);
    free(voxels);
}

static void unordered_class_borders_are_refused(void **state)
{
    ost_error err = {0};
    ost_geometry g = cubic_geometry(4, 4, 4, 1000 * UM, (ost_pm3){0, 0, 0});
    ost_bone *bone;
    assert_ok(ost_bone_create(*state, &g, 32, 120, &bone, &err));
    ost_tool *tool = solid_tool(*state, (ost_tool_geometry){{4, 4, 4}, 1000 * UM, {0, 0, 0}}, OST_TOOL_CUTTING);
    ost_pose pose = ost_pose_identity();
    scene_event *e = malloc(sizeof *e);
    assert_non_null(e);
    const ost_removal_event *event = event_of(e, &g, tool, &pose, 1);
    ost_removal_report report = {0};
    assert_ok(ost_bone_collide(bone, tool, event, &report, &err));
    e->classes.border[2] = e->classes.border[1];
    assert_int_equal(ost_bone_collide(bone, tool, event, &report, NULL), OST_ERR_USAGE);
    assert_int_equal(ost_bone_remove(bone, tool, event, &report, &err), OST_ERR_USAGE);
    assert_string_equal(err.text, "density class 2 begins at 150, which is not above 150");
    e->classes.border[2] = 650;
    e->classes.border[0] = 0;
    assert_int_equal(ost_bone_collide(bone, tool, event, &report, NULL), OST_ERR_USAGE);
    free(e);
    ost_removal_report_free(&report);
    ost_tool_free(tool);
    ost_bone_free(bone);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(cube_removes_the_expected_voxels),
        cmocka_unit_test(counts_by_class_and_touched_voxels),
        cmocka_unit_test(emptied_chunk_is_freed),
        cmocka_unit_test(chunk_size_does_not_change_the_result),
        cmocka_unit_test(report_equals_the_difference),
        cmocka_unit_test(collision_report_equals_removal_report),
        cmocka_unit_test(event_equals_separate_poses),
        cmocka_unit_test(events_commute_and_add_no_voxels),
        cmocka_unit_test(translation_does_not_change_the_result),
        cmocka_unit_test(quarter_turns_rotate_the_result),
        cmocka_unit_test(unordered_class_borders_are_refused),
    };
    return run_on_backends(tests, open_test_backend, close_test_backend);
}
