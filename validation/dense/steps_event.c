/* SPDX-License-Identifier: Apache-2.0 */
/* Determines which ticks are events. For each tick, the code examines all ticks since the beginning of the sweep
   again. The only state is therefore the list of ticks that were not refused, with some indices into this list. */
#include "validation/dense/steps.h"

#include <stdlib.h>

ost_status steps_history_begin(const ost_path *path, bool sweep_off, int64_t period_ns, steps_history *out,
                               ost_error *err)
{
    *out = (steps_history){.sweep_off = sweep_off, .period_ns = period_ns, .ticks = path->ticks};
    out->taken = calloc(path->count + 1, sizeof *out->taken);
    return out->taken ? OST_OK : ost_fail(err, OST_ERR_MEMORY, "out of memory for a list of %zu ticks", path->count);
}

void steps_history_free(steps_history *h)
{
    free(h->taken);
    *h = (steps_history){.taken = NULL};
}

static const ost_tick *taken(const steps_history *h, size_t position)
{
    return &h->ticks[h->taken[position]];
}

/* Returns true if an event is due at the tick. An event is due at the first tick after a restart, at the first tick
   after the motor was off, and at the first tick in each period (AR-REM-7). */
static bool is_due(const steps_history *h, const ost_tick *tick, bool restarts)
{
    if (restarts || h->period_ns == 0 || taken(h, h->count - 1)->rpm == 0)
        return true;
    const wide p = wide_of(h->period_ns);
    return wide_order(wide_floor(wide_of(tick->t_ns), p), wide_floor(wide_of(taken(h, h->last_event)->t_ns), p)) != 0;
}

/* Returns true if the motor has turned by more than a quarter turn since the last event (AR-MOTOR-6). */
static bool turns_too_far(const steps_history *h, const ost_tick *tick)
{
    wide sum = wide_of(0);
    for (size_t k = h->begin[tick->tool] + 1; k <= h->count; k++) {
        const ost_tick *now = k < h->count ? taken(h, k) : tick, *before = taken(h, k - 1);
        if (now->rpm > 0)
            sum = wide_plus(sum, wide_times(wide_of(now->rpm), wide_minus(wide_of(now->t_ns), wide_of(before->t_ns))));
    }
    return wide_order(sum, wide_of(60000000000 / 4)) > 0;
}

steps_event steps_next(steps_history *h, size_t i, const ost_tool_geometry *grid, ost_pm bone_voxel)
{
    const ost_tick *tick = &h->ticks[i];
    const bool on = tick->rpm != 0,
               restarts = h->count == 0 || taken(h, h->count - 1)->tool != tick->tool || tick->lifted;
    steps_event e = {.from = tick->pose};
    if (on && is_due(h, tick, restarts)) {
        e.removal = true;
        e.count = 1;
        if (!restarts && !h->sweep_off) { /* the conditions of AR-SWEEP-5 and AR-SWEEP-6 for a sweep */
            e.from = taken(h, h->begin[tick->tool])->pose;
            e.count = turns_too_far(h, tick) ? 0 : steps_sweep_count(&e.from, &tick->pose, grid, bone_voxel);
            if (e.count == 0)
                return (steps_event){.refused = true};
        }
    }
    h->taken[h->count] = i;
    if (e.removal || !on) /* AR-MOTOR-5 */
        h->begin[tick->tool] = h->count;
    if (e.removal)
        h->last_event = h->count;
    h->count++;
    return e;
}
