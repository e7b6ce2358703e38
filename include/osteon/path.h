/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A path: the motion of a tool over time.  Each row is a tick, and t strictly
 * increases.  A row contains the index of the tool in use and the speed of the tool's motor (docs/spec/arithmetic.md,
 * AR-MOTOR). A path can therefore switch tools.
 *
 * Threads: the functions share no state; an object may be used by one thread at a time, or read by several.
 */
#ifndef OSTEON_PATH_H
#define OSTEON_PATH_H

#include <stdbool.h>

#include <osteon/pose.h>

#ifdef __cplusplus
extern "C" {
#endif

/*
 * OST_RPM_ON: the motor is on at an unknown speed, and the pose includes the rotation of the tool.
 * OST_RPM_OF_DEVICE: the pose is the pose of the device, without the rotation of the motor, which the operation
 * adds (motor.h). A world does not accept a tick with OST_RPM_OF_DEVICE.
 */
enum { OST_RPM_ON = -1, OST_RPM_OF_DEVICE = -2, OST_RPM_MAX = 3000 };

/* One revolution of the motor, in the unit of motor angles, which is 1 rpm * 1 ns. */
#define OST_MOTOR_TURN INT64_C(60000000000)

/* A row of a path: the pose of a tool at a point in time. */
typedef struct ost_tick {
    int64_t t_ns; /* time in nanoseconds */
    int32_t tool; /* index into the world's tools */
    /*
     * Speed of the motor: 1 to OST_RPM_MAX, OST_RPM_ON or OST_RPM_OF_DEVICE. With 0, the motor is off and the tool
     * removes no bone.
     */
    int32_t rpm;
    ost_pose pose;
    /* True if the tool was lifted before this tick, so that there is no sweep from the previous tick (AR-SWEEP-5). */
    bool lifted;
} ost_tick;

/* Ticks in ascending order of time. */
typedef struct ost_path {
    size_t count;
    ost_tick *ticks; /* owned */
} ost_path;

enum { OST_PATH_TICKS_MAX = 100000000 };
#define OST_PATH_TIME_MAX_NS INT64_C(4000000000000000000)

enum { OST_PATH_NO_GAPS = -1 };
/*
 * Limits that determine gaps. If two rows are farther apart than max_gap_ns or max_jump_pm, there is a gap between
 * the rows, and the second row is lifted. If a limit is 0, it is computed from the rows (AR-PATH-5).
 * OST_PATH_NO_GAPS means that there is no limit.
 */
typedef struct ost_path_options {
    int64_t max_gap_ns;
    ost_pm max_jump_pm;
} ost_path_options;

/* Allocates `count` rows without initialising them. Returns OST_ERR_RANGE if count exceeds OST_PATH_TICKS_MAX, and
 * OST_ERR_MEMORY if memory is exhausted. After an error, the path is empty. The caller frees the rows with
 * ost_path_free. */
OST_API ost_status ost_path_init(ost_path *path, size_t count, ost_error *err);
/* Frees the rows of a path, which is then empty. */
OST_API void ost_path_free(ost_path *path);

#ifdef __cplusplus
}
#endif
#endif
