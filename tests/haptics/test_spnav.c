/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests the `spnav` driver with a stand-in for libspnav, which delivers the events that a test prepares: motion while
 * the device is pushed, buttons, and failures of the device and of its daemon.
 *
 * Covers: REQ-DEVICES
 */
#include "fake_library.h"

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
    /* The dead zone ends at 10 counts, and full deflection is 350 counts. A push to the left by 180 counts is halfway
       between them, so the tool moves at 5 mm/s. */
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
        cmocka_unit_test(spnav_moves_while_it_is_pushed),
        cmocka_unit_test(spnav_hold_option_and_failures),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
