/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests the devices that are always available. The tests check the list of devices, the errors for
 * invalid specs, and the ticks that scripts and sessions replay. The simulated device is compared
 * with the equations of its mechanics.
 * Covers: REQ-DEVICES
 */
#include "harness.h"

#include <math.h>
#include <unistd.h>

#include <osteon/haptics.h>
#include <osteon/session.h>

#include "io/scratch_group.h"

#define MM OST_PM_PER_MM

static ost_path straight(size_t count, ost_pm step)
{
    ost_error err = {0};
    ost_path path;
    assert_ok(ost_path_init(&path, count, &err));
    for (size_t i = 0; i < count; i++)
        path.ticks[i] = (ost_tick){.t_ns = (int64_t)i * 1000000,
                                   .rpm = OST_RPM_ON,
                                   .pose = {.t = {(int64_t)i * step, MM, -MM}, .qw = OST_Q30_ONE}};
    return path;
}

static void devices_are_listed(void **state)
{
    (void)state;
    ost_error err = {0};
    ost_haptic_info info;
    assert_int_equal(ost_haptic_count(), 12);
    for (int i = 0; i < ost_haptic_count(); i++) {
        assert_ok(ost_haptic_describe(i, &info, &err));
        assert_true(info.name[0] && info.description[0]);
        /* The first six devices are always available. A reason is given for each other device that is unavailable. */
        assert_true(i < 6 ? info.available : info.available || info.reason[0]);
        assert_int_equal((info.caps & OST_HAPTIC_FORCE) != 0, info.max_force_n > 0);
    }
    assert_int_equal(ost_haptic_describe(ost_haptic_count(), &info, &err), OST_ERR_USAGE);
    assert_int_equal(ost_haptic_describe(-1, &info, &err), OST_ERR_USAGE);
}

static void wrong_specs_are_refused(void **state)
{
    (void)state;
    ost_path path = straight(2, MM);
    const ost_haptic_setup setup = {.path = &path, .start = ost_pose_identity()};
    static const struct {
        const char *spec, *message;
    } cases[] = {
        {"omni", "unknown device 'omni'; expected null, script, replay, sim, motion, mouse, openhaptics, dhd, spnav, "
                 "inverse3, udp or openxr"},
        {"", "unknown device ''"},
        {"si", "unknown device"},
        {"null:x=1", "unknown option 'x'"},
        {"sim:grip", "'grip' is not key=value"},
        {"sim:grip=weak", "expected light, normal or firm"},
        {"sim:seed=-1", "expected a whole number from 0"},
        {"sim:seed=1.5", "whole number"},
        {"sim:tremor=5001", "from 0 to 5000"},
        {"sim:seed=1,", "no option after the last ','"},
        {"sim:=1", "is not key=value"},
        {"script:a=b", "unknown option 'a'"},
        {"replay", "no session given"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        ost_error err = {0};
        ost_haptic *device = (ost_haptic *)&path;
        assert_int_equal(ost_haptic_open(cases[i].spec, &setup, &device, &err), OST_ERR_USAGE);
        assert_null(device);
        if (!strstr(err.text, cases[i].message))
            fail_msg("'%s': the error '%s' does not contain '%s'", cases[i].spec, err.text, cases[i].message);
    }
    ost_error err = {0};
    ost_haptic *device;
    assert_int_equal(ost_haptic_open("script", NULL, &device, &err), OST_ERR_USAGE);
    assert_int_equal(ost_haptic_open("sim", NULL, &device, &err), OST_ERR_USAGE);
    assert_ok(ost_haptic_open("null", NULL, &device, &err));
    assert_string_equal(ost_haptic_name(device), "null");
    ost_haptic_close(device);
    ost_path_free(&path);
}

static void plays_back_scripts_and_sessions(void **state)
{
    (void)state;
    ost_error err = {0};
    ost_path path = straight(50, MM / 10);
    path.ticks[20].tool = 3;
    char name[4200];
    snprintf(name, sizeof name, "%s/d.session", folder);
    ost_session_header *header;
    ost_recorder *recorder;
    assert_ok(ost_session_header_create(&header, &err));
    assert_ok(ost_recorder_open(name, header, NULL, &recorder, &err));
    ost_session_header_free(header);
    for (size_t i = 0; i < path.count; i++) {
        const ost_record record = {.kind = OST_RECORD_TICK, .as.tick = {.number = i, .tick = path.ticks[i]}};
        assert_true(ost_recorder_put(recorder, &record));
    }
    assert_ok(ost_recorder_close(recorder, NULL, &err));
    const ost_haptic_setup setup = {.path = &path, .session = name, .start = path.ticks[0].pose};
    static const char *const specs[] = {"script", "replay"};
    for (int d = 0; d < 2; d++) {
        ost_haptic *device;
        assert_ok(ost_haptic_open(specs[d], &setup, &device, &err));
        for (size_t i = 0; i < path.count; i++) {
            ost_haptic_state s;
            assert_int_equal(ost_haptic_read(device, &s), OST_HAPTIC_FRESH);
            assert_memory_equal(&s.pose, &path.ticks[i].pose, sizeof s.pose);
            assert_int_equal(s.tool, path.ticks[i].tool);
            ost_haptic_write(device, &(ost_wrench){{1, 2, 3}, {0}}); /* Writing a force must have no effect. */
        }
        ost_haptic_state s;
        assert_int_equal(ost_haptic_read(device, &s), OST_HAPTIC_ENDED);
        assert_int_equal(ost_haptic_read(device, &s), OST_HAPTIC_ENDED);
        ost_haptic_close(device);
    }
    ost_path_free(&path);
}

/* --------------------------------------------------------- the sim device */

static ost_haptic *open_sim(const char *spec, const ost_path *path)
{
    ost_error err = {0};
    ost_haptic *device;
    assert_ok(ost_haptic_open(spec, &(ost_haptic_setup){.path = path}, &device, &err));
    return device;
}

static double read_x_mm(ost_haptic *device)
{
    ost_haptic_state s;
    assert_int_equal(ost_haptic_read(device, &s), OST_HAPTIC_FRESH);
    /* Positions are multiples of the encoder step. */
    assert_int_equal(s.pose.t.x % (55 * (MM / 1000)), 0);
    assert_int_equal(s.pose.t.y % (55 * (MM / 1000)), 0);
    return ost_pm_to_mm(s.pose.t.x);
}

/* Applies a constant force to a hand at rest. In both directions, F = k * x must hold to within the friction. */
static void force_is_balanced_by_the_grip(void **state)
{
    (void)state;
    static const struct {
        const char *spec;
        double k;
    } hands[] = {{"sim:grip=light", 100}, {"sim", 150}, {"sim:grip=firm", 400}};
    ost_path path = straight(1, 0);
    for (int h = 0; h < 3; h++)
        for (int sign = -1; sign <= 1; sign += 2) {
            ost_haptic *device = open_sim(hands[h].spec, &path);
            double x = 0;
            for (int i = 0; i < 2000; i++) {
                x = read_x_mm(device);
                ost_haptic_write(device, &(ost_wrench){{sign * 1.0, 0, 0}, {0}});
            }
            assert_true(fabs(x) >= (1.0 - 0.26) / hands[h].k * 1000 - 0.0275);
            assert_true(fabs(x) <= (1.0 + 0.26) / hands[h].k * 1000 + 0.0275);
            assert_true(sign * x > 0);
            /* Friction keeps the device at rest. */
            assert_true(read_x_mm(device) == x);
            /* A force beyond the limit of the motors is clamped. A force that is not finite is treated as zero. */
            for (int i = 0; i < 2000; i++) {
                ost_haptic_write(device, &(ost_wrench){{sign * 1e9, 0, 0}, {0}});
                x = read_x_mm(device);
            }
            assert_true(fabs(x) <= (3.3 + 0.26) / hands[h].k * 1000 + 0.0275);
            for (int i = 0; i < 2000; i++) {
                ost_haptic_write(device, &(ost_wrench){{NAN, 0, 0}, {0}});
                x = read_x_mm(device);
            }
            assert_true(fabs(x) <= 0.26 / hands[h].k * 1000 + 0.0275);
            ost_haptic_close(device);
        }
    ost_path_free(&path);
}

/* A force below the friction does not move the device. */
static void force_below_the_friction_moves_nothing(void **state)
{
    (void)state;
    ost_path path = straight(1, 0);
    ost_haptic *device = open_sim("sim:grip=light", &path);
    for (int i = 0; i < 100; i++) {
        ost_haptic_write(device, &(ost_wrench){{0.25, 0, 0}, {0}});
        assert_true(read_x_mm(device) == 0);
    }
    ost_haptic_close(device);
    ost_path_free(&path);
}

/*
 * The device follows a hand that moves at v = 0.05 m/s. With a viscosity of 0.2 N s/m and a friction of 0.26 N, the lag
 * is (0.2 v + 0.26) / k, where k is the stiffness of the hand.
 */
static void device_follows_the_hand(void **state)
{
    (void)state;
    ost_path path = straight(1000, MM / 20);
    ost_haptic *device = open_sim("sim", &path);
    double x = 0;
    for (int i = 0; i < 999; i++)
        x = read_x_mm(device);
    const double behind = (0.2 * 0.05 + 0.26) / 150 * 1000;
    assert_true(fabs(999 * 0.05 - x - behind) < 0.0275 + 0.05);
    /* After the last tick of the plan, the device stops near the last position of the plan. */
    for (int i = 0; i < 2000; i++)
        x = read_x_mm(device);
    assert_true(fabs(999 * 0.05 - x) <= 0.26 / 150 * 1000 + 0.0275);
    ost_haptic_close(device);
    ost_path_free(&path);
}

/*
 * Presses the device 3 mm into a wall of stiffness k at x = 0. Returns the range of motion
 * after the first second, in mm.
 */
static double wall_range_mm(const char *spec, double k)
{
    ost_path path = straight(1, 0);
    path.ticks[0].pose.t.x = 3 * MM;
    ost_haptic *device = open_sim(spec, &path);
    double lo = 1e9, hi = -1e9;
    for (int i = 0; i < 3000; i++) {
        const double x = read_x_mm(device);
        ost_haptic_write(device, &(ost_wrench){{x > 0 ? -k * x * 1e-3 : 0, 0, 0}, {0}});
        if (i >= 1000) {
            lo = x < lo ? x : lo;
            hi = x > hi ? x : hi;
        }
    }
    ost_haptic_close(device);
    ost_path_free(&path);
    return hi - lo;
}

/*
 * The closed loop can oscillate. With a friction force f, the loop comes to rest if the stiffness is at most 2 * f /
 * (encoder step) = 2 * 0.26 N / 55 um = 9.5 kN/m (Diolaiti et al. 2006). Without friction, stability depends on the
 * damping of the hand, so with a light grip, the loop oscillates at a lower stiffness. A range of two encoder steps
 * counts as rest.
 */
static void closed_loop_is_stable_up_to_a_stiffness(void **state)
{
    (void)state;
    static const double stiffness[] = {150, 300, 600, 1200, 2400, 5000, 20000};
    for (int i = 0; i < 7; i++)
        printf("# wall of %5.0f N/m, no friction, range of motion: light %6.3f, normal %6.3f, firm %6.3f mm\n",
               stiffness[i], wall_range_mm("sim:grip=light,friction=0", stiffness[i]),
               wall_range_mm("sim:friction=0", stiffness[i]), wall_range_mm("sim:grip=firm,friction=0", stiffness[i]));
    /*
     * For a device without friction, the literature recommends a stiffness of 300 N/m for a light grip and
     * 400 N/m for a normal grip.
     */
    const double rest_mm = 0.111, swing = 0.3;
    assert_true(wall_range_mm("sim:grip=light", 300) <= rest_mm);
    assert_true(wall_range_mm("sim:grip=light,friction=0", 300) <= rest_mm);
    assert_true(wall_range_mm("sim", 400) <= rest_mm && wall_range_mm("sim:friction=0", 400) <= rest_mm);
    assert_true(wall_range_mm("sim:grip=firm", 400) <= rest_mm);
    assert_true(wall_range_mm("sim:grip=firm,friction=0", 2400) <= rest_mm);
    assert_true(wall_range_mm("sim:grip=light", 9000) <= rest_mm && wall_range_mm("sim", 9000) <= rest_mm &&
                wall_range_mm("sim:grip=firm", 9000) <= rest_mm);
    assert_true(wall_range_mm("sim:grip=light,friction=0", 2400) > swing);
    assert_true(wall_range_mm("sim:friction=0", 5000) > swing);
}

static void equal_seeds_give_equal_tremor(void **state)
{
    (void)state;
    ost_path path = straight(500, MM / 50);
    ost_haptic *a = open_sim("sim:tremor=300,seed=7", &path), *b = open_sim("sim:tremor=300,seed=7", &path),
               *c = open_sim("sim:tremor=300,seed=8", &path), *still = open_sim("sim", &path);
    int other = 0;
    double most = 0;
    for (int i = 0; i < 2000; i++) {
        const double x = read_x_mm(a);
        assert_true(read_x_mm(b) == x);
        other += read_x_mm(c) != x;
        const double away = fabs(read_x_mm(still) - x);
        most = away > most ? away : most;
    }
    assert_true(other > 100);
    assert_true(most > 0.05 && most < 1.5);
    ost_haptic_close(a);
    ost_haptic_close(b);
    ost_haptic_close(c);
    ost_haptic_close(still);
    ost_path_free(&path);
}

/* Every hand-held device must have a button for the motor. A device with two buttons must also have a button for the
   next tool. */
static void devices_have_default_buttons(void **state)
{
    (void)state;
    static const struct {
        const char *device, *buttons;
    } known[] = {{"mouse", "space=motor"},
                 {"openhaptics", "stylus1=motor,stylus2=next-tool"},
                 {"dhd", "button1=motor,button2=next-tool,button3=clutch,button4=home"},
                 {"spnav", "left=motor-switch,right=next-tool"},
                 {"inverse3", "a=motor,b=next-tool,c=clutch,d=home"},
                 {"udp", "button1=motor,button2=next-tool,button3=clutch,button4=home"},
                 {"openxr", "trigger=motor,menu=next-tool,squeeze=none"},
                 {"null", ""}, {"script", ""}, {"replay", ""}, {"sim", ""}, {"motion", ""}};
    ost_error err = {0};
    ost_action of[OST_BUTTONS_MAX];
    for (size_t k = 0; k < sizeof known / sizeof known[0]; k++) {
        ost_haptic_info info = {0};
        for (int i = 0; i < ost_haptic_count() && strcmp(info.name ? info.name : "", known[k].device) != 0; i++)
            assert_ok(ost_haptic_describe(i, &info, &err));
        assert_string_equal(info.name, known[k].device);
        char text[200] = "";
        assert_ok(ost_buttons_parse(&info, NULL, of, &err));
        for (int i = 0; i < info.button_count; i++) {
            const size_t used = strlen(text);
            snprintf(text + used, sizeof text - used, "%s%s=%s", used ? "," : "", info.buttons[i].name,
                     ost_action_name(of[i]));
        }
        assert_string_equal(text, known[k].buttons);
        if (info.button_count == 0) {
            assert_int_equal(ost_buttons_parse(&info, "1=motor", of, &err), OST_ERR_USAGE);
            continue;
        }
        assert_ok(ost_buttons_parse(&info, text, of, &err));
        /* A button is selected by its number. The other buttons must keep their actions. */
        assert_ok(ost_buttons_parse(&info, "1=clutch", of, &err));
        assert_int_equal(of[0], OST_ACTION_CLUTCH);
        for (int i = 1; i < info.button_count; i++)
            assert_int_equal(of[i], info.buttons[i].action);
        assert_int_equal(ost_buttons_parse(&info, "1=cut", of, &err), OST_ERR_USAGE);
        assert_non_null(strstr(err.text, "next-tool"));
        assert_int_equal(ost_buttons_parse(&info, "9=motor", of, &err), OST_ERR_USAGE);
        assert_int_equal(ost_buttons_parse(&info, "lever=motor", of, &err), OST_ERR_USAGE);
        assert_int_equal(of[0], OST_ACTION_CLUTCH); /* An error must not change anything. */
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(devices_are_listed),
        cmocka_unit_test(wrong_specs_are_refused),
        cmocka_unit_test(plays_back_scripts_and_sessions),
        cmocka_unit_test(force_is_balanced_by_the_grip),
        cmocka_unit_test(force_below_the_friction_moves_nothing),
        cmocka_unit_test(device_follows_the_hand),
        cmocka_unit_test(closed_loop_is_stable_up_to_a_stiffness),
        cmocka_unit_test(equal_seeds_give_equal_tremor),
        cmocka_unit_test(devices_have_default_buttons),
    };
    return cmocka_run_group_tests(tests, scratch_set_up, scratch_tear_down);
}
