/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests optional parts of the force. The coupling of the tool's orientation is compared with
 * springs in series, and a handle with this coupling must come to rest in a closed loop. Vibration
 * is compared with its formula. A file of parameters is read and written.
 * Covers: REQ-FORCE
 */
#include "force/press.h"

#include <unistd.h>

static ost_pose turned_mm(double x, double y, double z, double about_y)
{
    const double q[4] = {cos(about_y / 2), 0, sin(about_y / 2), 0};
    return (ost_pose){.t = {(ost_pm)(x * 1e9), (ost_pm)(y * 1e9), (ost_pm)(z * 1e9)},
                      .qw = (int32_t)lrint(q[0] * OST_Q30_ONE),
                      .qy = (int32_t)lrint(q[2] * OST_Q30_ONE)};
}

/* Makes a half space 30 mm wide with voxels of 0.5 mm; its surface is at z = 19.75 mm. */
static ost_bone *half_space_30mm(ost_backend *backend, int16_t hu)
{
    return half_space(backend, 60, 60, MM / 2, 40, hu);
}

/*
 * One blunt point lies on the bone at distance r from the tool's axis, and the hand moves down
 * by h. Because the point stays in place, the tool moves down by x and rotates by the angle a, with
 * x = r sin a. The spring of stiffness K carries the point's force, F = K (h - x). The rotational
 * spring of stiffness Kr carries the torque, F r cos a = Kr a. For small angles, F = h / (1/K + r^2/Kr).
 */
static void torque_rotates_the_tool(void **state)
{
    skip_without_samples(*state);
    ost_error err = {0};
    ost_bone *bone = half_space_30mm(*state, 800);
    const double r = 4e-3, h = 1e-3, top = 19.75;
    ost_shell_point point = {.at = {r, 0, 0}, .inward = {0, 0, 1}, .area = 1e-4};
    ost_force_params params = ost_force_defaults();
    params.turn_stiffness = 0.05;
    ost_force *force = force_of(bone, &params, &point, 1);
    ost_force_result out;
    for (int i = 0; i < 1500; i++) {
        const ost_pose hand = turned_mm(15, 15, top - (i < 200 ? h * 1e3 * i / 200 : h * 1e3), 0);
        assert_ok(ost_force_step(force, 0, &hand, 1e-3, &out, &err));
        assert_ok(ost_pose_check(&out.tool, &err));
    }
    const double expected = h / (1 / params.stiffness + r * r / params.turn_stiffness);
    assert_near("felt, N", out.force_n[2], expected, 0.01);
    assert_near("felt, N m", fabs(out.torque_nm[1]), expected * r, 0.01);
    assert_near("turned by, rad", 2 * fabs((double)out.tool.qy) / OST_Q30_ONE, expected * r / params.turn_stiffness,
                0.01);
    assert_near("sunk by, mm", top - (double)out.tool.t.z * 1e-9, (h - expected / params.stiffness) * 1e3, 0.02);
    assert_true(fabs(out.torque_nm[0]) < 1e-6 && abs(out.tool.qx) < 100);
    ost_force_free(force);

    /*
     * If the rotational stiffness is 0, the tool has the orientation of the hand, and the force deflects only the
     * spring of stiffness K.
     */
    params.turn_stiffness = 0;
    force = force_of(bone, &params, &point, 1);
    for (int i = 0; i < 1500; i++) {
        const ost_pose hand = turned_mm(15, 15, top - (i < 200 ? h * 1e3 * i / 200 : h * 1e3), 0.01);
        assert_ok(ost_force_step(force, 0, &hand, 1e-3, &out, &err));
        assert_int_equal(out.tool.qy, hand.qy);
    }
    assert_true(out.force_n[2] > 0.9 * params.stiffness * (h - r * 0.01) &&
                out.force_n[2] < 1.2 * params.stiffness * h);
    ost_force_free(force);
    ost_bone_free(bone);
}

/* In air the tool follows the hand through any rotation, even beyond half a turn. */
static void tool_follows_the_hand_in_air(void **state)
{
    skip_without_samples(*state);
    ost_error err = {0};
    ost_bone *bone = half_space_30mm(*state, 800);
    ost_shell_point point = {.at = {4e-3, 0, 0}, .inward = {0, 0, 1}, .area = 1e-6};
    ost_force_params params = ost_force_defaults();
    params.turn_stiffness = 0.5;
    ost_force *force = force_of(bone, &params, &point, 1);
    ost_force_result out = {0};
    ost_pose hand = {0};
    for (int i = 0; i < 4400; i++) {
        hand = turned_mm(15, 15, 40, 1e-3 * (i < 4000 ? i : 4000));
        assert_ok(ost_force_step(force, 0, &hand, 1e-3, &out, &err));
    }
    const double product = ((double)hand.qw * out.tool.qw + (double)hand.qy * out.tool.qy) / OST_Q30_ONE / OST_Q30_ONE;
    assert_true(fabs(product) > 1 - 1e-6);
    assert_int_equal(out.tool.t.z, hand.t.z);
    assert_true(fabs(out.torque_nm[1]) < 1e-5 && fabs(out.force_n[2]) < 1e-6);
    ost_force_free(force);
    ost_bone_free(bone);
}

/*
 * A handle with a moment of inertia of 0.15 g m2 rotates about y. A hand holds it in a light, normal
 * or firm grip (0.2, 0.3 or 0.8 N m/rad) with a target of 0.2 rad, and a blunt edge rests on the
 * bone. The handle must come to rest, although there is a delay of one tick and the encoder steps
 * are 0.5 mrad.
 */
static void rotating_handle_comes_to_rest(void **state)
{
    skip_without_samples(*state);
    ost_error err = {0};
    ost_bone *bone = half_space_30mm(*state, 800);
    ost_shell_point points[2] = {{.at = {8e-3, 0, 0}, .inward = {0, 0, 1}, .area = 1e-6},
                                 {.at = {-8e-3, 0, 0}, .inward = {0, 0, 1}, .area = 1e-6}};
    for (int grip = 0; grip < 3; grip++) {
        const double inertia = 1.5e-4, hand_k = (double[]){0.2, 0.3, 0.8}[grip],
                     hand_d = (double[]){1e-3, 3e-3, 8e-3}[grip], final_target = 0.2;
        ost_force_params params = ost_force_defaults();
        params.turn_stiffness = 0.5;
        ost_force *force = force_of(bone, &params, points, 2);
        ost_safety safety;
        ost_safety_begin(&safety, NULL);
        ost_force_result out;
        double at = 0, speed = 0, torque = 0, swing = 0;
        for (int i = 0; i < 3000; i++) {
            for (int part = 0; part < 10; part++) {
                const double target = i < 400 ? final_target * i / 400 : final_target;
                speed += (hand_k * (target - at) - hand_d * speed + torque) / inertia * 1e-4;
                at += speed * 1e-4;
            }
            const ost_pose hand = turned_mm(15, 15, 19.75, rint(at / 5e-4) * 5e-4);
            assert_ok(ost_force_step(force, 0, &hand, 1e-3, &out, &err));
            assert_int_equal(ost_safety_step(&safety, &hand, true, 0, 1e-3, out.force_n, out.torque_nm),
                             OST_SAFETY_GIVEN);
            torque = out.torque_nm[1];
            swing = i >= 2000 ? fmax(swing, fabs(speed)) : 0;
        }
        print_message("grip %d: angle %.3f rad, target %.1f rad, torque %.4f N m, speed at most %.4f rad/s\n", grip, at,
                      final_target, torque, swing);
        assert_true(swing < 0.05 && torque < -0.002 && at > 0.01 && at < final_target);
        ost_force_free(force);
    }
    ost_bone_free(bone);
}

/*
 * Compares two runs, one with and one without runout. As in an operation, the motor turns the pose by -phi about the
 * tool's z axis. At every tick, the difference between the forces must have the value that the formula gives. In the
 * handle's axes, the angle of this difference is phi, so the difference turns once per revolution of the tool. The tool
 * is a point on the z axis, so its contact does not depend on the rotation.
 */
static void runout_equals_its_formula(void **state)
{
    skip_without_samples(*state);
    ost_error err = {0};
    ost_shell_point point = {.at = {0, 0, 0}, .inward = {0, 0, 1}, .area = 1e-4, .cutting = true};
    ost_bone *bone = half_space_30mm(*state, REFERENCE_HU);
    ost_force_params quiet = ost_force_defaults(), loud = quiet;
    loud.runout = 0.1;
    ost_force *a = force_of(bone, &quiet, &point, 1), *b = force_of(bone, &loud, &point, 1);
    const double step = quiet.speed * 1e-3; /* rad per tick */
    double most = 0;
    for (int i = 0; i < 300; i++) {
        ost_force_result without, with;
        const double phi = step * (i + 1);
        ost_pose hand = turned_mm(15, 15, 19.75 - 0.01 * i, 0);
        hand.qw = (int32_t)lrint(cos(-step * i / 2) * OST_Q30_ONE);
        hand.qz = (int32_t)lrint(sin(-step * i / 2) * OST_Q30_ONE);
        if (i > 0) {
            ost_force_motor(a, quiet.speed, -step);
            ost_force_motor(b, quiet.speed, -step);
        }
        assert_ok(ost_force_step(a, 0, &hand, 1e-3, &without, &err));
        assert_ok(ost_force_step(b, 0, &hand, 1e-3, &with, &err));
        const double amplitude = quiet.scale * without.axial_n * ost_force_density(&quiet, REFERENCE_HU) /
                                 quiet.reference_density * loud.runout;
        assert_true(fabs(with.force_n[0] - without.force_n[0] - amplitude * cos(phi)) < 1e-5 * (1 + amplitude));
        assert_true(fabs(with.force_n[1] - without.force_n[1] - amplitude * sin(phi)) < 1e-5 * (1 + amplitude));
        most = fmax(most, amplitude);
    }
    assert_true(most > 0.001);
    ost_force_free(a);
    ost_force_free(b);
    ost_bone_free(bone);
}

/*
 * Compares two runs along the same path, with and without vibration. At every tick, the difference
 * between the forces must have the value that the formula gives.
 */
static void vibration_equals_its_formula(void **state)
{
    skip_without_samples(*state);
    enum { SPOKES = 16, RINGS = 8 };
    static ost_shell_point points[SPOKES * RINGS];
    ost_error err = {0};
    const double radius = 8e-3;
    for (int i = 0; i < SPOKES * RINGS; i++) {
        const double lo = radius * (i / SPOKES) / RINGS, hi = lo + radius / RINGS, r = (lo + hi) / 2,
                     angle = 2 * PI * (i % SPOKES) / SPOKES;
        points[i] = (ost_shell_point){.at = {r * cos(angle), r * sin(angle), 0},
                                      .inward = {0, 0, 1},
                                      .area = PI * (hi * hi - lo * lo) / SPOKES,
                                      .cutting = true};
    }
    for (int soft = 0; soft < 2; soft++) {
        const int hu = soft ? 500 : REFERENCE_HU;
        ost_bone *bone = half_space_30mm(*state, (int16_t)hu);
        ost_force_params quiet = ost_force_defaults(), loud = quiet;
        loud.vibration = 0.2;
        loud.runout = 0.1;
        loud.teeth = 12;
        ost_force *a = force_of(bone, &quiet, points, SPOKES * RINGS),
                  *b = force_of(bone, &loud, points, SPOKES * RINGS);
        double most = 0;
        for (int i = 0; i < 300; i++) {
            ost_force_result without, with;
            const ost_pose hand = turned_mm(15, 15, 19.75 - 0.01 * i, 0);
            assert_ok(ost_force_step(a, 0, &hand, 1e-3, &without, &err));
            assert_ok(ost_force_step(b, 0, &hand, 1e-3, &with, &err));
            assert_memory_equal(&with.tool, &without.tool, sizeof with.tool);
            const double amplitude = quiet.scale * without.axial_n * ost_force_density(&quiet, hu) /
                                     quiet.reference_density;
            const double phi = quiet.speed * 1e-3 * (i + 1);
            assert_true(fabs(with.force_n[0] - without.force_n[0] - amplitude * loud.runout * cos(phi)) <
                        1e-6 * (1 + amplitude));
            assert_true(fabs(with.force_n[1] - without.force_n[1] - amplitude * loud.runout * sin(phi)) <
                        1e-6 * (1 + amplitude));
            assert_true(fabs(with.force_n[2] - without.force_n[2] - amplitude * loud.vibration * sin(12 * phi)) <
                        1e-6 * (1 + amplitude));
            most = fmax(most, amplitude);
        }
        print_message("%d HU: the vibration is a share of at most %.3f N\n", hu, most);
        assert_true(most > (soft ? 0.005 : 0.1));
        ost_force_free(a);
        ost_force_free(b);
        ost_bone_free(bone);
    }
    /* By default vibration is off. The tick rate limits the frequency of the vibration. */
    ost_force_params p = ost_force_defaults();
    assert_true(p.vibration == 0 && p.runout == 0 && p.turn_stiffness == 0);
    p.vibration = 0.1;
    p.teeth = 120;
    ost_bone *bone = half_space_30mm(*state, 500);
    ost_force *force;
    assert_int_equal(ost_force_create(bone, &p, &force, &err), OST_ERR_RANGE);
    ost_bone_free(bone);
}

/* Even with the strongest vibration, the force on the hand stays within the limits for saturation and slew. */
static void vibration_stays_within_the_safety_limits(void **state)
{
    (void)state;
    ost_safety safety;
    ost_safety_params params = ost_safety_defaults();
    params.ramp_s = 0;
    ost_safety_begin(&safety, &params);
    double before = 0;
    for (int i = 0; i < 500; i++) {
        double force[3] = {0, 0, 2 + 8 * sin(2 * PI * 120 * i * 1e-3)}, torque[3] = {0};
        const ost_pose hand = turned_mm(0, 0, 0, 0);
        assert_int_equal(ost_safety_step(&safety, &hand, true, 0, 1e-3, force, torque), OST_SAFETY_GIVEN);
        assert_true(fabs(force[2]) <= params.max_force_n && fabs(force[2] - before) <= params.slew_n + 1e-12);
        before = force[2];
    }
}

/* ---------------------------------------------------------- parameter files */

static void write_text(const char *path, const char *text)
{
    FILE *out = fopen(path, "w");
    assert_non_null(out);
    fputs(text, out);
    fclose(out);
}

static void parameter_file_is_read_and_written(void **state)
{
    (void)state;
    ost_error err = {0};
    char path[64];
    snprintf(path, sizeof path, "force_%ld.params", (long)getpid());
    ost_force_params f = ost_force_defaults();
    ost_safety_params s = ost_safety_defaults();
    write_text(path, "# a light reamer\n\n  stiffness: 250   # N/m\nenergy: 4.5e7\r\nmax_force: 2\nstale_ticks: "
                     "3\ndead_man: 3\ndensity_per_hu: 0.001067");
    assert_ok(ost_force_params_read(path, &f, &s, &err));
    assert_true(f.stiffness == 250 && f.energy == 4.5e7 && s.max_force_n == 2 && s.max_ticks_without_sample == 3 &&
                s.dead_man == 3 && f.density_per_hu == 0.001067);
    assert_true(f.damping == 0.5 && s.slew_n == 0.3);
    /* Every parameter can be set, printed and read again. */
    FILE *out = fopen(path, "w");
    assert_non_null(out);
    char value[OST_FORCE_VALUE];
    for (int i = 0; i < ost_force_key_count(); i++) {
        assert_true(ost_force_key_at(i)->about[0] && ost_force_key_at(i)->unit[0]);
        fprintf(out, "%s: %s\n", ost_force_key_at(i)->name,
                ost_force_value_text(ost_force_key_value(i, &f, &s), value));
    }
    fclose(out);
    assert_null(ost_force_key_at(ost_force_key_count()));
    ost_force_params g = ost_force_defaults();
    ost_safety_params t = ost_safety_defaults();
    assert_ok(ost_force_params_read(path, &g, &t, &err));
    for (int i = 0; i < ost_force_key_count(); i++)
        assert_true(ost_force_key_value(i, &f, &s) == ost_force_key_value(i, &g, &t));
    const struct {
        const char *text, *message;
        ost_status status;
    } wrong[] = {
        {"stiffness 250\n", ":1: 'stiffness 250': expected 'key: number'", OST_ERR_INPUT},
        {"\n\nstifness: 250\n", ":3: unknown parameter 'stifness'", OST_ERR_INPUT},
        {"stiffness: much\n", ":1: stiffness is 'much': expected a number in N/m", OST_ERR_INPUT},
        {"stiffness:\n", ":1: stiffness is '': expected a number in N/m", OST_ERR_INPUT},
        {"stiffness: # 3\n", "expected a number in N/m", OST_ERR_INPUT},
        {"stiffness: nan\n", "expected a number", OST_ERR_INPUT},
        {"stiffness: 0x10\n", "expected a number", OST_ERR_INPUT},
        {"stiffness: 250 N\n", "expected a number", OST_ERR_INPUT},
        {"stiffness: 1e9\n", ":1: stiffness is '1e9': expected 1 to 1e+06 N/m", OST_ERR_RANGE},
        {"stiffness: -1\n", "expected 1 to", OST_ERR_RANGE},
        {"stiffness: 1e5000\n", "expected", OST_ERR_RANGE},
        {"stale_ticks: 1e54\n", "expected a whole number, 1 to 1000 ticks", OST_ERR_RANGE},
        {"dead_man: -1e300\n", "expected a whole number, 0 to", OST_ERR_RANGE},
        {"stale_ticks: 2.5\n", "expected a whole number, 1 to 1000 ticks", OST_ERR_RANGE},
        {"scale: 0.1\nscale: 0.2\n", ":2: scale is set twice", OST_ERR_INPUT},
        {"vibration: 0.1\nteeth: 200\n", "500 teeth a second", OST_ERR_RANGE},
    };
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        g = ost_force_defaults();
        write_text(path, wrong[i].text);
        const ost_status status = ost_force_params_read(path, &g, &t, &err);
        if (status != wrong[i].status || !strstr(err.text, wrong[i].message) ||
            strncmp(err.text, path, strlen(path)) != 0)
            fail_msg("'%s': the error '%s' does not contain '%s'", wrong[i].text, err.text, wrong[i].message);
        assert_true(g.stiffness == 300 && g.scale == 0.08 && g.vibration == 0);
    }
    unlink(path);
    assert_int_equal(ost_force_params_read(path, &g, &t, &err), OST_ERR_IO);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(torque_rotates_the_tool),
        cmocka_unit_test(tool_follows_the_hand_in_air),
        cmocka_unit_test(rotating_handle_comes_to_rest),
        cmocka_unit_test(vibration_equals_its_formula),
        cmocka_unit_test(vibration_stays_within_the_safety_limits),
        cmocka_unit_test(parameter_file_is_read_and_written),
        cmocka_unit_test(runout_equals_its_formula),
    };
    return run_on_backends(tests, open_test_backend, close_test_backend);
}
