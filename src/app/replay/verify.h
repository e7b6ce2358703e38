/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Compares a replay with its recording, and locates the first difference.
 *
 * At the end of the session, the counts and the digest of the bone are compared. A difference is located with a second
 * backend: the same ticks are run on the reference, and a comparison of the two bones yields the chunk and the voxel.
 */
#ifndef OST_APP_REPLAY_VERIFY_H
#define OST_APP_REPLAY_VERIFY_H

#include "app/replay/replay.h"

/* The end of a session, as recorded in the file and as reached by the replay. */
typedef struct replay_ending {
    bool found;     /* true if the file contains an end record */
    bool complete;  /* true if the file contains an end record and every tick before it */
    bool compared;  /* true if the replay reached the end of the session and the ends were therefore compared */
    uint64_t ticks; /* number of recorded ticks, from the end record or, without one, from the last readable tick */
    ost_session_end end;
    ost_world_totals totals;
    ost_digest root;
} replay_ending;

/* Reads the session to its end and sets the fields of *e that describe the recording. */
ost_status replay_find_end(ost_session *session, replay_ending *e, ost_error *err);
/* Returns true if the ends were compared and differ. */
bool replay_end_differs(const replay_ending *e);

/* Opens the session on another backend: the reference, or cpu if the first backend is the reference. */
ost_status replay_open_other(const app_state *app, const replay *here, replay *other, ost_error *err);

/*
 * Finds the first tick after which the bones of two backends differ, by bisection. Called if the bones differ although
 * the digests of all ticks are equal.
 */
ost_status replay_find_by_bisection(const app_state *app, const replay *here, uint64_t *tick,
                                    replay_difference *difference, ost_error *err);

#endif
