/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests each rule of the safety layer alone, with all other rules off. If a rule is removed,
 * its test fails.
 * Covers: REQ-SAFETY
 */
#include "harness.h"

#include <math.h>

#include <osteon/force.h>

#define T 1e-3

static ost_pose at_mm(double z)
{
    return (ost_pose){.t = {0, 0, (ost_pm)(z * 1e9)}, .qw = OST_Q30_ONE};
}

/* Returns parameters that disable all rules. */
static ost_safety_params open_params(void)
{
    return (ost_safety_params){.max_force_n = 1e6,
                               .max_torque_nm = 1e6,
                               .slew_n = 1e6,
                               .ramp_s = 0,
                               .max_ticks_without_sample = 1 << 30,
                               .stored_j = 1};
}

static ost_safety_answer step_safety(ost_safety *s, double z_mm, bool fresh, uint32_t buttons, double n, double *out)
{
    double force[3] = {0, 0, n}, torque[3] = {0, 0, n / 100};
    const ost_pose pose = at_mm(z_mm);
    const ost_safety_answer answer = ost_safety_step(s, &pose, fresh, buttons, T, force, torque);
    *out = force[2];
    return answer;
}

static void without_rules_the_force_is_unchanged(void **state)
{
    (void)state;
    const ost_safety_params p = open_params();
    ost_safety s;
    double f;
    ost_safety_begin(&s, &p);
    assert_int_equal(step_safety(&s, 0, true, 0, 500, &f), OST_SAFETY_GIVEN);
    assert_true(fabs(f - 500) < 1e-3);
}

static void non_finite_force_is_a_fault(void **state)
{
    (void)state;
    static const double none[] = {NAN, INFINITY, -INFINITY};
    for (int i = 0; i < 3; i++) {
        ost_safety s;
        double f = 0;
        ost_safety_begin(&s, NULL);
        for (int k = 0; k < 1000; k++)
            step_safety(&s, 0, true, 0, 1, &f);
        assert_true(f > 0.9);
        assert_int_equal(step_safety(&s, 0, true, 0, none[i], &f), OST_SAFETY_FAULT);
        assert_true(f == 0);
        /* After a fault the force must increase gradually. */
        assert_int_equal(step_safety(&s, 0, true, 0, 1, &f), OST_SAFETY_GIVEN);
        assert_true(f > 0 && f < 0.01);
    }
}

static void force_and_torque_saturate(void **state)
{
    (void)state;
    ost_safety_params p = open_params();
    p.max_force_n = 3;
    p.max_torque_nm = 0.1;
    ost_safety s;
    ost_safety_begin(&s, &p);
    double last = 0;
    for (double n = 0.1; n < 1e4; n *= 1.5) {
        double f[3] = {n, n, 0}, t[3] = {0, n, n};
        const ost_pose pose = at_mm(0);
        ost_safety_step(&s, &pose, true, 0, T, f, t);
        const double size = sqrt(f[0] * f[0] + f[1] * f[1]);
        assert_true(size <= 3 && size > last && sqrt(t[1] * t[1] + t[2] * t[2]) <= 0.1);
        assert_true(fabs(f[0] - f[1]) < 1e-6);
        last = size;
    }
    assert_true(last > 2.99);
}

static void force_rate_is_limited(void **state)
{
    (void)state;
    ost_safety_params p = open_params();
    p.slew_n = 0.3;
    ost_safety s;
    double f = 0, before = 0;
    ost_safety_begin(&s, &p);
    for (int i = 0; i < 40; i++) {
        step_safety(&s, 0, true, 0, i < 20 ? 2 : -2, &f);
        assert_true(fabs(f - before) <= 0.3 + 1e-9);
        before = f;
    }
    assert_true(fabs(f + 2) < 1e-6);
}

/*
 * Like the force, the torque may change by at most a tenth of its limit per tick. For a force limit of 3 N
 * this is 0.3 N; for a torque limit of 0.1 N m it is 10 mN m.
 */
static void torque_rate_is_limited(void **state)
{
    (void)state;
    ost_safety_params p = open_params();
    p.max_force_n = 3;
    p.max_torque_nm = 0.1;
    p.slew_n = 0.3;
    ost_safety s;
    double before = 0;
    ost_safety_begin(&s, &p);
    for (int i = 0; i < 40; i++) {
        double force[3] = {0}, torque[3] = {0, 0, i < 20 ? 0.05 : -0.05};
        const ost_pose pose = at_mm(0);
        assert_int_equal(ost_safety_step(&s, &pose, true, 0, T, force, torque), OST_SAFETY_GIVEN);
        assert_true(fabs(torque[2] - before) <= 0.01 + 1e-12);
        before = torque[2];
    }
    assert_true(fabs(before + 0.05 / sqrt(1.25)) < 1e-6);
}

static void force_increases_gradually_at_the_start(void **state)
{
    (void)state;
    ost_safety_params p = open_params();
    p.ramp_s = 0.5;
    ost_safety s;
    double f;
    ost_safety_begin(&s, &p);
    for (int i = 1; i <= 600; i++) {
        step_safety(&s, 0, true, 0, 1, &f);
        assert_true(fabs(f - (i < 500 ? i / 500.0 : 1)) < 1e-5);
    }
    ost_safety_stop(&s);
    step_safety(&s, 0, true, 0, 1, &f);
    assert_true(fabs(f - 0.002) < 1e-5);
}

static void released_dead_man_button_stops_the_force(void **state)
{
    (void)state;
    ost_safety_params p = open_params();
    p.dead_man = 5;
    ost_safety s;
    double f;
    ost_safety_begin(&s, &p);
    assert_int_equal(step_safety(&s, 0, true, 4, 1, &f), OST_SAFETY_GIVEN);
    assert_true(f > 0.9);
    assert_int_equal(step_safety(&s, 0, true, 2, 1, &f), OST_SAFETY_WITHHELD);
    assert_true(f == 0);
}

static void missing_samples_stop_the_force(void **state)
{
    (void)state;
    ost_safety_params p = open_params();
    p.max_ticks_without_sample = 2;
    ost_safety s;
    double f;
    ost_safety_begin(&s, &p);
    step_safety(&s, 0, true, 0, 1, &f);
    /* A single tick without a sample is bridged. */
    assert_int_equal(step_safety(&s, 0, false, 0, 1, &f), OST_SAFETY_GIVEN);
    assert_true(f > 0.9);
    assert_int_equal(step_safety(&s, 0, false, 0, 1, &f), OST_SAFETY_WITHHELD);
    assert_true(f == 0);
    assert_int_equal(step_safety(&s, 0, true, 0, 1, &f), OST_SAFETY_GIVEN);
}

/*
 * A delayed spring generates energy in every cycle, so a mass that is attached to it oscillates
 * with growing amplitude. Simulates 3 s and returns the amplitude in the last second.
 */
static double oscillation_amplitude(double max_damping, uint64_t *damped)
{
    ost_safety_params p = open_params();
    p.stored_j = 1e-3;
    p.max_damping = max_damping;
    ost_safety s;
    ost_safety_begin(&s, &p);
    double z = 1e-3, v = 0, lag[3] = {z, z, z}, peak = 0, f = 0;
    for (int i = 0; i < 3000; i++) {
        for (int k = 0; k < 10; k++) {
            v += (f - 0.1 * v) / 0.06 * T / 10;
            z += v * T / 10;
        }
        lag[2] = lag[1];
        lag[1] = lag[0];
        lag[0] = z;
        step_safety(&s, z * 1e3, true, 0, -400 * lag[2], &f);
        if (i > 2000 && fabs(z) > peak)
            peak = fabs(z);
    }
    *damped = s.damped_ticks;
    return peak;
}

static void passivity_controller_damps_an_oscillation(void **state)
{
    (void)state;
    uint64_t damped;
    const double free_swing = oscillation_amplitude(0, &damped);
    assert_int_equal(damped, 0);
    const double held = oscillation_amplitude(2, &damped);
    print_message("amplitude of a delayed spring: %.3g m without, %.3g m with the passivity controller\n", free_swing,
                  held);
    assert_true(free_swing > 20e-3 && held < 4e-3 && damped > 10);
}

/* A passive wall must not be damped. */
static void passive_wall_is_not_damped(void **state)
{
    (void)state;
    ost_safety_params p = open_params();
    p.max_damping = 2;
    ost_safety s;
    double f;
    ost_safety_begin(&s, &p);
    for (int i = 0; i < 1000; i++) {
        const double z = 1e-3 * sin(i * 0.01), next = 1e-3 * sin((i + 1) * 0.01);
        /*
         * The force is the sum of a spring force and a damping force. The spring force is computed at the middle
         * between `z` and `next`, so that its work equals the change of the spring's energy exactly.
         */
        step_safety(&s, z * 1e3, true, 0, -300 * (z + next) / 2 - 0.01 * (next - z) / T, &f);
    }
    assert_int_equal(s.damped_ticks, 0);
}

/*
 * A coupling cannot store more than stored_j. Even if the hand supplies 0.1 J, the force must
 * not return more than stored_j.
 */
static void returned_energy_is_limited(void **state)
{
    (void)state;
    ost_safety_params p = open_params();
    p.max_damping = 2;
    p.stored_j = 0.015;
    ost_safety s;
    double z = 0, f;
    ost_safety_begin(&s, &p);
    for (int i = 0; i < 100; i++)
        step_safety(&s, z -= 1, true, 0, 1, &f);
    for (int i = 0; i < 10; i++)
        step_safety(&s, z += 1, true, 0, 1, &f);
    assert_int_equal(s.damped_ticks, 0);
    for (int i = 0; i < 20; i++)
        step_safety(&s, z += 1, true, 0, 1, &f);
    assert_true(s.damped_ticks > 5);
}

/* The force limit also applies to the damping of the passivity controller. */
static void damping_force_is_limited(void **state)
{
    (void)state;
    ost_safety_params p = open_params();
    p.max_force_n = 3;
    p.max_damping = 100;
    p.stored_j = 0;
    ost_safety s;
    double f;
    ost_safety_begin(&s, &p);
    step_safety(&s, 0, true, 0, 3, &f);
    step_safety(&s, 4.9, true, 0, 3, &f);
    step_safety(&s, 5.9, true, 0, 3, &f);
    assert_true(s.damped_ticks == 2 && f < -2.9 && f >= -3 - 1e-12);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(without_rules_the_force_is_unchanged),
        cmocka_unit_test(non_finite_force_is_a_fault),
        cmocka_unit_test(force_and_torque_saturate),
        cmocka_unit_test(force_rate_is_limited),
        cmocka_unit_test(force_increases_gradually_at_the_start),
        cmocka_unit_test(released_dead_man_button_stops_the_force),
        cmocka_unit_test(missing_samples_stop_the_force),
        cmocka_unit_test(passivity_controller_damps_an_oscillation),
        cmocka_unit_test(passive_wall_is_not_damped),
        cmocka_unit_test(torque_rate_is_limited),
        cmocka_unit_test(returned_energy_is_limited),
        cmocka_unit_test(damping_force_is_limited),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
