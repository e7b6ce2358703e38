/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests the metrics of a tool and its path. The times, lengths, forces, tilts and plunges of a known path are compared
 * with closed forms. The properties of tools made of boxes are compared with the sizes of the boxes. The position of a
 * tool's tip at a pose is compared with values computed by hand.
 *
 * Covers: REQ-METRICS
 */
#include "near.h"

/*
 * The tool moves 8 mm through air and 3 mm into bone at 1.5 mm/s, makes two turns of 5 mm radius
 * about the axis, plunges 2 mm at 40 mm/s, and leaves.
 */
static void path_and_contact_of_tool(void **state)
{
    (void)state;
    enum {
        AIR = 400,
        ADVANCE = 2000,
        TURNS = 4000,
        PLUNGE = 50,
        OUT = 650,
        ALL = AIR + ADVANCE + TURNS + PLUNGE + OUT
    };
    static ost_motion m[ALL + 1];
    const ost_metrics_plan plan = {.axis = {0, 0, -2}, .depth_mm = 3};
    ost_technique t;
    ost_error err = {0};
    for (int i = 0; i <= ALL; i++) {
        const double advance = fmin(fmax(i - AIR, 0), ADVANCE) * 1.5e-3,
                     plunge = fmin(fmax(i - AIR - ADVANCE - TURNS, 0), PLUNGE) * 0.04;
        const double out = fmax(i - AIR - ADVANCE - TURNS - PLUNGE, 0) * 0.02,
                     turn = fmin(fmax(i - AIR - ADVANCE, 0), TURNS) * 4 * PI / TURNS;
        const double depth = -8 + fmin(i, AIR) * 0.02 + advance + plunge - out;
        const bool in = i >= AIR && i <= AIR + ADVANCE + TURNS + PLUNGE;
        m[i] = (ost_motion){.t_s = i * 1e-3,
                            .mm = {5 * cos(turn), 5 * sin(turn), -depth},
                            .axis = {sin(PI / 18), 0, -cos(PI / 18)},
                            .force_n = in ? i % 2 ? 1.5 : 2.5 : 0,
                            .removed = in && i % 3 == 0 ? 10u : 0u};
    }
    m[AIR + 1000].force_n = 4;
    assert_ok(ost_technique_make(m, ALL + 1, &plan, &t, &err));
    NEAR(t.seconds, ALL * 1e-3, 1e-9);
    /*
     * The path is measured between positions that are 20 ms apart. If the tool reverses its direction
     * between two positions, the distance that it covers in these 20 ms is not measured completely.
     */
    NEAR(t.path_mm, 8 + 3 + 2 * 2 * PI * 5 + 2 + 13, 0.8);
    NEAR(t.contact_s, (ADVANCE + TURNS + PLUNGE) * 1e-3, 1e-9);
    NEAR(t.contact_path_mm, 3 + 2 * 2 * PI * 5 + 2, 0.5);
    NEAR(t.cutting_s, t.contact_s, 0.004);
    assert_int_equal(t.contacts, 1);
    assert_int_equal(t.passes, 1);
    assert_true(t.felt);
    NEAR(t.force_mean_n, 2, 0.01);
    NEAR(t.force_p95_n, 2.5, 1e-9);
    NEAR(t.force_max_n, 4, 1e-9);
    NEAR(t.tilt_mean_deg, 10, 1e-6);
    NEAR(t.tilt_max_deg, 10, 1e-6);
    NEAR(t.inward_max_mm_s, 40, 1e-6);
    assert_int_equal(t.plunges, 1);
    NEAR(t.plunge_mm, 2, 0.05);
    /*
     * The built-in paths advance at 20 mm/s in contact. An advance at this speed must not count as a plunge.
     * The axis here is oblique, so that the steps are rounded.
     */
    const ost_metrics_plan oblique = {.axis = {0.817462, 0.406924, -0.407639}};
    for (int i = 0; i <= ALL; i++) {
        for (int a = 0; a < 3; a++)
            m[i].mm[a] = rint(i * 0.02 * oblique.axis[a] * 1e9 + (i * 7919 % 13)) / 1e9;
        m[i].removed = 1;
    }
    assert_ok(ost_technique_make(m, ALL + 1, &oblique, &t, &err));
    NEAR(t.inward_max_mm_s, 20, 0.01);
    assert_int_equal(t.plunges, 0);
    /*
     * For one second, the tool advances faster, and its speed varies around the limit for a plunge.
     * This must count as one plunge.
     */
    for (int i = 0; i <= ALL; i++)
        for (int a = 0; a < 3; a++)
            m[i].mm[a] = (fmin(i, 1000) * 0.025 + (i < 1000 ? 0.05 * sin(i * 0.5) : 0)) * oblique.axis[a];
    assert_ok(ost_technique_make(m, ALL + 1, &oblique, &t, &err));
    assert_int_equal(t.plunges, 1);
    for (int i = 0; i <= ALL; i++)
        for (int a = 0; a < 3; a++)
            m[i].mm[a] = 0;
    /*
     * The tool is lifted off the bone for some time in the middle. A lift of 0.3 s gives two contacts and
     * one pass. A lift of 0.6 s gives two contacts and two passes. There is no force in the recording.
     */
    for (int lift = 300; lift <= 600; lift += 300) {
        for (int i = 0; i <= ALL; i++) {
            m[i].force_n = 0;
            m[i].removed = i >= AIR && i < AIR + ADVANCE && !(i > 1000 && i < 1000 + lift) ? 1 : 0;
        }
        assert_ok(ost_technique_make(m, ALL + 1, &plan, &t, &err));
        assert_int_equal(t.contacts, 2);
        assert_int_equal(t.passes, lift / 300);
        assert_false(t.felt);
        assert_int_equal(t.plunges, 0);
    }
    assert_ok(ost_technique_make(m, 0, &plan, &t, &err));
    assert_true(t.contacts == 0 && t.path_mm == 0);
}

/*
 * The cutting part of each tool is a box of 1 mm voxels. A shaft of voxels that do not cut surrounds the box and
 * extends above and below it.
 */
static void properties_of_tools(void **state)
{
    (void)state;
    enum { SIDE = 40 };
    static const struct {
        int from[3], size[3]; /* first voxel and size of the box, in voxels */
        ost_metrics_tool expected;
    } cases[] = {
        {{4, 10, 3}, {16, 5, 2}, {OST_METRICS_REAMER, 8, 2, {0, 0, -7}}},
        {{10, 4, 3}, {5, 17, 36}, {OST_METRICS_REAMER, 8.5, 36, {0, 0, -7}}},
        {{4, 10, 3}, {15, 5, 30}, {OST_METRICS_DRILL, 7.5, 30, {0, 0, -7}}},
        {{4, 10, 3}, {15, 5, 29}, {OST_METRICS_OTHER, 7.5, 29, {0, 0, -7}}},
        /* In the next two cases, the axis of the frame, x = y = 0, is outside the box. In the last case, it lies
           along an edge of the box. */
        {{11, 3, 20}, {4, 4, 8}, {OST_METRICS_DRILL, 2, 8, {3, -7, 10}}},
        {{1, 13, 0}, {4, 2, 7}, {OST_METRICS_OTHER, 2, 7, {-7, 2, -10}}},
        {{10, 8, 0}, {4, 4, 7}, {OST_METRICS_OTHER, 2, 7, {0, 0, -10}}},
    };
    ost_error err = {0};
    ost_backend *backend = NULL;
    ost_tool_volume volume;
    const ost_tool_geometry g = {.dims = {SIDE, SIDE, SIDE}, .voxel = MM, .corner = {-10 * MM, -12 * MM, -10 * MM}};
    assert_ok(ost_backend_open("ref", &backend, &err));
    assert_ok(ost_tool_volume_init(&volume, &g, &err));
    for (size_t n = 0; n <= sizeof cases / sizeof cases[0]; n++) {
        const bool empty = n == sizeof cases / sizeof cases[0];
        ost_metrics_tool found;
        ost_tool *tool = NULL;
        for (int z = 0, i = 0; z < SIDE; z++)
            for (int y = 0; y < SIDE; y++)
                for (int x = 0; x < SIDE; x++, i++) {
                    const int at[3] = {x, y, z};
                    bool in = !empty;
                    for (int a = 0; a < 3 && in; a++)
                        in = at[a] >= cases[n].from[a] && at[a] < cases[n].from[a] + cases[n].size[a];
                    volume.voxels[i] = in ? OST_TOOL_CUTTING : OST_TOOL_NONCUTTING;
                }
        assert_ok(ost_tool_upload(backend, &volume, &tool, &err));
        assert_ok(ost_metrics_tool_make(tool, &found, &err));
        const ost_metrics_tool *expected = empty ? &(ost_metrics_tool){.kind = OST_METRICS_OTHER} : &cases[n].expected;
        print_message("tool %zu\n", n);
        assert_int_equal(found.kind, expected->kind);
        NEAR(found.radius_mm, expected->radius_mm, 1e-9);
        NEAR(found.length_mm, expected->length_mm, 1e-9);
        for (int a = 0; a < 3; a++)
            NEAR(found.tip_mm[a], expected->tip_mm[a], 1e-9);
        ost_tool_free(tool);
    }
    ost_tool_volume_free(&volume);
    ost_backend_close(backend);
}

/* A turn by 90 degrees about x maps y to z, and z to -y. The pose's quaternion need not have the length 1. */
static void tip_at_pose(void **state)
{
    (void)state;
    const ost_metrics_tool tool = {.tip_mm = {1, 2, 3}};
    double mm[3], axis[3];
    ost_pose pose = ost_pose_identity();
    ost_metrics_tip(&tool, &pose, mm, axis);
    for (int a = 0; a < 3; a++) {
        NEAR(mm[a], a + 1, 1e-9);
        NEAR(axis[a], a == 2 ? -1 : 0, 1e-9);
    }
    pose.t = (ost_pm3){10 * MM, 20 * MM, 30 * MM};
    pose.qw = pose.qx = 759000000; /* 2^30 / sqrt(2) is 759,250,125 */
    ost_metrics_tip(&tool, &pose, mm, axis);
    NEAR(mm[0], 11, 1e-9);
    NEAR(mm[1], 17, 1e-9);
    NEAR(mm[2], 32, 1e-9);
    NEAR(axis[1], 1, 1e-9);
    NEAR(fabs(axis[0]) + fabs(axis[2]), 0, 1e-9);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(path_and_contact_of_tool),
        cmocka_unit_test(properties_of_tools),
        cmocka_unit_test(tip_at_pose),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
