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
    cpu_set_t cores; /* the affinity before pinning */
} realtime_before;

/*
 * Sets up the calling thread and describes in *out what was obtained. If request is false, requests
 * no priority and no locked memory, and *out says so. If core is negative, the thread is not
 * pinned. realtime_leave, called on the same thread, restores what realtime_enter changed.
 */
void realtime_enter(bool request, int core, realtime_before *before, ost_realtime *out);
void realtime_leave(const realtime_before *before);

#endif
