/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests the step of a world: sweep, tool switching, motor, removal period, errors and totals.
 * Covers: AR-SWEEP-5, AR-SWEEP-6, AR-REM-7, AR-MOTOR-1, AR-MOTOR-5, AR-MOTOR-6
 */
#include "ref/scene.h"

#include <osteon/sim.h>

typedef struct fixture {
    ost_geometry g;
    ost_bone *bone;
    ost_tool *peg, *plate;
    ost_world *world;
} fixture;

/* Makes a bone of 40 x 20 x 20 mm with voxels of 1 mm, a peg of 2 x 2 x 6 mm, and a plate of 6 x 6 x 1 mm. */
static fixture make_fixture(ost_backend *backend, const ost_world_options *options)
{
    ost_error err = {0};
    fixture l = {.g = cubic_geometry(40, 20, 20, OST_PM_PER_MM, (ost_pm3){0, 0, 0})};
    int16_t *full = malloc(voxel_count(&l.g) * sizeof *full);
    for (size_t i = 0; i < voxel_count(&l.g); i++)
        full[i] = (int16_t)(120 + i % 1000);
    l.bone = bone_of(backend, &l.g, 16, full);
    free(full);
    l.peg = solid_tool(backend, (ost_tool_geometry){{4, 4, 12}, 500 * UM, {-OST_PM_PER_MM, -OST_PM_PER_MM, 0}},
                       OST_TOOL_CUTTING);
    l.plate = solid_tool(backend, (ost_tool_geometry){{6, 6, 1}, OST_PM_PER_MM, {-3000 * UM, -3000 * UM, 0}},
                         OST_TOOL_CUTTING);
    assert_ok(ost_world_create(l.bone, options, &l.world, &err));
    int index = -1;
    assert_ok(ost_world_add_tool(l.world, "peg", l.peg, &index, &err));
    assert_int_equal(index, 0);
    assert_ok(ost_world_add_tool(l.world, "plate", l.plate, &index, &err));
    assert_int_equal(index, 1);
    return l;
}

static void free_fixture(fixture *l)
{
    ost_world_free(l->world);
    ost_tool_free(l->peg);
    ost_tool_free(l->plate);
    ost_bone_free(l->bone);
}

static ost_tick tick_at(int64_t t_ms, int32_t tool, int64_t x_um, int64_t y_um, int64_t z_um)
{
    ost_tick tick = {.t_ns = t_ms * 1000000, .tool = tool, .rpm = OST_RPM_ON, .pose = ost_pose_identity()};
    tick.pose.t = (ost_pm3){x_um * UM, y_um * UM, z_um * UM};
    return tick;
}

static ost_step_result step(fixture *l, ost_tick tick)
{
    ost_error err = {0};
    ost_step_result result;
    assert_ok(ost_world_step(l->world, &tick, &result, &err));
    return result;
}

static void sweep_leaves_no_gap(void **state)
{
    /*
     * A sweep has one pose per half voxel, so the motion of 10 mm through voxels of 1 mm has 20 poses. The
     * peg of 2 mm removes the voxels from x = 4 to 15, y = 9 to 10 and z = 5 to 10.
     */
    fixture l = make_fixture(*state, NULL);
    ost_step_result r = step(&l, tick_at(0, 0, 5000, 10000, 5000));
    assert_true(r.removal && r.boxes_meet);
    assert_int_equal(r.pose_count, 1);
    assert_int_equal(r.report->total_voxels, 2 * 2 * 6);
    r = step(&l, tick_at(1, 0, 15000, 10000, 5000));
    assert_int_equal(r.pose_count, 20);
    assert_int_equal(r.report->total_voxels, 10 * 2 * 6);
    ost_world_totals totals;
    ost_world_totals_get(l.world, &totals);
    assert_int_equal(totals.ticks, 2);
    assert_int_equal(totals.removals, 2);
    assert_int_equal(totals.poses, 21);
    assert_int_equal(totals.removed_voxels, 12 * 2 * 6);
    ost_bone_info info;
    assert_int_equal(ost_bone_info_get(l.bone, &info, NULL), OST_OK);
    assert_int_equal(info.active_voxels, 40 * 20 * 20 - 12 * 2 * 6);
    uint64_t by_class = 0;
    int64_t density = 0;
    for (int c = 0; c < OST_CLASS_MAX; c++) {
        by_class += totals.removed_by_class[c];
        density += totals.density_by_class[c];
    }
    assert_int_equal(by_class, totals.removed_voxels);
    int64_t expected = 0; /* The density of a voxel is a function of its index. */
    for (int x = 4; x < 16; x++)
        for (int y = 9; y < 11; y++)
            for (int z = 5; z < 11; z++)
                expected += 120 + (x + 40 * (y + 20 * z)) % 1000;
    assert_int_equal(density, expected);
    free_fixture(&l);
}

static void one_pose_without_sweep(void **state)
{
    fixture l = make_fixture(*state, &(ost_world_options){.sweep_off = true});
    step(&l, tick_at(0, 0, 5000, 10000, 5000));
    ost_step_result r = step(&l, tick_at(1, 0, 15000, 10000, 5000));
    assert_int_equal(r.pose_count, 1);
    assert_int_equal(r.report->total_voxels, 2 * 2 * 6);
    /* Sweeps are off, so their limits do not apply: the tool may move by metres and rotate by half a turn. */
    step(&l, tick_at(2, 0, 7000000, 0, 0));
    ost_tick turned = tick_at(3, 0, 0, 0, 0);
    turned.pose.qw = 0;
    turned.pose.qx = OST_Q30_ONE;
    step(&l, turned);
    free_fixture(&l);
}

static void selected_tool_does_not_sweep(void **state)
{
    fixture l = make_fixture(*state, NULL);
    step(&l, tick_at(0, 0, 5000, 10000, 5000));
    assert_int_equal(step(&l, tick_at(1, 1, 30000, 10000, 5000)).pose_count, 1);
    assert_int_equal(step(&l, tick_at(2, 1, 31000, 10000, 5000)).pose_count, 2);
    /*
     * The peg is selected again, far from its last position. The first event after the selection
     * has one pose, and the next sweep begins at this pose.
     */
    assert_int_equal(step(&l, tick_at(3, 0, 35000, 10000, 5000)).pose_count, 1);
    assert_int_equal(step(&l, tick_at(4, 0, 35000, 13000, 5000)).pose_count, 6);
    free_fixture(&l);
}

/*
 * The tool moves by 20 mm through bone while it is lifted. With and without a removal period, it
 * must remove the voxels at its new position, but nothing between the two positions.
 */
static void lifted_tool_does_not_sweep(void **state)
{
    for (int period_ms = 0; period_ms <= 3; period_ms += 3) {
        fixture l = make_fixture(*state, &(ost_world_options){.removal_period_ns = period_ms * 1000000});
        step(&l, tick_at(3, 0, 5000, 10000, 5000));
        ost_tick far = tick_at(4, 0, 25000, 10000, 5000);
        far.lifted = true;
        ost_step_result r = step(&l, far);
        assert_true(r.removal);
        assert_int_equal(r.pose_count, 1);
        assert_int_equal(r.report->total_voxels, 2 * 2 * 6);
        /* The next tick must sweep again, from the new position. */
        r = step(&l, tick_at(6, 0, 26000, 10000, 5000));
        assert_int_equal(r.pose_count, 2);
        /* A rotation of 180 degrees is too large for a sweep. It is allowed here because the tick is lifted. */
        far = tick_at(7, 0, 25000, 10000, 5000);
        far.pose.qw = 0;
        far.pose.qx = OST_Q30_ONE;
        far.lifted = true;
        assert_int_equal(step(&l, far).pose_count, 1);
        free_fixture(&l);
    }
}

static void removal_period_selects_ticks(void **state)
{
    /*
     * Ticks occur at 1 kHz from t = 1 ms, and the removal period is 3 ms. Removals occur at 1 ms (the first
     * tick) and at 3, 6 and 9 ms. At 10 ms another tool is selected, and the first tick of this tool also
     * removes bone. The next removal occurs at 12 ms.
     */
    fixture l = make_fixture(*state, &(ost_world_options){.removal_period_ns = 3000000});
    static const bool removes[] = {false, true, false, true, false, false, true, false, false, true, true, false, true};
    for (int t = 1; t <= 12; t++) {
        ost_step_result r = step(&l, tick_at(t, t >= 10, 5000 + 500 * t, 10000, 5000));
        assert_int_equal(r.removal, removes[t]);
        assert_int_equal(r.report != NULL, removes[t]);
        /*
         * The tool moves by half a voxel (0.5 mm) per tick. A sweep begins at the pose of the last
         * event, not of the last tick, so it has one pose for each tick since that event.
         */
        assert_int_equal(r.pose_count, !removes[t] ? 0 : t == 1 || t == 10 ? 1 : t == 3 || t == 12 ? 2 : 3);
    }
    ost_world_totals totals;
    ost_world_totals_get(l.world, &totals);
    assert_int_equal(totals.ticks, 12);
    assert_int_equal(totals.removals, 6);
    free_fixture(&l);
}

static void periods_of_negative_times(void **state)
{
    /*
     * The number of the removal period of a tick is its time divided by the period, rounded down and not towards
     * zero. Therefore -1 ms and 0 ms are in different periods of 3 ms, and -3 ms and -1 ms are in the same period.
     */
    fixture l = make_fixture(*state, &(ost_world_options){.removal_period_ns = 3000000});
    assert_true(step(&l, tick_at(-3, 0, 0, 0, 0)).removal);
    assert_false(step(&l, tick_at(-1, 0, 0, 0, 0)).removal);
    assert_true(step(&l, tick_at(0, 0, 0, 0, 0)).removal);
    assert_false(step(&l, tick_at(2, 0, 0, 0, 0)).removal);
    free_fixture(&l);
}

static ost_tick motor_at(int64_t t_ms, int32_t rpm, int64_t x_um)
{
    ost_tick tick = tick_at(t_ms, 0, x_um, 10000, 5000);
    tick.rpm = rpm;
    return tick;
}

/*
 * The peg moves through the bone with the motor off, and jumps by metres and half turns. Nothing
 * may be removed, and the limits of sweeps must not apply.
 */
static void motor_off_removes_nothing(void **state)
{
    fixture l = make_fixture(*state, NULL);
    const ost_digest before = digest_of(l.bone);
    for (int t = 0; t < 40; t++) {
        ost_tick tick = motor_at(t, 0, t % 2 ? 7000000 : 1000 * t);
        tick.pose.qw = t % 3 ? OST_Q30_ONE : 0;
        tick.pose.qz = t % 3 ? 0 : OST_Q30_ONE;
        const ost_step_result r = step(&l, tick);
        assert_false(r.removal || r.boxes_meet || r.report || r.pose_count);
    }
    ost_world_totals totals;
    ost_world_totals_get(l.world, &totals);
    assert_int_equal(totals.ticks, 40);
    assert_int_equal(totals.removals + totals.removed_voxels, 0);
    const ost_digest after = digest_of(l.bone);
    assert_true(ost_digest_equal(&before, &after));
    free_fixture(&l);
}

/*
 * The motor is on until the tool is at 5 mm, off while the tool moves to 30 mm, and then on again.
 * The next sweep, over 2 mm, has 4 poses, and nothing between 5 and 30 mm is removed.
 */
static void sweep_begins_at_last_pose_with_motor_off(void **state)
{
    for (int period = 0; period <= 1; period++) {
        fixture l = make_fixture(*state, &(ost_world_options){.removal_period_ns = period * 1000000000});
        step(&l, motor_at(0, 200, 5000));
        step(&l, motor_at(1, 0, 15000));
        step(&l, motor_at(2, 0, 30000));
        const ost_step_result r = step(&l, motor_at(3, 200, 32000));
        assert_true(r.removal); /* The first tick with the motor on removes bone in any period. */
        assert_int_equal(r.pose_count, 4);
        /* The peg of 2 x 2 x 6 mm is at x = 30.5, 31, 31.5 and 32, and removes the centres with 29.5 <= x < 33. */
        assert_int_equal(r.report->total_voxels, 3 * 2 * 6);
        assert_int_equal(step(&l, motor_at(4, 200, 32000)).removal, !period);
        /*
         * If a tool is selected while the motor is off, the first sweep of this tool begins at the tool's
         * pose in the tick of the selection.
         */
        ost_tick other = tick_at(5, 1, 20000, 10000, 5000);
        other.rpm = 0;
        assert_false(step(&l, other).removal);
        other.t_ns += 1000000;
        other.pose.t.x += 1000 * UM;
        other.rpm = 200;
        assert_int_equal(step(&l, other).pose_count, 2);
        free_fixture(&l);
    }
}

/* At 3000 revolutions per minute, a quarter turn takes 5 ms. A sweep over a larger angle could have the wrong
   direction. */
static void motor_turn_over_quarter_is_refused(void **state)
{
    ost_error err = {0};
    fixture l = make_fixture(*state, NULL);
    ost_tick tick = motor_at(0, 3000, 20000);
    step(&l, tick);
    tick.t_ns += 5000000;
    assert_true(step(&l, tick).removal);
    tick.t_ns += 5000001;
    assert_int_equal(ost_world_step(l.world, &tick, NULL, &err), OST_ERR_RANGE);
    assert_non_null(strstr(err.text, "3000 rpm"));
    tick.t_ns = INT64_MAX;
    assert_int_equal(ost_world_step(l.world, &tick, NULL, &err), OST_ERR_RANGE);
    tick.rpm = 0;
    tick.t_ns = 100000000;
    assert_false(step(&l, tick).removal);
    tick.rpm = 3001;
    tick.t_ns++;
    assert_int_equal(ost_world_step(l.world, &tick, NULL, &err), OST_ERR_USAGE);
    free_fixture(&l);
    /* The rotations of all ticks since the last event are added. Three ticks of 2 ms give more than a quarter turn. */
    l = make_fixture(*state, &(ost_world_options){.removal_period_ns = 6000000});
    for (int t = 0; t < 6; t += 2)
        assert_int_equal(step(&l, motor_at(t, 3000, 20000)).removal, t == 0);
    tick = motor_at(6, 3000, 20000);
    assert_int_equal(ost_world_step(l.world, &tick, NULL, &err), OST_ERR_RANGE);
    free_fixture(&l);
}

static void failed_step_changes_nothing(void **state)
{
    ost_error err = {0};
    fixture l = make_fixture(*state, NULL);
    step(&l, tick_at(5, 0, 5000, 10000, 5000));
    ost_digest before = digest_of(l.bone);
    ost_world_totals totals, still;
    ost_world_totals_get(l.world, &totals);

    ost_tick turned = tick_at(6, 0, 5000, 10000, 5000), short_q = turned, far = turned;
    turned.pose.qw = 0;
    turned.pose.qz = OST_Q30_ONE;
    short_q.pose.qw = OST_Q30_ONE - OST_Q30_ONE / 900;
    far.pose.t.y = OST_LENGTH_MAX + 1;
    const struct {
        ost_tick tick;
        ost_status status;
    } cases[] = {
        {tick_at(6, 0, 5000 + 2049000, 10000, 5000), OST_ERR_RANGE}, /* 4,098 poses */
        {turned, OST_ERR_RANGE},
        {short_q, OST_ERR_RANGE},
        {far, OST_ERR_RANGE},
        {tick_at(5, 0, 6000, 10000, 5000), OST_ERR_USAGE}, /* time does not increase */
        {tick_at(6, 2, 6000, 10000, 5000), OST_ERR_USAGE}, /* no such tool */
        {tick_at(6, -1, 6000, 10000, 5000), OST_ERR_USAGE},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        ost_step_result r;
        if (ost_world_step(l.world, &cases[i].tick, &r, &err) != cases[i].status)
            fail_msg("case %zu: the status is not %s: %s", i, ost_status_name(cases[i].status), err.text);
        assert_true(strlen(err.text) > 10);
        assert_false(r.removal);
        assert_null(r.report);
        ost_world_totals_get(l.world, &still);
        assert_memory_equal(&totals, &still, sizeof totals);
        ost_digest after = digest_of(l.bone);
        assert_true(ost_digest_equal(&before, &after));
    }
    /* The next sweep must begin at the pose of the last valid tick: a motion of 2 mm gives 4 poses. */
    assert_int_equal(step(&l, tick_at(6, 0, 7000, 10000, 5000)).pose_count, 4);
    free_fixture(&l);
}

static void distant_tool_reaches_no_chunk(void **state)
{
    fixture l = make_fixture(*state, NULL);
    ost_step_result r = step(&l, tick_at(0, 0, 500000, 0, 0));
    assert_true(r.removal);
    assert_false(r.boxes_meet);
    assert_int_equal(r.report->total_voxels, 0);
    for (int a = 0; a < 3; a++)
        assert_true(r.chunk_lo[a] >= r.chunk_hi[a]);
    free_fixture(&l);
}

static void range_of_chunks_of_event(void **state)
{
    /*
     * The peg at (15.5, 10, 5) mm covers x = 14.5 to 16.5 mm. Enlarged by one voxel (0.5 mm) on
     * each side, this range reaches chunks 0 and 1 along x and chunk 0 along y and z.
     */
    fixture l = make_fixture(*state, NULL);
    ost_step_result r = step(&l, tick_at(0, 0, 15500, 10000, 5000));
    static const int32_t lo[3] = {0, 0, 0}, hi[3] = {2, 1, 1};
    assert_memory_equal(r.chunk_lo, lo, sizeof lo);
    assert_memory_equal(r.chunk_hi, hi, sizeof hi);
    free_fixture(&l);
}

static void invalid_worlds_and_tools_are_refused(void **state)
{
    ost_error err = {0};
    fixture l = make_fixture(*state, NULL);
    ost_world *world;
    assert_int_equal(ost_world_create(NULL, NULL, &world, &err), OST_ERR_USAGE);
    assert_int_equal(ost_world_create(l.bone, &(ost_world_options){.removal_period_ns = -1}, &world, &err),
                     OST_ERR_USAGE);
    ost_world_options options = {.classes = {.count = 2, .border = {200, 200}}};
    assert_int_equal(ost_world_create(l.bone, &options, &world, &err), OST_ERR_USAGE);
    options.classes.border[0] = 0;
    assert_int_equal(ost_world_create(l.bone, &options, &world, &err), OST_ERR_USAGE);
    ost_backend *other;
    assert_ok(ost_backend_open(test_backend, &other, &err));
    ost_tool *foreign = solid_tool(other, (ost_tool_geometry){{1, 1, 1}, OST_PM_PER_MM, {0, 0, 0}}, OST_TOOL_CUTTING);
    assert_int_equal(ost_world_add_tool(l.world, "foreign", foreign, NULL, &err), OST_ERR_USAGE);
    ost_tool *fine = solid_tool(*state, (ost_tool_geometry){{1, 1, 1}, 62 * UM, {0, 0, 0}}, OST_TOOL_CUTTING);
    /* 1 mm is more than 16 voxels of this tool. */
    assert_int_equal(ost_world_add_tool(l.world, "fine", fine, NULL, &err), OST_ERR_RANGE);
    for (int i = 2; i < OST_WORLD_TOOLS_MAX; i++)
        assert_ok(ost_world_add_tool(l.world, NULL, l.peg, NULL, &err));
    assert_int_equal(ost_world_add_tool(l.world, "one too many", l.peg, NULL, &err), OST_ERR_USAGE);
    ost_tool_free(fine);
    ost_tool_free(foreign);
    ost_backend_close(other);
    free_fixture(&l);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sweep_leaves_no_gap),
        cmocka_unit_test(one_pose_without_sweep),
        cmocka_unit_test(lifted_tool_does_not_sweep),
        cmocka_unit_test(selected_tool_does_not_sweep),
        cmocka_unit_test(removal_period_selects_ticks),
        cmocka_unit_test(periods_of_negative_times),
        cmocka_unit_test(failed_step_changes_nothing),
        cmocka_unit_test(motor_off_removes_nothing),
        cmocka_unit_test(sweep_begins_at_last_pose_with_motor_off),
        cmocka_unit_test(motor_turn_over_quarter_is_refused),
        cmocka_unit_test(distant_tool_reaches_no_chunk),
        cmocka_unit_test(range_of_chunks_of_event),
        cmocka_unit_test(invalid_worlds_and_tools_are_refused),
    };
    return run_on_backends(tests, open_test_backend, close_test_backend);
}
