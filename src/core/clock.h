/* SPDX-License-Identifier: Apache-2.0 */
/* Time that only goes forward, in ns from a start of its own; any thread. */
#ifndef OST_CORE_CLOCK_H
#define OST_CORE_CLOCK_H

#include <stdint.h>
#include <time.h>

static inline int64_t ost_clock_ns(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return t.tv_sec * INT64_C(1000000000) + t.tv_nsec;
}

#endif
