/* SPDX-License-Identifier: Apache-2.0 */
/* What a thread that must be on time asks of the system, and gives back. */
#ifndef OST_HAPTICS_REALTIME_H
#define OST_HAPTICS_REALTIME_H

#include <sched.h>

#include <osteon/haptics.h>

typedef struct realtime_before {
    int policy, priority, nice;
    bool scheduled, niced, slack, locked;
    unsigned long slack_ns;
    bool pinned;
    cpu_set_t cores; /* where it might run */
} realtime_before;

/* For the calling thread; what it got is in out. ask false: no priority, no locked memory, and out says so; core below 0: anywhere. */
void realtime_enter(bool ask, int core, realtime_before *before, ost_realtime *out);
void realtime_leave(const realtime_before *before);

#endif
