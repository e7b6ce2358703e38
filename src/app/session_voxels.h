/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Which voxels went, and when: a session knows how many, so its ticks are done
 * again on the bone, and every 20 ms what was touched is compared with before.
 */
#ifndef OST_APP_SESSION_VOXELS_H
#define OST_APP_SESSION_VOXELS_H

#include "app/app.h"

/* Zero-initialise; session_voxels_free in any case. */
typedef struct session_voxels {
    ost_session_voxels list; /* its arrays are owned here */
    size_t group_room, room;
} session_voxels;

/* Bone and tools must be where they were. */
ost_status session_voxels_take(const app_state *app, ost_session *session, const char *name, session_voxels *out, ost_error *err);
void session_voxels_free(session_voxels *v);

#endif
