/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests the force of an operation whose device is not tracked for 100 ticks. The force must be 0 during this time and
 * must return gradually. This file contains the driver of the device.
 */
#include "ref/scene.h"

#include <math.h>

#include <osteon/operation.h>

#include "haptics/driver.h"

#define MM OST_PM_PER_MM

static struct haptic_instance {
    int at;
} interrupted;

enum { PRESS = 300, DARK = 100, TICKS = 700 };

static ost_status interrupted_open(const char *options, const ost_haptic_setup *setup, haptic_instance **out,
                                   ost_error *err)
{
    (void)options;
    (void)setup;
    (void)err;
    interrupted.at = 0;
    *out = &interrupted;
    return OST_OK;
}

static void interrupted_close(haptic_instance *instance)
{
    (void)instance;
}

static ost_haptic_answer interrupted_read(haptic_instance *b, ost_haptic_state *state)
{
    const int t = b->at++;
    if (t >= PRESS && t < PRESS + DARK)
        return OST_HAPTIC_NOT_TRACKED;
    /* The device moves by 2 mm along x, so that the tool enters the bone's side, and stays there. */
    *state = (ost_haptic_state){
        .pose = {.t = {-2 * MM + (t < 200 ? t : 200) * MM / 100, 20 * MM, 20 * MM}, .qw = OST_Q30_ONE}, .tool = -1};
    return OST_HAPTIC_FRESH;
}

static void interrupted_write(haptic_instance *b, const ost_wrench *wrench)
{
    (void)b;
    (void)wrench;
}

static const haptic_driver blinker = {.name = "blinker",
                                      .caps = OST_HAPTIC_FORCE | OST_HAPTIC_LOGICAL,
                                      .open = interrupted_open,
                                      .close = interrupted_close,
                                      .read = interrupted_read,
                                      .write = interrupted_write};

typedef struct force_record {
    ost_operation *operation;
    double n[TICKS];
    int count;
} force_record;

static bool record_force(void *user, const ost_servo_sample *sample, ost_wrench *wrench)
{
    force_record *f = user;
    const bool more = ost_operation_tick(f->operation, sample, wrench);
    f->n[f->count++] = -wrench->force_n[0];
    return more;
}

static void force_stops_at_dropouts_and_returns_gradually(void **state)
{
    skip_without_samples(*state);
    ost_error err = {0};
    const ost_geometry g = cubic_geometry(40, 40, 40, MM, (ost_pm3){0, 0, 0});
    int16_t *full = malloc(voxel_count(&g) * sizeof *full);
    assert_non_null(full);
    for (size_t i = 0; i < voxel_count(&g); i++)
        full[i] = 500;
    ost_bone *bone = bone_of(*state, &g, 16, full);
    free(full);
    ost_tool *tool = solid_tool(*state, (ost_tool_geometry){{4, 4, 12}, 500 * UM, {-MM, -MM, 0}}, OST_TOOL_CUTTING);
    ost_world *world;
    ost_force *force;
    ost_haptic *device;
    static force_record f;
    static ost_servo_report report;
    f = (force_record){0};
    ost_force_params params = ost_force_defaults();
    params.speed = 0;
    ost_safety_params safety = ost_safety_defaults();
    safety.ramp_s = 0.1;
    assert_ok(ost_world_create(bone, NULL, &world, &err));
    assert_ok(ost_world_add_tool(world, "peg", tool, NULL, &err));
    assert_ok(ost_force_create(bone, &params, &force, &err));
    assert_ok(ost_force_add_tool(force, tool, &err));
    assert_ok(ost_haptic_open_driver(&blinker, "", NULL, &device, &err));
    assert_ok(
        ost_operation_create(world, &(ost_operation_options){.force = force, .safety = &safety}, &f.operation, &err));
    assert_ok(ost_servo_run(device, &(ost_servo_options){.no_clock = true, .no_realtime = true, .ticks = TICKS},
                            record_force, NULL, &f, &report, &err));
    assert_int_equal(f.count, TICKS);
    const double full_n = f.n[PRESS - 1];
    assert_true(full_n > 0.1);
    for (int t = PRESS; t < PRESS + DARK; t++)
        assert_true(f.n[t] == 0);
    assert_true(f.n[PRESS + DARK] < 0.05 * full_n);
    for (int t = PRESS + DARK; t < PRESS + DARK + 90; t++)
        assert_true(f.n[t + 1] >= f.n[t] && f.n[t + 1] - f.n[t] < 0.05 * full_n);
    assert_true(fabs(f.n[TICKS - 1] - full_n) < 0.02 * full_n);
    ost_operation_free(f.operation);
    ost_haptic_close(device);
    ost_force_free(force);
    ost_world_free(world);
    ost_tool_free(tool);
    ost_bone_free(bone);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(force_stops_at_dropouts_and_returns_gradually),
    };
    return run_on_backends(tests, open_test_backend, close_test_backend);
}
