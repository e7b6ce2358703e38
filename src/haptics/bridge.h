/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The bridge is the remote end of the `udp` driver: a device on this machine drives a simulation on another machine.
 *
 *   device --read--> tick --newest--> thread --pose--> simulation
 *     ^               |  ^--newest--- thread <-state--    |
 *     '-- wrench: coupling to the plane of the newest state
 *
 * The coupling is computed on this machine. A state contains a force, the pose at which the force was computed, and the
 * stiffness at that pose. These values define a plane, which stays fixed until the next state arrives. A spring and a
 * damper on this machine push the device out of the plane. The safety layer (safety.c) limits this force and keeps the
 * loop passive. Because the coupling and the safety layer run on this machine, no feedback loop includes the delay of
 * the link.
 *
 *   force = max(f + K (p - x) . n - B v . n, 0)     f, n, p, K and B are taken from the state;
 *                                                   x and v are the current position and speed
 *
 * The device renders no force if no state has arrived for BRIDGE_LIMP_MS, or if the newest state
 * has LINK_AGAIN or LINK_ENDED set. After such an interruption, the clutch engages again with the
 * tool at its current position.
 */
#ifndef OST_HAPTICS_BRIDGE_H
#define OST_HAPTICS_BRIDGE_H

#include <osteon/force.h>
#include "haptics/link.h"

enum { BRIDGE_LIMP_MS = 50, BRIDGE_PATIENCE_MS = 5000, BRIDGE_ADDRESS = 128 };

typedef struct bridge_options {
    const char *to;        /* address of the simulation, "host:port" or "[address]:port" */
    const char *key;       /* path of the file that contains the key */
    /* number of ticks; 0 means that the bridge runs until the device or the simulation ends, or until stop_requested()
       returns true */
    uint64_t ticks;
    /* timeout in ms for the first answer; 0 selects BRIDGE_PATIENCE_MS */
    int64_t patience_ms;
    bool no_realtime;
    bool (*stop_requested)(void); /* called once per tick; returns true to end the run; NULL if not used */
} bridge_options;

typedef struct bridge_report {
    ost_servo_report loop;
    char to[BRIDGE_ADDRESS];        /* numeric address and port */
    /* `sent` counts sent packets, and `states` accepted states. The other fields count dropped states: `bad` the
       invalid states, `late` those that arrived too late, and `replayed` those that were already received. */
    uint64_t sent, states, bad, late, replayed;
    /* `limps` counts how often the force was switched off after the device had been held. `limp_ticks` counts the ticks
       without force since the device was first held. */
    uint64_t limps, limp_ticks;
    uint64_t fault_ticks;           /* number of ticks in which the device returned no valid pose */
    bool met;                       /* set if a simulation has answered */
    bool busy;                      /* set if the simulation already has another bridge */
    bool ended;                     /* set if the simulation has sent its last packet */
    double peak_n;                  /* maximum force on the device in N */
    ost_times round_trip;           /* time from sending a pose to receiving the state that answers this pose */
} bridge_report;

/*
 * Computes the force that the plane in *state exerts on a device at the position `at` (m) that
 * moves with `speed` (m/s). All vectors are in the bone's frame. The stiffness is limited to
 * most_stiffness (N/m).
 */
void ost_bridge_press(const link_packet *state, const double at[3], const double speed[3], double most_stiffness,
                      double force_n[3]);

/*
 * Runs the bridge until one of the conditions in bridge_options ends the run. Returns
 * OST_ERR_UNAVAILABLE if no simulation answers in time.
 */
ost_status ost_bridge_run(ost_haptic *device, const bridge_options *options, bridge_report *report, ost_error *err);

#endif
