/* SPDX-License-Identifier: Apache-2.0 */
#include "app/film/frame_times.h"

#include <math.h>

void frame_times_add(frame_times *times, int64_t ns)
{
    const int64_t bin = ns / FRAME_BIN_NS;
    times->count++;
    times->max_ns = ns > times->max_ns ? ns : times->max_ns;
    times->bin[bin < 0 ? 0 : bin < FRAME_BINS ? bin : FRAME_BINS - 1]++;
}

double frame_times_ms(const frame_times *times, double share)
{
    const double rank = share * (double)times->count;
    uint64_t seen = 0;
    for (int i = 0; i < FRAME_BINS && times->count; i++) {
        seen += times->bin[i];
        if (seen && (double)seen >= rank)
            return fmin((i + 0.5) * FRAME_BIN_NS, (double)times->max_ns) * 1e-6;
    }
    return 0;
}
