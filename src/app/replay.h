/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A session done again: a world as it was when the recording began, and its
 * ticks through the same step.
 *
 *   header --> bone, tools, world       checked by their digests
 *   ticks  --> ost_world_step --> digest == recorded?
 */
#ifndef OST_APP_REPLAY_H
#define OST_APP_REPLAY_H

#include "app/session_keys.h"

/* Zero-initialise; replay_close in any case. */
typedef struct replay {
    ost_session *session; /* borrowed */
    const char *name;     /* of the session; borrowed */
    session_setup setup;
    ost_backend *backend;
    ost_bone *bone;
    ost_import_result imported;
    ost_tool *tools[OPTION_LIST_MAX];
    ost_world *world;
    uint64_t done;        /* ticks */
    /* At the first tick whose digest was another: */
    bool differs;
    ost_session_tick recorded;
    uint64_t digest;
    ost_step_result step; /* its report lives until the next tick */
    /* Of every tick, when there is somebody for it: */
    ost_status (*each)(void *user, const ost_session_tick *tick, const ost_step_result *step, ost_error *err);
    void *each_user;
} replay;

/*
 * setup as session_keys_read made it, perhaps with other names of files.  app
 * chooses the backend.  Bone and tools must be those of the recording.
 */
ost_status replay_open(const app_state *app, ost_session *session, const char *name, const session_setup *setup, replay *out, ost_error *err);
void replay_close(replay *r);

/* From the first tick on: up to count ticks, or until one differs when compare is true. */
ost_status replay_run(replay *r, uint64_t count, bool compare, ost_error *err);

/* Whether its last tick came out as ticks of the recording say: this replay's or another's. */
bool replay_as_recorded(const replay *r, const ost_session_tick *tick);

/* Where two bones of one session differ first: chunk by chunk, then voxel by voxel. */
typedef struct replay_place {
    bool found;
    int64_t chunk;
    int32_t voxel[3];
    int16_t here, there;
    uint64_t voxels; /* how many differ */
} replay_place;

ost_status replay_compare_bones(const replay *here, const replay *there, replay_place *out, ost_error *err);

#endif
