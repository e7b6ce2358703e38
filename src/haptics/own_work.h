/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What a thread did itself between two moments, and what was done to it.
 *
 *   wall time  =  own work  +  taken away (other threads, the hypervisor)
 *   of a time in which it waited by its own will (slept, met a lock, read a
 *   file), all counts as its own: a tick must not wait
 *
 * The processor time of a thread leaves out what a hypervisor took where the
 * kernel keeps a virtual machine's stolen time apart (Linux with
 * CONFIG_PARAVIRT_TIME_ACCOUNTING); elsewhere that counts as the thread's own,
 * so own work is never told too small.
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

/* The calling thread's, since it began; about a microsecond. */
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
 * Why a tick was not done in time: what it did itself if that was more than
 * half a period; else being woken a period late or more, which a loop that
 * does nothing would have been too; else that its core was taken away.
 */
static inline own_blame own_work_blame(int64_t own_ns, int64_t wake_ns, int64_t period_ns)
{
    if (own_ns > period_ns / 2)
        return OWN_BLAME_WORK;
    return wake_ns >= period_ns ? OWN_BLAME_WOKEN_LATE : OWN_BLAME_TAKEN;
}

#endif
