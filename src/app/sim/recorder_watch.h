/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Produces messages about a recorder while an operation runs. A message reports that the disk fails, that nothing is
 * written, that ticks are being lost, or that the recorder writes again. Each of these events is reported once.
 *
 *   thread, every 100 ms --> ost_recorder_state --> recorder_watch_update --> a line, or none
 */
#ifndef OST_APP_SIM_RECORDER_WATCH_H
#define OST_APP_SIM_RECORDER_WATCH_H

#include <osteon/session.h>

typedef struct recorder_watch {
    bool failing, stuck, losing;
    uint64_t written;   /* highest number of written records so far */
    double grew_ms;     /* time at which this number last increased */
    uint64_t reported_lost; /* number of lost records in the most recent message */
} recorder_watch;

enum { RECORDER_WATCH_TEXT = 320 };
/*
 * Checks the state of a recorder. The recorder writes the file `name`, and its ring has `capacity` records. Writes a
 * new message to `text` and returns `text`, or returns NULL if there is no new message.
 */
const char *recorder_watch_update(recorder_watch *watch, const char *name, const ost_recorder_state *state,
                                  uint64_t capacity, double now_ms, char text[RECORDER_WATCH_TEXT]);

#endif
