/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The other end of the device udp: a device of this machine, and a simulation
 * on another.
 *
 *   device --read--> tick --newest--> thread --pose--> simulation
 *     ^               |  ^--newest--- thread <-state--    |
 *     '-- wrench: coupling to the plane of the newest state
 *
 * The coupling is here.  A state says at which pose which force was felt, and
 * how stiff it is: a plane that goes on standing while the next state is on
 * its way, and that the hand is pressed out of by a spring and a damper of this
 * side, behind the rules of safety.c with passivity among them.  So however
 * late the link is, it is in no loop.
 *
 *   force = f + K (p - x) . n - B v . n, never pulling    f, n, p, K, B: the state's; x, v: the hand now
 *
 * Without a state for LIMP_MS, or when the simulation says so, the hand is let
 * alone; then the tool is taken hold of anew where it is.
 */
#ifndef OST_HAPTICS_BRIDGE_H
#define OST_HAPTICS_BRIDGE_H

#include <osteon/force.h>
#include "haptics/link.h"

enum { BRIDGE_LIMP_MS = 50, BRIDGE_PATIENCE_MS = 5000, BRIDGE_ADDRESS = 128 };

typedef struct bridge_options {
    const char *to;        /* "host:port", "[address]:port" */
    const char *key;       /* a file */
    uint64_t ticks;        /* 0: until the device or the simulation ends, or asked says so */
    int64_t patience_ms;   /* for a first answer; 0: BRIDGE_PATIENCE_MS */
    bool no_realtime;
    bool (*asked)(void);   /* to end; looked at once a tick; may be NULL */
} bridge_options;

typedef struct bridge_report {
    ost_servo_report loop;
    char to[BRIDGE_ADDRESS];        /* in numbers */
    uint64_t sent, states, bad, late, replayed; /* packets: ours, taken, not ours or broken, older than newer ones, twice */
    uint64_t limps, limp_ticks;     /* how often the hand was let alone after it held, and for how long */
    uint64_t fault_ticks;           /* in which the device gave no pose */
    bool met;                       /* a simulation answered */
    bool busy;                      /* it has another bridge */
    bool ended;                     /* it said that it is over */
    double peak_n;
    ost_times round_trip;           /* from a pose to the state that answers it */
} bridge_report;

/* The plane of a state, for a hand that is at `at` (m) with `speed` (m/s), all in the bone's frame; stiffness at most N/m. */
void bridge_press(const link_packet *state, const double at[3], const double speed[3], double most_stiffness, double force_n[3]);

/* Runs until an end. OST_ERR_UNAVAILABLE when no simulation answers in time. */
ost_status bridge_run(ost_haptic *device, const bridge_options *options, bridge_report *report, ost_error *err);

#endif
