/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests the `dhd` and `openhaptics` drivers with stand-ins for the vendors' libraries. The tests check the calls and
 * their order, and compare poses and forces with values computed by hand. Further tests check the results if a library
 * is absent or lacks a function, and if a device is absent, is unplugged, overheats, hangs or returns NaN. They also
 * check the limits that devices report.
 *
 * Covers: REQ-DEVICES
 */
#include "fake_library.h"

#include <math.h>

static void absent_and_incomplete_libraries(void **state)
{
    (void)state;
    static const struct {
        const char *device, *variable, *file, *message;
    } cases[] = {
        {"dhd", DHD, "/nowhere/libdhd.so", "cannot load the library in OSTEON_DHD_LIBRARY: "},
        {"openhaptics", HD, "/nowhere/libHD.so", "cannot load the library in OSTEON_OPENHAPTICS_LIBRARY: "},
        {"dhd", DHD, "fake_dhd_short", "lacks dhdSetForceAndTorqueAndGripperForce"},
        {"openhaptics", HD, "fake_dhd", "lacks hdInitDevice"},
        {"spnav", SPNAV, "/nowhere/libspnav.so", "cannot load the library in OSTEON_SPNAV_LIBRARY: "},
        {"spnav", SPNAV, "fake_spnav_short", "lacks spnav_poll_event"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        const char *file = cases[i].file[0] == '/' ? cases[i].file : fake_file(cases[i].file);
        if (cases[i].file[0] != '/' && access(file, R_OK) != 0)
            continue;
        setenv(cases[i].variable, file, 1);
        ost_error err = {0};
        ost_haptic_info info;
        ost_haptic *device;
        assert_ok(ost_haptic_describe(index_of(cases[i].device), &info, &err));
        assert_false(info.available);
        assert_non_null(strstr(info.reason, cases[i].message));
        assert_int_equal(ost_haptic_open(cases[i].device, NULL, &device, &err), OST_ERR_UNAVAILABLE);
        assert_null(device);
        assert_non_null(strstr(err.text, cases[i].message));
    }
}

static void dhd_frames_and_forces(void **state)
{
    (void)state;
    fake_note *note = load_stand_in(DHD, "fake_dhd", "fake_dhd");
    const ost_haptic_setup setup = at_start();
    ost_error err = {0};
    ost_haptic *device;
    ost_haptic_state s;
    assert_ok(ost_haptic_open("dhd:scale=200", &setup, &device, &err));
    assert_int_equal(ost_haptic_read(device, &s), OST_HAPTIC_FRESH);
    assert_memory_equal(&s.pose.t, &setup.start.t, sizeof s.pose.t);
    for (int i = 0; i < 4; i++)
        assert_true(abs((&s.pose.qw)[i] - (&setup.start.qw)[i]) <= 2);
    assert_int_equal(s.tool, -1);
    /*
     * The device moves 1 mm away from the operator (-x), 2 mm to the right (y) and 3 mm up (z). The
     * device's x, y and z axes are the tool's z, x and y axes, which are the bone's x, -z and y axes.
     */
    note->position[0] = -0.001;
    note->position[1] = 0.002;
    note->position[2] = 0.003;
    note->buttons = 5;
    assert_int_equal(ost_haptic_read(device, &s), OST_HAPTIC_FRESH);
    assert_true(llabs(s.pose.t.x - (10 - 2) * MM) < 100 && llabs(s.pose.t.y - (20 + 6) * MM) < 100 &&
                llabs(s.pose.t.z - (30 - 4) * MM) < 100);
    assert_int_equal(s.buttons, 5);
    /* A force along the bone's x pulls the device towards the operator. */
    const ost_wrench wrench = {{1, 2, 3}, {0.1, 0.2, 0.3}};
    ost_haptic_write(device, &wrench);
    assert_true(fabs(note->force[0] - 1) < 1e-8 && fabs(note->force[1] + 3) < 1e-8 && fabs(note->force[2] - 2) < 1e-8);
    assert_true(fabs(note->torque[0] - 0.1) < 1e-9 && fabs(note->torque[1] + 0.3) < 1e-9 &&
                fabs(note->torque[2] - 0.2) < 1e-9);
    ost_haptic_close(device);
    assert_string_equal(note->calls, "oeppffdc");
    assert_int_equal(note->forces_on, 0);
    assert_true(note->force[0] == 0 && note->force[1] == 0 && note->force[2] == 0);
}

static void dhd_rotations(void **state)
{
    (void)state;
    fake_note *note = load_stand_in(DHD, "fake_dhd", "fake_dhd");
    const ost_haptic_setup setup = {.start = {.qw = OST_Q30_ONE}};
    ost_error err = {0};
    ost_haptic *device;
    ost_haptic_state s;
    assert_ok(ost_haptic_open("dhd", &setup, &device, &err));
    /* The handle rotates by a quarter turn about the device's x, which is the tool's z. */
    static const double turned[3][3] = {{1, 0, 0}, {0, 0, 1}, {0, -1, 0}};
    memcpy(note->column, turned, sizeof turned);
    assert_int_equal(ost_haptic_read(device, &s), OST_HAPTIC_FRESH);
    const int32_t c = 759250125;
    assert_true(abs(s.pose.qw - c) <= 2 && abs(s.pose.qz - c) <= 2 && abs(s.pose.qx) <= 2 && abs(s.pose.qy) <= 2);
    ost_haptic_close(device);
}

static void dhd_failures(void **state)
{
    (void)state;
    ost_error err = {0};
    ost_haptic *device;
    ost_haptic_state s;
    fake_note *note = load_stand_in(DHD, "fake_dhd", "fake_dhd");
    note->fail_open = 1;
    assert_int_equal(ost_haptic_open("dhd", NULL, &device, &err), OST_ERR_UNAVAILABLE);
    assert_non_null(strstr(err.text, "no device found"));
    note->fail_open = 0;
    assert_int_equal(ost_haptic_open("dhd:scale=0", NULL, &device, &err), OST_ERR_USAGE);
    assert_int_equal(ost_haptic_open("dhd:size=3", NULL, &device, &err), OST_ERR_USAGE);
    /* A pose that contains NaN is an invalid pose for one tick. The device continues. */
    note->no_number_at = 2;
    note->fail_read_at = 4;
    assert_ok(ost_haptic_open("dhd", NULL, &device, &err));
    for (int frame = 1; frame <= 3; frame++) {
        assert_int_equal(ost_haptic_read(device, &s), OST_HAPTIC_FRESH);
        assert_int_equal(ost_pose_check(&s.pose, &err), frame == 2 ? OST_ERR_RANGE : OST_OK);
    }
    assert_int_equal(ost_haptic_read(device, &s), OST_HAPTIC_LOST);
    ost_haptic_close(device);
    /* If a force cannot be written, the device is lost at the next tick. */
    note = load_stand_in(DHD, "fake_dhd", "fake_dhd");
    note->fail_write_at = 1;
    assert_ok(ost_haptic_open("dhd", NULL, &device, &err));
    assert_int_equal(ost_haptic_read(device, &s), OST_HAPTIC_FRESH);
    ost_haptic_write(device, &(ost_wrench){{1, 0, 0}, {0}});
    assert_int_equal(ost_haptic_read(device, &s), OST_HAPTIC_LOST);
    ost_haptic_close(device);
}

/* ------------------------------------------------------------- openhaptics */

typedef struct seen {
    uint64_t ticks;
    ost_haptic_state last;
    int faults; /* invalid poses */
} seen;

static bool push(void *user, const ost_servo_sample *sample, ost_wrench *wrench)
{
    seen *s = user;
    s->ticks++;
    s->last = sample->state;
    s->faults += ost_pose_check(&sample->state.pose, NULL) != OST_OK;
    wrench->force_n[0] = 1.5;
    return true;
}

static ost_status run(seen *s, uint64_t ticks, ost_servo_report *report, ost_error *err)
{
    const ost_servo_options options = {.ticks = ticks, .no_realtime = true};
    const ost_haptic_setup setup = {.start = {.t = {MM, 0, 0}, .qw = OST_Q30_ONE}};
    ost_haptic *device;
    *s = (seen){0};
    ost_status status = ost_haptic_open("openhaptics", &setup, &device, err);
    if (status == OST_OK)
        status = ost_servo_run(device, &options, push, NULL, s, report, err);
    ost_haptic_close(device);
    return status;
}

static void openhaptics_frames(void **state)
{
    (void)state;
    fake_note *note = load_stand_in(HD, "fake_hd", "fake_hd");
    ost_error err = {0};
    static ost_servo_report report;
    seen s;
    note->position[2] = -4; /* mm */
    note->buttons = 2;
    assert_ok(run(&s, 3, &report, &err));
    assert_int_equal(report.end, OST_SERVO_TICKS);
    assert_int_equal(s.ticks, 3);
    assert_int_equal(s.last.buttons, 2);
    assert_true(s.last.pose.t.x == MM && s.last.pose.t.z == -4 * MM && s.last.pose.qw == OST_Q30_ONE);
    assert_string_equal(note->calls, "is<m(f)m(f)m(f)>ud");
    assert_true(note->most_force > 1.49 && note->most_force < 1.51);
    /* In the frame that ends the loop, the force is zero. */
    assert_true(note->force[0] == 0 && note->force[1] == 0 && note->force[2] == 0);
}

static void openhaptics_failures(void **state)
{
    (void)state;
    ost_error err = {0};
    static ost_servo_report report;
    seen s;
    fake_note *note = load_stand_in(HD, "fake_hd", "fake_hd");
    note->fail_open = 1;
    assert_int_equal(run(&s, 3, &report, &err), OST_ERR_UNAVAILABLE);
    assert_non_null(strstr(err.text, "no connection to the device"));
    /* The device is unplugged. */
    note = load_stand_in(HD, "fake_hd", "fake_hd");
    note->fail_read_at = 4;
    assert_ok(run(&s, 100, &report, &err));
    assert_int_equal(report.end, OST_SERVO_DEVICE_LOST);
    assert_int_equal(s.ticks, 3);
    assert_true(note->force[0] == 0);
    /*
     * The device is too warm from its first frame on. It returns poses and outputs no force during this
     * run.
     */
    note = load_stand_in(HD, "fake_hd", "fake_hd");
    note->warm_at = 1;
    assert_ok(run(&s, 20, &report, &err));
    assert_int_equal(s.ticks, 20);
    assert_true(note->most_force == 0);
    /* A pose that contains NaN is an invalid pose for one tick. */
    note = load_stand_in(HD, "fake_hd", "fake_hd");
    note->no_number_at = 2;
    assert_ok(run(&s, 5, &report, &err));
    assert_int_equal(s.faults, 1);
    /* The vendor's thread hangs. */
    note = load_stand_in(HD, "fake_hd", "fake_hd");
    note->hang_at = 3;
    assert_int_equal(run(&s, 100, &report, &err), OST_ERR_UNAVAILABLE);
    assert_non_null(strstr(err.text, "no call of its servo thread"));
    assert_int_equal(s.ticks, 2);
}

/* ------------------------------------------------------------------ limits */

static ost_haptic_limits limits_of(const char *spec)
{
    ost_error err = {0};
    ost_haptic *device;
    ost_haptic_limits limits;
    assert_ok(ost_haptic_open(spec, NULL, &device, &err));
    assert_true(ost_haptic_limits_get(device, &limits));
    ost_haptic_close(device);
    return limits;
}

static void openhaptics_reports_its_limits(void **state)
{
    (void)state;
    static const struct {
        double force, continuous;
        bool usable;
    } cases[] = {{3.3, 0.88, true}, {8.5, 0, true},   {0.1, 0, true}, {100, 0, true}, {0.09, 0, false},
                 {101, 0, false},   {0, 0.88, false}, {-1, 1, false}, {NAN, NAN, false}, {INFINITY, 1, false}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        fake_note *note = load_stand_in(HD, "fake_hd", "fake_hd");
        note->limit = cases[i].force;
        note->continuous = cases[i].continuous;
        const ost_haptic_limits l = limits_of("openhaptics");
        assert_int_equal(ost_haptic_limits_usable(&l), cases[i].usable);
        /*
         * If the limit of a case is negative, the stand-in reports an error, as a library without this parameter
         * does. The error must not be attributed to the device.
         */
        if (cases[i].usable)
            assert_true(l.force_n == cases[i].force && l.continuous_n == cases[i].continuous && l.torque_nm == 0);
        assert_string_equal(l.from, "HD_NOMINAL_MAX_FORCE");
    }
    fake_note *note = load_stand_in(HD, "fake_hd", "fake_hd");
    note->limit = -1;
    ost_error err = {0};
    static ost_servo_report report;
    seen s;
    assert_ok(run(&s, 3, &report, &err));
    assert_int_equal(report.end, OST_SERVO_TICKS);
}

static void dhd_has_the_limits_of_its_type(void **state)
{
    (void)state;
    /* The types are the DHD_DEVICE_... constants of the SDK. The limits were taken from the vendors' data sheets. */
    static const struct {
        int type;
        double force, torque;
        const char *from;
    } cases[] = {{33, 12, 0, "an omega.3"},       {35, 12, 0, "an omega.7"}, {104, 12, 0.2, "a sigma.7"},
                 {63, 20, 0, "a delta.3"},        {60, 8, 0, "a Falcon"},    {0, 0, 0, "type 0 of the SDK"},
                 {-1, 0, 0, "type -1 of the SDK"}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        load_stand_in(DHD, "fake_dhd", "fake_dhd")->type = cases[i].type;
        const ost_haptic_limits l = limits_of("dhd");
        assert_int_equal(ost_haptic_limits_usable(&l), cases[i].force > 0);
        if (cases[i].force > 0)
            assert_true(l.force_n == cases[i].force && l.torque_nm == cases[i].torque && l.continuous_n == 0);
        assert_string_equal(l.from, cases[i].from);
    }
    ost_error err = {0};
    ost_haptic *device;
    ost_haptic_limits l;
    assert_ok(ost_haptic_open("null", NULL, &device, &err));
    assert_false(ost_haptic_limits_get(device, &l));
    ost_haptic_close(device);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(absent_and_incomplete_libraries),
        cmocka_unit_test(dhd_frames_and_forces),
        cmocka_unit_test(dhd_rotations),
        cmocka_unit_test(dhd_failures),
        cmocka_unit_test(openhaptics_frames),
        cmocka_unit_test(openhaptics_failures),
        cmocka_unit_test(openhaptics_reports_its_limits),
        cmocka_unit_test(dhd_has_the_limits_of_its_type),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
