/* SPDX-License-Identifier: Apache-2.0 */
/* The `null` driver: a tool that does not move, for measuring the loop alone and for viewing a scene. */
#include <stdlib.h>

#include "haptics/driver.h"

struct haptic_instance {
    ost_pose pose;
};

static ost_status take(void *user, const char *key, const char *value, ost_error *err)
{
    (void)user;
    (void)value;
    return ost_fail(err, OST_ERR_USAGE, "device null: unknown option '%s'; it has no options", key);
}

static ost_status null_open(const char *options, const ost_haptic_setup *setup, haptic_instance **out, ost_error *err)
{
    ost_status status = ost_haptic_options("null", options, take, NULL, err);
    if (status == OST_OK)
        status = ost_pose_check(&setup->start, err);
    if (status != OST_OK)
        return status;
    *out = malloc(sizeof **out);
    if (!*out)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for device null");
    (*out)->pose = setup->start;
    return OST_OK;
}

static void null_close(haptic_instance *instance)
{
    free(instance);
}

static ost_haptic_answer null_read(haptic_instance *instance, ost_haptic_state *state)
{
    *state = (ost_haptic_state){.pose = instance->pose, .tool = -1};
    return OST_HAPTIC_FRESH;
}

const haptic_driver ost_haptic_null = {
    .name = "null",
    .description = "a tool that does not move",
    .caps = OST_HAPTIC_LOGICAL,
    .open = null_open,
    .close = null_close,
    .read = null_read,
};
