/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The motor that turns a tool about its own z axis (docs/spec/arithmetic.md, AR-MOTOR).
 *
 *   pose of the hand, speed, time --ost_motor_turn--> pose of the tool
 *
 * An angle is an integer in units of one turn per minute times one nanosecond, so
 * that nothing is rounded as time passes; a turn is OST_MOTOR_TURN units.
 *
 * Threads: the functions share no state; an object may be used by one thread at a time, or read by several.
 */
#ifndef OSTEON_MOTOR_H
#define OSTEON_MOTOR_H

#include <osteon/path.h>

#ifdef __cplusplus
extern "C" {
#endif

/* The default speed of a reamer, in turns per minute. */
enum { OST_RPM_REAMER = 200 };

/* A motor's state, which must be zero-initialised before the first tick. */
typedef struct ost_motor {
    int64_t phase; /* 0 to OST_MOTOR_TURN - 1 */
    int64_t t_ns;  /* time of the last tick */
    bool moved;    /* true after the first tick */
} ost_motor;

/*
 * Advances the motor to the tick's time at the tick's speed; a speed of 0 or OST_RPM_ON does not
 * change the phase.
 */
OST_API void ost_motor_advance(ost_motor *motor, const ost_tick *tick);
/* Returns the tool's pose: the hand's pose, turned by the motor's phase. */
OST_API ost_pose ost_motor_pose(const ost_motor *motor, const ost_pose *handle);
/* Returns the hand's pose from the tool's: the inverse of ost_motor_pose, except for one unit of rounding. */
OST_API ost_pose ost_motor_handle_pose(const ost_motor *motor, const ost_pose *tool);
/* Returns the tool's rotation about its z axis in radians, from 0 down to -2 pi, for forces and pictures. */
OST_API double ost_motor_angle(const ost_motor *motor);
/*
 * Sets the speed of a tick whose pose is the hand's to rpm, advances the motor and replaces the pose
 * by the tool's.
 */
OST_API void ost_motor_turn(ost_motor *motor, ost_tick *tick, int32_t rpm);

/*
 * The most ticks into which a row of a path is divided; a row is divided if the motor turns by more
 * than 1/8 turn in it.
 */
enum { OST_MOTOR_PARTS_MAX = 4096 };

/*
 * Replaces the rows of a path that are poses of a hand (OST_RPM_OF_DEVICE) by the ticks of
 * a tool that a motor turns at rpm (AR-MOTOR-7); all other rows do not change.
 * *motor is the motor's state before the path and, on return, after it.  After an
 * error the path is unchanged: OST_ERR_RANGE if a row is too far from the previous
 * one, OST_ERR_USAGE if the speed is not from 0 to OST_RPM_MAX.
 */
OST_API ost_status ost_motor_path(ost_path *path, int32_t rpm, ost_motor *motor, ost_error *err);

#ifdef __cplusplus
}
#endif
#endif
