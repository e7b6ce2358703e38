/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The rotation of a tool by its motor (AR-MOTOR).
 *
 *   phase <- (phase + rpm (t - t')) mod turn      exact
 *   k = floor(4096 phase / turn)                  a step of 0.088 degrees
 *   q_tool = q_hand * (C_k, 0, 0, -S_k)           each component RHE by 2^30
 *
 * C_k = RHE(2^30 cos(pi k / 4096)) and S_k = RHE(2^30 sin(pi k / 4096)) are read from a table of
 * sines for angles up to 90 degrees. The values for angles up to 180 degrees follow by symmetry.
 */
#include <osteon/event.h>
#include <osteon/motor.h>

#include <stdlib.h>

#include "core/conditions.h"
#include "core/integer.h"
#include "core/motor_table.h"

enum { STEPS = 4096, HALF = STEPS / 2 };

_Static_assert(sizeof motor_sine / sizeof motor_sine[0] == HALF + 1, "the table has the sines of a quarter of a turn");

typedef struct spin {
    int64_t c, s;
} spin;

/* Returns C_k and S_k for the phase of a motor. phase < 2^36, so its product with 2^12 fits in int64. */
static spin spin_of(const ost_motor *motor)
{
    const int k = (int)(motor->phase * STEPS / OST_MOTOR_TURN);
    return k <= HALF ? (spin){motor_sine[HALF - k], motor_sine[k]}
                     : (spin){-(int64_t)motor_sine[k - HALF], motor_sine[STEPS - k]};
}

/*
 * Returns RHE((a c + b s) / 2^30). |q| <= 1.001 * 2^30 and |(c, s)| <= 2^30 + 1, so the sum of the
 * products is below 2^60.01, and the quotient is below 2^30.01.
 */
static int32_t component(int64_t a, int64_t c, int64_t b, int64_t s)
{
    return (int32_t)ost_rhe_div(a * c + b * s, OST_Q30_ONE);
}

static ost_pose turned(const ost_pose *p, spin by)
{
    return (ost_pose){p->t, component(p->qw, by.c, p->qz, by.s), component(p->qx, by.c, -(int64_t)p->qy, by.s),
                      component(p->qy, by.c, p->qx, by.s), component(p->qz, by.c, -(int64_t)p->qw, by.s)};
}

ost_pose ost_motor_pose(const ost_motor *motor, const ost_pose *handle)
{
    return turned(handle, spin_of(motor));
}

ost_pose ost_motor_handle_pose(const ost_motor *motor, const ost_pose *tool)
{
    const spin by = spin_of(motor);
    return turned(tool, (spin){by.c, -by.s});
}

double ost_motor_angle(const ost_motor *motor)
{
    return -6.283185307179586 / STEPS * (double)(motor->phase * STEPS / OST_MOTOR_TURN);
}

/* Returns the time between two ticks in ns. `to` is later than `from`, so the difference modulo 2^64 is the exact
   result. */
static uint64_t since(int64_t from, int64_t to)
{
    return (uint64_t)to - (uint64_t)from;
}

/* rpm <= 3000, so the product of time and rpm is less than 3000 * 6 * 10^10 < 2^48. */
void ost_motor_advance(ost_motor *motor, const ost_tick *tick)
{
    if (motor->moved && tick->rpm > 0)
        motor->phase = (motor->phase + (int64_t)(since(motor->t_ns, tick->t_ns) % OST_MOTOR_TURN) * tick->rpm) %
                       OST_MOTOR_TURN;
    motor->t_ns = tick->t_ns;
    motor->moved = true;
}

void ost_motor_turn(ost_motor *motor, ost_tick *tick, int32_t rpm)
{
    tick->rpm = rpm;
    ost_motor_advance(motor, tick);
    tick->pose = ost_motor_pose(motor, &tick->pose);
}

/* -------------------------------------------------------------------- paths */

/*
 * Returns the number of ticks into which a row is divided (AR-MOTOR-7), at least 1. If the number exceeds
 * OST_MOTOR_PARTS_MAX, returns OST_MOTOR_PARTS_MAX + 1.
 */
static int64_t parts_of(const ost_tick *before, const ost_tick *row, int32_t rpm)
{
    if (row->rpm != OST_RPM_OF_DEVICE || !before || before->rpm != OST_RPM_OF_DEVICE || before->tool != row->tool ||
        row->lifted)
        return 1;
    const ost_i128 turned_by = (ost_i128)since(before->t_ns, row->t_ns) * rpm, eighth = OST_MOTOR_TURN / 8;
    const ost_i128 parts = (turned_by + eighth - 1) / eighth;
    return parts < 1 ? 1 : parts > OST_MOTOR_PARTS_MAX ? OST_MOTOR_PARTS_MAX + 1 : (int64_t)parts;
}

/*
 * Returns true if the hand rotates by more than 90 degrees between two poses (AR-SWEEP-3).
 * |q| <= 1.001 * 2^30, so every sum is below 2^60.01.
 */
static bool turns_too_far(const ost_pose *a, const ost_pose *b)
{
    const int64_t p = (int64_t)a->qw * b->qw + (int64_t)a->qx * b->qx + (int64_t)a->qy * b->qy + (int64_t)a->qz * b->qz;
    const int64_t na = (int64_t)a->qw * a->qw + (int64_t)a->qx * a->qx + (int64_t)a->qy * a->qy +
                       (int64_t)a->qz * a->qz;
    const int64_t nb = (int64_t)b->qw * b->qw + (int64_t)b->qx * b->qx + (int64_t)b->qy * b->qy +
                       (int64_t)b->qz * b->qz;
    return 2 * (ost_i128)p * p < (ost_i128)na * nb;
}

/* Returns the integer square root of n: the greatest r with r^2 <= n. Requires n < 2^62. */
static int64_t root(int64_t n)
{
    int64_t r = 0;
    for (int64_t bit = INT64_C(1) << 30; bit; bit >>= 1)
        if ((r + bit) * (r + bit) <= n)
            r += bit;
    return r;
}

/*
 * Returns pose j of the `parts` hand poses that are interpolated between two rows of a path, renormalised to unit
 * length. A component is below 2^30.01 and r >= 2^29.5, so every quotient is at most 2^30 + 2.
 */
static ost_pose handle_between(const ost_pose *a, const ost_pose *b, int j, int parts)
{
    ost_pose p = ost_sweep_pose(a, b, j, parts);
    const int64_t r = root((int64_t)p.qw * p.qw + (int64_t)p.qx * p.qx + (int64_t)p.qy * p.qy + (int64_t)p.qz * p.qz);
    p.qw = (int32_t)ost_rhe_div((int64_t)p.qw * OST_Q30_ONE, r);
    p.qx = (int32_t)ost_rhe_div((int64_t)p.qx * OST_Q30_ONE, r);
    p.qy = (int32_t)ost_rhe_div((int64_t)p.qy * OST_Q30_ONE, r);
    p.qz = (int32_t)ost_rhe_div((int64_t)p.qz * OST_Q30_ONE, r);
    return p;
}

static ost_status count_ticks(const ost_path *handle, int32_t rpm, size_t *count, ost_error *err)
{
    *count = 0;
    for (size_t i = 0; i < handle->count; i++) {
        const ost_tick *row = &handle->ticks[i], *before = i ? row - 1 : NULL;
        const int64_t parts = parts_of(before, row, rpm);
        if (parts > OST_MOTOR_PARTS_MAX)
            return ost_fail(err, OST_ERR_RANGE, "row %zu at %.9f s: the motor turns more than %d times since the "
                            "previous row; expected shorter intervals, or a lifted tool between the rows", i,
                            (double)row->t_ns * 1e-9, OST_MOTOR_PARTS_MAX / 8);
        if (parts > 1 && turns_too_far(&before->pose, &row->pose))
            return ost_fail(err, OST_ERR_RANGE, "row %zu at %.9f s: the device turns by more than 90 degrees since "
                            "the previous row; expected shorter intervals", i, (double)row->t_ns * 1e-9);
        *count += (size_t)parts;
        if (*count > OST_PATH_TICKS_MAX)
            return ost_fail(err, OST_ERR_RANGE, "at %d rpm, the path has more than %d ticks",
                            rpm, OST_PATH_TICKS_MAX);
    }
    return OST_OK;
}

ost_status ost_motor_path(ost_path *path, int32_t rpm, ost_motor *motor, ost_error *err)
{
    size_t count, at = 0;
    ost_path out;
    if (rpm < 0 || rpm > OST_RPM_MAX)
        return ost_fail(err, OST_ERR_USAGE, "a motor speed of %d rpm; expected 0 to %d", rpm, OST_RPM_MAX);
    ost_status status = count_ticks(path, rpm, &count, err);
    if (status == OST_OK)
        status = ost_path_init(&out, count, err);
    if (status != OST_OK)
        return status;
    for (size_t i = 0; i < path->count; i++) {
        const ost_tick *row = &path->ticks[i], *before = i ? row - 1 : NULL;
        const int64_t parts = parts_of(before, row, rpm);
        for (int64_t j = 1; j <= parts; j++) {
            ost_tick *tick = &out.ticks[at++];
            *tick = *row;
            if (j < parts) {
                tick->t_ns = (int64_t)((uint64_t)before->t_ns +
                                       (uint64_t)((ost_i128)since(before->t_ns, row->t_ns) * j / parts));
                tick->pose = handle_between(&before->pose, &row->pose, (int)j, (int)parts);
            }
            if (row->rpm == OST_RPM_OF_DEVICE)
                ost_motor_turn(motor, tick, rpm);
            else
                ost_motor_advance(motor, tick);
        }
    }
    ost_path_free(path);
    *path = out;
    return OST_OK;
}
