/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests a motor's rotation: the phase is exact, the tool's poses are correct, and the intervals
 * between the rows of a path are divided into the required number of ticks.
 *
 * Covers: AR-MOTOR-2, AR-MOTOR-4, AR-MOTOR-7
 */
#include "harness.h"

#include <math.h>
#include <string.h>

#include <osteon/motor.h>

static const ost_pose straight = {.qw = OST_Q30_ONE};

/* Tests the example of docs/spec/arithmetic.md, section 11: the second tick, and the same tick one turn later. */
static void the_worked_example(void **state)
{
    (void)state;
    ost_motor motor = {0};
    for (int64_t k = 0; k <= 300; k++) {
        ost_tick tick = {.t_ns = -5 + k * 1000000, .pose = straight};
        ost_motor_turn(&motor, &tick, 200);
        assert_int_equal(tick.rpm, 200);
        if (k == 1) {
            const ost_pose expected = {.qw = 1073688450, .qz = -10705968};
            assert_memory_equal(&tick.pose, &expected, sizeof expected);
        } else if (k == 0 || k == 300) {
            assert_memory_equal(&tick.pose, &straight, sizeof straight);
        }
    }
    assert_int_equal(motor.phase, 0);
}

/*
 * For any device pose and phase, the tool's rotation is the device's rotation times a clockwise rotation about z. The
 * inverse function restores the device's rotation.
 */
static void tool_rotates_about_its_z_axis(void **state)
{
    (void)state;
    ost_error err = {0};
    test_rng rng = rng_seeded("turned");
    for (int i = 0; i < 20000; i++) {
        double q[4], n = 0;
        for (int a = 0; a < 4; a++) {
            q[a] = (double)rng_range(&rng, -1000000, 1000000);
            n += q[a] * q[a];
        }
        if (n < 1)
            continue;
        ost_pose handle = {.t = {i, -i, 7},
                           (int32_t)(q[0] / sqrt(n) * OST_Q30_ONE),
                           (int32_t)(q[1] / sqrt(n) * OST_Q30_ONE),
                           (int32_t)(q[2] / sqrt(n) * OST_Q30_ONE),
                           (int32_t)(q[3] / sqrt(n) * OST_Q30_ONE)};
        const ost_motor motor = {.phase = rng_range(&rng, 0, OST_MOTOR_TURN - 1)};
        const double angle = -3.14159265358979323846 * floor(4096.0 * (double)motor.phase / (double)OST_MOTOR_TURN) /
                             4096,
                     c = cos(angle), s = sin(angle);
        const double w = handle.qw, x = handle.qx, y = handle.qy, z = handle.qz;
        const double expected[4] = {w * c - z * s, x * c + y * s, y * c - x * s, z * c + w * s};
        const ost_pose tool = ost_motor_pose(&motor, &handle), back = ost_motor_handle_pose(&motor, &tool);
        const int32_t got[4] = {tool.qw, tool.qx, tool.qy, tool.qz}, again[4] = {back.qw, back.qx, back.qy, back.qz},
                      was[4] = {handle.qw, handle.qx, handle.qy, handle.qz};
        assert_memory_equal(&tool.t, &handle.t, sizeof handle.t);
        assert_ok(ost_pose_check(&tool, &err));
        for (int a = 0; a < 4; a++) {
            assert_true(fabs(got[a] - expected[a]) <= 2);
            assert_true(again[a] - was[a] <= 2 && was[a] - again[a] <= 2);
        }
    }
}

/*
 * The phase does not change while a motor is off or its speed is unknown. The difference between the least and the
 * greatest time in int64 does not overflow.
 */
static void phase_is_exact(void **state)
{
    (void)state;
    ost_motor motor = {0};
    ost_tick tick = {.t_ns = INT64_MIN, .rpm = 3000, .pose = straight};
    ost_motor_advance(&motor, &tick);
    assert_int_equal(motor.phase, 0);
    tick.t_ns = INT64_MAX; /* (2^64 - 1) mod 6 * 10^10 is 33,709,551,615 */
    ost_motor_advance(&motor, &tick);
    assert_int_equal(motor.phase, (INT64_C(33709551615) * 3000) % OST_MOTOR_TURN);
    motor = (ost_motor){0};
    int64_t turned = 0, t = -1000000000;
    test_rng rng = rng_seeded("phase");
    for (int i = 0; i < 5000; i++) {
        const int64_t step = rng_range(&rng, 1, 50000000);
        tick = (ost_tick){.t_ns = t += step, .rpm = (int32_t)rng_range(&rng, -1, 3000), .pose = straight};
        turned = i && tick.rpm > 0 ? (turned + step * tick.rpm) % OST_MOTOR_TURN : turned;
        ost_motor_advance(&motor, &tick);
        assert_int_equal(motor.phase, turned);
    }
}

static ost_tick row(int64_t t_ms, int32_t rpm, int64_t x)
{
    ost_tick tick = {.t_ns = t_ms * 1000000, .rpm = rpm, .pose = straight};
    tick.pose.t.x = x;
    return tick;
}

static void intervals_are_divided_into_ticks(void **state)
{
    (void)state;
    ost_error err = {0};
    ost_path path;
    ost_motor motor = {0};
    assert_ok(ost_path_init(&path, 7, &err));
    path.ticks[0] = row(0, OST_RPM_OF_DEVICE, 0);
    /* A full turn is U = 6 * 10^10, and a part is at most U / 8. In 100 ms at 200 rpm the motor turns by U / 3, which
       is between 2 U / 8 and 3 U / 8. Therefore this interval has 3 parts. */
    path.ticks[1] = row(100, OST_RPM_OF_DEVICE, 30);
    path.ticks[2] = row(137, OST_RPM_OF_DEVICE, 40); /* the turn in 37 ms is 7.4 * 10^9, which is less than U / 8 */
    path.ticks[3] = row(1137, OST_RPM_OF_DEVICE, 50);
    path.ticks[3].lifted = true;                /* a lifted row gives one tick, whatever the interval */
    path.ticks[4] = row(2137, OST_RPM_OF_DEVICE, 60);
    path.ticks[4].tool = 1;                     /* a row that follows a row with another tool also gives one tick */
    /* A row that contains a motor speed, like the rows of a session's path, is unchanged. */
    path.ticks[5] = row(3137, 50, 70);
    path.ticks[6] = row(3200, OST_RPM_OF_DEVICE, 80);
    assert_ok(ost_motor_path(&path, 200, &motor, &err));
    assert_int_equal(path.count, 9);
    static const int64_t t_ns[] = {0,          33333333,   66666666,   100000000, 137000000,
                                   1137000000, 2137000000, 3137000000, 3200000000};
    static const int64_t x[] = {0, 10, 20, 30, 40, 50, 60, 70, 80};
    int64_t phase = 0;
    for (int i = 0; i < 9; i++) {
        const ost_tick *tick = &path.ticks[i];
        assert_int_equal(tick->t_ns, t_ns[i]);
        assert_int_equal(tick->pose.t.x, x[i]);
        assert_int_equal(tick->rpm, i == 7 ? 50 : 200);
        assert_int_equal(tick->lifted, i == 5);
        assert_int_equal(tick->tool, i == 6);
        phase = i ? (phase + (t_ns[i] - t_ns[i - 1]) * tick->rpm) % OST_MOTOR_TURN : 0;
        const ost_pose expected = ost_motor_pose(&(ost_motor){.phase = i == 7 ? 0 : phase}, &straight);
        assert_int_equal(tick->pose.qw, expected.qw);
        assert_int_equal(tick->pose.qz, expected.qz);
    }
    ost_path_free(&path);
}

/*
 * The device turns by 80 degrees between two rows. The interpolated quaternions must have the same length as the
 * quaternions of the two rows.
 */
static void interpolated_quaternions_keep_their_length(void **state)
{
    (void)state;
    ost_error err = {0};
    ost_path path;
    assert_ok(ost_path_init(&path, 2, &err));
    path.ticks[0] = row(0, OST_RPM_OF_DEVICE, 0);
    path.ticks[1] = row(1000, OST_RPM_OF_DEVICE, 0);
    path.ticks[1].pose.qw = (int32_t)(0.766044443 * OST_Q30_ONE);
    path.ticks[1].pose.qx = (int32_t)(0.642787610 * OST_Q30_ONE);
    assert_ok(ost_motor_path(&path, 200, &(ost_motor){0}, &err));
    assert_int_equal(path.count, 1 + 27); /* 1 s at 200 rpm is 10/3 turns, or 26.7 eighths */
    for (size_t i = 0; i < path.count; i++) {
        const ost_pose *p = &path.ticks[i].pose;
        const double q[4] = {p->qw, p->qx, p->qy, p->qz}, n = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
        assert_true(fabs(sqrt(n) / OST_Q30_ONE - 1) < 1e-8);
    }
    ost_path_free(&path);
}

static void intervals_of_too_many_turns_are_refused(void **state)
{
    (void)state;
    ost_error err = {0};
    ost_path path;
    assert_ok(ost_path_init(&path, 2, &err));
    path.ticks[0] = row(0, OST_RPM_OF_DEVICE, 0);
    path.ticks[1] = row(153600, OST_RPM_OF_DEVICE, 0); /* 153.6 s at 200 rpm are 512 turns, or 4096 parts */
    ost_path same = path;
    assert_int_equal(ost_motor_path(&path, 3001, &(ost_motor){0}, &err), OST_ERR_USAGE);
    assert_int_equal(ost_motor_path(&path, -1, &(ost_motor){0}, &err), OST_ERR_USAGE);
    path.ticks[1].t_ns++;
    assert_int_equal(ost_motor_path(&path, 200, &(ost_motor){0}, &err), OST_ERR_RANGE);
    assert_non_null(strstr(err.text, "row 1"));
    path.ticks[1] = row(50, OST_RPM_OF_DEVICE, 0);
    path.ticks[1].pose = (ost_pose){.qx = OST_Q30_ONE};
    assert_int_equal(ost_motor_path(&path, 200, &(ost_motor){0}, &err), OST_ERR_RANGE);
    assert_memory_equal(&path, &same, sizeof path);
    /* If the motor is off, no angle is swept and no limit applies. */
    assert_ok(ost_motor_path(&path, 0, &(ost_motor){0}, &err));
    assert_int_equal(path.count, 2);
    path.ticks[0] = row(0, OST_RPM_OF_DEVICE, 0);
    path.ticks[1] = row(153600, OST_RPM_OF_DEVICE, 0);
    assert_ok(ost_motor_path(&path, 200, &(ost_motor){0}, &err));
    assert_int_equal(path.count, 4097);
    ost_path_free(&path);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_worked_example),
        cmocka_unit_test(tool_rotates_about_its_z_axis),
        cmocka_unit_test(phase_is_exact),
        cmocka_unit_test(intervals_are_divided_into_ticks),
        cmocka_unit_test(interpolated_quaternions_keep_their_length),
        cmocka_unit_test(intervals_of_too_many_turns_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
