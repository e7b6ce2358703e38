/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Finds which voxels were removed, and when. A session records only their number, so its ticks are
 * replayed on the bone, and every 20 ms the affected slices are compared with their previous state.
 */
#ifndef OST_APP_REPLAY_SESSION_VOXELS_H
#define OST_APP_REPLAY_SESSION_VOXELS_H

#include "app/common/app.h"

/* Must be zero-initialized; call session_voxels_free in any case. */
typedef struct session_voxels {
    ost_session_voxels list; /* its arrays are owned here */
    size_t group_capacity, capacity;
} session_voxels;

/* Replays the session. The bone and the tools must be at the recorded paths. */
ost_status session_voxels_take(const app_state *app, ost_session *session, const char *name, session_voxels *out, ost_error *err);
void session_voxels_free(session_voxels *v);

#endif
