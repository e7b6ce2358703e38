/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests the motor of an operation, and the actions of buttons and keys: motor, switch, next tool, clutch and home.
 *
 * Covers: AR-MOTOR-2, AR-MOTOR-4, AR-MOTOR-5, REQ-OPERATION
 */
#include "operation_world.h"

/*
 * Executes one tick of an operation with a device that selects no tool. Stores the live state
 * after the tick in *state.
 */
static void tick_of(ost_operation *o, int64_t t_ms, ost_pose pose, uint32_t buttons, ost_live_channel *live,
                    ost_live_state *state)
{
    ost_wrench wrench = {{0}, {0}};
    const ost_servo_sample sample = {
        .number = (uint64_t)t_ms, .t_ns = t_ms * 1000000, .state = {.pose = pose, .tool = -1, .buttons = buttons}};
    assert_true(ost_operation_tick(o, &sample, &wrench));
    ost_operation_done(o, (uint64_t)t_ms, 0);
    assert_true(ost_live_state_get(live, state));
}

static ost_pose pose_at(ost_pm x, ost_pm y, ost_pm z)
{
    return (ost_pose){.t = {x, y, z}, .qw = OST_Q30_ONE};
}

/*
 * With the motor off, a tool in bone removes nothing. With the motor on, the ticks must equal those
 * that ost_motor_turn computes. If a tick is too late, its motor counts as off.
 */
static void operation_switches_its_motor(void **state)
{
    ost_error err = {0};
    fixture live_fixture = make_fixture(*state), by_hand = make_fixture(*state);
    ost_live_channel *live;
    ost_live_state s;
    ost_operation *operation;
    ost_world_totals totals;
    assert_ok(ost_live_create(live_fixture.bone, &live, &err));
    const ost_operation_options options = {.live = live,
                                           .rpm = 300,
                                           .motor_waits = true,
                                           .buttons = {OST_ACTION_NONE, OST_ACTION_MOTOR, OST_ACTION_SWITCH}};
    assert_ok(ost_operation_create(live_fixture.world, &options, &operation, &err));
    ost_motor motor = {0};
    for (int i = 0; i < 100; i++) {
        /* The motor's button is held in ticks 40 to 60. The switch turns the motor on in tick 60 and off in tick 80. */
        const bool on = i >= 40 && i < 80;
        const uint32_t buttons = i >= 40 && i < 60 ? 2 : (i >= 60 && i < 65) || (i >= 80 && i < 83) ? 4 : 0;
        ost_tick tick = {.t_ns = (int64_t)i * 1000000, .pose = pose_at(2 * MM + i * MM / 5, 10 * MM, 5 * MM)};
        tick_of(operation, i, tick.pose, i == 60 ? 6 : buttons, live, &s);
        ost_motor_turn(&motor, &tick, on ? 300 : 0);
        assert_ok(ost_world_step(by_hand.world, &tick, NULL, &err));
        assert_int_equal(s.rpm, tick.rpm);
        assert_memory_equal(&s.pose, &tick.pose, sizeof s.pose);
        ost_world_totals_get(live_fixture.world, &totals);
        if (i < 40)
            assert_int_equal(totals.removals, 0);
    }
    assert_true(totals.removed_voxels > 0);
    const ost_digest a = digest_of(live_fixture.bone), b = digest_of(by_hand.bone);
    assert_true(ost_digest_equal(&a, &b));
    /* At 300 rpm, an eighth of a turn takes 25 ms. */
    tick_of(operation, 200, pose_at(22 * MM, 10 * MM, 5 * MM), 2, live, &s);
    assert_int_equal(s.rpm, 0);
    tick_of(operation, 225, pose_at(22 * MM, 10 * MM, 5 * MM), 2, live, &s);
    assert_int_equal(s.rpm, 300);
    ost_operation_free(operation);
    /* A speed beyond the limit is refused. */
    assert_int_equal(ost_operation_create(live_fixture.world, &(ost_operation_options){.rpm = 3001}, &operation, &err),
                     OST_ERR_USAGE);
    ost_live_free(live);
    free_fixture(&live_fixture);
    free_fixture(&by_hand);
}

/* The actions `next tool`, `clutch` and `home` must have the same effect with a button and with a key. */
static void buttons_and_keys_have_equal_effects(void **state)
{
    ost_error err = {0};
    for (int by_key = 0; by_key <= 1; by_key++) {
        fixture r = make_fixture(*state);
        ost_live_channel *live;
        ost_live_state s;
        ost_operation *o;
        assert_ok(ost_world_add_tool(r.world, "another", r.tool, NULL, &err));
        assert_ok(ost_live_create(r.bone, &live, &err));
        ost_operation_options options = {.live = live, .rpm = 200, .tools = 2, .home = pose_at(-20 * MM, 0, 0)};
        const uint32_t tool = by_key ? UINT32_C(1) << OST_ACTION_TOOL : 1,
                       clutch = by_key ? UINT32_C(1) << OST_ACTION_CLUTCH : 2,
                       home = by_key ? UINT32_C(1) << OST_ACTION_HOME : 4;
        if (!by_key)
            memcpy(options.buttons, (ost_action[3]){OST_ACTION_TOOL, OST_ACTION_CLUTCH, OST_ACTION_HOME},
                   3 * sizeof(ost_action));
        assert_ok(ost_operation_create(r.world, &options, &o, &err));
        int64_t t = 0;
        ost_pm x = -10 * MM;
#define TICK(held)                                                                      \
    do {                                                                                \
        ost_operation_keys(o, by_key ? (held) : 0);                                     \
        tick_of(o, t++, pose_at(x, 10 * MM, 5 * MM), by_key ? 0 : (held), live, &s); \
        assert_int_equal(s.fault, OST_FAULT_NONE);                                      \
    } while (0)
        TICK(0);
        assert_int_equal(s.tool, 0);
        TICK(tool);
        TICK(tool); /* The button or key is still pressed, so the tool is not changed again. */
        assert_int_equal(s.tool, 1);
        TICK(0);
        TICK(tool);
        assert_int_equal(s.tool, 0);
        assert_int_equal(s.pose.t.x, -10 * MM);
        /*
         * While the clutch is held, the device moves 60 mm, through the bone and beyond. Without the
         * clutch, the steps would be jumps. The tool stays in place and continues from there when the
         * clutch is released.
         */
        for (int i = 0; i < 10; i++, x += 6 * MM)
            TICK(clutch);
        assert_int_equal(s.pose.t.x, -10 * MM);
        TICK(0);
        assert_true(llabs(s.pose.t.x + 10 * MM) <= 1);
        x += MM;
        TICK(0);
        assert_true(llabs(s.pose.t.x + 9 * MM) <= 1);
        /* The `home` action moves the tool out of the bone without removing anything on the way. */
        for (int i = 0; i < 20; i++, x += MM)
            TICK(0);
        ost_world_totals before, after;
        ost_world_totals_get(r.world, &before);
        assert_true(before.removed_voxels > 0);
        TICK(home);
        assert_true(llabs(s.pose.t.x + 20 * MM) <= 1 && llabs(s.pose.t.y) <= 1);
        TICK(home);
        x += MM;
        TICK(0);
        assert_true(llabs(s.pose.t.x + 19 * MM) <= 1);
        ost_world_totals_get(r.world, &after);
        assert_int_equal(before.removed_voxels, after.removed_voxels);
#undef TICK
        ost_operation_free(o);
        ost_live_free(live);
        free_fixture(&r);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(operation_switches_its_motor),
        cmocka_unit_test(buttons_and_keys_have_equal_effects),
    };
    return run_on_backends(tests, open_test_backend, close_test_backend);
}
