/* SPDX-License-Identifier: Apache-2.0 */
/*
 * An operation: a world that a device moves the tools of, recorded as it goes.
 *
 *   ost_servo_run --sample--> pose guard --> motor: its turn --> force: tool's pose --> ost_world_step --> digest
 *         ^                       |                                |                                        |
 *         '-------- wrench ---- safety <---------------------------'   faults --------------------> record, put
 *
 * It is what to give to ost_servo_run: ost_operation_tick and
 * ost_operation_done, with the operation as user.  Live, scripted and
 * simulated operations are this one.
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

typedef enum ost_fault {
    OST_FAULT_NONE,
    OST_FAULT_JUMP, /* the pose moved more than 5 mm in a tick */
    OST_FAULT_TURN, /* the pose turned more than the sweep can follow, or is none */
    OST_FAULT_TOOL, /* the device names a tool that the world does not have */
    OST_FAULT_FORCE /* the force is no number */
} ost_fault;

typedef struct ost_operation ost_operation;

typedef struct ost_operation_options {
    int32_t tool;            /* where the device does not say */
    /*
     * Turns a minute of the motor when it is on, 0 to OST_RPM_MAX; 0: the tool removes nothing.  OST_RPM_ON: the device's poses
     * have the tool's turn already, and its motor is on.
     */
    int32_t rpm;
    bool motor_waits;        /* the motor is off until a button or a key switches it on; else it is on from the first tick */
    ost_action buttons[OST_BUTTONS_MAX]; /* of the device */
    int32_t tools;           /* that OST_ACTION_TOOL goes through, from `tool` on; 0: none */
    ost_pose home;           /* where OST_ACTION_HOME puts the hand; a zero quaternion: nowhere */
    ost_recorder *recorder;  /* borrowed; NULL: nothing is recorded */
    ost_force *force;        /* borrowed, with the world's tools in their order; NULL: none is given, and the tool is where the device is */
    ost_live *live;          /* borrowed, of the world's bone; NULL: nobody looks on */
    const ost_safety_params *safety; /* read when the operation is created; NULL: the defaults */
    /* Of an operation that goes on: how many ticks the world took before, the last of them, and its motor then; 0 and NULL else. */
    uint64_t steps_before;
    const ost_tick *last;    /* read when the operation is created */
    ost_motor motor;
    /* Returns how deep a tool at a pose is, mm, for the live state; called on the servo thread. NULL: nothing is shown of it. */
    double (*depth_of)(void *user, int32_t tool, const ost_pose *pose);
    void *depth_user;
} ost_operation_options;

/* The world is borrowed, and used by the servo's thread alone while it runs. */
OST_API ost_status ost_operation_create(ost_world *world, const ost_operation_options *options, ost_operation **out, ost_error *err);
OST_API void ost_operation_free(ost_operation *operation); /* NULL is allowed */

/*
 * One that goes on begins a millisecond after its last tick, where the tool
 * was: a device that is elsewhere is in a fault until it comes there.
 */

/*
 * A pose that cannot be the hand's is a fault: the tool stays where it was,
 * nothing is removed and no force is given, until the device comes back to
 * within 5 mm of there.  The same while a device says that it does not see the
 * hand, which is no fault: a drop-out, noted and counted.  A backend that
 * fails ends the loop.
 */
OST_API bool ost_operation_tick(void *operation, const ost_servo_sample *sample, ost_wrench *wrench);
/* Keys that do what buttons do, from one other thread at any time: bits 1 << ost_action of those that are held now. */
OST_API void ost_operation_keys(ost_operation *operation, uint32_t held);
/* Between two ticks: bone, tables and code of the next into the caches. Changes nothing that a tick or a record depends on. */
OST_API void ost_operation_rehearse(void *operation);
OST_API void ost_operation_done(void *operation, uint64_t number, uint32_t exec_ns);

typedef struct ost_operation_report {
    uint64_t steps;        /* ticks that the world took */
    uint64_t faults;       /* how often one began */
    uint64_t fault_ticks;  /* ticks in one */
    ost_fault last_fault;  /* the last that began */
    uint64_t dropouts, dropout_ticks, longest_dropout; /* times in which the device did not see the hand; ticks in all, and of the longest */
    double peak_n;         /* the greatest force given */
    double peak_axial_n, energy_j; /* real: along the axis, and the work of cutting */
    uint64_t touching_ticks, damped_ticks; /* in contact; in which the passivity controller took something */
    ost_status shown;      /* not OST_OK: what others see stopped there, as the backend gave nothing to see */
    ost_status status;     /* not OST_OK: the world failed, with the text in error */
    ost_error error;
} ost_operation_report;
OST_API void ost_operation_report_get(const ost_operation *operation, ost_operation_report *out);
/* A few words, "the pose jumped". */
OST_API const char *ost_fault_text(ost_fault fault);

#ifdef __cplusplus
}
#endif
#endif
