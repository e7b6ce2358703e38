/* SPDX-License-Identifier: Apache-2.0 */
/* Requests real-time scheduling for the calling thread, and restores its previous state. */
#ifndef OST_HAPTICS_REALTIME_H
#define OST_HAPTICS_REALTIME_H

#include <sched.h>

#include <osteon/haptics.h>

typedef struct realtime_before {
    int policy, priority, nice;
    bool scheduled, niced, slack, locked;
    unsigned long slack_ns;
    bool pinned;
    cpu_set_t cores; /* affinity before pinning */
} realtime_before;

/*
 * Sets up the calling thread and describes the result in *out. If `request` is false, the function requests neither a
 * priority nor locked memory, and *out records this. If `core` is negative, the thread is not pinned. Afterwards the
 * caller must call ost_realtime_leave on the same thread. ost_realtime_leave restores what ost_realtime_enter changed.
 */
void ost_realtime_enter(bool request, int core, realtime_before *before, ost_realtime *out);
void ost_realtime_leave(const realtime_before *before);

#endif
