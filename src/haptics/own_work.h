/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Measures the processor time that a thread used between two moments, and
 * classifies missed deadlines by it.
 *
 *   wall time  =  own work  +  time taken away (other threads, the hypervisor)
 *   an interval in which the thread waited voluntarily (slept, waited for a
 *   lock, read a file) counts completely as own work: a tick must not wait
 *
 * Where the kernel accounts for a virtual machine's stolen time separately
 * (Linux with CONFIG_PARAVIRT_TIME_ACCOUNTING), a thread's processor time
 * excludes the time that a hypervisor took.  Elsewhere stolen time counts as own
 * work, so own work is never reported too small.
 */
#ifndef OST_HAPTICS_OWN_WORK_H
#define OST_HAPTICS_OWN_WORK_H

#include <stdint.h>
#include <sys/resource.h>

#include "core/clock.h"

typedef struct own_work {
    int64_t wall_ns, cpu_ns;
    long waits;
} own_work;

/* Reads the calling thread's times since the thread began; takes about a microsecond. */
static inline own_work own_work_now(void)
{
    struct timespec cpu;
    own_work now = {0};
#ifdef RUSAGE_THREAD
    struct rusage usage;
    if (getrusage(RUSAGE_THREAD, &usage) == 0)
        now.waits = usage.ru_nvcsw;
#endif
    if (clock_gettime(CLOCK_THREAD_CPUTIME_ID, &cpu) == 0)
        now.cpu_ns = cpu.tv_sec * INT64_C(1000000000) + cpu.tv_nsec;
    now.wall_ns = ost_clock_ns();
    return now;
}

static inline int64_t own_work_between(const own_work *from, const own_work *to)
{
    const int64_t wall = to->wall_ns - from->wall_ns, cpu = to->cpu_ns - from->cpu_ns;
    return to->waits != from->waits || cpu > wall ? wall : cpu;
}

typedef enum own_blame { OWN_BLAME_WORK, OWN_BLAME_WOKEN_LATE, OWN_BLAME_TAKEN } own_blame;

/*
 * Returns the cause of a missed deadline.  It is the tick's own work if that
 * took more than half a period.  Otherwise it is late wake-up if the loop was
 * woken a period late or more: an idle loop would have missed the deadline too.
 * Otherwise the core was taken away.
 */
static inline own_blame own_work_blame(int64_t own_ns, int64_t wake_ns, int64_t period_ns)
{
    if (own_ns > period_ns / 2)
        return OWN_BLAME_WORK;
    return wake_ns >= period_ns ? OWN_BLAME_WOKEN_LATE : OWN_BLAME_TAKEN;
}

#endif
