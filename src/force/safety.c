/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Implements the safety layer between the computed force and the device:
 *
 *   force --> finite? --> enabled, fresh? --> ramp --> saturation --> slew --> passivity --> device
 *
 * Passivity (observer and controller of Hannaford and Ryu 2002): the energy that the
 * hand has supplied, minus the energy that it has received, is the energy stored in
 * the contact.  A coupling can store at most stored_j, so the stored energy is limited to this
 * value.  A negative value means that energy was generated; a damper then removes it.
 */
#include <math.h>
#include <string.h>

#include <osteon/force.h>

#include "core/vector.h"

void ost_safety_begin(ost_safety *safety, const ost_safety_params *params)
{
    *safety = (ost_safety){.params = params ? *params : ost_safety_defaults()};
}

void ost_safety_stop(ost_safety *safety)
{
    safety->ramp = 0;
    safety->energy_j = 0;
    safety->has_at = false;
    memset(safety->last, 0, sizeof safety->last);
    memset(safety->last_torque, 0, sizeof safety->last_torque);
    memset(safety->applied, 0, sizeof safety->applied);
}

/* Limits the length of a vector to the value `most`. The limit is smooth: short vectors hardly change. */
static void saturate(double v[3], double most)
{
    const double share = ost_vector_length(v) / most, down = most > 0 ? 1 / sqrt(1 + share * share) : 0;
    for (int a = 0; a < 3; a++)
        v[a] *= down;
}

static void slew(double v[3], const double last[3], double most)
{
    double d[3] = {v[0] - last[0], v[1] - last[1], v[2] - last[2]};
    const double size = ost_vector_length(d);
    for (int a = 0; a < 3 && size > most; a++)
        v[a] = last[a] + d[a] * most / size;
}

/*
 * Computes the work of the last force over `moved`, the motion since the last tick, and subtracts it from the stored
 * energy. If the result is negative, adds damping to the force.
 */
static void passivity(ost_safety *s, const double moved[3], double period_s, double force_n[3])
{
    for (int a = 0; a < 3; a++)
        s->energy_j -= s->applied[a] * moved[a];
    if (s->energy_j > s->params.stored_j)
        s->energy_j = s->params.stored_j;
    const double square = moved[0] * moved[0] + moved[1] * moved[1] + moved[2] * moved[2];
    if (s->energy_j >= 0 || square <= 0 || s->params.max_damping <= 0)
        return;
    /* The damping, in N s/m, dissipates the generated energy within a tick: damping * |v|^2 * period = -energy. */
    double damping = -s->energy_j * period_s / square;
    if (damping > s->params.max_damping)
        damping = s->params.max_damping;
    for (int a = 0; a < 3; a++)
        force_n[a] -= damping * moved[a] / period_s;
    s->damped_ticks++;
}

static bool is_number(const double v[3])
{
    return isfinite(v[0]) && isfinite(v[1]) && isfinite(v[2]);
}

ost_safety_answer ost_safety_step(ost_safety *safety, const ost_pose *device, bool fresh, uint32_t buttons,
                                  double period_s, double force_n[3], double torque_nm[3])
{
    static const double none[3] = {0};
    ost_safety *s = safety;
    const double at[3] = {(double)device->t.x * 1e-12, (double)device->t.y * 1e-12, (double)device->t.z * 1e-12};
    double moved[3] = {0};
    if (!is_number(force_n) || !is_number(torque_nm)) {
        ost_safety_stop(s);
        memcpy(force_n, none, sizeof none);
        memcpy(torque_nm, none, sizeof none);
        return OST_SAFETY_FAULT;
    }
    for (int a = 0; a < 3 && s->has_at; a++)
        moved[a] = at[a] - s->at[a];
    memcpy(s->at, at, sizeof at);
    s->has_at = true;
    s->ticks_without_sample = fresh ? 0 : s->ticks_without_sample + 1;
    const bool withheld = (s->params.dead_man && !(buttons & s->params.dead_man)) ||
                          s->ticks_without_sample >= s->params.max_ticks_without_sample;
    s->ramp = withheld ? 0 : s->params.ramp_s > 0 ? fmin(1, s->ramp + period_s / s->params.ramp_s) : 1;
    for (int a = 0; a < 3; a++) {
        force_n[a] *= s->ramp;
        torque_nm[a] *= s->ramp;
    }
    saturate(force_n, s->params.max_force_n);
    saturate(torque_nm, s->params.max_torque_nm);
    /*
     * The slew limit of the torque is the slew limit of the force, scaled by the ratio of the maximum torque to the
     * maximum force.
     */
    slew(force_n, s->last, s->params.slew_n);
    slew(torque_nm, s->last_torque, s->params.slew_n * s->params.max_torque_nm / s->params.max_force_n);
    memcpy(s->last, force_n, sizeof s->last);
    memcpy(s->last_torque, torque_nm, sizeof s->last_torque);
    passivity(s, moved, period_s, force_n);
    const double size = ost_vector_length(force_n);
    for (int a = 0; a < 3 && size > s->params.max_force_n; a++)
        force_n[a] *= s->params.max_force_n / size;
    memcpy(s->applied, force_n, sizeof s->applied);
    return withheld ? OST_SAFETY_WITHHELD : OST_SAFETY_GIVEN;
}
