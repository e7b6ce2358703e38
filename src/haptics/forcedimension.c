/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The `dhd` driver: Force Dimension's delta, omega, sigma and lambda devices and Novint's Falcon,
 * through the library of the vendor's SDK.
 *
 * The library's functions run in the calling thread and use SI units; x points toward the operator,
 * y to the operator's right, and z up. An id of -1 selects the device that was opened last. The
 * return values 1 (the function was called again too soon) and 2 (a motor is at its limit) are not
 * failures.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "haptics/driver.h"
#include "haptics/vendor.h"
#include "haptics/workspace.h"

typedef struct dhd_calls {
    int (*open)(void);
    int (*close)(char id);
    int (*get_type)(char id);
    int (*get_pose)(double *x, double *y, double *z, double matrix[3][3], char id);
    int (*get_buttons)(char id);
    int (*enable_force)(unsigned char on, char id);
    int (*set_force)(double fx, double fy, double fz, double tx, double ty, double tz, double gripper, char id);
    const char *(*last_error)(void);
} dhd_calls;

static const vendor_symbol symbols[] = {
    {"dhdOpen", offsetof(dhd_calls, open)},
    {"dhdClose", offsetof(dhd_calls, close)},
    {"dhdGetSystemType", offsetof(dhd_calls, get_type)},
    {"dhdGetPositionAndOrientationFrame", offsetof(dhd_calls, get_pose)},
    {"dhdGetButtonMask", offsetof(dhd_calls, get_buttons)},
    {"dhdEnableForce", offsetof(dhd_calls, enable_force)},
    {"dhdSetForceAndTorqueAndGripperForce", offsetof(dhd_calls, set_force)},
    {"dhdErrorGetLastStr", offsetof(dhd_calls, last_error)},
};
static const char *const names[] = {"libdhd.so.3", "libdhd.so", NULL};
static const vendor_library library = {"OSTEON_DHD_LIBRARY", names, "Force Dimension's SDK", symbols,
                                       sizeof symbols / sizeof symbols[0]};

/* The library reports the type of a device but not its maximum forces. These forces are taken from
   the vendors' data sheets. */
static const struct {
    int type;
    const char *name;
    double force_n, torque_nm;
} types[] = {
    {32, "an omega", 12, 0},   {33, "an omega.3", 12, 0}, {34, "an omega.6", 12, 0}, {36, "an omega.6", 12, 0},
    {35, "an omega.7", 12, 0}, {37, "an omega.7", 12, 0}, {63, "a delta.3", 20, 0},  {64, "a delta.6", 20, 0},
    {60, "a Falcon", 8, 0},    {104, "a sigma.7", 12, 0.2}, {105, "a sigma.7", 12, 0.2},
};

enum { LAST_OPENED = -1, MOST_SCALE_PERCENT = 1000 };

struct haptic_instance {
    dhd_calls dhd;
    haptic_workspace workspace;
    bool lost;
};

static bool dhd_usable(char reason[256])
{
    dhd_calls calls;
    return ost_vendor_load(&library, &calls, reason);
}

static ost_status take(void *user, const char *key, const char *value, ost_error *err)
{
    if (strcmp(key, "scale") == 0)
        return ost_haptic_integer("dhd", key, value, 1, MOST_SCALE_PERCENT, user, err);
    return ost_fail(err, OST_ERR_USAGE, "device dhd: unknown option '%s'; expected scale (per cent)", key);
}

static ost_status dhd_open(const char *options, const ost_haptic_setup *setup, haptic_instance **out, ost_error *err)
{
    /* The device's y points to the right, z up, and x toward the operator. */
    static const int axes[3] = {1, 2, 0};
    int64_t percent = 100;
    char reason[256];
    ost_status status = ost_haptic_options("dhd", options, take, &percent, err);
    if (status != OST_OK)
        return status;
    haptic_instance *d = calloc(1, sizeof *d);
    if (!d)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for device dhd");
    if (!ost_vendor_load(&library, &d->dhd, reason)) {
        free(d);
        return ost_fail(err, OST_ERR_UNAVAILABLE, "device dhd: %s", reason);
    }
    d->workspace = ost_haptic_workspace_make(&setup->start, axes, (double)percent / 100);
    if (d->dhd.open() < 0) {
        status = ost_fail(err, OST_ERR_UNAVAILABLE, "device dhd: cannot open: %.160s", d->dhd.last_error());
    } else if (d->dhd.enable_force(1, LAST_OPENED) < 0) {
        status = ost_fail(err, OST_ERR_UNAVAILABLE, "device dhd: cannot enable forces: %.160s", d->dhd.last_error());
        d->dhd.close(LAST_OPENED);
    }
    if (status != OST_OK)
        free(d);
    else
        *out = d;
    return status;
}

static void dhd_close(haptic_instance *d)
{
    d->dhd.set_force(0, 0, 0, 0, 0, 0, 0, LAST_OPENED);
    d->dhd.enable_force(0, LAST_OPENED);
    d->dhd.close(LAST_OPENED);
    free(d);
}

static ost_haptic_answer dhd_read(haptic_instance *d, ost_haptic_state *state)
{
    double at[3] = {NAN, NAN, NAN}, frame[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    if (d->lost || d->dhd.get_pose(&at[0], &at[1], &at[2], frame, LAST_OPENED) < 0)
        return OST_HAPTIC_LOST;
    const int buttons = d->dhd.get_buttons(LAST_OPENED);
    if (buttons < 0)
        return OST_HAPTIC_LOST;
    *state = (ost_haptic_state){
        .pose = ost_haptic_workspace_pose(&d->workspace, at, frame), .tool = -1, .buttons = (uint32_t)buttons};
    return OST_HAPTIC_FRESH;
}

static void dhd_write(haptic_instance *d, const ost_wrench *wrench)
{
    double f[3], t[3];
    ost_haptic_workspace_vector(&d->workspace, wrench->force_n, f);
    ost_haptic_workspace_vector(&d->workspace, wrench->torque_nm, t);
    d->lost = d->lost || d->dhd.set_force(f[0], f[1], f[2], t[0], t[1], t[2], 0, LAST_OPENED) < 0;
}

static void dhd_limits(haptic_instance *d, ost_haptic_limits *out)
{
    const int type = d->dhd.get_type(LAST_OPENED);
    out->force_n = NAN;
    snprintf(out->from, sizeof out->from, "type %d of the SDK", type);
    for (size_t i = 0; i < sizeof types / sizeof types[0]; i++)
        if (types[i].type == type) {
            out->force_n = types[i].force_n;
            out->torque_nm = types[i].torque_nm;
            snprintf(out->from, sizeof out->from, "%s", types[i].name);
        }
}

const haptic_driver ost_haptic_dhd = {
    .name = "dhd",
    .description = "Force Dimension's delta, omega, sigma and lambda, and Novint's Falcon",
    .caps = OST_HAPTIC_FORCE | OST_HAPTIC_TORQUE | OST_HAPTIC_ORIENTATION,
    .max_force_n = 8, /* maximum force in N of the Falcon, the weakest of these devices */
    .max_stiffness_n_m = 3000,
    .buttons = {{"button1", OST_ACTION_MOTOR},
                {"button2", OST_ACTION_TOOL},
                {"button3", OST_ACTION_CLUTCH},
                {"button4", OST_ACTION_HOME}},
    .usable = dhd_usable,
    .open = dhd_open,
    .close = dhd_close,
    .read = dhd_read,
    .write = dhd_write,
    .limits = dhd_limits,
};
