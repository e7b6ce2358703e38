/* SPDX-License-Identifier: Apache-2.0 */
/*
 * An operation is a world whose tools are moved by a device and whose ticks are recorded in a session.
 *
 *   ost_servo_run --sample--> pose check --> motor: rotation --> force: tool's pose --> ost_world_step --> digest
 *         ^                       |                                |                                        |
 *         '-------- wrench ---- safety <---------------------------'   faults --------------------> record, put
 *
 * ost_servo_run calls ost_operation_tick and ost_operation_done; its `user` argument is the operation.  Live,
 * scripted and simulated operations all use these functions.
 *
 * Threads: while ost_servo_run is running, only the servo thread may use the operation, except that one other thread
 * may call ost_operation_keys. At other times, an operation may be used by one thread at a time.
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

/* A fault: a physically impossible device sample, or a force that is not finite. */
typedef enum ost_fault {
    OST_FAULT_NONE,
    OST_FAULT_JUMP, /* the position changed by more than 5 mm in a tick */
    OST_FAULT_TURN, /* the orientation changed by more than a sweep allows (AR-SWEEP-3), or the pose is invalid */
    OST_FAULT_TOOL, /* the device reports a tool that does not exist in the world */
    OST_FAULT_FORCE /* the force is not finite */
} ost_fault;

typedef struct ost_operation ost_operation;

/* Options of an operation. A zero-initialised struct selects the defaults. */
typedef struct ost_operation_options {
    int32_t tool;            /* index of the tool in use if the device does not report a tool */
    /*
     * Speed of the motor while it is on, in revolutions per minute, 0 to OST_RPM_MAX. With a speed of 0, the tool
     * removes no bone. OST_RPM_ON means that the motor is on and that the poses of the device already include the
     * rotation of the tool.
     */
    int32_t rpm;
    /* If true, the motor is off until it is switched on. If false, the motor is on from the first tick. */
    bool motor_waits;
    ost_action buttons[OST_BUTTONS_MAX]; /* actions of the device's buttons */
    /* Number of tools through which OST_ACTION_TOOL cycles. With 0, the action has no effect. */
    int32_t tools;
    ost_pose home;           /* pose of the hand after OST_ACTION_HOME; a zero quaternion disables the action */
    ost_recorder *recorder;  /* borrowed; if NULL, nothing is recorded */
    /* Borrowed; contains the world's tools. If NULL, there is no force, and the pose of the tool is the pose of the
     * device. */
    ost_force *force;
    ost_live_channel *live;          /* borrowed; created for the bone of the world; NULL if there is no live state */
    const ost_safety_params *safety; /* read by ost_operation_create; NULL selects the defaults */
    /*
     * The following members are for an operation that continues an earlier one: the number of ticks of the earlier
     * operation, its last tick, and the state of the motor after that tick. For any other operation, these members are
     * zero or NULL.
     */
    uint64_t steps_before;
    const ost_tick *last;    /* read by ost_operation_create */
    ost_motor motor;
    /* Returns the depth of a tool at a pose, in mm, for the live state. Called on the servo thread. The function
     * pointer may be NULL. */
    double (*depth_of)(void *user, int32_t tool, const ost_pose *pose);
    void *depth_user;
} ost_operation_options;

/*
 * Creates an operation on a world. The world must outlive the operation, and while the servo loop runs, only the servo
 * thread may use the world. An operation that continues an earlier operation begins 1 ms after the last tick of the
 * earlier operation, at the last pose of the tool. If the device is more than 5 mm away from this pose, there is a
 * fault until the device returns to the pose. options may be NULL. Returns OST_ERR_USAGE if world is NULL or
 * options->rpm is out of range, and OST_ERR_MEMORY if memory is exhausted. The caller frees *out with
 * ost_operation_free.
 */
OST_API ost_status ost_operation_create(ost_world *world, const ost_operation_options *options, ost_operation **out,
                                        ost_error *err);
/* Frees an operation. NULL is allowed. */
OST_API void ost_operation_free(ost_operation *operation);

/*
 * Runs one tick. This function is an ost_servo_tick. A pose that a hand cannot have reached is a fault: the tool does
 * not move, no bone is removed, and the force is 0 until the device is again within 5 mm of the tool's pose. The tool
 * also does not move during a drop-out, while the device reports that tracking is lost. A drop-out is not a fault, but
 * it is recorded and counted. Returns false, which stops the loop, if the backend fails.
 */
OST_API bool ost_operation_tick(void *operation, const ost_servo_sample *sample, ost_wrench *wrench);
/*
 * Sets the actions whose keys are held: `active` has the bit 1 << action for each of these actions. One thread other
 * than the servo thread may call this function at any time.
 */
OST_API void ost_operation_keys(ost_operation *operation, uint32_t active);
/*
 * Loads the bone, tables and code needed for the next tick into the caches. Changes no state. This function is an
 * ost_servo_rehearse.
 */
OST_API void ost_operation_rehearse(void *operation);
/* Records the duration of a tick and publishes the live state. This function is an ost_servo_done. */
OST_API void ost_operation_done(void *operation, uint64_t number, uint32_t exec_ns);

/* The counts, peak values and final status of an operation. */
typedef struct ost_operation_report {
    uint64_t steps;        /* number of ticks of the world */
    uint64_t faults;       /* number of intervals with a fault */
    uint64_t fault_ticks;  /* number of ticks during faults */
    ost_fault last_fault;  /* the most recent fault */
    /* Number of drop-outs, number of ticks in all drop-outs, and number of ticks in the longest drop-out. */
    uint64_t dropouts, dropout_ticks, longest_dropout;
    double peak_n;         /* maximum hand force in N */
    /* maximum contact force along the tool's axis in N, and energy used for cutting in J */
    double peak_axial_n, energy_j;
    /* Number of ticks in contact, and number of ticks in which the passivity controller added damping. */
    uint64_t touching_ticks, damped_ticks;
    /* Status of the live state. It is not OST_OK if the backend failed to deliver the occupancy; the live state is
     * then no longer updated. */
    ost_status shown;
    /* Status of the world. It is not OST_OK if the world failed; `error` then contains the message. */
    ost_status status;
    ost_error error;
} ost_operation_report;
/* Copies the report. May be called only after the loop has ended. */
OST_API void ost_operation_report_get(const ost_operation *operation, ost_operation_report *out);
/* Returns a short description of a fault, for instance "the pose jumped". The string is static. */
OST_API const char *ost_fault_text(ost_fault fault);

#ifdef __cplusplus
}
#endif
#endif
