/* SPDX-License-Identifier: Apache-2.0 */
/*
 * One tick of an operation. The functions called in a tick do not wait and make no system calls. Only ost_world_step
 * may allocate memory.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <stdatomic.h>

#include <osteon/operation.h>

#include "core/integer.h"
#include "haptics/clutch.h"

enum { AFTER_NS = 1000000 };
#define JUMP_PM (5 * OST_PM_PER_MM)

struct ost_operation {
    ost_world *world;
    ost_operation_options options;
    int classes;
    int64_t t_ns;      /* time of the loop's first tick */
    bool moved;        /* true if at least one tick was executed; `hand` is valid only then */
    ost_motor motor;
    bool on;           /* true if the motor is switched on and runs without a button being held */
    uint32_t active_actions; /* actions held in the last tick */
    _Atomic uint32_t keys;
    int32_t tool;      /* index of the tool to use if the device selects none */
    ost_pose hand;     /* pose of the last tick, with the clutch applied and without the motor's rotation */
    haptic_clutch clutch;
    bool clutched;     /* true once OST_ACTION_CLUTCH or OST_ACTION_HOME has moved the hand relative to the device */
    int32_t last_tool;
    ost_safety safety;
    bool given;        /* true if a force is written to the device in this tick */
    double contact_n;  /* force of the tool on the bone in this tick */
    ost_fault fault;   /* the current fault */
    uint64_t dropout;  /* number of ticks of the current drop-out; 0 while the device is tracked */
    bool lifted;       /* true if the tool was lifted after the last executed tick */
    ost_operation_report report;
    ost_record pending; /* record of the last tick, held back until the duration of the tick is available */
    bool has_pending;
    ost_live_state seen; /* state published for viewers */
};

const char *ost_fault_text(ost_fault fault)
{
    switch (fault) {
    case OST_FAULT_NONE: return "none";
    case OST_FAULT_JUMP: return "the pose jumped";
    case OST_FAULT_TURN: return "the pose turned too far, or is invalid";
    case OST_FAULT_TOOL: return "there is no such tool";
    case OST_FAULT_FORCE: return "the force is not a number";
    }
    return "unknown";
}

ost_status ost_operation_create(ost_world *world, const ost_operation_options *options, ost_operation **out,
                                ost_error *err)
{
    *out = NULL;
    if (!world)
        return ost_fail(err, OST_ERR_USAGE, "an operation needs a world");
    ost_operation *o = calloc(1, sizeof *o);
    if (!o)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for an operation");
    o->world = world;
    if (options)
        o->options = *options;
    o->classes = ost_world_classes(world)->count;
    ost_safety_begin(&o->safety, o->options.safety);
    o->options.safety = NULL;
    if (o->options.rpm < OST_RPM_ON || o->options.rpm > OST_RPM_MAX) {
        ost_fail(err, OST_ERR_USAGE, "a motor speed of %d rpm; expected 0 to %d", o->options.rpm, OST_RPM_MAX);
        free(o);
        return OST_ERR_USAGE;
    }
    o->motor = o->options.motor;
    o->on = !o->options.motor_waits;
    o->tool = o->options.tool;
    if (o->options.last) {
        o->moved = true;
        o->hand = ost_motor_handle_pose(&o->motor, &o->options.last->pose);
        o->last_tool = o->options.last->tool;
        o->t_ns = o->options.last->t_ns + AFTER_NS;
        if (o->options.force)
            ost_force_set_pose(o->options.force, o->last_tool, &o->options.last->pose);
        o->options.last = NULL;
    }
    ost_status status = ost_world_reserve(world, err);
    if (status != OST_OK) {
        free(o);
        return status;
    }
    *out = o;
    return OST_OK;
}

void ost_operation_free(ost_operation *operation)
{
    free(operation);
}

static uint32_t at_most_32(uint64_t n)
{
    return n < UINT32_MAX ? (uint32_t)n : UINT32_MAX;
}

static void put(ost_operation *o, const ost_record *record)
{
    if (o->options.recorder)
        ost_recorder_put(o->options.recorder, record); /* the recorder counts the records that it cannot store */
}

static void note(ost_operation *o, int64_t t_ns, const char *text)
{
    ost_record record = {.kind = OST_RECORD_NOTE, .as.note.t_ns = t_ns};
    size_t length = strlen(text);
    length = length < OST_SESSION_TEXT - 1 ? length : OST_SESSION_TEXT - 1;
    memcpy(record.as.note.text, text, length);
    put(o, &record);
}

/*
 * Returns true if two poses are more than 5 mm apart. Valid poses lie within 8 m, so a difference is below 2^44 and its
 * square is below 2^88.
 */
static bool is_far(const ost_pose *a, const ost_pose *b)
{
    const int64_t d[3] = {a->t.x - b->t.x, a->t.y - b->t.y, a->t.z - b->t.z};
    ost_i128 square = 0;
    for (int i = 0; i < 3; i++)
        square += (ost_i128)d[i] * d[i];
    return square > (ost_i128)JUMP_PM * JUMP_PM;
}

static ost_fault judge(const ost_operation *o, const ost_tick *tick, bool lifted)
{
    if (ost_pose_check(&tick->pose, NULL) != OST_OK)
        return OST_FAULT_TURN;
    /* After a lift or a change of tools, the tool starts at a new position without a sweep. */
    if (o->moved && !lifted && tick->tool == o->last_tool && is_far(&tick->pose, &o->hand))
        return OST_FAULT_JUMP;
    return OST_FAULT_NONE;
}

static void set_fault(ost_operation *o, ost_fault fault, int64_t t_ns)
{
    if (fault != OST_FAULT_NONE) {
        o->report.fault_ticks++;
        if (o->fault == OST_FAULT_NONE)
            o->report.faults++;
        o->report.last_fault = fault;
    }
    if (fault != o->fault)
        note(o, t_ns, fault == OST_FAULT_NONE ? "the fault is over" : ost_fault_text(fault));
    o->fault = fault;
}

/* Handles a tick without tracking. As in a fault, the force is 0, but a drop-out does not count as an error. */
static void drop_out(ost_operation *o, int64_t t_ns)
{
    ost_operation_report *r = &o->report;
    if (o->dropout++ == 0) {
        r->dropouts++;
        note(o, t_ns, "the device does not see the hand: the tool stays where it is");
        ost_safety_stop(&o->safety);
    }
    r->dropout_ticks++;
    if (o->dropout > r->longest_dropout)
        r->longest_dropout = o->dropout;
}

static void drop_out_over(ost_operation *o, int64_t t_ns)
{
    char text[OST_SESSION_TEXT];
    snprintf(text, sizeof text, "the device sees the hand again after %llu ms",
             (unsigned long long)(o->dropout * AFTER_NS / 1000000));
    note(o, t_ns, text);
    o->dropout = 0;
}

static int32_t millionths(double value)
{
    return (int32_t)rint(fmax(-2e9, fmin(2e9, value * 1e6)));
}

/*
 * Converts revolutions per minute to radians per second. If the speed is unknown (OST_RPM_ON), this function is not
 * called, and ost_force uses its default speed.
 */
static double speed_of(int32_t rpm)
{
    return rpm * 0.10471975511965977;
}

/*
 * Computes the wrench and the pose of the tool. On entry, tick->pose is the pose of the device, including the motor's
 * rotation; on return, tick->pose is the pose of the tool. Sets *fault if the result is not valid.
 */
static ost_status feel(ost_operation *o, const ost_servo_sample *sample, double turned, int64_t period_ns,
                       ost_tick *tick, ost_wrench *wrench, ost_fault *fault)
{
    ost_force_result felt;
    const double period_s = (double)period_ns * 1e-9;
    const ost_pose device = tick->pose;
    if (tick->rpm != OST_RPM_ON)
        ost_force_motor(o->options.force, speed_of(tick->rpm), turned);
    ost_status status = ost_force_step(o->options.force, tick->tool, &device, period_s, &felt, &o->report.error);
    if (status != OST_OK)
        return status;
    memcpy(wrench->force_n, felt.force_n, sizeof felt.force_n);
    memcpy(wrench->torque_nm, felt.torque_nm, sizeof felt.torque_nm);
    const ost_safety_answer answer = ost_safety_step(&o->safety, &device, !sample->declared, sample->state.buttons,
                                                     period_s, wrench->force_n, wrench->torque_nm);
    if (answer == OST_SAFETY_FAULT || ost_pose_check(&felt.tool, NULL) != OST_OK) {
        *fault = OST_FAULT_FORCE;
        return OST_OK;
    }
    tick->pose = felt.tool;
    o->given = answer == OST_SAFETY_GIVEN;
    ost_operation_report *r = &o->report;
    const double *f = wrench->force_n;
    r->peak_n = fmax(r->peak_n, sqrt(f[0] * f[0] + f[1] * f[1] + f[2] * f[2]));
    o->contact_n = sqrt(felt.axial_n * felt.axial_n + felt.off_axis_n * felt.off_axis_n);
    r->peak_axial_n = fmax(r->peak_axial_n, felt.axial_n);
    r->energy_j += felt.power_w * period_s;
    r->touching_ticks += felt.touching > 0;
    r->damped_ticks = o->safety.damped_ticks;
    return OST_OK;
}

static void remember(ost_operation *o, const ost_servo_sample *sample, const ost_tick *tick,
                     const ost_step_result *step, const ost_wrench *wrench)
{
    o->pending = (ost_record){
        .kind = OST_RECORD_TICK,
        .as.tick = {.number = o->options.steps_before + o->report.steps,
                    .tick = *tick,
                    .flags = (step->removal ? OST_TICK_REMOVAL : 0) | (step->boxes_meet ? OST_TICK_MET : 0) |
                             (o->given ? OST_TICK_FORCE : 0) | (sample->declared ? OST_TICK_DECLARED : 0),
                    .buttons = sample->state.buttons,
                    .digest = ost_step_digest(step, o->classes),
                    .removed = step->report ? at_most_32(step->report->total_voxels) : 0,
                    .touched = step->report ? at_most_32(step->report->touched_voxels) : 0,
                    .poses = (uint16_t)step->pose_count,
                    .wake_ns = sample->wake_ns,
                    .missed = sample->missed},
    };
    for (int a = 0; a < 3; a++) {
        o->pending.as.tick.force_un[a] = millionths(wrench->force_n[a]);
        o->pending.as.tick.torque_unm[a] = millionths(wrench->torque_nm[a]);
    }
    o->has_pending = true;
}

/* Updates the state for viewers. In a fault, neither tool nor bone changes, and `step` is NULL. */
static void show(ost_operation *o, const ost_servo_sample *sample, const ost_tick *tick, const ost_step_result *step,
                 const ost_wrench *wrench)
{
    ost_live_state *s = &o->seen;
    s->device = sample->state.pose;
    s->fault = (int32_t)o->fault;
    s->declared = sample->declared;
    s->wake_ns = sample->wake_ns;
    s->missed += sample->missed;
    memcpy(s->force_n, wrench->force_n, sizeof s->force_n);
    memcpy(s->torque_nm, wrench->torque_nm, sizeof s->torque_nm);
    s->contact_n = step ? o->contact_n : 0;
    s->touching = 0;
    if (!step)
        return;
    s->ticks++;
    s->t_ns = tick->t_ns;
    s->tool = tick->tool;
    s->pose = tick->pose;
    s->rpm = tick->rpm;
    if (!step->report)
        return;
    s->removals++;
    s->removed_voxels += step->report->total_voxels;
    s->touching = at_most_32(step->report->total_voxels + step->report->touched_voxels);
    if (o->options.depth_of && step->report->total_voxels && tick->tool < OST_LIVE_TOOLS)
        s->reached_mm[tick->tool] = fmax(s->reached_mm[tick->tool],
                                         o->options.depth_of(o->options.depth_user, tick->tool, &tick->pose));
    ost_live_changed(o->options.live, step->report);
}

static bool is(uint32_t actions, ost_action action)
{
    return actions >> action & 1;
}

/*
 * Combines buttons and keys. Returns the actions that are held, and sets *pressed to the actions that were not held in
 * the previous tick.
 */
static uint32_t actions_of(ost_operation *o, uint32_t buttons, uint32_t *pressed)
{
    uint32_t active_actions = atomic_load_explicit(&o->keys, memory_order_relaxed);
    for (int i = 0; i < OST_BUTTONS_MAX; i++)
        active_actions |= buttons >> i & 1 ? UINT32_C(1) << o->options.buttons[i] : 0;
    *pressed = active_actions & ~o->active_actions;
    o->active_actions = active_actions;
    return active_actions;
}

void ost_operation_keys(ost_operation *operation, uint32_t active_actions)
{
    atomic_store_explicit(&operation->keys, active_actions, memory_order_relaxed);
}

/*
 * Converts *pose from the pose of the device to the pose of the hand. The two poses are equal until OST_ACTION_CLUTCH
 * or OST_ACTION_HOME occurs for the first time. Sets *put if OST_ACTION_HOME moves the tool to the home pose. While
 * OST_ACTION_CLUTCH is held, the pose of the hand does not change, and the function returns false.
 */
static bool hand_of(ost_operation *o, uint32_t active_actions, uint32_t pressed, ost_pose *pose, bool *put)
{
    if (ost_pose_check(pose, NULL) != OST_OK)
        return true; /* an invalid pose is reported as a fault by judge() */
    const bool home = is(pressed, OST_ACTION_HOME) &&
                      o->options.home.qw | o->options.home.qx | o->options.home.qy | o->options.home.qz;
    const bool stays = is(active_actions, OST_ACTION_CLUTCH) && o->moved;
    if ((home || stays) && !o->clutched) {
        o->clutch = ost_haptic_clutch_make(o->moved ? &o->hand : pose, 1);
        o->clutch.laid = o->clutched = true; /* the axes of the device are not rotated */
    }
    if (home) {
        ost_haptic_clutch_engage_at(&o->clutch, &o->options.home);
        o->hand = o->options.home;
        *put = true;
    }
    if (stays) {
        ost_haptic_clutch_release(&o->clutch);
        *pose = o->hand;
        return false;
    }
    if (o->clutched)
        *pose = ost_haptic_clutch_follow(&o->clutch, pose);
    return true;
}

/*
 * Sets the motor speed of the tick and the pose of the tool. If the tick is so late that the motor would have rotated
 * by more than 1/8 turn, the motor is off in this tick. There is then no sweep, because the motion in between is
 * unknown.
 */
static void run_motor(const ost_operation *o, const ost_haptic_state *state, bool on, ost_motor *motor, ost_tick *tick)
{
    if (state->turned || o->options.rpm == OST_RPM_ON) {
        tick->rpm = state->turned ? state->rpm : on ? OST_RPM_ON : 0;
        ost_motor_advance(motor, tick);
        return;
    }
    int32_t rpm = on ? o->options.rpm : 0;
    if (motor->moved && rpm > 0 && tick->t_ns - motor->t_ns > OST_MOTOR_TURN / 8 / rpm)
        rpm = 0;
    ost_motor_turn(motor, tick, rpm);
}

bool ost_operation_tick(void *operation, const ost_servo_sample *sample, ost_wrench *wrench)
{
    ost_operation *o = operation;
    ost_tick tick = {.t_ns = o->t_ns + sample->t_ns, .pose = sample->state.pose};
    ost_motor motor = o->motor;
    ost_step_result step;
    o->given = false;
    o->contact_n = 0;
    if (sample->tracking_lost) {
        drop_out(o, tick.t_ns);
        return true;
    }
    /*
     * After a drop-out, there is no sweep from the previous pose, but a device that is too far from the previous pose
     * still causes a fault.
     */
    const bool lifted = !sample->declared && sample->state.lifted;
    o->lifted |= o->dropout > 0;
    if (o->dropout)
        drop_out_over(o, tick.t_ns);
    uint32_t pressed;
    const uint32_t active_actions = actions_of(o, sample->state.buttons, &pressed);
    if (is(pressed, OST_ACTION_TOOL) && o->options.tools > 0)
        o->tool = (o->tool + 1) % o->options.tools;
    o->on ^= is(pressed, OST_ACTION_SWITCH);
    tick.tool = sample->state.tool >= 0 ? sample->state.tool : o->tool;
    bool put = lifted;
    const bool follows = hand_of(o, active_actions, pressed, &tick.pose, &put);
    o->lifted |= put;
    const ost_pose hand = tick.pose;
    tick.lifted = o->lifted && o->moved;
    ost_fault fault = judge(o, &tick, put);
    run_motor(o, &sample->state, o->on || is(active_actions, OST_ACTION_MOTOR), &motor, &tick);
    if (put)
        /* resets the safety layer, so that this displacement does not count as work done by the hand */
        ost_safety_stop(&o->safety);
    if (fault == OST_FAULT_NONE && put && o->options.force)
        ost_force_set_pose(o->options.force, tick.tool, &tick.pose);
    if (fault == OST_FAULT_NONE && o->options.force) {
        o->report.status = feel(o, sample, ost_motor_angle(&motor) - ost_motor_angle(&o->motor), AFTER_NS, &tick,
                                wrench, &fault);
        if (o->report.status == OST_ERR_USAGE)
            fault = OST_FAULT_TOOL;
        else if (o->report.status != OST_OK)
            return false;
    }
    if (fault == OST_FAULT_NONE) {
        o->report.status = ost_world_step(o->world, &tick, &step, &o->report.error);
        if (o->report.status == OST_ERR_RANGE)
            fault = OST_FAULT_TURN;
        else if (o->report.status == OST_ERR_USAGE)
            fault = OST_FAULT_TOOL;
        else if (o->report.status != OST_OK)
            return false;
    }
    set_fault(o, fault, tick.t_ns);
    if (fault != OST_FAULT_NONE) {
        /* The world has not changed, so the operation can continue. The force is 0. */
        o->report.status = OST_OK;
        *wrench = (ost_wrench){{0}, {0}};
        ost_safety_stop(&o->safety);
        if (o->options.live)
            show(o, sample, &tick, NULL, wrench);
        return true;
    }
    if (!follows) {
        *wrench = (ost_wrench){{0}, {0}};
        o->given = false;
        ost_safety_stop(&o->safety);
    }
    if (o->options.live)
        show(o, sample, &tick, &step, wrench);
    remember(o, sample, &tick, &step, wrench);
    o->report.steps++;
    o->moved = true;
    o->motor = motor;
    o->lifted = false;
    o->hand = hand;
    o->last_tool = tick.tool;
    return true;
}

/*
 * Rehearses the next tick under the assumption that the hand does not move. The tool may move nevertheless if a force
 * couples it to the hand.
 */
void ost_operation_rehearse(void *operation)
{
    ost_operation *o = operation;
    if (!o->moved || o->dropout || o->fault != OST_FAULT_NONE)
        return;
    const ost_pose tool = o->options.rpm == OST_RPM_ON ? o->hand : ost_motor_pose(&o->motor, &o->hand);
    ost_force_result felt = {.tool = tool};
    /* Errors of the rehearsal are ignored, because the tick itself reports them. */
    if (!o->options.force ||
        ost_force_rehearse(o->options.force, o->last_tool, &tool, (double)AFTER_NS * 1e-9, &felt, NULL) == OST_OK)
        (void)ost_world_rehearse(o->world, o->last_tool, &felt.tool, NULL);
}

void ost_operation_done(void *operation, uint64_t number, uint32_t exec_ns)
{
    ost_operation *o = operation;
    (void)number;
    /* The state is published after the wrench has been written, so that viewers do not delay the device. */
    if (o->options.live && o->report.shown == OST_OK) {
        o->seen.exec_ns = exec_ns;
        o->report.shown = ost_live_publish(o->options.live, &o->seen, NULL);
    }
    /* An error is ignored here, because the next tick reports it. */
    if (o->options.force)
        (void)ost_force_refresh(o->options.force, NULL);
    if (!o->has_pending)
        return;
    o->pending.as.tick.exec_ns = exec_ns;
    put(o, &o->pending);
    o->has_pending = false;
}

void ost_operation_report_get(const ost_operation *operation, ost_operation_report *out)
{
    *out = operation->report;
}
