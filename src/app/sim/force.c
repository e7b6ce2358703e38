/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Chooses the force model and its parameters according to the device and the options --force and --force-params.
 * Writes the parameters as keys of a session.
 */
#include "app/sim/sim.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "app/common/result.h"
#include "app/common/print.h"

/*
 * Default stiffness, in N m/rad, for a device that renders torques. The value suits a handle of 60 g with an inertia of
 * 0.15 g m2, held by a hand with a damping of 10 mN m s.
 */
#define TURN_STIFFNESS 0.5

const char *const sim_force_names[] = {"off", "energy", "instant"};

static uint32_t caps_of(const sim_args *args)
{
    ost_haptic_info info;
    return sim_device_info(args, &info) ? info.caps : 0;
}

ost_status sim_force_params(const app_state *app, sim_args *args, ost_error *err)
{
    const uint32_t caps = caps_of(args);
    args->force_params = ost_force_defaults();
    args->force_params.speed = (double)args->rpm * 0.10471975511965977; /* rpm to rad/s */
    args->safety = ost_safety_defaults();
    if (caps & OST_HAPTIC_TORQUE)
        args->force_params.turn_stiffness = TURN_STIFFNESS;
    args->max_force_from = "default";
    if (!args->force_file)
        return OST_OK;
    /* Values that the file does not set remain NAN. */
    ost_safety_params read = args->safety;
    read.max_force_n = read.max_torque_nm = NAN;
    ost_status status = ost_force_params_read(args->force_file, &args->force_params, &read, err);
    args->max_force_given = !isnan(read.max_force_n);
    args->max_torque_given = !isnan(read.max_torque_nm);
    if (args->max_force_given)
        args->max_force_from = "force-params";
    else
        read.max_force_n = args->safety.max_force_n;
    if (!args->max_torque_given)
        read.max_torque_nm = args->safety.max_torque_nm;
    args->safety = read;
    if (status == OST_OK && args->force_params.turn_stiffness > 0 && !(caps & OST_HAPTIC_TORQUE)) {
        warn(app, "%s: turn_stiffness ignored: device %s renders no torques", args->force_file, args->device);
        args->force_params.turn_stiffness = 0;
    }
    return status;
}

void sim_force_print(const app_state *app, const sim_args *args)
{
    json_t *o = json_object();
    char text[OST_FORCE_VALUE];
    print_line(app, "# osteon sim --force-params FILE: an omitted parameter has the value that is given here");
    for (int i = 0; i < ost_force_key_count(); i++) {
        const ost_force_key *key = ost_force_key_at(i);
        const double value = ost_force_key_value(i, &args->force_params, &args->safety);
        print_line(app, "%s", "");
        print_line(app, "# %s", key->about);
        print_line(app, "%s: %s   # %s, %g to %g", key->name, ost_force_value_text(value, text), key->unit, key->lo,
                   key->hi);
        put_real(o, key->name, value);
    }
    put(app->result, "force_params", o);
}

/* Replaces each limit that the file does not set with the limit of the open device. */
static void take_limits(const app_state *app, sim_args *args, const simulation *s)
{
    ost_haptic_limits own;
    if (!ost_haptic_limits_get(s->device, &own))
        return;
    if (!ost_haptic_limits_usable(&own)) {
        warn(app, "device %s reports that it gives %g N and %g N m (%s), which is not a usable limit; forces are "
             "limited to %g N; set another limit with --force-params FILE", ost_haptic_name(s->device), own.force_n,
             own.torque_nm, own.from, args->safety.max_force_n);
        return;
    }
    args->limits = own;
    if (!args->max_torque_given && own.torque_nm > 0)
        args->safety.max_torque_nm = OST_HAPTIC_LIMIT_SHARE * own.torque_nm;
    if (args->max_force_given)
        return;
    args->safety.max_force_n = OST_HAPTIC_LIMIT_SHARE * own.force_n;
    args->max_force_from = "device";
}

void sim_force_limit_text(const sim_args *args, char text[SIM_LIMIT_TEXT])
{
    const ost_haptic_limits *l = &args->limits;
    char more[2][32] = {"", ""};
    if (l->torque_nm > 0)
        snprintf(more[0], sizeof more[0], ", %g N m", l->torque_nm);
    if (l->continuous_n > 0)
        snprintf(more[1], sizeof more[1], ", %g N for long", l->continuous_n);
    if (strcmp(args->max_force_from, "device") == 0)
        snprintf(text, SIM_LIMIT_TEXT, "device: %s gives %g N%s%s", l->from, l->force_n, more[0], more[1]);
    else
        snprintf(text, SIM_LIMIT_TEXT, "%s", args->max_force_from);
}

ost_status sim_force_make(const app_state *app, sim_args *args, simulation *s, ost_error *err)
{
    const bool renders = caps_of(args) & (OST_HAPTIC_FORCE | OST_HAPTIC_SHOWN);
    if (!args->force_given)
        args->force = renders;
    if (args->force && !renders)
        return usage_error(app, err, "--force %s: device %s cannot render a force; pass --force off",
                           sim_force_names[args->force], args->device);
    if (!args->force)
        return OST_OK;
    take_limits(app, args, s);
    args->force_params.mode = args->force == 2 ? OST_FORCE_INSTANT : OST_FORCE_ENERGY;
    ost_status status = ost_force_create(s->bone, &args->force_params, &s->force, err);
    if (status == OST_ERR_UNAVAILABLE && !args->force_given) {
        warn(app, "%s; no force is rendered", err->text);
        args->force = 0;
        *err = (ost_error){0};
        return OST_OK;
    }
    for (int i = 0; i < args->tools.count && status == OST_OK; i++)
        status = ost_force_add_tool(s->force, s->tools[i], err);
    return status;
}

void sim_force_session(const sim_args *args, sim_force_texts *texts, session_key *keys)
{
    int i = 0;
    for (; args->force && i < ost_force_key_count() && i < SIM_FORCE_KEYS; i++) {
        snprintf(texts->key[i], sizeof texts->key[i], "force.%s", ost_force_key_at(i)->name);
        ost_force_value_text(ost_force_key_value(i, &args->force_params, &args->safety), texts->value[i]);
        keys[i] = (session_key){texts->key[i], texts->value[i]};
    }
    if (args->force) {
        sim_force_limit_text(args, texts->from);
        keys[i++] = (session_key){"force.max_force_from", texts->from};
    }
    keys[i] = (session_key){NULL, NULL};
}
