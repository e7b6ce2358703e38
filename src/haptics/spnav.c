/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The `spnav` driver: 3Dconnexion's SpaceMouse and similar devices, through libspnav and spacenavd.
 *
 *   cap pushed by c counts of 350 --> a speed --> integrated tick by tick --> pose
 *
 * The cap sets a speed, not a position, because it returns to its centre by itself. The motion is
 * therefore unlimited. A fully pushed cap moves the tool at the speed given by the `speed` option and rotates the tool
 * at the speed given by the `turn` option. Within the dead zone, the speed is zero; from the edge of the dead zone to
 * full deflection, it increases linearly. x points to the right, y up, and z toward the operator; libspnav's z has the
 * opposite direction. libspnav reports only changes, so the last values apply until the next event.
 *
 * With hold=1, the tool moves only while button 1 is pressed. The device renders no force.
 */
#include <math.h>
#include <poll.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/quaternion.h"
#include "haptics/driver.h"
#include "haptics/vendor.h"
#include "haptics/workspace.h"

/* These definitions are copied from libspnav. Its largest event has 40 bytes. */
enum { EVENT_MOTION = 1, EVENT_BUTTON = 2, EVENT_DEVICE = 3, DEVICE_REMOVED = 1 };
typedef union spnav_event {
    int type;
    struct {
        int type, x, y, z, rx, ry, rz;
        unsigned period;
        int *data;
    } motion;
    struct {
        int type, press, number;
    } button;
    struct {
        int type, operation, id, kind, usb[2];
    } device;
    char unused[128]; /* reserved space for larger events of later versions */
} spnav_event;

typedef struct spnav_calls {
    int (*open)(void);
    int (*close)(void);
    int (*fd)(void);
    int (*poll)(spnav_event *event);
} spnav_calls;

static const vendor_symbol symbols[] = {
    {"spnav_open", offsetof(spnav_calls, open)},
    {"spnav_close", offsetof(spnav_calls, close)},
    {"spnav_fd", offsetof(spnav_calls, fd)},
    {"spnav_poll_event", offsetof(spnav_calls, poll)},
};
static const char *const names[] = {"libspnav.so.0", "libspnav.so", NULL};
static const vendor_library library = {"OSTEON_SPNAV_LIBRARY", names, "libspnav0 and spacenavd", symbols,
                                       sizeof symbols / sizeof symbols[0]};

enum { FULL = 350, DEAD = 10, EVENTS = 32, SPEED_MM = 20, TURN_DEGREES = 30, HOLD_BUTTON = 0, BUTTONS = 32 };
#define TICK_S 1e-3

typedef struct choice {
    double speed_mm, turn_degrees;
    int64_t hold;
} choice;

struct haptic_instance {
    spnav_calls spnav;
    haptic_workspace workspace;
    choice how;
    /* values of the last event: translations along x, y and z, and rotations about x, y and z */
    int push[6];
    double at[3], q[4];      /* pose relative to the start pose, in the frame of the start pose */
    uint32_t buttons;
    bool lost;
};

static bool spnav_usable(char reason[256])
{
    spnav_calls calls;
    return ost_vendor_load(&library, &calls, reason);
}

/* Number of open instances. libspnav supports only one connection. */
static _Atomic int in_use;

/* Checks that the daemon answers. Without the daemon, the library finds no device. */
static bool spnav_answers(char reason[256])
{
    spnav_calls calls;
    if (atomic_load(&in_use) > 0)
        return true;
    if (!ost_vendor_load(&library, &calls, reason))
        return false;
    const bool answers = calls.open() >= 0;
    if (answers)
        calls.close();
    else
        snprintf(reason, 256, "libspnav is here, but spacenavd does not answer; is it started?");
    return answers;
}

static ost_status take(void *user, const char *key, const char *value, ost_error *err)
{
    choice *c = user;
    if (strcmp(key, "speed") == 0)
        return ost_haptic_number("spnav", key, value, 0.1, 500, &c->speed_mm, err);
    if (strcmp(key, "turn") == 0)
        return ost_haptic_number("spnav", key, value, 0, 720, &c->turn_degrees, err);
    if (strcmp(key, "hold") == 0)
        return ost_haptic_integer("spnav", key, value, 0, 1, &c->hold, err);
    return ost_fail(err, OST_ERR_USAGE, "device spnav: unknown option '%s'; expected speed, turn or hold", key);
}

static ost_status spnav_begin(const char *options, const ost_haptic_setup *setup, haptic_instance **out, ost_error *err)
{
    static const int axes[3] = {0, 1, 2};
    choice c = {.speed_mm = SPEED_MM, .turn_degrees = TURN_DEGREES};
    char reason[256];
    ost_status status = ost_haptic_options("spnav", options, take, &c, err);
    if (status != OST_OK)
        return status;
    haptic_instance *s = calloc(1, sizeof *s);
    if (!s)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for device spnav");
    s->how = c;
    s->q[0] = 1;
    s->workspace = ost_haptic_workspace_make(&setup->start, axes, 1);
    if (!ost_vendor_load(&library, &s->spnav, reason))
        status = ost_fail(err, OST_ERR_UNAVAILABLE, "device spnav: %s", reason);
    else if (s->spnav.open() < 0)
        status = ost_fail(err, OST_ERR_UNAVAILABLE, "device spnav: spacenavd does not answer; start it first");
    if (status != OST_OK) {
        free(s);
        return status;
    }
    atomic_fetch_add(&in_use, 1);
    *out = s;
    return OST_OK;
}

static void spnav_end(haptic_instance *s)
{
    s->spnav.close();
    atomic_fetch_sub(&in_use, 1);
    free(s);
}

static void press(haptic_instance *s, int number, bool down)
{
    if (number < 0 || number >= BUTTONS)
        return;
    s->buttons = down ? s->buttons | UINT32_C(1) << number : s->buttons & ~(UINT32_C(1) << number);
}

static void take_event(haptic_instance *s, const spnav_event *e)
{
    if (e->type == EVENT_MOTION) {
        const int push[6] = {e->motion.x, e->motion.y, -e->motion.z, e->motion.rx, e->motion.ry, -e->motion.rz};
        memcpy(s->push, push, sizeof push);
    } else if (e->type == EVENT_BUTTON) {
        press(s, e->button.number, e->button.press);
    } else if (e->type == EVENT_DEVICE && e->device.operation == DEVICE_REMOVED) {
        s->lost = true;
    }
}

/* Maps counts to a fraction of the full speed, from -1 to 1. */
static double share_of(int counts)
{
    const double beyond = fmin(FULL, fabs((double)counts)) - DEAD;
    return beyond <= 0 ? 0 : copysign(beyond / (FULL - DEAD), counts);
}

/*
 * Applies the rotation of one tick. The rotation is at most 0.72 degrees about each axis, so the normalized quaternion
 * (1, w / 2) is accurate enough.
 */
static void turn_on(double q[4], const double by[3])
{
    const double s = by[0] / 2, t = by[1] / 2, u = by[2] / 2;
    const double r[4] = {q[0] - s * q[1] - t * q[2] - u * q[3], q[1] + s * q[0] + t * q[3] - u * q[2],
                         q[2] + t * q[0] + u * q[1] - s * q[3], q[3] + u * q[0] + s * q[2] - t * q[1]};
    memcpy(q, r, sizeof r);
    ost_quaternion_unit(q);
}

static ost_haptic_answer spnav_read(haptic_instance *s, ost_haptic_state *state)
{
    struct pollfd daemon = {.fd = s->spnav.fd(), .events = POLLIN};
    spnav_event event;
    for (int i = 0; i < EVENTS && s->spnav.poll(&event); i++)
        take_event(s, &event);
    /* The socket is checked, because libspnav does not report that the daemon has ended. */
    if (s->lost || daemon.fd < 0 || (poll(&daemon, 1, 0) > 0 && (daemon.revents & (POLLHUP | POLLERR | POLLNVAL))))
        return OST_HAPTIC_LOST;
    const bool moves = !s->how.hold || (s->buttons >> HOLD_BUTTON & 1);
    double by[3], frame[3][3];
    for (int a = 0; a < 3; a++) {
        s->at[a] += moves ? share_of(s->push[a]) * s->how.speed_mm * 1e-3 * TICK_S : 0;
        by[a] = moves ? share_of(s->push[3 + a]) * s->how.turn_degrees * (M_PI / 180) * TICK_S : 0;
    }
    turn_on(s->q, by);
    ost_quaternion_matrix(s->q, frame);
    *state = (ost_haptic_state){
        .pose = ost_haptic_workspace_pose(&s->workspace, s->at, frame), .tool = -1, .buttons = s->buttons};
    return OST_HAPTIC_FRESH;
}

const haptic_driver ost_haptic_spnav = {
    .name = "spnav",
    .description = "3Dconnexion's SpaceMouse, by libspnav; the deflection of its cap sets the speed",
    .caps = OST_HAPTIC_ORIENTATION,
    .buttons = {{"left", OST_ACTION_SWITCH}, {"right", OST_ACTION_TOOL}},
    .usable = spnav_usable,
    .answers = spnav_answers,
    .open = spnav_begin,
    .close = spnav_end,
    .read = spnav_read,
};
