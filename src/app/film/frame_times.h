/* SPDX-License-Identifier: Apache-2.0 */
/* A histogram of the durations of frames, or of the intervals between frames, with bins of 10 us up
   to one second. */
#ifndef OST_APP_FILM_FRAME_TIMES_H
#define OST_APP_FILM_FRAME_TIMES_H

#include "app/common/app.h"

enum { FRAME_BINS = 100000, FRAME_BIN_NS = 10000 };

typedef struct frame_times {
    uint64_t count;
    int64_t max_ns;
    uint32_t bin[FRAME_BINS];
} frame_times;

void frame_times_add(frame_times *times, int64_t ns);
/*
 * Returns a quantile of the times in ms; `share` is from 0 to 1. The result is the middle of a bin, limited to the
 * maximum. Returns 0 if the histogram is empty.
 */
double frame_times_ms(const frame_times *times, double share);

#endif
