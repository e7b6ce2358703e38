/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The `openxr` driver: a tracked controller of a headset holds the tool.
 *
 *   headset, once per frame --ost_hand_input_put--> three buffers --read--> low pass, limited step --> the tool's pose
 *
 * The tool is where the controller is: motions are not scaled. When tracking begins or resumes, the tool moves to
 * the controller at once, without a sweep. A controller renders no force; forces are displayed.
 */
#include <stdlib.h>
#include <string.h>

#include "haptics/driver.h"
#include "haptics/follow.h"
#include "haptics/hand.h"
#include "haptics/newest.h"
#include "haptics/workspace.h"

/* maximum motion per tick in m; a fifth of the jump that an operation treats as a fault */
static const double STEP_M = 1e-3;

struct ost_hand_input {
    newest newest;
    ost_hand_sample sample[NEWEST_SLOTS];
    bool left;
};

ost_status ost_hand_input_create(ost_hand_input **out, ost_error *err)
{
    *out = calloc(1, sizeof **out);
    if (!*out)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for the state of device openxr");
    newest_begin(&(*out)->newest);
    return OST_OK;
}

void ost_hand_input_free(ost_hand_input *input)
{
    free(input);
}

void ost_hand_input_put(ost_hand_input *input, const ost_hand_sample *sample)
{
    input->sample[input->newest.back] = *sample;
    newest_put(&input->newest);
}

bool ost_hand_input_is_left(const ost_hand_input *input)
{
    return input->left;
}

/* ----------------------------------------------------------------- driver */

struct haptic_instance {
    ost_hand_input *input; /* borrowed */
    haptic_follow tool;
    bool tracked;          /* true if the hand was tracked in the last tick */
};

static ost_status take(void *user, const char *key, const char *value, ost_error *err)
{
    bool *left = user;
    if (strcmp(key, "hand") != 0)
        return ost_fail(err, OST_ERR_USAGE, "device openxr: unknown option '%s'; expected hand", key);
    *left = strcmp(value, "left") == 0;
    if (!*left && strcmp(value, "right") != 0)
        return ost_fail(err, OST_ERR_USAGE, "device openxr: hand=%.40s: expected left or right", value);
    return OST_OK;
}

static ost_status openxr_open(const char *options, const ost_haptic_setup *setup, haptic_instance **out, ost_error *err)
{
    bool left = false;
    ost_status status = ost_haptic_options("openxr", options, take, &left, err);
    if (status != OST_OK)
        return status;
    if (!setup->hand)
        return ost_fail(err, OST_ERR_USAGE, "device openxr: needs a headset; pass --headset to osteon sim");
    haptic_instance *o = calloc(1, sizeof *o);
    if (!o)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for device openxr");
    o->input = setup->hand;
    o->input->left = left;
    *out = o;
    return OST_OK;
}

static void openxr_close(haptic_instance *instance)
{
    free(instance);
}

static ost_haptic_answer openxr_read(haptic_instance *o, ost_haptic_state *state)
{
    newest_take(&o->input->newest);
    const ost_hand_sample *sample = &o->input->sample[o->input->newest.front];
    const bool lifted = !o->tracked;
    double to[3], toward[4];
    o->tracked = sample->tracked;
    if (!sample->tracked)
        return OST_HAPTIC_NOT_TRACKED;
    ost_haptic_pose_to_metres(&sample->pose, to, toward);
    if (lifted) {
        memcpy(o->tool.at, to, sizeof to);
        memcpy(o->tool.q, toward, sizeof toward);
    }
    ost_haptic_follow_tick(&o->tool, to, toward, STEP_M);
    *state = (ost_haptic_state){.pose = ost_haptic_pose_quantise(o->tool.at, o->tool.q),
                                .tool = -1,
                                .buttons = sample->buttons,
                                .lifted = lifted};
    return OST_HAPTIC_FRESH;
}

/* The device renders no force. Viewers read the force from ost_live_channel. */
static void openxr_write(haptic_instance *instance, const ost_wrench *wrench)
{
    (void)instance;
    (void)wrench;
}

const haptic_driver ost_haptic_openxr = {
    .name = "openxr",
    .description = "a headset's controller (sim --headset), by OpenXR; forces are displayed",
    .caps = OST_HAPTIC_SHOWN | OST_HAPTIC_ORIENTATION,
    .buttons = {{"trigger", OST_ACTION_MOTOR}, {"menu", OST_ACTION_TOOL}, {"squeeze", OST_ACTION_NONE}},
    .open = openxr_open,
    .close = openxr_close,
    .read = openxr_read,
    .write = openxr_write,
};
