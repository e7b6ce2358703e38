/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What to tell people about a recorder while an operation goes on: that the
 * disk fails, that nothing reaches it, that ticks are being lost, and that it
 * is well again.  Each is said once.
 *
 *   thread, every 100 ms --> ost_recorder_state --> recorder_watch_look --> a line, or none
 */
#ifndef OST_APP_RECORDER_WATCH_H
#define OST_APP_RECORDER_WATCH_H

#include <osteon/session.h>

typedef struct recorder_watch {
    bool failing, stuck, losing;
    uint64_t written;   /* when it last grew */
    double grew_ms;     /* and when that was */
    uint64_t told_lost; /* when it was last said how many */
} recorder_watch;

enum { RECORDER_WATCH_TEXT = 320 };
/* Of the recorder of name, with room for so many records; NULL when there is nothing new to say. */
const char *recorder_watch_look(recorder_watch *watch, const char *name, const ost_recorder_state *state, uint64_t room, double now_ms,
                                char text[RECORDER_WATCH_TEXT]);

#endif
