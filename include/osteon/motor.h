/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The motor that turns a tool about its own z axis (docs/spec/arithmetic.md, AR-MOTOR).
 *
 *   pose of the hand, speed, time --ost_motor_turn--> pose of the tool
 *
 * An angle is an integer in units of 1 rpm * 1 ns, so that no rounding errors accumulate over time; one
 * revolution is OST_MOTOR_TURN units.
 *
 * Threads: the functions share no state; an object may be used by one thread at a time, or read by several.
 */
#ifndef OSTEON_MOTOR_H
#define OSTEON_MOTOR_H

#include <osteon/path.h>

#ifdef __cplusplus
extern "C" {
#endif

/* The default speed of a reamer, in revolutions per minute. */
enum { OST_RPM_REAMER = 200 };

/* The state of a motor. Must be zero-initialised before the first tick. */
typedef struct ost_motor {
    int64_t phase; /* angle of the motor, 0 to OST_MOTOR_TURN - 1 */
    int64_t t_ns;  /* time of the last tick */
    bool moved;    /* true after the first tick */
} ost_motor;

/*
 * Advances the motor to the time of the tick, at the speed of the tick. If this speed is 0 or OST_RPM_ON, the angle of
 * the motor does not change.
 */
OST_API void ost_motor_advance(ost_motor *motor, const ost_tick *tick);
/* Returns the pose of the tool, which is the hand's pose rotated by the angle of the motor. */
OST_API ost_pose ost_motor_pose(const ost_motor *motor, const ost_pose *handle);
/*
 * Computes the pose of the hand from the pose of the tool. This is the inverse of ost_motor_pose, apart from one
 * unit of rounding.
 */
OST_API ost_pose ost_motor_handle_pose(const ost_motor *motor, const ost_pose *tool);
/* Returns the tool's rotation about its z axis in radians, from 0 to -2 pi. Used only for forces and pictures. */
OST_API double ost_motor_angle(const ost_motor *motor);
/*
 * Converts a tick that contains the pose of the hand. Sets the tick's speed to rpm, advances the motor, and converts
 * the pose to the pose of the tool.
 */
OST_API void ost_motor_turn(ost_motor *motor, ost_tick *tick, int32_t rpm);

/*
 * Maximum number of ticks into which a row of a path is divided. A row is divided if the motor has rotated by more than
 * 1/8 turn since the previous row.
 */
enum { OST_MOTOR_PARTS_MAX = 4096 };

/*
 * Converts a path of a hand to the ticks of a tool that a motor rotates at rpm (AR-MOTOR-7). Only rows that are poses
 * of a hand (OST_RPM_OF_DEVICE) are converted; all other rows remain unchanged. On entry, *motor is the state of the
 * motor before the path; on return, it is the state after the path. Returns OST_ERR_RANGE if a row is too far from the
 * previous row, and OST_ERR_USAGE if rpm is not within 0 to OST_RPM_MAX; the path is then unchanged.
 */
OST_API ost_status ost_motor_path(ost_path *path, int32_t rpm, ost_motor *motor, ost_error *err);

#ifdef __cplusplus
}
#endif
#endif
