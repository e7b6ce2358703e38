/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The motor that turns a tool about its own z axis (docs/arithmetic.md, AR-MOTOR).
 *
 *   pose of the hand, speed, time --ost_motor_turn--> pose of the tool
 *
 * Angles are integers of one turn a minute times one nanosecond, so that
 * nothing is rounded as time passes; OST_MOTOR_TURN of them are a turn.
 */
#ifndef OSTEON_MOTOR_H
#define OSTEON_MOTOR_H

#include <osteon/path.h>

#ifdef __cplusplus
extern "C" {
#endif

/* A reamer's speed, where nothing else is said: turns a minute. */
enum { OST_RPM_REAMER = 200 };

/* Zero-initialised before the first tick. */
typedef struct ost_motor {
    int64_t phase; /* 0 to OST_MOTOR_TURN - 1 */
    int64_t t_ns;  /* of the last tick */
    bool moved;    /* there was one */
} ost_motor;

/* Advances the motor to the tick's time at the tick's speed; a speed of 0 or OST_RPM_ON leaves the phase as it is. */
OST_API void ost_motor_advance(ost_motor *motor, const ost_tick *tick);
/* Returns the hand's pose with the tool's turn by the motor's phase. */
OST_API ost_pose ost_motor_pose(const ost_motor *motor, const ost_pose *hand);
/* Returns the hand's pose of a tool's: ost_motor_pose the other way round, but for one unit of rounding. */
OST_API ost_pose ost_motor_hand(const ost_motor *motor, const ost_pose *tool);
/* Returns the tool's turn about its z axis, radians, from 0 down to -2 pi: for forces and pictures. */
OST_API double ost_motor_angle(const ost_motor *motor);
/* Gives a tick, whose pose is the hand's, a motor of rpm: advances the motor and replaces the pose by the tool's. */
OST_API void ost_motor_turn(ost_motor *motor, ost_tick *tick, int32_t rpm);

/* A row of a path whose motor turns by more than an eighth of a turn becomes up to so many ticks. */
enum { OST_MOTOR_PARTS_MAX = 4096 };

/*
 * Replaces the rows of a path that are a hand's (OST_RPM_HAND) by the ticks of
 * a tool that a motor of rpm turns (AR-MOTOR-7); all other rows stay as they
 * are.  *motor is where the motor begins and ends.  On an error path is as it
 * was: OST_ERR_RANGE names a row that is too far from the one before it,
 * OST_ERR_USAGE a speed that is not from 0 to OST_RPM_MAX.
 */
OST_API ost_status ost_motor_path(ost_path *path, int32_t rpm, ost_motor *motor, ost_error *err);

#ifdef __cplusplus
}
#endif
#endif
