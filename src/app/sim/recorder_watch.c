/* SPDX-License-Identifier: Apache-2.0 */
#include "app/sim/recorder_watch.h"

#include <stdio.h>

/* The recorder normally writes every 25 ms, so two seconds without progress are more than a short delay. */
enum { STUCK_MS = 2000 };

const char *recorder_watch_update(recorder_watch *watch, const char *name, const ost_recorder_state *state,
                                  uint64_t capacity, double now_ms, char text[RECORDER_WATCH_TEXT])
{
    const uint64_t waiting = state->put - state->written;
    const double left_s = (double)(capacity > waiting ? capacity - waiting : 0) * 1e-3;
    if (watch->grew_ms == 0 || state->written != watch->written || waiting == 0) {
        watch->written = state->written;
        watch->grew_ms = now_ms;
    }
    const bool losing = state->lost > watch->reported_lost && !watch->losing;
    const bool stuck = !state->failing && now_ms - watch->grew_ms > STUCK_MS;
    if (losing) {
        watch->losing = true;
        watch->reported_lost = state->lost;
        snprintf(text, RECORDER_WATCH_TEXT,
                 "%s: there is no room left: what happens from here on is not recorded; the operation goes on", name);
        return text;
    }
    if (state->failing && !watch->failing) {
        watch->failing = true;
        snprintf(text, RECORDER_WATCH_TEXT,
                 "%s: %s; the operation goes on, and the recording waits: there is room for %.0f s", name,
                 state->reason, left_s);
        return text;
    }
    if (stuck && !watch->stuck) {
        watch->stuck = true;
        snprintf(text, RECORDER_WATCH_TEXT,
                 "%s: nothing could be written for 2 s: the disk is slow, or the recorder was stopped; the operation "
                 "goes on, and there is room for %.0f s",
                 name, left_s);
        return text;
    }
    /* a recovery is reported only after a record has been written again */
    if ((watch->failing || watch->stuck || watch->losing) && !state->failing && !stuck &&
        state->lost == watch->reported_lost && waiting < capacity / 2) {
        watch->failing = watch->stuck = watch->losing = false;
        if (state->lost)
            snprintf(text, RECORDER_WATCH_TEXT, "%s: recording goes on; %llu ticks were lost", name,
                     (unsigned long long)state->lost);
        else
            snprintf(text, RECORDER_WATCH_TEXT, "%s: recording goes on; nothing was lost", name);
        return text;
    }
    watch->reported_lost = state->lost;
    return NULL;
}
