/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The `script` and `replay` drivers play back recorded ticks, one tick per read. The `script` driver reads a path, and
 * the `replay` driver reads the ticks of a session.
 */
#include <stdlib.h>
#include <string.h>

#include <osteon/session.h>

#include "haptics/driver.h"

struct haptic_instance {
    ost_path path; /* owned */
    size_t next;
};

static ost_status no_options(void *user, const char *key, const char *value, ost_error *err)
{
    (void)value;
    return ost_fail(err, OST_ERR_USAGE, "device %s: unknown option '%s'; it has no options", (const char *)user, key);
}

static ost_status make(const char *name, const char *options, haptic_instance **out, ost_error *err)
{
    char known[8];
    memcpy(known, name, strlen(name) + 1);
    ost_status status = ost_haptic_options(name, options, no_options, known, err);
    if (status != OST_OK)
        return status;
    *out = calloc(1, sizeof **out);
    return *out ? OST_OK : ost_fail(err, OST_ERR_MEMORY, "out of memory for device %s", name);
}

static void script_close(haptic_instance *instance)
{
    ost_path_free(&instance->path);
    free(instance);
}

static ost_status script_open(const char *options, const ost_haptic_setup *setup, haptic_instance **out, ost_error *err)
{
    if (!setup->path || setup->path->count == 0)
        return ost_fail(err, OST_ERR_USAGE, "device script: no path given; pass --path");
    ost_status status = make("script", options, out, err);
    if (status != OST_OK)
        return status;
    status = ost_path_init(&(*out)->path, setup->path->count, err);
    if (status == OST_OK)
        memcpy((*out)->path.ticks, setup->path->ticks, setup->path->count * sizeof *setup->path->ticks);
    else
        script_close(*out);
    return status;
}

static ost_status replay_open(const char *options, const ost_haptic_setup *setup, haptic_instance **out, ost_error *err)
{
    if (!setup->session)
        return ost_fail(err, OST_ERR_USAGE, "device replay: no session given");
    ost_session *session;
    ost_status status = make("replay", options, out, err);
    if (status != OST_OK)
        return status;
    status = ost_session_open(setup->session, &session, err);
    if (status == OST_OK) {
        status = ost_session_path(session, &(*out)->path, err);
        ost_session_close(session);
    }
    if (status != OST_OK)
        script_close(*out);
    return status;
}

static ost_haptic_answer script_read(haptic_instance *instance, ost_haptic_state *state)
{
    if (instance->next == instance->path.count)
        return OST_HAPTIC_ENDED;
    const ost_tick *tick = &instance->path.ticks[instance->next++];
    *state = (ost_haptic_state){.pose = tick->pose,
                                .tool = tick->tool,
                                .lifted = tick->lifted,
                                .turned = tick->rpm != OST_RPM_OF_DEVICE,
                                .rpm = tick->rpm};
    return OST_HAPTIC_FRESH;
}

const haptic_driver ost_haptic_script = {
    .name = "script",
    .description = "the rows of a path, one per tick",
    .caps = OST_HAPTIC_ORIENTATION | OST_HAPTIC_TOOL | OST_HAPTIC_LOGICAL,
    .open = script_open,
    .close = script_close,
    .read = script_read,
};

const haptic_driver ost_haptic_replay = {
    .name = "replay",
    .description = "the ticks of a recorded session",
    .caps = OST_HAPTIC_ORIENTATION | OST_HAPTIC_TOOL | OST_HAPTIC_LOGICAL,
    .open = replay_open,
    .close = script_close,
    .read = script_read,
};
