/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The `mouse` driver: a device that follows a target pose at a thousand ticks per second. A window's
 * thread sets the target pose.
 *
 *   window, 60 times a second --ost_mouse_input_put--> three buffers --read--> the target pose
 *                                                                  |  low pass, limited step per tick
 *                                                                  '--> the device's pose
 *
 * A mouse moves in steps of pixels. The device follows with a time constant of 15 ms, at no more
 * than 250 mm/s and three revolutions per second. Such a motion is accepted by the pose check and
 * can be swept.
 *
 * Forces are displayed but cannot be felt. Viewers read them from the live state.
 */
#include <stdlib.h>
#include <string.h>

#include "haptics/driver.h"
#include "haptics/follow.h"
#include "haptics/newest.h"
#include "haptics/workspace.h"

static const double STEP_M = 0.25e-3;         /* maximum motion per tick in m */

struct ost_mouse_input {
    newest newest; /* passes the newest state from the window's thread to the device */
    ost_haptic_state state[NEWEST_SLOTS];
    /* lifts[i] is the number of lifts up to and including state[i]; `lifted` is the total number of lifts */
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
    haptic_follow tool_pose;
    int32_t tool;
    uint32_t lifts; /* number of lifts counted up to the last read */
};

static ost_status take(void *user, const char *key, const char *value, ost_error *err)
{
    (void)user;
    (void)value;
    return ost_fail(err, OST_ERR_USAGE, "device mouse: unknown option '%s'; it has no options", key);
}

static ost_status mouse_open(const char *options, const ost_haptic_setup *setup, haptic_instance **out, ost_error *err)
{
    haptic_instance m = {.input = setup->mouse};
    ost_status status = ost_haptic_options("mouse", options, take, NULL, err);
    if (status != OST_OK)
        return status;
    if (!m.input)
        return ost_fail(err, OST_ERR_USAGE, "device mouse: needs a window; omit --headless");
    const ost_haptic_state *start = latest(m.input);
    ost_haptic_pose_to_metres(&start->pose, m.tool_pose.at, m.tool_pose.q);
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

static ost_haptic_answer mouse_read(haptic_instance *m, ost_haptic_state *state)
{
    const ost_haptic_state *input = latest(m->input);
    const uint32_t lifts = m->input->lifts[m->input->newest.front];
    const bool lifted = lifts != m->lifts;
    double to[3], toward[4];
    ost_haptic_pose_to_metres(&input->pose, to, toward);
    if (input->tool != m->tool || lifted) {
        /* After a change of tools or a lift, the tool takes its new pose at once, without intermediate steps. */
        memcpy(m->tool_pose.at, to, sizeof to);
        memcpy(m->tool_pose.q, toward, sizeof toward);
        m->tool = input->tool;
        m->lifts = lifts;
    }
    ost_haptic_follow_tick(&m->tool_pose, to, toward, STEP_M);
    *state = (ost_haptic_state){.pose = ost_haptic_pose_quantise(m->tool_pose.at, m->tool_pose.q),
                                .tool = input->tool,
                                .buttons = input->buttons,
                                .lifted = lifted};
    return OST_HAPTIC_FRESH;
}

/* The device renders no force. Viewers read the force from ost_live_channel. */
static void mouse_write(haptic_instance *instance, const ost_wrench *wrench)
{
    (void)instance;
    (void)wrench;
}

const haptic_driver ost_haptic_mouse = {
    .name = "mouse",
    .description = "the mouse and keys of the simulator's window; forces are displayed",
    .caps = OST_HAPTIC_SHOWN | OST_HAPTIC_ORIENTATION | OST_HAPTIC_TOOL,
    .buttons = {{"space", OST_ACTION_MOTOR}},
    .open = mouse_open,
    .close = mouse_close,
    .read = mouse_read,
    .write = mouse_write,
};
