/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The `openhaptics` driver: 3D Systems' Touch and Touch X, and the Phantom Omni of the thesis,
 * through OpenHaptics' HD interface.
 *
 *   vendor's thread, a thousand times a second
 *     frame begins --transform, buttons--> beat: read, tick, write --force--> frame ends
 *
 * A complete tick runs within the vendor's frame, so the force is computed from the pose of the
 * same millisecond. Meanwhile, the thread that called run waits and checks that the vendor's thread
 * is still running. Units are millimetres and newtons; x points to the right, y up, and z toward
 * the operator. The device senses six degrees of freedom and renders forces in three.
 */
#include <errno.h>
#include <math.h>
#include <semaphore.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "haptics/driver.h"
#include "haptics/vendor.h"
#include "haptics/workspace.h"

/* This struct has the layout of the vendor's HDErrorInfo. */
typedef struct hd_error {
    unsigned code;
    int internal;
    unsigned device;
} hd_error;
_Static_assert(sizeof(hd_error) == 12, "an HDErrorInfo");

enum {
    HD_BUTTONS = 0x2000,
    HD_TRANSFORM = 0x2052,
    HD_MAX_FORCE = 0x2603,
    HD_MAX_CONTINUOUS_FORCE = 0x2604,
    HD_FORCE = 0x2700,
    HD_FORCE_OUTPUT = 0x4000,
    HD_WARM_MOTORS = 0x0200,
    HD_EXCEEDED_FORCE = 0x0201,
    HD_DONE = 0,
    HD_CONTINUE = 1,
    HD_PRIORITY = 32767
};
#define HD_NO_DEVICE 0xffffffffu

typedef struct hd_calls {
    unsigned (*init)(const char *name);
    void (*disable)(unsigned device);
    void (*make_current)(unsigned device);
    void (*begin)(unsigned device);
    void (*end)(unsigned device);
    void (*get_doubles)(unsigned what, double *values);
    void (*get_integers)(unsigned what, int *values);
    void (*set_doubles)(unsigned what, const double *values);
    void (*enable)(unsigned what);
    hd_error (*error)(void);
    const char *(*error_text)(unsigned code);
    unsigned long (*schedule)(unsigned (*call)(void *), void *user, unsigned short priority);
    void (*unschedule)(unsigned long handle);
    void (*start)(void);
    void (*stop)(void);
} hd_calls;

static const vendor_symbol symbols[] = {
    {"hdInitDevice", offsetof(hd_calls, init)},
    {"hdDisableDevice", offsetof(hd_calls, disable)},
    {"hdMakeCurrentDevice", offsetof(hd_calls, make_current)},
    {"hdBeginFrame", offsetof(hd_calls, begin)},
    {"hdEndFrame", offsetof(hd_calls, end)},
    {"hdGetDoublev", offsetof(hd_calls, get_doubles)},
    {"hdGetIntegerv", offsetof(hd_calls, get_integers)},
    {"hdSetDoublev", offsetof(hd_calls, set_doubles)},
    {"hdEnable", offsetof(hd_calls, enable)},
    {"hdGetError", offsetof(hd_calls, error)},
    {"hdGetErrorString", offsetof(hd_calls, error_text)},
    {"hdScheduleAsynchronous", offsetof(hd_calls, schedule)},
    {"hdUnschedule", offsetof(hd_calls, unschedule)},
    {"hdStartScheduler", offsetof(hd_calls, start)},
    {"hdStopScheduler", offsetof(hd_calls, stop)},
};
static const char *const names[] = {"libHD.so", "libHD.so.3.4", NULL};
static const vendor_library library = {"OSTEON_OPENHAPTICS_LIBRARY", names, "OpenHaptics and the device's driver",
                                       symbols, sizeof symbols / sizeof symbols[0]};

enum { COOL_TICKS = 1000, POLL_MS = 500, NAME = 64 };

struct haptic_instance {
    hd_calls hd;
    unsigned device;
    haptic_workspace workspace;
    ost_haptic_limits limits;
    /* While the vendor's thread runs, only that thread uses the fields from `beat` to `lost`. */
    haptic_beat *beat;
    void *user;
    ost_haptic_state state;
    double force[3];
    int cooling; /* number of remaining ticks without force */
    bool lost;
    _Atomic uint64_t frames;
    sem_t over;
};

typedef struct choice {
    int64_t percent;
    char name[NAME];
} choice;

static bool openhaptics_usable(char reason[256])
{
    hd_calls calls;
    return ost_vendor_load(&library, &calls, reason);
}

static ost_status take(void *user, const char *key, const char *value, ost_error *err)
{
    choice *c = user;
    if (strcmp(key, "scale") == 0)
        return ost_haptic_integer("openhaptics", key, value, 1, 1000, &c->percent, err);
    if (strcmp(key, "name") != 0)
        return ost_fail(err, OST_ERR_USAGE, "device openhaptics: unknown option '%s'; expected name or scale", key);
    if (strlen(value) >= NAME)
        return ost_fail(err, OST_ERR_USAGE, "device openhaptics: name=%.60s...: longer than %d bytes", value, NAME - 1);
    strcpy(c->name, value);
    return OST_OK;
}

/*
 * Reads a parameter of the current device. If the device does not have this parameter, removes the
 * error from the queue and returns NaN.
 */
static double nominal(const haptic_instance *h, unsigned what)
{
    double value = NAN;
    h->hd.get_doubles(what, &value);
    return h->hd.error().code == 0 ? value : NAN;
}

static ost_haptic_limits read_limits(const haptic_instance *h)
{
    const double continuous = nominal(h, HD_MAX_CONTINUOUS_FORCE);
    return (ost_haptic_limits){.force_n = nominal(h, HD_MAX_FORCE),
                               .continuous_n = continuous > 0 ? continuous : 0,
                               .from = "HD_NOMINAL_MAX_FORCE"};
}

static ost_status openhaptics_open(const char *options, const ost_haptic_setup *setup, haptic_instance **out,
                                   ost_error *err)
{
    static const int axes[3] = {0, 1, 2};
    choice c = {.percent = 100};
    char reason[256];
    ost_status status = ost_haptic_options("openhaptics", options, take, &c, err);
    if (status != OST_OK)
        return status;
    haptic_instance *h = calloc(1, sizeof *h);
    if (!h)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for device openhaptics");
    if (!ost_vendor_load(&library, &h->hd, reason)) {
        free(h);
        return ost_fail(err, OST_ERR_UNAVAILABLE, "device openhaptics: %s", reason);
    }
    h->workspace = ost_haptic_workspace_make(&setup->start, axes, (double)c.percent / 100);
    h->state.tool = -1;
    h->device = h->hd.init(c.name[0] ? c.name : NULL);
    const hd_error error = h->hd.error();
    if (h->device == HD_NO_DEVICE || error.code != 0) {
        status = ost_fail(err, OST_ERR_UNAVAILABLE, "device openhaptics: '%s' cannot be opened: %.120s",
                          c.name[0] ? c.name : "default", h->hd.error_text(error.code));
        free(h);
        return status;
    }
    h->limits = read_limits(h);
    h->hd.enable(HD_FORCE_OUTPUT);
    sem_init(&h->over, 0, 0);
    *out = h;
    return OST_OK;
}

static void openhaptics_limits(haptic_instance *h, ost_haptic_limits *out)
{
    *out = h->limits;
}

static void openhaptics_close(haptic_instance *h)
{
    h->hd.disable(h->device);
    sem_destroy(&h->over);
    free(h);
}

static ost_haptic_answer openhaptics_read(haptic_instance *h, ost_haptic_state *state)
{
    if (h->lost)
        return OST_HAPTIC_LOST;
    *state = h->state;
    return OST_HAPTIC_FRESH;
}

static void openhaptics_write(haptic_instance *h, const ost_wrench *wrench)
{
    ost_haptic_workspace_vector(&h->workspace, wrench->force_n, h->force);
}

/*
 * Handles errors of the device. If the motors are too warm, the device renders no force for a second. The error
 * "exceeded force" is ignored. Any other error means that the device is lost.
 */
static void judge(haptic_instance *h)
{
    const hd_error error = h->hd.error();
    if (error.code == HD_WARM_MOTORS)
        h->cooling = COOL_TICKS;
    else if (error.code != 0 && error.code != HD_EXCEEDED_FORCE)
        h->lost = true;
}

static unsigned frame(void *user)
{
    static const double nothing[3];
    haptic_instance *h = user;
    double m[16];
    int buttons = 0;
    for (int i = 0; i < 16; i++)
        m[i] = NAN;
    h->hd.make_current(h->device);
    h->hd.begin(h->device);
    h->hd.get_doubles(HD_TRANSFORM, m);
    h->hd.get_integers(HD_BUTTONS, &buttons);
    judge(h);
    /* The matrix is in column-major order. */
    const double at[3] = {m[12] / 1000, m[13] / 1000, m[14] / 1000};
    const double turned[3][3] = {{m[0], m[4], m[8]}, {m[1], m[5], m[9]}, {m[2], m[6], m[10]}};
    h->state.pose = ost_haptic_workspace_pose(&h->workspace, at, turned);
    h->state.buttons = (uint32_t)buttons;
    memset(h->force, 0, sizeof h->force);
    const bool more = h->beat(h->user);
    h->cooling -= h->cooling > 0;
    h->hd.set_doubles(HD_FORCE, more && !h->cooling && !h->lost ? h->force : nothing);
    h->hd.end(h->device);
    judge(h);
    atomic_fetch_add(&h->frames, 1);
    if (!more)
        sem_post(&h->over);
    return more ? HD_CONTINUE : HD_DONE;
}

/* Waits until the vendor's thread has run its last frame. Returns false if that thread has stopped
   calling the function `frame`. */
static bool wait_for(haptic_instance *h)
{
    for (uint64_t before = 0, now;; before = now) {
        struct timespec until;
        clock_gettime(CLOCK_REALTIME, &until);
        until.tv_nsec += POLL_MS * 1000000L;
        until.tv_sec += until.tv_nsec / 1000000000L;
        until.tv_nsec %= 1000000000L;
        int waited;
        do
            waited = sem_timedwait(&h->over, &until);
        while (waited != 0 && errno == EINTR);
        now = atomic_load(&h->frames);
        if (waited == 0)
            return true;
        if (now == before)
            return false;
    }
}

static ost_status openhaptics_run(haptic_instance *h, haptic_beat *beat, void *user, ost_error *err)
{
    h->beat = beat;
    h->user = user;
    const unsigned long handle = h->hd.schedule(frame, h, HD_PRIORITY);
    h->hd.start();
    const bool over = wait_for(h);
    h->hd.stop();
    h->hd.unschedule(handle);
    return over ? OST_OK : ost_fail(err, OST_ERR_UNAVAILABLE,
                                    "device openhaptics: no call of its servo thread for %d ms", POLL_MS);
}

const haptic_driver ost_haptic_openhaptics = {
    .name = "openhaptics",
    .description = "3D Systems' Touch and Touch X, and the Phantom Omni",
    .caps = OST_HAPTIC_FORCE | OST_HAPTIC_ORIENTATION | OST_HAPTIC_OWN_CLOCK,
    .max_force_n = 3.3,
    .max_stiffness_n_m = 400,
    .buttons = {{"stylus1", OST_ACTION_MOTOR}, {"stylus2", OST_ACTION_TOOL}},
    .usable = openhaptics_usable,
    .open = openhaptics_open,
    .close = openhaptics_close,
    .read = openhaptics_read,
    .write = openhaptics_write,
    .limits = openhaptics_limits,
    .run = openhaptics_run,
};
