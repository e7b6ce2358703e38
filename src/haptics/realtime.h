/* SPDX-License-Identifier: Apache-2.0 */
/* What a thread that must be on time asks of the system, and gives back. */
#ifndef OST_HAPTICS_REALTIME_H
#define OST_HAPTICS_REALTIME_H

#include <osteon/haptics.h>

typedef struct realtime_before {
    int policy, priority, nice;
    bool scheduled, niced, slack, locked;
    unsigned long slack_ns;
} realtime_before;

/* For the calling thread; what it got is in out. ask false: nothing, and out says so. */
void realtime_enter(bool ask, realtime_before *before, ost_realtime *out);
void realtime_leave(const realtime_before *before);

#endif
