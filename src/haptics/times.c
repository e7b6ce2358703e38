/* SPDX-License-Identifier: Apache-2.0 */
/* Implements histograms to which a tick can add durations. Adding a duration takes two divisions and the computation of
   an index, but no search and no floating-point arithmetic. */
#include <osteon/haptics.h>

void ost_times_add(ost_times *times, uint64_t ns)
{
    const uint64_t us = ns / 1000, ms = ns / 1000000;
    times->count++;
    times->max_ns = ns > times->max_ns ? ns : times->max_ns;
    if (us < OST_TIMES_BINS)
        times->us[us]++;
    else
        times->ms[ms < OST_TIMES_BINS ? ms : OST_TIMES_BINS - 1]++;
}

double ost_times_share_us(const ost_times *times, double share)
{
    const double max_us = (double)times->max_ns * 1e-3;
    uint64_t seen = 0;
    if (times->count == 0)
        return 0;
    for (int i = 0; i < 2 * OST_TIMES_BINS; i++) {
        const bool fine = i < OST_TIMES_BINS;
        seen += fine ? times->us[i] : times->ms[i - OST_TIMES_BINS];
        if ((double)seen >= share * (double)times->count) {
            const double end = fine ? i + 1 : (i - OST_TIMES_BINS + 1) * 1000.0;
            return end < max_us ? end : max_us;
        }
    }
    return max_us;
}
