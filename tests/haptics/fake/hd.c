/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A stand-in for OpenHaptics' HD library with the functions that the driver calls, and a thread
 * that invokes the callback a thousand times per second.
 */
#include <math.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "haptics/fake/fake.h"

#define EXPORT __attribute__((visibility("default")))
enum {
    DEVICE = 7,
    BUTTONS = 0x2000,
    TRANSFORM = 0x2052,
    FORCE = 0x2700,
    FORCE_OUTPUT = 0x4000,
    WARM = 0x0200,
    MAX_FORCE = 0x2603,
    MAX_CONTINUOUS = 0x2604,
    COMMUNICATION = 0x0302
};

typedef struct fake_error {
    unsigned code;
    int internal;
    unsigned device;
} fake_error;

EXPORT fake_note fake_hd = {.column = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, .limit = 3.3, .continuous = 0.88};

static unsigned (*callback)(void *);
static void *callback_user;
static unsigned pending; /* the error that hdGetError returns next */
static pthread_t thread;
static _Atomic int running;

EXPORT unsigned hdInitDevice(const char *name);
EXPORT void hdDisableDevice(unsigned device);
EXPORT void hdMakeCurrentDevice(unsigned device);
EXPORT void hdBeginFrame(unsigned device);
EXPORT void hdEndFrame(unsigned device);
EXPORT void hdGetDoublev(unsigned what, double *values);
EXPORT void hdGetIntegerv(unsigned what, int *values);
EXPORT void hdSetDoublev(unsigned what, const double *values);
EXPORT void hdEnable(unsigned what);
EXPORT fake_error hdGetError(void);
EXPORT const char *hdGetErrorString(unsigned code);
EXPORT unsigned long hdScheduleAsynchronous(unsigned (*call)(void *), void *user, unsigned short priority);
EXPORT void hdUnschedule(unsigned long handle);
EXPORT void hdStartScheduler(void);
EXPORT void hdStopScheduler(void);

/*
 * Reads settings from the environment, for tests of the osteon command: the frame at which
 * reading a pose fails, and the maximum force.
 */
__attribute__((constructor)) static void read_environment(void)
{
    const char *at = getenv("FAKE_HD_FAIL_READ_AT"), *limit = getenv("FAKE_HD_MAX_FORCE");
    if (limit)
        fake_hd.limit = strtod(limit, NULL);
    if (at)
        fake_hd.fail_read_at = atoi(at);
}

static char of_device(unsigned device, char letter)
{
    return device == DEVICE ? letter : '!';
}

unsigned hdInitDevice(const char *name)
{
    fake_call(&fake_hd, name ? 'n' : 'i');
    pending = fake_hd.fail_open ? COMMUNICATION : 0;
    return fake_hd.fail_open ? 0xffffffffu : DEVICE;
}

void hdDisableDevice(unsigned device) { fake_call(&fake_hd, of_device(device, 'd')); }
void hdMakeCurrentDevice(unsigned device) { fake_call(&fake_hd, of_device(device, 'm')); }
void hdBeginFrame(unsigned device) { fake_call(&fake_hd, of_device(device, '(')); }
void hdEndFrame(unsigned device) { fake_call(&fake_hd, of_device(device, ')')); }
void hdEnable(unsigned what) { fake_hd.forces_on = what == FORCE_OUTPUT; }

void hdGetDoublev(unsigned what, double *values)
{
    if (what == MAX_FORCE || what == MAX_CONTINUOUS) {
        *values = what == MAX_FORCE ? fake_hd.limit : fake_hd.continuous;
        if (*values < 0)
            pending = COMMUNICATION;
    }
    if (what != TRANSFORM)
        return;
    memset(values, 0, 16 * sizeof *values);
    for (int c = 0; c < 3; c++)
        memcpy(values + 4 * c, fake_hd.column[c], sizeof fake_hd.column[c]);
    memcpy(values + 12, fake_hd.position, sizeof fake_hd.position);
    values[15] = 1;
    if (fake_hd.frames == fake_hd.no_number_at)
        values[13] = NAN;
}

void hdGetIntegerv(unsigned what, int *values)
{
    if (what == BUTTONS)
        *values = fake_hd.buttons;
}

void hdSetDoublev(unsigned what, const double *values)
{
    fake_call(&fake_hd, what == FORCE ? 'f' : '!');
    memcpy(fake_hd.force, values, sizeof fake_hd.force);
    for (int a = 0; a < 3; a++)
        fake_hd.most_force = fmax(fake_hd.most_force, fabs(values[a]));
}

fake_error hdGetError(void)
{
    const fake_error error = {pending, 0, DEVICE};
    pending = 0;
    return error;
}

const char *hdGetErrorString(unsigned code)
{
    return code == COMMUNICATION ? "no connection to the device" : "no error";
}

unsigned long hdScheduleAsynchronous(unsigned (*call)(void *), void *user, unsigned short priority)
{
    fake_call(&fake_hd, priority == 32767 ? 's' : '!');
    callback = call;
    callback_user = user;
    return 1;
}

void hdUnschedule(unsigned long handle) { fake_call(&fake_hd, handle == 1 ? 'u' : '!'); }

static void *run_device(void *unused)
{
    const struct timespec millisecond = {.tv_nsec = 1000000};
    (void)unused;
    while (running) {
        const int frame = atomic_fetch_add(&fake_hd.frames, 1) + 1;
        if (fake_hd.hang_at && frame >= fake_hd.hang_at) {
            nanosleep(&millisecond, NULL);
            continue;
        }
        pending = frame == fake_hd.warm_at ? WARM : frame == fake_hd.fail_read_at ? COMMUNICATION : 0;
        if (callback(callback_user) == 0)
            break;
        nanosleep(&millisecond, NULL);
    }
    return NULL;
}

void hdStartScheduler(void)
{
    fake_call(&fake_hd, '<');
    running = 1;
    pthread_create(&thread, NULL, run_device, NULL);
}

void hdStopScheduler(void)
{
    running = 0;
    pthread_join(thread, NULL);
    fake_call(&fake_hd, '>');
}
