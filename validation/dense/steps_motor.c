/* SPDX-License-Identifier: Apache-2.0 */
/* Computes the rotation of a motor. The cosines are computed here, whereas src/core reads them from a table. Each
   cosine times 2^30 differs by at least 10^-6 from every midpoint between two integers, so an error in its last digits
   does not change the rounded value. */
#include "validation/dense/steps.h"

#include <math.h>
#include <stdlib.h>

static const int64_t turn = 60000000000; /* one revolution in units of 1 rpm * 1 ns, the U of AR-MOTOR */

static wide way_of(int64_t from, int64_t to, int64_t rpm)
{
    return wide_times(wide_minus(wide_of(to), wide_of(from)), wide_of(rpm));
}

/* Returns the tool's pose for a pose of the handle and the phase P of the motor (AR-MOTOR-3, AR-MOTOR-4). */
static ost_pose turned(const ost_pose *handle, wide phase)
{
    const int64_t k = wide_to_int64(wide_floor(wide_times(wide_of(4096), phase), wide_of(turn)));
    const long double angle = acosl(-1.0L) * (long double)k / 4096;
    const wide c = wide_of(llrintl(1073741824.0L * cosl(angle))), s = wide_of(llrintl(1073741824.0L * sinl(angle)));
    const int32_t q[4] = {handle->qw, handle->qx, handle->qy, handle->qz};
    /* component i of the product is c * q[i] + s * sign[i] * q[other[i]], for example c * w + s * z for i = 0 */
    static const int other[4] = {3, 2, 1, 0}, sign[4] = {1, -1, 1, -1};
    int32_t out[4];
    for (int i = 0; i < 4; i++) {
        const wide sum = wide_plus(wide_times(wide_of(q[i]), c),
                                   wide_times(wide_of(sign[i] * (int64_t)q[other[i]]), s));
        out[i] = (int32_t)wide_to_int64(wide_nearest(sum, wide_power_of_two(30)));
    }
    return (ost_pose){handle->t, out[0], out[1], out[2], out[3]};
}

/* Returns the integer square root of n, by bisection. */
static wide root_of(wide n)
{
    wide r = wide_of(0);
    for (int bit = 40; bit >= 0; bit--) {
        const wide more = wide_plus(r, wide_power_of_two(bit));
        if (wide_order(wide_times(more, more), n) <= 0)
            r = more;
    }
    return r;
}

static int32_t of_unit_length(int32_t c, wide r)
{
    return (int32_t)wide_to_int64(wide_nearest(wide_times(wide_power_of_two(30), wide_of(c)), r));
}

/* Returns pose j of the m poses between rows a and b of the handle's path. */
static ost_pose handle_between(const ost_pose *a, const ost_pose *b, int j, int m)
{
    ost_pose p = steps_sweep_pose(a, b, j, m);
    const wide r = root_of(steps_norm(&p));
    return (ost_pose){p.t, of_unit_length(p.qw, r), of_unit_length(p.qx, r), of_unit_length(p.qy, r),
                      of_unit_length(p.qz, r)};
}

/* Returns m of AR-MOTOR-7 for row i: the smallest m >= 1 with 8 * n * (t - t') <= m * U. n is the motor's speed, t' and
   t are the times of the previous row and of row i, and U is one revolution. */
static int64_t parts_of(const ost_path *rows, size_t i, int32_t rpm)
{
    if (i == 0 || rpm <= 0)
        return 1;
    const ost_tick *before = &rows->ticks[i - 1], *row = &rows->ticks[i];
    if (row->rpm != OST_RPM_OF_DEVICE || before->rpm != OST_RPM_OF_DEVICE || row->tool != before->tool || row->lifted)
        return 1;
    const wide way = wide_times(wide_of(8), way_of(before->t_ns, row->t_ns, rpm));
    const int64_t down = wide_to_int64(wide_floor(way, wide_of(turn))),
                  m = wide_order(wide_times(wide_of(down), wide_of(turn)), way) < 0 ? down + 1 : down;
    return m < 1 ? 1 : m;
}

ost_status steps_motor_path(const ost_path *rows, int32_t rpm, ost_path *out, ost_error *err)
{
    size_t count = 0, at = 0;
    for (size_t i = 0; i < rows->count; i++) {
        const int64_t m = parts_of(rows, i, rpm);
        if (m > 4096)
            return ost_fail(err, OST_ERR_RANGE,
                            "a row of a path turns its motor by more than 4096 eighths (AR-MOTOR-7)");
        count += (size_t)m;
    }
    ost_status status = ost_path_init(out, count, err);
    wide phase = wide_of(0);
    for (size_t i = 0; i < rows->count && status == OST_OK; i++) {
        const ost_tick *row = &rows->ticks[i];
        const int m = (int)parts_of(rows, i, rpm);
        for (int j = 1; j <= m; j++, at++) {
            ost_tick *tick = &out->ticks[at];
            *tick = *row;
            if (j < m) {
                const ost_tick *before = row - 1;
                const wide part = wide_times(wide_of(j), wide_minus(wide_of(row->t_ns), wide_of(before->t_ns)));
                tick->t_ns = before->t_ns + wide_to_int64(wide_floor(part, wide_of(m)));
                tick->pose = handle_between(&before->pose, &row->pose, j, m);
            }
            if (row->rpm == OST_RPM_OF_DEVICE)
                tick->rpm = rpm;
            /* AR-MOTOR-2: subtracts complete turns, so that the phase stays below one turn */
            if (at > 0 && tick->rpm > 0) {
                phase = wide_plus(phase, way_of(out->ticks[at - 1].t_ns, tick->t_ns, tick->rpm));
                phase = wide_minus(phase, wide_times(wide_floor(phase, wide_of(turn)), wide_of(turn)));
            }
            if (row->rpm == OST_RPM_OF_DEVICE)
                tick->pose = turned(&tick->pose, phase);
        }
    }
    return status;
}
