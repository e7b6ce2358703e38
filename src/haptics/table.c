/* SPDX-License-Identifier: Apache-2.0 */
/* Defines the list of drivers and the public functions that open and list devices. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "haptics/driver.h"

static const haptic_driver *const drivers[] = {
    &ost_haptic_null,   &ost_haptic_script,   &ost_haptic_replay,      &ost_haptic_sim,
    &ost_haptic_motion, &ost_haptic_mouse,    &ost_haptic_openhaptics, &ost_haptic_dhd,
    &ost_haptic_spnav,  &ost_haptic_inverse3, &ost_haptic_udp,         &ost_haptic_openxr,
};

enum { DRIVERS = sizeof drivers / sizeof drivers[0] };

int ost_haptic_count(void)
{
    return DRIVERS;
}

ost_status ost_haptic_describe(int index, ost_haptic_info *out, ost_error *err)
{
    if (index < 0 || index >= DRIVERS)
        return ost_fail(err, OST_ERR_USAGE, "no device %d; expected 0 to less than %d", index, DRIVERS);
    const haptic_driver *d = drivers[index];
    *out = (ost_haptic_info){.name = d->name,
                             .description = d->description,
                             .caps = d->caps,
                             .max_force_n = d->max_force_n,
                             .max_stiffness_n_m = d->max_stiffness_n_m};
    for (int i = 0; i < OST_BUTTONS_MAX && d->buttons[i].name; i++)
        out->buttons[out->button_count++] = d->buttons[i];
    out->available = (!d->usable || d->usable(out->reason)) && (!d->answers || d->answers(out->reason));
    return OST_OK;
}

ost_status ost_haptic_open_driver(const haptic_driver *driver, const char *options, const ost_haptic_setup *setup,
                                  ost_haptic **out, ost_error *err)
{
    static const ost_haptic_setup nothing = {.start = {.qw = OST_Q30_ONE}};
    char reason[256] = "";
    *out = NULL;
    if (driver->usable && !driver->usable(reason))
        return ost_fail(err, OST_ERR_UNAVAILABLE, "device %s: %s", driver->name, reason);
    ost_haptic *device = calloc(1, sizeof *device);
    if (!device)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for device %s", driver->name);
    device->driver = driver;
    ost_status status = driver->open(options, setup ? setup : &nothing, &device->instance, err);
    if (status != OST_OK) {
        free(device);
        return status;
    }
    *out = device;
    return OST_OK;
}

ost_status ost_haptic_open(const char *spec, const ost_haptic_setup *setup, ost_haptic **out, ost_error *err)
{
    *out = NULL;
    if (!spec)
        return ost_fail(err, OST_ERR_USAGE, "no device given");
    const size_t length = strcspn(spec, ":");
    for (int i = 0; i < DRIVERS; i++)
        if (strlen(drivers[i]->name) == length && memcmp(drivers[i]->name, spec, length) == 0)
            return ost_haptic_open_driver(drivers[i], spec[length] ? spec + length + 1 : "", setup, out, err);
    char names[192] = "";
    for (int i = 0, used = 0; i < DRIVERS; i++)
        used += snprintf(names + used, sizeof names - (size_t)used, "%s%s",
                         !i                 ? ""
                         : i == DRIVERS - 1 ? " or "
                                            : ", ",
                         drivers[i]->name);
    return ost_fail(err, OST_ERR_USAGE, "unknown device '%.60s'; expected %s", spec, names);
}

void ost_haptic_close(ost_haptic *device)
{
    if (!device)
        return;
    device->driver->close(device->instance);
    free(device);
}

const char *ost_haptic_name(const ost_haptic *device)
{
    return device->driver->name;
}

const char *ost_haptic_about(const ost_haptic *device, char text[OST_HAPTIC_TEXT])
{
    text[0] = '\0';
    if (device->driver->about)
        device->driver->about(device->instance, text);
    return text;
}

bool ost_haptic_limits_get(const ost_haptic *device, ost_haptic_limits *out)
{
    *out = (ost_haptic_limits){0};
    if (device->driver->limits)
        device->driver->limits(device->instance, out);
    return device->driver->limits;
}

bool ost_haptic_limits_usable(const ost_haptic_limits *l)
{
    /* The accepted ranges include every known device. The greatest force of a known device is 40 N, and its greatest
       torque is below 2 N m. */
    return l->force_n >= 0.1 && l->force_n <= 100 &&
           (l->torque_nm == 0 || (l->torque_nm >= 1e-3 && l->torque_nm <= 10));
}

int ost_haptic_counts(const ost_haptic *device, ost_haptic_tally out[OST_HAPTIC_COUNTS])
{
    return device->driver->counts ? device->driver->counts(device->instance, out) : 0;
}

ost_haptic_answer ost_haptic_read(ost_haptic *device, ost_haptic_state *state)
{
    return device->driver->read(device->instance, state);
}

void ost_haptic_write(ost_haptic *device, const ost_wrench *wrench)
{
    if (device->driver->write)
        device->driver->write(device->instance, wrench);
}
