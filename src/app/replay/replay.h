/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Replays a session: restores the world as it was when the recording began, and runs the recorded
 * ticks through the same step function.
 *
 *   header --> bone, tools, world       checked by their digests
 *   ticks  --> ost_world_step --> digest == recorded?
 */
#ifndef OST_APP_REPLAY_REPLAY_H
#define OST_APP_REPLAY_REPLAY_H

#include "app/session/keys.h"

/* A replay. Zero-initialise the struct before use, and call replay_close, even after an error. */
typedef struct replay {
    ost_session *session; /* borrowed */
    const char *name;     /* name of the session; borrowed */
    session_setup setup;
    ost_backend *backend;
    ost_bone *bone;
    ost_import_result imported;
    ost_tool *tools[OPTION_LIST_MAX];
    ost_world *world;
    uint64_t done;        /* number of ticks replayed */
    /* The following members describe the first tick whose digest differs. */
    bool differs;
    ost_session_tick recorded;
    uint64_t digest;
    ost_step_result step; /* result of the latest step; step.report is valid until the next tick */
    /* called after every tick, unless NULL */
    ost_status (*each)(void *user, const ost_session_tick *tick, const ost_step_result *step, ost_error *err);
    void *each_user;
} replay;

/*
 * Opens a replay. `setup` comes from session_keys_read; the caller may have replaced its file names. `app` selects
 * the backend. Returns an error if the bone or the tools differ from those of the recording.
 */
ost_status replay_open(const app_state *app, ost_session *session, const char *name, const session_setup *setup,
                       replay *out, ost_error *err);
void replay_close(replay *r);

/*
 * Replays at most the first `count` ticks of the session. If `compare` is true, stops after the first tick whose result
 * differs from the recorded result.
 */
ost_status replay_run(replay *r, uint64_t count, bool compare, ost_error *err);

/*
 * Returns true if the result of the latest tick of `r` equals the result recorded in `tick`, which may come from
 * another replay.
 */
bool replay_as_recorded(const replay *r, const ost_session_tick *tick);

/* The first difference between two bones of one session. Differences are ordered by chunk and then by voxel. */
typedef struct replay_difference {
    bool found;
    int64_t chunk;
    int32_t voxel[3];
    int16_t here, there;
    uint64_t voxels; /* number of voxels that differ */
} replay_difference;

ost_status replay_compare_bones(const replay *here, const replay *there, replay_difference *out, ost_error *err);

#endif
