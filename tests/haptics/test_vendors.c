/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests the drivers of vendors' devices with stand-ins for the vendors' libraries. The tests check the calls and
 * their order, and compare poses and forces with values computed by hand. Further tests check the results if a
 * library is absent or lacks a function, and if a device is absent, is unplugged, overheats, hangs or returns NaN.
 * They also check the limits that devices report, and an operation whose motor and tools are switched by buttons of
 * a device.
 */
#include "ref/scene.h"

#include <dlfcn.h>
#include <math.h>
#include <unistd.h>

#include <osteon/haptics.h>
#include <osteon/operation.h>

#include "haptics/fake/fake.h"

#define MM OST_PM_PER_MM
#define DHD "OSTEON_DHD_LIBRARY"
#define HD "OSTEON_OPENHAPTICS_LIBRARY"
#define SPNAV "OSTEON_SPNAV_LIBRARY"

/* Returns the path of a stand-in in the build folder of make check. */
static const char *fake_file(const char *name)
{
    static char path[4096];
    const char *build = getenv("top_builddir");
    snprintf(path, sizeof path, "%s/.libs/%s.so", build ? build : ".", name);
    return path;
}

/*
 * Replaces the vendor's library with the stand-in and returns the stand-in's record, cleared.
 * Skips the test if shared objects were not built.
 */
static fake_note *load_stand_in(const char *variable, const char *name, const char *note_name)
{
    const char *file = fake_file(name);
    if (access(file, R_OK) != 0) {
        printf("# %s: built without shared objects\n", file);
        skip();
    }
    assert_int_equal(setenv(variable, file, 1), 0);
    void *handle = dlopen(file, RTLD_NOW | RTLD_LOCAL);
    assert_non_null(handle);
    fake_note *note = dlsym(handle, note_name);
    assert_non_null(note);
    memset(note, 0, sizeof *note);
    for (int a = 0; a < 3; a++)
        note->column[a][a] = 1;
    return note;
}

static int index_of(const char *name)
{
    ost_haptic_info info;
    for (int i = 0; i < ost_haptic_count(); i++)
        if (ost_haptic_describe(i, &info, NULL) == OST_OK && strcmp(info.name, name) == 0)
            return i;
    return -1;
}

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

static ost_haptic_setup at_start(void)
{
    /* A quarter turn about y rotates the tool's axis z to the bone's x. */
    const int32_t c = 759250125;
    return (ost_haptic_setup){.start = {.t = {10 * MM, 20 * MM, 30 * MM}, .qw = c, .qy = c}};
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

/* ----------------------------------------------------------- an operation */

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

/* ------------------------------------------------------------------- spnav */

static fake_feed *feed_of(void)
{
    void *handle = dlopen(fake_file("fake_spnav"), RTLD_NOW | RTLD_LOCAL);
    assert_non_null(handle);
    fake_feed *feed = dlsym(handle, "fake_spnav_feed");
    assert_non_null(feed);
    memset(feed, 0, sizeof *feed);
    return feed;
}

static void put_event(fake_feed *feed, int type, int a, int b, int c, int d, int e, int f)
{
    const int event[8] = {type, a, b, c, d, e, f, 16};
    memcpy(feed->event[feed->count++], event, sizeof event);
}

static void read_on(ost_haptic *device, int ticks, ost_haptic_state *s)
{
    for (int i = 0; i < ticks; i++)
        assert_int_equal(ost_haptic_read(device, s), OST_HAPTIC_FRESH);
}

static void spnav_moves_while_it_is_pushed(void **state)
{
    (void)state;
    fake_note *note = load_stand_in(SPNAV, "fake_spnav", "fake_spnav");
    fake_feed *feed = feed_of();
    /* The tool's x, y and z axes are the bone's -z, y and x axes. */
    const ost_haptic_setup setup = at_start();
    ost_error err = {0};
    ost_haptic *device;
    ost_haptic_state s;
    assert_ok(ost_haptic_open("spnav:speed=10,turn=90", &setup, &device, &err));
    read_on(device, 50, &s);
    assert_memory_equal(&s.pose.t, &setup.start.t, sizeof s.pose.t);
    assert_int_equal(s.tool, -1);
    /*
     * The device is pushed away from the operator (libspnav's z) beyond its full deflection. The
     * tool therefore moves at 10 mm/s along its -z axis. One event is sufficient for all
     * following ticks.
     */
    put_event(feed, 1, 5, -9, 500, 0, 0, 0);
    read_on(device, 1000, &s);
    assert_true(llabs(s.pose.t.x - 0) < 1000 && s.pose.t.y == 20 * MM && s.pose.t.z == 30 * MM);
    /* A push to the left by half of the range beyond the dead zone moves the tool at 5 mm/s. */
    put_event(feed, 1, -180, 0, 0, 0, 0, 0);
    read_on(device, 200, &s);
    assert_true(llabs(s.pose.t.z - 31 * MM) < 1000 && llabs(s.pose.t.x) < 1000);
    /* After release the tool does not move. */
    put_event(feed, 1, 0, 0, 0, 0, 0, 0);
    read_on(device, 100, &s);
    assert_true(llabs(s.pose.t.z - 31 * MM) < 1000);
    /* A rotation about the device's y for one second adds a quarter turn about the bone's y. */
    put_event(feed, 1, 0, 0, 0, 0, 350, 0);
    read_on(device, 1000, &s);
    assert_true(abs(s.pose.qw) < 1 << 10 && abs(s.pose.qy - OST_Q30_ONE) < 1 << 10 && abs(s.pose.qx) < 1 << 10 &&
                abs(s.pose.qz) < 1 << 10);
    /* A button is reported while it is pressed. Button numbers above 31 are ignored. */
    put_event(feed, 1, 0, 0, 0, 0, 0, 0);
    put_event(feed, 2, 1, 1, 0, 0, 0, 0);
    put_event(feed, 2, 1, 5, 0, 0, 0, 0);
    put_event(feed, 2, 1, 40, 0, 0, 0, 0);
    read_on(device, 1, &s);
    assert_int_equal(s.buttons, 1 << 1 | 1 << 5);
    put_event(feed, 2, 0, 1, 0, 0, 0, 0);
    read_on(device, 1, &s);
    assert_int_equal(s.buttons, 1 << 5);
    ost_haptic_close(device);
    assert_string_equal(note->calls, "oc");
}

static void spnav_hold_option_and_failures(void **state)
{
    (void)state;
    const int spnav = index_of("spnav");
    fake_note *note = load_stand_in(SPNAV, "fake_spnav", "fake_spnav");
    fake_feed *feed = feed_of();
    const ost_haptic_setup setup = {.start = {.qw = OST_Q30_ONE}};
    ost_error err = {0};
    ost_haptic *device;
    ost_haptic_info info;
    ost_haptic_state s;
    assert_ok(ost_haptic_describe(spnav, &info, &err));
    assert_true(info.available);
    assert_string_equal(note->calls, "oc");
    note = load_stand_in(SPNAV, "fake_spnav", "fake_spnav");
    assert_ok(ost_haptic_open("spnav:hold=1", &setup, &device, &err));
    /* The library allows only one connection. Listing the devices must not affect the open connection. */
    assert_ok(ost_haptic_describe(spnav, &info, &err));
    assert_true(info.available);
    assert_string_equal(note->calls, "o");
    put_event(feed, 1, 350, 0, 0, 0, 0, 0);
    read_on(device, 100, &s);
    assert_true(s.pose.t.x == 0);
    assert_int_equal(s.tool, -1);
    put_event(feed, 2, 1, 0, 0, 0, 0, 0);
    read_on(device, 100, &s);
    assert_true(llabs(s.pose.t.x - 2 * MM) < 1000);
    put_event(feed, 2, 0, 0, 0, 0, 0, 0);
    read_on(device, 100, &s);
    assert_true(llabs(s.pose.t.x - 2 * MM) < 1000);
    /* The device is unplugged. */
    put_event(feed, 3, 1, 0, 0, 0, 0, 0);
    assert_int_equal(ost_haptic_read(device, &s), OST_HAPTIC_LOST);
    ost_haptic_close(device);
    /* The daemon ends. */
    note = load_stand_in(SPNAV, "fake_spnav", "fake_spnav");
    feed_of();
    note->hang_at = 3;
    assert_ok(ost_haptic_open("spnav", &setup, &device, &err));
    read_on(device, 2, &s);
    assert_int_equal(ost_haptic_read(device, &s), OST_HAPTIC_LOST);
    ost_haptic_close(device);
    /* The daemon is not running. */
    note = load_stand_in(SPNAV, "fake_spnav", "fake_spnav");
    note->fail_open = 1;
    assert_int_equal(ost_haptic_open("spnav", &setup, &device, &err), OST_ERR_UNAVAILABLE);
    assert_non_null(strstr(err.text, "spacenavd does not answer"));
    assert_ok(ost_haptic_describe(spnav, &info, &err));
    assert_false(info.available);
    assert_non_null(strstr(info.reason, "spacenavd does not answer"));
    assert_string_equal(note->calls, "oo");
    assert_int_equal(ost_haptic_open("spnav:speed=0", &setup, &device, &err), OST_ERR_USAGE);
    assert_int_equal(ost_haptic_open("spnav:size=3", &setup, &device, &err), OST_ERR_USAGE);
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
        cmocka_unit_test(buttons_of_devices_switch_motor_and_tool),
        cmocka_unit_test(spnav_moves_while_it_is_pushed),
        cmocka_unit_test(spnav_hold_option_and_failures),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
