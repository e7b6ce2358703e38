/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Defines the parameters that a parameter file may set: their names, their bounds and the source of
 * each default.  docs/reference/force.md documents their meaning.
 *
 *   # comment lines and blank lines are skipped
 *   stiffness: 250        # a comment after a value
 */
#include "core/conditions.h"

#include "force/params.h"

#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include <osteon/length.h>

#include "core/file.h"
#include "core/shortest.h"

ost_force_params ost_force_defaults(void)
{
    return (ost_force_params){
        .mode = OST_FORCE_ENERGY,
        .scale = 0.08,
        .stiffness = 300,
        .damping = 0.5,
        .speed = 31.4,
        .cutting_ratio = 0.5,
        .energy = 30e6,
        .reference_density = 1.95,
        .density_at_0 = 0.131,
        .density_per_hu = 1.067e-3,
        .layer = 2e-3,
        .layer_stiffness = 5e7,
        .turn_stiffness = 0,
        .turn_damping = 2e-3,
        .vibration = 0,
        .runout = 0,
        .teeth = 20,
    };
}

double ost_force_density(const ost_force_params *params, int hu)
{
    return params->density_at_0 + params->density_per_hu * hu;
}

double ost_force_energy(const ost_force_params *params, int hu)
{
    const double density = ost_force_density(params, hu), share = density / params->reference_density;
    return density > 0 ? params->energy * share * share : 0;
}

ost_safety_params ost_safety_defaults(void)
{
    return (ost_safety_params){
        .max_force_n = 3.0,
        .max_torque_nm = 0.1,
        .slew_n = 0.3,
        .ramp_s = 0.5,
        .max_ticks_without_sample = 2,
        .dead_man = 0,
        .stored_j = 0.015,
        .max_damping = 2,
    };
}

/* ------------------------------------------------------------------ by name */

typedef enum kind { REAL, TICKS, BUTTONS } kind;

typedef struct parameter {
    ost_force_key key;
    bool safety;   /* true if the field belongs to ost_safety_params */
    kind kind;
    size_t offset;
} parameter;

#define FORCE(field, unit, lo, hi, about)                                                                              \
    {                                                                                                                  \
        {#field, unit, about, lo, hi}, false, REAL, offsetof(ost_force_params, field)                                  \
    }
#define SAFETY(name, kind, field, unit, lo, hi, about)                                                                 \
    {                                                                                                                  \
        {name, unit, about, lo, hi}, true, kind, offsetof(ost_safety_params, field)                                    \
    }

static const parameter parameters[] = {
    FORCE(scale, "1", 0.01, 1,
          "ratio of the rendered to the computed force; a reamer is pressed with about 40 N, an Omni renders 3.3 N"),
    FORCE(stiffness, "N/m", 1, 1e6,
          "stiffness of the coupling as felt; at 1 kHz, with 60 g, a light grip and no friction, it oscillates from "
          "250 to 300 on"),
    FORCE(damping, "N s/m", 0, 1e3, "damping of the coupling as felt; an Omni tolerates less than 2 (data sheet)"),
    FORCE(cutting_ratio, "1", 1e-3, 10,
          "ratio of the tangential to the normal force of cutting, of the order known for bone; to be calibrated"),
    FORCE(energy, "J/m3", 1, 1e12,
          "energy per volume to cut bone of reference density: cortical 30e6 to 150e6, trabecular 2e6 to 15e6; to be "
          "calibrated"),
    FORCE(reference_density, "g/cm3", 1e-3, 1e3,
          "density at which this energy is needed; it grows with the square of density, as strength does (Carter, "
          "Hayes 1977)"),
    FORCE(density_at_0, "g/cm3", -1e3, 1e3, "density at 0 HU (Rho, Hobatho, Ashman 1995)"),
    FORCE(density_per_hu, "g/cm3", -1, 1, "increase of density per HU (same source)"),
    FORCE(layer, "m", 1e-6, 1, "thickness of the compressed layer of bone around the tool (--force instant)"),
    FORCE(layer_stiffness, "N/m3", 0, 1e15,
          "stiffness of that layer per area and depth, in bone of reference density (--force instant)"),
    FORCE(turn_stiffness, "N m/rad", 0, 1e3,
          "rotational stiffness of the coupling as felt, on devices that render torques; 0: the tool "
          "turns with the hand"),
    FORCE(turn_damping, "N m s/rad", 0, 1e2, "rotational damping of the coupling as felt"),
    FORCE(vibration, "1", 0, 1,
          "amplitude of the vibration by passing teeth, relative to the felt force in bone of reference density; 0: "
          "none; to be calibrated"),
    FORCE(runout, "1", 0, 1, "amplitude of the vibration once per turn, across the axis, relative to the same force"),
    FORCE(teeth, "1", 1, 1000, "number of teeth that pass per turn; teeth times turns per second must be below 500"),
    SAFETY("max_force", REAL, max_force_n, "N", 1e-3, 1e3,
           "limit of the force, approached smoothly; default: 0.9 times the limit that the device reports, or, if it "
           "reports none, less than the 3.3 N of an Omni"),
    SAFETY("max_torque", REAL, max_torque_nm, "N m", 1e-6, 1e2,
           "limit of the torque, by the same rule; if the device reports none, half the torque of a sigma.7"),
    SAFETY("slew", REAL, slew_n, "N/tick", 1e-6, 1e3, "greatest change of the force per tick"),
    SAFETY("ramp", REAL, ramp_s, "s", 0, 60,
           "time in which the force rises to its full value, after a start and after every fault"),
    SAFETY("stale_ticks", TICKS, max_ticks_without_sample, "ticks", 1, 1000,
           "number of ticks without a new pose after which the force is switched off"),
    SAFETY("dead_man", BUTTONS, dead_man, "buttons", 0, 4294967295.0,
           "buttons of which one must be held, as a sum of 1, 2, 4, ...; 0: none"),
    SAFETY("stored_energy", REAL, stored_j, "J", 0, 10,
           "energy that the coupling may store (300 N/m at 3 N) before the passivity controller acts"),
    SAFETY("max_damping", REAL, max_damping, "N s/m", 0, 1e3,
           "greatest damping that the passivity controller adds (Hannaford, Ryu 2002); 0: none"),
};

enum { COUNT = sizeof parameters / sizeof parameters[0] };

int ost_force_key_count(void)
{
    return COUNT;
}

const ost_force_key *ost_force_key_at(int index)
{
    return index >= 0 && index < COUNT ? &parameters[index].key : NULL;
}

double ost_force_key_value(int index, const ost_force_params *force, const ost_safety_params *safety)
{
    if (index < 0 || index >= COUNT)
        return 0;
    const parameter *p = &parameters[index];
    const char *at = (p->safety ? (const char *)safety : (const char *)force) + p->offset;
    if (p->kind == REAL)
        return *(const double *)(const void *)at;
    return p->kind == TICKS ? (double)*(const int *)(const void *)at : (double)*(const uint32_t *)(const void *)at;
}

static void put(const parameter *p, double value, ost_force_params *force, ost_safety_params *safety)
{
    char *at = (p->safety ? (char *)safety : (char *)force) + p->offset;
    if (p->kind == REAL)
        *(double *)(void *)at = value;
    else if (p->kind == TICKS)
        *(int *)(void *)at = (int)value;
    else
        *(uint32_t *)(void *)at = (uint32_t)value;
}

char *ost_force_value_text(double value, char text[OST_FORCE_VALUE])
{
    snprintf(text, OST_FORCE_VALUE, "%.15g", value);
    ost_point_put_back(text);
    return text;
}

/*
 * Returns true if the frequency of the teeth is at least half the tick rate of 1 kHz. A vibration at such a frequency
 * would be rendered at a wrong frequency.
 */
static bool passes_too_fast(const ost_force_params *p)
{
    return p->vibration > 0 && p->speed * p->teeth >= 500 * 6.283185307179586;
}

static const char too_fast[] = "speed and teeth: more than 500 teeth a second cannot be felt at 1 kHz";

ost_status ost_force_params_check(const ost_force_params *params, ost_error *err)
{
    for (int i = 0; i < COUNT && !parameters[i].safety; i++) {
        const double value = ost_force_key_value(i, params, NULL);
        if (!(value >= parameters[i].key.lo && value <= parameters[i].key.hi))
            return ost_fail(err, OST_ERR_RANGE, "force: %s is %g; expected %g to %g", parameters[i].key.name, value,
                            parameters[i].key.lo, parameters[i].key.hi);
    }
    if (!(params->speed >= 0 && params->speed <= 1e4))
        return ost_fail(err, OST_ERR_RANGE, "force: speed is %g; expected 0 to 1e4 rad/s", params->speed);
    return passes_too_fast(params) ? ost_fail(err, OST_ERR_RANGE, "force: %s", too_fast) : OST_OK;
}

/* ------------------------------------------------------------------- a file */

enum { LINE = 400 };

static const char *end_of(const char *text)
{
    const char *end = text + strcspn(text, "#\r\n");
    while (end > text && (end[-1] == ' ' || end[-1] == '\t'))
        end--;
    return end;
}

/*
 * Converts a decimal to a double. The result is correctly rounded if the decimal has at most 15 digits and an exponent
 * from -22 to 22.
 */
static double real_of(const ost_decimal *d)
{
    double value = (double)d->mantissa, ten = 1;
    int32_t e = d->exponent < 0 ? -d->exponent : d->exponent;
    for (e = e < 400 ? e : 400; e > 0; e--)
        ten *= 10;
    return d->exponent < 0 ? value / ten : value * ten;
}

static ost_status take(const char *file, int line, const char *text, ost_force_params *force, ost_safety_params *safety,
                       bool seen[], ost_error *err)
{
    text += strspn(text, " \t");
    const char *end = end_of(text), *colon = memchr(text, ':', (size_t)(end - text));
    const size_t length = colon ? (size_t)(colon - text) : 0;
    if (end == text)
        return OST_OK;
    if (!colon)
        return ost_fail(err, OST_ERR_INPUT, "%s:%d: '%.*s': expected 'key: number'", file, line,
                        (int)(end - text < 60 ? end - text : 60), text);
    int i = 0;
    while (i < COUNT && (strlen(parameters[i].key.name) != length || memcmp(parameters[i].key.name, text, length) != 0))
        i++;
    if (i == COUNT && length == 5 && memcmp("speed", text, length) == 0)
        return ost_fail(err, OST_ERR_INPUT,
                        "%s:%d: speed is set by the motor; remove the line and pass --rpm to osteon sim", file, line);
    if (i == COUNT)
        return ost_fail(err, OST_ERR_INPUT, "%s:%d: unknown parameter '%.*s'; see osteon sim --print-force-params",
                        file, line, (int)(length < 60 ? length : 60), text);
    if (seen[i])
        return ost_fail(err, OST_ERR_INPUT, "%s:%d: %s is set twice", file, line, parameters[i].key.name);
    seen[i] = true;
    const ost_force_key *key = &parameters[i].key;
    const char *value = colon + 1 + strspn(colon + 1, " \t"), *after;
    ost_decimal d;
    const int shown = end - value < 0 ? 0 : end - value < 60 ? (int)(end - value) : 60;
    after = value <= end ? ost_decimal_read(value, end, &d) : NULL;
    if (!after || after != end)
        return ost_fail(err, OST_ERR_INPUT, "%s:%d: %s is '%.*s': expected a number in %s", file, line, key->name,
                        shown, value, key->unit);
    const double number = real_of(&d);
    /* The bounds are checked first, because converting a number outside the range of int64_t is undefined. */
    if (!(number >= key->lo && number <= key->hi) || (parameters[i].kind != REAL && number != (double)(int64_t)number))
        return ost_fail(err, OST_ERR_RANGE, "%s:%d: %s is '%.*s': expected %s%g to %g %s", file, line, key->name, shown,
                        value, parameters[i].kind == REAL ? "" : "a whole number, ", key->lo, key->hi, key->unit);
    put(&parameters[i], number, force, safety);
    return OST_OK;
}

ost_status ost_force_params_read(const char *file, ost_force_params *force, ost_safety_params *safety, ost_error *err)
{
    ost_force_params f = *force;
    ost_safety_params s = *safety;
    bool seen[COUNT] = {false};
    char text[LINE];
    FILE *in;
    ost_status status = ost_file_stream(file, &in, NULL, err);
    if (status != OST_OK)
        return status;
    for (int line = 1; status == OST_OK && fgets(text, sizeof text, in); line++) {
        if (!strchr(text, '\n') && !feof(in))
            status = ost_fail(err, OST_ERR_INPUT, "%s:%d: longer than %d bytes, or binary; expected 'key: number'",
                              file, line, LINE - 2);
        else
            status = take(file, line, text, &f, &s, seen, err);
    }
    if (status == OST_OK && ferror(in))
        status = ost_fail(err, OST_ERR_INPUT, "%s: cannot be read", file);
    fclose(in);
    if (status == OST_OK && passes_too_fast(&f))
        status = ost_fail(err, OST_ERR_RANGE, "%s: %s", file, too_fast);
    if (status != OST_OK)
        return status;
    *force = f;
    *safety = s;
    return OST_OK;
}
