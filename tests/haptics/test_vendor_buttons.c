/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests an operation whose motor and tools are switched by the buttons of a device, with stand-ins for the vendors'
 * libraries.
 *
 * Covers: AR-MOTOR-5, REQ-DEVICES
 */
#include "fake_library.h"

#include <osteon/operation.h>

enum {
    MOTOR_FROM = 80,
    MOTOR_TO = 110,
    TOOL_FROM = 130,
    TOOL_TO = 140,
    SECOND_FROM = 150,
    SECOND_TO = 180,
    TICKS = 200
};

typedef struct course {
    ost_operation *operation;
    ost_live_channel *live;
    ost_world *world;
    fake_note *note;
    /* `along` points to the device's coordinate along the bone's x. `step` is 0.1 mm in the device's unit of length. */
    double *along, step;
    int tick;
    uint64_t removed[TICKS];
    ost_live_state seen[TICKS];
} course;

static int held_at(int tick)
{
    const bool motor = (tick >= MOTOR_FROM && tick < MOTOR_TO) || (tick >= SECOND_FROM && tick < SECOND_TO);
    return motor ? 1 : tick >= TOOL_FROM && tick < TOOL_TO ? 2 : 0;
}

/*
 * Executes one tick and sets the position for the next tick. Each tick counts as one
 * millisecond, even if the machine is slow.
 */
static bool follow_course(void *user, const ost_servo_sample *sample, ost_wrench *wrench)
{
    course *c = user;
    ost_servo_sample s = *sample;
    ost_world_totals totals;
    s.number = (uint64_t)c->tick;
    s.t_ns = c->tick * INT64_C(1000000);
    if (!ost_operation_tick(c->operation, &s, wrench))
        return false;
    ost_operation_done(c->operation, s.number, 0);
    ost_world_totals_get(c->world, &totals);
    c->removed[c->tick] = totals.removed_voxels;
    ost_live_state_get(c->live, &c->seen[c->tick]);
    c->tick++;
    *c->along += c->step;
    c->note->buttons = held_at(c->tick);
    return c->tick < TICKS;
}

/*
 * Moves the tool by 20 mm along x, into bone. The buttons of the device switch the motor on, select the next
 * tool, and switch the motor on again.
 */
static void operate_by_buttons(const char *name, fake_note *note, double *along, double step)
{
    static course c;
    ost_error err = {0};
    ost_backend *backend;
    ost_haptic_info info;
    ost_haptic *device;
    static ost_servo_report report;
    ost_operation_options options = {.rpm = 200, .tools = 2, .motor_waits = true};
    const ost_geometry g = cubic_geometry(40, 20, 20, MM, (ost_pm3){0, 0, 0});
    c = (course){.note = note, .along = along, .step = step};
    assert_ok(ost_backend_open("ref", &backend, &err));
    int16_t *full = malloc(voxel_count(&g) * sizeof *full);
    assert_non_null(full);
    for (size_t i = 0; i < voxel_count(&g); i++)
        full[i] = 500;
    ost_bone *bone = bone_of(backend, &g, 16, full);
    free(full);
    ost_tool *tool = solid_tool(backend, (ost_tool_geometry){{4, 4, 12}, 500 * UM, {-MM, -MM, 0}}, OST_TOOL_CUTTING);
    assert_ok(ost_world_create(bone, NULL, &c.world, &err));
    assert_ok(ost_world_add_tool(c.world, "peg", tool, NULL, &err));
    assert_ok(ost_world_add_tool(c.world, "another", tool, NULL, &err));
    assert_ok(ost_live_create(bone, &c.live, &err));
    assert_ok(ost_haptic_describe(index_of(name), &info, &err));
    assert_ok(ost_buttons_parse(&info, NULL, options.buttons, &err));
    options.live = c.live;
    assert_ok(ost_operation_create(c.world, &options, &c.operation, &err));
    const ost_haptic_setup setup = {.start = {.t = {-5 * MM, 10 * MM, 5 * MM}, .qw = OST_Q30_ONE}};
    assert_ok(ost_haptic_open(name, &setup, &device, &err));
    const ost_servo_options how = {.no_realtime = true};
    assert_ok(ost_servo_run(device, &how, follow_course, NULL, &c, &report, &err));
    ost_haptic_close(device);
    assert_int_equal(c.tick, TICKS);
    for (int i = 0; i < TICKS; i++) {
        assert_int_equal(c.seen[i].fault, OST_FAULT_NONE);
        assert_int_equal(c.seen[i].rpm, held_at(i) == 1 ? 200 : 0);
        assert_int_equal(c.seen[i].tool, i >= TOOL_FROM);
    }
    assert_int_equal(c.removed[MOTOR_FROM - 1], 0); /* The tool is already in the bone. */
    assert_true(c.removed[MOTOR_TO - 1] > 10);
    assert_int_equal(c.removed[SECOND_FROM - 1], c.removed[MOTOR_TO - 1]);
    assert_true(c.removed[SECOND_TO - 1] > c.removed[MOTOR_TO - 1] + 10);
    assert_int_equal(c.removed[TICKS - 1], c.removed[SECOND_TO - 1]);
    ost_operation_free(c.operation);
    ost_live_free(c.live);
    ost_world_free(c.world);
    ost_tool_free(tool);
    ost_bone_free(bone);
    ost_backend_close(backend);
}

static void buttons_of_devices_switch_motor_and_tool(void **state)
{
    (void)state;
    fake_note *note = load_stand_in(HD, "fake_hd", "fake_hd");
    /* position[0] is the coordinate to the right, which is the tool's x, in mm. */
    operate_by_buttons("openhaptics", note, &note->position[0], 0.1);
    note = load_stand_in(DHD, "fake_dhd", "fake_dhd");
    operate_by_buttons("dhd", note, &note->position[1], 1e-4); /* to the right, in m */
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(buttons_of_devices_switch_motor_and_tool),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
