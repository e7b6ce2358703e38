/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A path: what a tool does over time.  A row is a tick; t strictly increases.
 * Rows carry the index of the tool in use, so that a path may switch tools, and
 * the speed of its motor (docs/arithmetic.md, AR-MOTOR).
 */
#ifndef OSTEON_PATH_H
#define OSTEON_PATH_H

#include <stdbool.h>

#include <osteon/pose.h>

#ifdef __cplusplus
extern "C" {
#endif

/*
 * OST_RPM_ON: the motor is on at a speed that is not known; the pose has the
 * tool's turn already.  OST_RPM_HAND: the pose is the hand's, and the operation
 * has the motor (motor.h); no world takes such a tick.
 */
enum { OST_RPM_ON = -1, OST_RPM_HAND = -2, OST_RPM_MAX = 3000 };

/* A turn of the motor in turns a minute times nanoseconds: angles are integers of this unit. */
#define OST_MOTOR_TURN INT64_C(60000000000)

typedef struct ost_tick {
    int64_t t_ns; /* nanoseconds */
    int32_t tool; /* index into the world's tools */
    int32_t rpm;  /* of the motor, 0 to OST_RPM_MAX; 0: off, the tool removes nothing; OST_RPM_ON, OST_RPM_HAND */
    ost_pose pose;
    bool lifted;  /* the tool was lifted before this tick: nothing is swept from the tick before (AR-SWEEP-5) */
} ost_tick;

typedef struct ost_path {
    size_t count;
    ost_tick *ticks; /* owned */
} ost_path;

enum { OST_PATH_TICKS_MAX = 100000000 };
#define OST_PATH_TIME_MAX_NS INT64_C(4000000000000000000)

enum { OST_PATH_NO_GAPS = -1 };
/* Two rows farther apart than this are a gap, and the second begins lifted; 0: found from the rows (AR-PATH-5); OST_PATH_NO_GAPS. */
typedef struct ost_path_options {
    int64_t max_gap_ns;
    ost_pm max_jump_pm;
} ost_path_options;

/* Uninitialised rows. */
OST_API ost_status ost_path_init(ost_path *path, size_t count, ost_error *err);
OST_API void ost_path_free(ost_path *path);

#ifdef __cplusplus
}
#endif
#endif
