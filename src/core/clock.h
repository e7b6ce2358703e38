/* SPDX-License-Identifier: Apache-2.0 */
/* The monotonic clock, in nanoseconds since an arbitrary start. Any thread may read it. */
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
