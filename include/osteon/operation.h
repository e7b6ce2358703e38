/* SPDX-License-Identifier: Apache-2.0 */
/*
 * An operation: a world whose tools are moved by a device, with recording.
 *
 *   ost_servo_run --sample--> pose guard --> motor: its turn --> force: tool's pose --> ost_world_step --> digest
 *         ^                       |                                |                                        |
 *         '-------- wrench ---- safety <---------------------------'   faults --------------------> record, put
 *
 * ost_servo_run calls ost_operation_tick and ost_operation_done with the
 * operation as user.  Live, scripted and simulated operations all run through
 * these functions.
 */
#ifndef OSTEON_OPERATION_H
#define OSTEON_OPERATION_H

#include <osteon/force.h>
#include <osteon/haptics.h>
#include <osteon/live.h>
#include <osteon/motor.h>
#include <osteon/session.h>
#include <osteon/sim.h>

#ifdef __cplusplus
extern "C" {
#endif

/* A fault: a sample of the device or a force that cannot be real. */
typedef enum ost_fault {
    OST_FAULT_NONE,
    OST_FAULT_JUMP, /* the pose moved more than 5 mm in a tick */
    OST_FAULT_TURN, /* the pose turned by more than a sweep allows (AR-SWEEP-3), or is not a pose */
    OST_FAULT_TOOL, /* the device names a tool that the world does not have */
    OST_FAULT_FORCE /* the force is not finite */
} ost_fault;

typedef struct ost_operation ost_operation;

/* Options of an operation; zero for the defaults. */
typedef struct ost_operation_options {
    int32_t tool;            /* index of the tool if the device does not report it */
    /*
     * Speed of the motor while it is on, in turns a minute, 0 to OST_RPM_MAX; with 0 the tool removes nothing.
     * OST_RPM_ON: the device's poses already contain the tool's turn, and the motor is on.
     */
    int32_t rpm;
    bool motor_waits;        /* true: the motor is off until switched on; false: on from the first tick */
    ost_action buttons[OST_BUTTONS_MAX]; /* actions of the device's buttons */
    int32_t tools;           /* number of tools, from `tool` on, that OST_ACTION_TOOL cycles through; 0: none */
    ost_pose home;           /* pose of the hand after OST_ACTION_HOME; a zero quaternion disables the action */
    ost_recorder *recorder;  /* borrowed; NULL: nothing is recorded */
    ost_force *force;        /* borrowed, with the world's tools; NULL: no force, the tool has the device's pose */
    ost_live_channel *live;          /* borrowed, for the world's bone; NULL: no live state */
    const ost_safety_params *safety; /* read by ost_operation_create; NULL: the defaults */
    /* For an operation that continues: ticks before, the last tick, the motor after it. Otherwise 0 and NULL. */
    uint64_t steps_before;
    const ost_tick *last;    /* read by ost_operation_create */
    ost_motor motor;
    /* Returns the depth of a tool at a pose in mm, for the live state; called on the servo thread. May be NULL. */
    double (*depth_of)(void *user, int32_t tool, const ost_pose *pose);
    void *depth_user;
} ost_operation_options;

/*
 * Creates an operation on a world, which must outlive it and which only the servo thread may use while the loop runs.
 * An operation that continues begins 1 ms after its last tick, at the tool's last pose; a device that is elsewhere is
 * in a fault until it reaches that pose.
 */
OST_API ost_status ost_operation_create(ost_world *world, const ost_operation_options *options, ost_operation **out,
                                        ost_error *err);
/* Frees an operation. NULL is allowed. */
OST_API void ost_operation_free(ost_operation *operation);

/*
 * Runs one tick; an ost_servo_tick.  A pose that cannot be a hand's is a fault: the tool does not move, nothing is
 * removed and the force is 0 until the device is within 5 mm of the tool's pose again.  The same holds during a
 * drop-out, while the device reports lost tracking; a drop-out is recorded and counted, and is no fault.  Returns
 * false, which stops the loop, if the backend fails.
 */
OST_API bool ost_operation_tick(void *operation, const ost_servo_sample *sample, ost_wrench *wrench);
/* Sets the actions of keys that are held, as bits 1 << ost_action. One other thread may call it at any time. */
OST_API void ost_operation_keys(ost_operation *operation, uint32_t active);
/* Loads bone, tables and code of the next tick into the caches; an ost_servo_rehearse. Changes no state. */
OST_API void ost_operation_rehearse(void *operation);
/* Records the duration of a tick; an ost_servo_done. */
OST_API void ost_operation_done(void *operation, uint64_t number, uint32_t exec_ns);

typedef struct ost_operation_report {
    uint64_t steps;        /* ticks of the world */
    uint64_t faults;       /* number of faults */
    uint64_t fault_ticks;  /* ticks during faults */
    ost_fault last_fault;  /* the most recent fault */
    uint64_t dropouts, dropout_ticks, longest_dropout; /* number of drop-outs, their ticks, ticks of the longest */
    double peak_n;         /* greatest hand force */
    double peak_axial_n, energy_j; /* greatest contact force along the axis; work of cutting */
    uint64_t touching_ticks, damped_ticks; /* ticks in contact; ticks that the passivity controller damped */
    ost_status shown;      /* not OST_OK: the backend failed to deliver the live state, which is no longer updated */
    ost_status status;     /* not OST_OK: the world failed; error has the text */
    ost_error error;
} ost_operation_report;
/* Copies the report. Call it after the loop has ended. */
OST_API void ost_operation_report_get(const ost_operation *operation, ost_operation_report *out);
/* Returns a few words, for instance "the pose jumped". */
OST_API const char *ost_fault_text(ost_fault fault);

#ifdef __cplusplus
}
#endif
#endif
