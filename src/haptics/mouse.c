/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The `mouse` driver: follows a target pose that a window's thread sets, at a thousand ticks per
 * second.
 *
 *   window, 60 times a second --ost_mouse_input_put--> three buffers --read--> the target pose
 *                                                                  |  low pass, limited step per tick
 *                                                                  '--> the device's pose
 *
 * A mouse jumps by pixels. The device follows with a time constant of 15 ms, at no more than 250 mm
 * and three revolutions per second. Such a motion is accepted by the pose check and can be swept.
 *
 * Forces are displayed but cannot be felt. Viewers read them from the live state.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "haptics/driver.h"
#include "haptics/newest.h"
#include "haptics/workspace.h"

static const double FOLLOW = 0.0645;          /* fraction of the remaining distance per tick: 1 - exp(-1 ms / 15 ms) */
static const double STEP_M = 0.25e-3;         /* greatest motion per tick, in m */
static const double TURN = 0.0188;            /* greatest rotation per tick, in radians: three revolutions per second */

struct ost_mouse_input {
    newest newest; /* passes the newest state from the window's thread to the device */
    ost_haptic_state state[NEWEST_SLOTS];
    /* lifts[i] is the number of lifts that preceded state[i]; `lifted` is the total number of lifts */
    uint32_t lifts[NEWEST_SLOTS], lifted;
};

ost_status ost_mouse_input_create(const ost_haptic_state *start, ost_mouse_input **out, ost_error *err)
{
    *out = NULL;
    ost_status status = ost_pose_check(&start->pose, err);
    if (status != OST_OK)
        return status;
    ost_mouse_input *input = calloc(1, sizeof *input);
    if (!input)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for the state of device mouse");
    for (int i = 0; i < NEWEST_SLOTS; i++)
        input->state[i] = *start;
    newest_begin(&input->newest);
    *out = input;
    return OST_OK;
}

void ost_mouse_input_free(ost_mouse_input *input)
{
    free(input);
}

void ost_mouse_input_put(ost_mouse_input *input, const ost_haptic_state *state)
{
    input->lifted += state->lifted;
    input->state[input->newest.back] = *state;
    input->lifts[input->newest.back] = input->lifted;
    newest_put(&input->newest);
}

static const ost_haptic_state *latest(ost_mouse_input *input)
{
    newest_take(&input->newest);
    return &input->state[input->newest.front];
}

/* ----------------------------------------------------------------- driver */

struct haptic_instance {
    ost_mouse_input *input; /* borrowed */
    double at[3];   /* position in m */
    double q[4];    /* unit quaternion */
    int32_t tool;
    uint32_t lifts; /* number of lifts counted up to the last read */
};

static void take_pose(const ost_pose *pose, double at[3], double q[4])
{
    double mm[3], n = 0;
    ost_pose_to_doubles(pose, mm, q);
    for (int i = 0; i < 4; i++)
        n += q[i] * q[i];
    for (int i = 0; i < 4; i++)
        q[i] /= sqrt(n);
    for (int i = 0; i < 3; i++)
        at[i] = mm[i] * 1e-3;
}

static ost_status take(void *user, const char *key, const char *value, ost_error *err)
{
    (void)user;
    (void)value;
    return ost_fail(err, OST_ERR_USAGE, "device mouse: unknown option '%s'; it has no options", key);
}

static ost_status mouse_open(const char *options, const ost_haptic_setup *setup, haptic_instance **out, ost_error *err)
{
    haptic_instance m = {.input = setup->mouse};
    ost_status status = haptic_options("mouse", options, take, NULL, err);
    if (status != OST_OK)
        return status;
    if (!m.input)
        return ost_fail(err, OST_ERR_USAGE, "device mouse: needs a window; omit --headless");
    const ost_haptic_state *start = latest(m.input);
    take_pose(&start->pose, m.at, m.q);
    m.tool = start->tool;
    *out = malloc(sizeof **out);
    if (!*out)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for device mouse");
    **out = m;
    return OST_OK;
}

static void mouse_close(haptic_instance *instance)
{
    free(instance);
}

static void approach_position(haptic_instance *m, const double to[3])
{
    double d[3], length = 0;
    for (int a = 0; a < 3; a++) {
        d[a] = (to[a] - m->at[a]) * FOLLOW;
        length += d[a] * d[a];
    }
    length = sqrt(length);
    for (int a = 0; a < 3; a++)
        m->at[a] += length > STEP_M ? d[a] * STEP_M / length : d[a];
}

/* Rotates the tool toward `to` along the shorter arc. The rotation is the fraction FOLLOW of the angle, but at most
   TURN. The quaternions q and -q denote the same orientation. */
static void approach_turn(haptic_instance *m, const double to[4])
{
    double cosine = 0, n = 0;
    for (int i = 0; i < 4; i++)
        cosine += m->q[i] * to[i];
    const double sign = cosine < 0 ? -1 : 1, angle = 2 * acos(fmin(1, fabs(cosine)));
    const double share = angle * FOLLOW > TURN ? TURN / angle : FOLLOW;
    for (int i = 0; i < 4; i++) {
        m->q[i] += (sign * to[i] - m->q[i]) * share;
        n += m->q[i] * m->q[i];
    }
    for (int i = 0; i < 4; i++)
        m->q[i] /= sqrt(n);
}

static ost_haptic_answer mouse_read(haptic_instance *m, ost_haptic_state *state)
{
    const ost_haptic_state *input = latest(m->input);
    const uint32_t lifts = m->input->lifts[m->input->newest.front];
    const bool lifted = lifts != m->lifts;
    double to[3], toward[4];
    take_pose(&input->pose, to, toward);
    if (input->tool != m->tool || lifted) {
        /* When a tool is exchanged or lifted, it takes its new pose at once, without intermediate steps. */
        memcpy(m->at, to, sizeof m->at);
        memcpy(m->q, toward, sizeof m->q);
        m->tool = input->tool;
        m->lifts = lifts;
    }
    approach_position(m, to);
    approach_turn(m, toward);
    *state = (ost_haptic_state){
        .pose = haptic_pose_quantise(m->at, m->q), .tool = input->tool, .buttons = input->buttons, .lifted = lifted};
    return OST_HAPTIC_FRESH;
}

/* The device renders no force. Viewers read the force from ost_live_channel. */
static void mouse_write(haptic_instance *instance, const ost_wrench *wrench)
{
    (void)instance;
    (void)wrench;
}

const haptic_driver haptic_mouse = {
    .name = "mouse",
    .description = "the mouse and keys of the simulator's window; forces are displayed",
    .caps = OST_HAPTIC_SHOWN | OST_HAPTIC_ORIENTATION | OST_HAPTIC_TOOL,
    .buttons = {{"space", OST_ACTION_MOTOR}},
    .open = mouse_open,
    .close = mouse_close,
    .read = mouse_read,
    .write = mouse_write,
};
