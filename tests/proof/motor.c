/* SPDX-License-Identifier: Apache-2.0 */
#include "proof.h"

#include "core/motor.c"

static ost_pose any_pose(int64_t limit)
{
    return (ost_pose){.qw = (int32_t)any64(limit),
                      .qx = (int32_t)any64(limit),
                      .qy = (int32_t)any64(limit),
                      .qz = (int32_t)any64(limit)};
}

/* Proves for any phase P below the turn U < 2^36 that spin_of does not overflow (4096 * P < 2^48) and that its cosine
   and sine are at most 2^30 in magnitude. */
void motor_spin(void)
{
    ost_motor motor = {.phase = nondet_int64()};
    ASSUME(motor.phase >= 0 && motor.phase < OST_MOTOR_TURN << WIDER);
    const spin by = spin_of(&motor);
    BOUNDED(by.c, INT64_C(1) << 30);
    BOUNDED(by.s, INT64_C(1) << 30);
}

/* Proves that P stays below U for any two int64 times and any speed up to 3000. */
void motor_advance(void)
{
    ost_motor motor = {.phase = nondet_int64(), .t_ns = nondet_int64(), .moved = true};
    ost_tick tick = {.t_ns = nondet_int64(), .rpm = any32(-2, 3000)};
    ASSUME(motor.phase >= (WIDER ? -OST_MOTOR_TURN : 0) && motor.phase < OST_MOTOR_TURN);
    ost_motor_advance(&motor, &tick);
    ASSERT(motor.phase >= 0 && motor.phase < OST_MOTOR_TURN);
}

/* Proves that each sum is below 2^62 and fits in int64 for |q| <= 1.001 * 2^30 and |C|, |S| <= 2^30. */
void motor_component(void)
{
    const int64_t q = INT64_C(1074815566), sc = INT64_C(1) << 30; /* 1.001 * 2^30 + 1 */
    const int64_t a = any64(q << WIDER), b = any64(q << WIDER), c = any64(sc), s = any64(sc);
    const int64_t sum = a * c + b * s;
    BOUNDED(sum, INT64_C(1) << 62);
}

void motor_parts(void)
{
    const ost_tick before = {.t_ns = nondet_int64(), .rpm = OST_RPM_OF_DEVICE},
                   row = {.t_ns = nondet_int64(), .rpm = OST_RPM_OF_DEVICE};
    const int64_t parts = parts_of(&before, &row, any32(0, 3000));
    ASSERT(parts >= 1 + WIDER && parts <= OST_MOTOR_PARTS_MAX + 1);
}

void motor_turned(void)
{
    const int64_t q = (INT64_C(1) << 30) + (1 << 21);
    const ost_pose a = any_pose(q << WIDER), b = any_pose(q << WIDER);
    (void)turns_too_far(&a, &b);
}

/* Proves for any N below 2^62 that (r + bit)^2 does not overflow and that the root is below 2^31. */
void motor_root(void)
{
    const int64_t n = nondet_int64();
    ASSUME(n >= 0 && n < INT64_C(1) << 62);
    const int64_t r = root(n);
    ASSERT(r >= 0 && r < INT64_C(1) << 31 >> WIDER);
}
