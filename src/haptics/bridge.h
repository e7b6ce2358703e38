/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The remote end of the device udp: a device on this machine drives a
 * simulation on another machine.
 *
 *   device --read--> tick --newest--> thread --pose--> simulation
 *     ^               |  ^--newest--- thread <-state--    |
 *     '-- wrench: coupling to the plane of the newest state
 *
 * The coupling is computed here.  A state contains a force, the pose at which
 * it was computed, and the stiffness there; together they define a plane, which
 * stays fixed until the next state arrives.  A spring and a damper on this side
 * push the device out of the plane, limited by the rules of safety.c, among
 * them passivity.  The delay of the link is therefore in no feedback loop,
 * however long it is.
 *
 *   force = f + K (p - x) . n - B v . n, never pulling    f, n, p, K, B: from the state; x, v: position and speed now
 *
 * The device gets no force when no state has arrived for BRIDGE_LIMP_MS or when
 * the state has LINK_AGAIN set.  Afterwards the clutch engages again where the
 * tool is.
 */
#ifndef OST_HAPTICS_BRIDGE_H
#define OST_HAPTICS_BRIDGE_H

#include <osteon/force.h>
#include "haptics/link.h"

enum { BRIDGE_LIMP_MS = 50, BRIDGE_PATIENCE_MS = 5000, BRIDGE_ADDRESS = 128 };

typedef struct bridge_options {
    const char *to;        /* "host:port", "[address]:port" */
    const char *key;       /* path of the key's file */
    uint64_t ticks;        /* 0: until the device or the simulation ends, or stop_requested() returns true */
    int64_t patience_ms;   /* how long to wait for the first answer; 0: BRIDGE_PATIENCE_MS */
    bool no_realtime;
    bool (*stop_requested)(void); /* returns true to end the run; called once each tick; may be NULL */
} bridge_options;

typedef struct bridge_report {
    ost_servo_report loop;
    char to[BRIDGE_ADDRESS];        /* numeric address and port */
    /* packets: sent; accepted states; dropped as invalid, as late, as received before */
    uint64_t sent, states, bad, late, replayed;
    /*
     * how often the device was released after it had been held; ticks without force since it
     * was first held
     */
    uint64_t limps, limp_ticks;
    uint64_t fault_ticks;           /* ticks in which the device returned no valid pose */
    bool met;                       /* a simulation answered */
    bool busy;                      /* the simulation already has another bridge */
    bool ended;                     /* the simulation sent its last packet */
    double peak_n;
    ost_times round_trip;           /* from sending a pose to receiving the state that answers it */
} bridge_report;

/*
 * Computes the force of the plane in *state on a device at `at` (m) moving with `speed` (m/s),
 * all in the bone's frame. The stiffness is limited to most_stiffness (N/m).
 */
void bridge_press(const link_packet *state, const double at[3], const double speed[3], double most_stiffness,
                  double force_n[3]);

/*
 * Runs until one of the ends in bridge_options. Returns OST_ERR_UNAVAILABLE if no simulation
 * answers in time.
 */
ost_status bridge_run(ost_haptic *device, const bridge_options *options, bridge_report *report, ost_error *err);

#endif
