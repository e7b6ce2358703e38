/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Measures the processor time that a thread used between two moments, and determines the causes of
 * missed deadlines from this time.
 *
 *   wall time  =  own work  +  time taken away (other threads, the hypervisor)
 *   an interval in which the thread waited voluntarily (slept, waited for a lock, read a file)
 *   counts as own work, because a tick must not wait
 *
 * If the kernel accounts for the stolen time of a virtual machine separately (Linux with
 * CONFIG_PARAVIRT_TIME_ACCOUNTING), a thread's processor time excludes the time that a hypervisor
 * took. On other systems, stolen time counts as own work, so own work is never underestimated.
 */
#ifndef OST_HAPTICS_THREAD_TIME_H
#define OST_HAPTICS_THREAD_TIME_H

#include <stdint.h>
#include <sys/resource.h>

#include "core/clock.h"

typedef struct thread_time {
    int64_t wall_ns, cpu_ns;
    long waits;
} thread_time;

/* Reads the times that the calling thread has used since it began. Takes about a microsecond. */
static inline thread_time thread_time_now(void)
{
    struct timespec cpu;
    thread_time now = {0};
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

static inline int64_t thread_time_between(const thread_time *from, const thread_time *to)
{
    const int64_t wall = to->wall_ns - from->wall_ns, cpu = to->cpu_ns - from->cpu_ns;
    return to->waits != from->waits || cpu > wall ? wall : cpu;
}

typedef enum missed_deadline { MISSED_BY_WORK, MISSED_WOKEN_LATE, MISSED_PREEMPTED } missed_deadline;

/*
 * Returns the cause of a missed deadline. If the tick's own work took more than half a period, this
 * work is the cause. Otherwise, if the loop was woken at least a period late, the late wake-up is
 * the cause; an idle loop would then have missed the deadline too. In all other cases, the cause is
 * that the thread was preempted.
 */
static inline missed_deadline classify_missed_deadline(int64_t own_ns, int64_t wake_ns, int64_t period_ns)
{
    if (own_ns > period_ns / 2)
        return MISSED_BY_WORK;
    return wake_ns >= period_ns ? MISSED_WOKEN_LATE : MISSED_PREEMPTED;
}

#endif
