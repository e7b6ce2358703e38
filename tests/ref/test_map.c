/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Compares sweep and map with values computed by hand or by other programs. In addition, tests/oracle
 * compares thousands of random cases with another implementation.
 * Covers: AR-SWEEP-1..6, AR-MAP-1..5, AR-POSE-4
 */
#include "ref/scene.h"

static const ost_tool_geometry small_tool = {{10, 20, 30}, OST_PM_PER_MM / 2, {-2500000000, -5000000000, 0}};

static ost_pose at_um(int64_t x, int64_t y, int64_t z)
{
    ost_pose pose = ost_pose_identity();
    pose.t = (ost_pm3){x * UM, y * UM, z * UM};
    return pose;
}

static int count_of(const ost_pose *a, const ost_pose *b, const ost_tool_geometry *tool, ost_pm voxel)
{
    ost_error err = {0};
    int count = -1;
    assert_ok(ost_sweep_count(a, b, tool, voxel, &count, &err));
    return count;
}

static void sweep_of_the_worked_example(void **state)
{
    (void)state;
    ost_pose a = at_um(0, 0, 0), b = at_um(300, 400, 0);
    assert_int_equal(count_of(&a, &b, &small_tool, 470 * UM), 3);
    ost_pose p = ost_sweep_pose(&a, &b, 1, 3);
    assert_int_equal(p.t.x, 100000000);
    assert_int_equal(p.t.y, 133333333);
    p = ost_sweep_pose(&a, &b, 2, 3);
    assert_int_equal(p.t.y, 266666667);
    p = ost_sweep_pose(&a, &b, 3, 3);
    assert_memory_equal(&p, &b, sizeof p);
}

static void pose_count_is_the_least(void **state)
{
    (void)state;
    /* The sweep of a motion of exactly n half voxels has n poses. If the motion is 1 pm longer, it has n + 1 poses. */
    ost_pose a = at_um(10, 20, 30);
    assert_int_equal(count_of(&a, &a, &small_tool, 470 * UM), 1);
    for (int n = 1; n <= OST_SWEEP_MAX; n = n < 8 ? n + 1 : 2 * n) {
        ost_pose b = a;
        b.t.y -= n * 235 * UM;
        assert_int_equal(count_of(&a, &b, &small_tool, 470 * UM), n);
        b.t.y--;
        int count;
        ost_status status = ost_sweep_count(&a, &b, &small_tool, 470 * UM, &count, NULL);
        if (n == OST_SWEEP_MAX)
            assert_int_equal(status, OST_ERR_RANGE);
        else
            assert_int_equal(count, n + 1);
    }
}

static void rotation_moves_the_corners(void **state)
{
    /*
     * An exact quarter turn of 90 degrees about z, q = (c, 0, 0, c), is allowed. The farthest
     * corner in the plane is (+-2.5, +-5). It moves by the chord sqrt(2) * |(2.5, 5)| = sqrt(2 *
     * 31.25) = 7.90569 mm. With voxels of 0.47 mm, the number of poses is therefore ceil(2 * 7.90569 /
     * 0.47) = ceil(33.64) = 34.
     */
    (void)state;
    ost_pose a = at_um(0, 0, 0), b = a;
    b.qw = b.qz = 759250125; /* 2^30 / sqrt(2) */
    ost_pose c = {.qw = 759250124, .qz = 759250126}; /* slightly more than a quarter turn */
    assert_int_equal(count_of(&a, &b, &small_tool, 470 * UM), 34);
    int count;
    assert_int_equal(ost_sweep_count(&a, &c, &small_tool, 470 * UM, &count, NULL), OST_ERR_RANGE);
    /* The quaternions -q and q are the same rotation, so there is no rotation between the two poses. */
    ost_pose minus = {.t = a.t, .qw = -a.qw};
    assert_int_equal(count_of(&a, &minus, &small_tool, 470 * UM), 1);
    /*
     * The sweep interpolates the shorter rotation. The components are (759,250,125 + 2^30) / 2 =
     * 916,495,974.5 and 759,250,125 / 2 = 379,625,062.5, both rounded to even.
     */
    ost_pose half = ost_sweep_pose(&b, &minus, 1, 2);
    assert_int_equal(half.qw, 916495974);
    assert_int_equal(half.qz, 379625062);
}

static void map_of_the_worked_example(void **state)
{
    /* Checks the worked example of docs/spec/arithmetic.md section 12. */
    (void)state;
    ost_error err = {0};
    ost_geometry bone = cubic_geometry(256, 234, 428, 470 * UM, (ost_pm3){-57340 * UM, -54755 * UM, 0});
    ost_tool_geometry tool = {{73, 74, 43}, 500 * UM, {-18500 * UM, -18500 * UM, -500 * UM}};
    ost_pose pose = {.t = {12000 * UM, -7500 * UM, 30250 * UM}, .qw = 858993459, .qy = 644245094};
    static const int32_t steps[3][3] = {{275985, 0, 946235}, {0, 985661, 0}, {-946235, 0, 275985}};
    static const int32_t base[3] = {38164811, 34319892, -2393270};
    ost_map map;
    assert_ok(ost_map_make(&pose, &bone, &tool, &map, &err));
    assert_memory_equal(map.step, steps, sizeof steps);
    int32_t found[3];
    assert_true(ost_map_block_base(&map, (ost_dims){9, 6, 4}, found));
    assert_memory_equal(found, base, sizeof base);
}

static void quarter_turns_are_exact(void **state)
{
    /*
     * With bone voxels of 1 mm and tool voxels of 1/2 mm, each step is two tool voxels along the rotated
     * axis, for any length of the quaternion.
     */
    (void)state;
    ost_error err = {0};
    ost_geometry bone = cubic_geometry(64, 64, 64, OST_PM_PER_MM, (ost_pm3){0, 0, 0});
    static const int32_t lengths[] = {759250125, 759250000, 758600000, 759900000};
    for (size_t i = 0; i < 4; i++) {
        ost_pose pose = {.t = {OST_PM_PER_MM, 0, 0}, .qw = lengths[i], .qz = lengths[i]};
        ost_map map;
        assert_ok(ost_map_make(&pose, &bone, &small_tool, &map, &err));
        /* The tool's x axis is the bone's y, and its y axis is the bone's -x: R' is R transposed. */
        static const int32_t two = 2 << 20;
        const int32_t steps[3][3] = {{0, -two, 0}, {two, 0, 0}, {0, 0, two}};
        assert_memory_equal(map.step, steps, sizeof steps);
        int32_t base[3];
        assert_true(ost_map_block_base(&map, (ost_dims){1, 2, 3}, base));
        /*
         * The vector p - t is (15, 32, 48) mm, which is (32, -15, 48) mm in the tool's frame. Relative to
         * the tool's corner this is (34.5, -10, 48) mm, or (69, -20, 96) half millimetres.
         */
        assert_int_equal(base[0], 69 << 20);
        assert_int_equal(base[1], -(20 << 20));
        assert_int_equal(base[2], 96 << 20);
    }
}

static void far_blocks_are_reported(void **state)
{
    /* For each limit of AR-MAP-5, tests the last near base along x and the first far base, which differ by one unit
       (2^-20 of a voxel). The voxels of bone and tool are 2^30 pm wide. */
    (void)state;
    ost_error err = {0};
    const ost_pm v = INT64_C(1) << 30; /* 2^-20 of this voxel is 1,024 pm */
    ost_geometry bone = cubic_geometry(16, 16, 16, v, (ost_pm3){0, 0, 0});
    ost_tool_geometry tool = {{4, 4, 4}, v, {0, 0, 0}};
    const struct {
        int64_t base;
        bool near;
    } cases[] = {{-(INT64_C(1) << 29), true},
                 {-(INT64_C(1) << 29) - 1, false},
                 {(INT64_C(3) << 29) - 1, true},
                 {INT64_C(3) << 29, false}};
    for (size_t i = 0; i < 4; i++) {
        ost_pose pose = ost_pose_identity();
        pose.t.x = -cases[i].base * 1024;
        ost_map map;
        assert_ok(ost_map_make(&pose, &bone, &tool, &map, &err));
        int32_t base[3];
        assert_int_equal(ost_map_block_base(&map, (ost_dims){0, 0, 0}, base), cases[i].near);
        if (cases[i].near)
            assert_int_equal(base[0], cases[i].base);
    }
}

static void ties_of_the_base_go_to_even(void **state)
{
    /* Half a unit of 2^-20 is 512 pm here. The bases are +-0.5, +-1.5 and +-2.5 units. */
    (void)state;
    ost_error err = {0};
    const ost_pm v = INT64_C(1) << 30;
    ost_geometry bone = cubic_geometry(16, 16, 16, v, (ost_pm3){0, 0, 0});
    ost_tool_geometry tool = {{4, 4, 4}, v, {0, 0, 0}};
    static const int expected[] = {-2, -2, 0, 0, 2, 2};
    for (int i = 0; i < 6; i++) {
        ost_pose pose = ost_pose_identity();
        pose.t.x = -(2 * i - 5) * 512;
        ost_map map;
        int32_t base[3];
        assert_ok(ost_map_make(&pose, &bone, &tool, &map, &err));
        assert_true(ost_map_block_base(&map, (ost_dims){0, 0, 0}, base));
        assert_int_equal(base[0], expected[i]);
    }
}

static void refuses_values_beyond_the_proved_ranges(void **state)
{
    (void)state;
    ost_map map;
    int count;
    ost_pose pose = ost_pose_identity(), broken = {.qw = INT32_MIN, .qx = INT32_MIN, .qy = INT32_MAX, .qz = INT32_MIN};
    ost_pose far = pose;
    far.t.z = OST_LENGTH_MAX + 1;
    ost_geometry bone = cubic_geometry(8, 8, 8, 16 * UM, (ost_pm3){0, 0, 0});
    ost_tool_geometry tool = {{1024, 1, 1}, UM, {0, 0, 0}}, wide = {{1025, 1, 1}, UM, {0, 0, 0}};
    assert_int_equal(ost_map_make(&pose, &bone, &tool, &map, NULL), OST_OK);
    assert_int_equal(map.step[0][0], 16 << 20);
    assert_int_equal(ost_map_make(&pose, &bone, &wide, &map, NULL), OST_ERR_RANGE);
    wide.dims = (ost_dims){1, 1025, 1};
    assert_int_equal(ost_map_make(&pose, &bone, &wide, &map, NULL), OST_ERR_RANGE);
    wide.dims = (ost_dims){1, 1, 1025};
    assert_int_equal(ost_map_make(&pose, &bone, &wide, &map, NULL), OST_ERR_RANGE);
    assert_int_equal(ost_map_make(&broken, &bone, &tool, &map, NULL), OST_ERR_RANGE);
    assert_int_equal(ost_map_make(&far, &bone, &tool, &map, NULL), OST_ERR_RANGE);
    assert_int_equal(ost_sweep_count(&pose, &broken, &tool, 16 * UM, &count, NULL), OST_ERR_RANGE);
    assert_int_equal(ost_sweep_count(&far, &pose, &tool, 16 * UM, &count, NULL), OST_ERR_RANGE);
    /* An uninitialized pose has the quaternion zero, for which N, the divisor, would be 0. */
    const ost_pose empty = {0};
    assert_int_equal(ost_map_make(&empty, &bone, &tool, &map, NULL), OST_ERR_RANGE);
    assert_int_equal(ost_sweep_count(&empty, &empty, &tool, 16 * UM, &count, NULL), OST_ERR_RANGE);
    assert_int_equal(ost_sweep_count(&pose, &empty, &tool, 16 * UM, &count, NULL), OST_ERR_RANGE);
    assert_int_equal(ost_sweep_count(&empty, &pose, &tool, 16 * UM, &count, NULL), OST_ERR_RANGE);
    bone = cubic_geometry(8, 8, 8, 16 * UM + 1, (ost_pm3){0, 0, 0});
    assert_int_equal(ost_map_make(&pose, &bone, &tool, &map, NULL), OST_ERR_RANGE);
    bone.spacing.z = 16 * UM;
    assert_int_equal(ost_map_make(&pose, &bone, &tool, &map, NULL), OST_ERR_USAGE);
}

/*
 * Tests boxes of 1 mm that extend from the origin into each octant, rotated by a quarter turn about each
 * axis. The corner that is farthest from the axis moves by the chord sqrt(2) * |(1, 1)| = 2 mm, so a voxel
 * size of 0.47 mm gives n = ceil(4 / 0.47) = ceil(8.51) = 9. Any other corner would give ceil(6.02) = 7 or
 * less.
 */
static void every_corner_is_considered(void **state)
{
    (void)state;
    const ost_pose a = at_um(0, 0, 0);
    for (int octant = 0; octant < 8; octant++) {
        const ost_tool_geometry tool = {
            {10, 10, 10},
            OST_PM_PER_MM / 10,
            {octant & 1 ? 0 : -OST_PM_PER_MM, octant & 2 ? 0 : -OST_PM_PER_MM, octant & 4 ? 0 : -OST_PM_PER_MM}};
        const int32_t quarter = 759250125; /* 2^30 / sqrt(2) */
        const ost_pose about[3] = {
            {.qw = quarter, .qx = quarter}, {.qw = quarter, .qy = quarter}, {.qw = quarter, .qz = quarter}};
        for (int axis = 0; axis < 3; axis++)
            assert_int_equal(count_of(&a, &about[axis], &tool, 470 * UM), 9);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sweep_of_the_worked_example),
        cmocka_unit_test(pose_count_is_the_least),
        cmocka_unit_test(rotation_moves_the_corners),
        cmocka_unit_test(every_corner_is_considered),
        cmocka_unit_test(map_of_the_worked_example),
        cmocka_unit_test(quarter_turns_are_exact),
        cmocka_unit_test(far_blocks_are_reported),
        cmocka_unit_test(ties_of_the_base_go_to_even),
        cmocka_unit_test(refuses_values_beyond_the_proved_ranges),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
