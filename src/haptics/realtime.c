/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Requests real-time scheduling. The code tries the following settings until one succeeds: SCHED_FIFO 80, SCHED_FIFO at
 * the highest priority that RLIMIT_RTPRIO allows, nice -11, and the default. In each case, the shortest timer slack is
 * set. Processes and threads created by this thread get default scheduling (SCHED_RESET_ON_FORK). Otherwise OpenMP's
 * workers and the drivers' threads would compete with the loop that uses them.
 *
 * Memory is locked so that no tick waits for a page. If the amount of locked memory is not limited, later allocations
 * are locked too. If the amount is limited, they are not locked, because locking could make them fail.
 *
 * If a core is reserved for the loop, it is the last core, because most interrupts are handled by the first cores.
 */
#include "haptics/realtime.h"

#include <errno.h>
#include <sched.h>
#include <stdio.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

enum { PRIORITY = 80, NICE_VALUE = -11, STACK = 256 * 1024 };

static bool fifo(int priority)
{
    const struct sched_param param = {.sched_priority = priority};
    return sched_setscheduler(0, SCHED_FIFO | SCHED_RESET_ON_FORK, &param) == 0;
}

static void schedule(realtime_before *before, ost_realtime *out)
{
    struct sched_param param;
    struct rlimit limit;
    const id_t thread = (id_t)syscall(SYS_gettid);
    before->policy = sched_getscheduler(0);
    before->priority = sched_getparam(0, &param) == 0 ? param.sched_priority : 0;
    errno = 0;
    before->nice = getpriority(PRIO_PROCESS, thread);
    if (fifo(PRIORITY)) {
        before->scheduled = true;
        snprintf(out->scheduling, sizeof out->scheduling, "SCHED_FIFO %d", PRIORITY);
        return;
    }
    const int refused = errno;
    if (getrlimit(RLIMIT_RTPRIO, &limit) == 0 && limit.rlim_cur > 0) {
        const int allowed = limit.rlim_cur < PRIORITY ? (int)limit.rlim_cur : PRIORITY;
        if (fifo(allowed)) {
            before->scheduled = true;
            snprintf(out->scheduling, sizeof out->scheduling, "SCHED_FIFO %d, which is the limit (rtprio)", allowed);
            return;
        }
    }
    if (setpriority(PRIO_PROCESS, thread, NICE_VALUE) == 0) {
        before->niced = true;
        snprintf(out->scheduling, sizeof out->scheduling, "nice %d; no SCHED_FIFO: %s", NICE_VALUE, strerror(refused));
        return;
    }
    snprintf(out->scheduling, sizeof out->scheduling, "plain; no SCHED_FIFO: %s (limits.d: rtprio 80)",
             strerror(refused));
}

static void lock_memory(realtime_before *before, ost_realtime *out)
{
    struct rlimit limit;
    const bool unlimited = geteuid() == 0 ||
                           (getrlimit(RLIMIT_MEMLOCK, &limit) == 0 && limit.rlim_cur == RLIM_INFINITY);
    before->locked = mlockall(unlimited ? MCL_CURRENT | MCL_FUTURE : MCL_CURRENT) == 0;
    if (before->locked)
        snprintf(out->memory, sizeof out->memory, "locked");
    else
        snprintf(out->memory, sizeof out->memory, "not locked: %s (limits.d: memlock unlimited)", strerror(errno));
}

/* Accesses the stack, so that its pages are mapped before the first tick. */
static void touch_stack(void)
{
    volatile unsigned char stack[STACK];
    for (size_t i = 0; i < STACK; i += 4096)
        stack[i] = 1;
    (void)stack[0];
}

int ost_servo_core(void)
{
    cpu_set_t set;
    if (sched_getaffinity(0, sizeof set, &set) != 0 || CPU_COUNT(&set) < 2)
        return -1;
    int last = CPU_SETSIZE - 1;
    while (!CPU_ISSET(last, &set))
        last--;
    return last;
}

bool ost_servo_core_leave(int core)
{
    cpu_set_t set;
    if (core < 0 || core >= CPU_SETSIZE || sched_getaffinity(0, sizeof set, &set) != 0)
        return false;
    CPU_CLR(core, &set);
    return CPU_COUNT(&set) > 0 && sched_setaffinity(0, sizeof set, &set) == 0;
}

static void pin(int core, realtime_before *before, ost_realtime *out)
{
    cpu_set_t own;
    if (core < 0) {
        snprintf(out->core, sizeof out->core, "any");
        return;
    }
    CPU_ZERO(&own);
    if (core < CPU_SETSIZE)
        CPU_SET(core, &own);
    if (sched_getaffinity(0, sizeof before->cores, &before->cores) == 0 &&
        sched_setaffinity(0, sizeof own, &own) == 0) {
        before->pinned = true;
        snprintf(out->core, sizeof out->core, "core %d", core);
    } else {
        snprintf(out->core, sizeof out->core, "any, not core %d alone: %s", core, strerror(errno));
    }
}

void ost_realtime_enter(bool request, int core, realtime_before *before, ost_realtime *out)
{
    *before = (realtime_before){0};
    pin(core, before, out);
    if (!request) {
        snprintf(out->scheduling, sizeof out->scheduling, "as it was");
        snprintf(out->memory, sizeof out->memory, "as it was");
        return;
    }
    schedule(before, out);
    const int slack = prctl(PR_GET_TIMERSLACK);
    before->slack_ns = slack > 0 ? (unsigned long)slack : 0;
    before->slack = prctl(PR_SET_TIMERSLACK, 1UL) == 0;
    lock_memory(before, out);
    touch_stack();
}

void ost_realtime_leave(const realtime_before *before)
{
    if (before->scheduled) {
        const struct sched_param param = {.sched_priority = before->priority};
        sched_setscheduler(0, before->policy < 0 ? SCHED_OTHER : before->policy, &param);
    }
    if (before->niced)
        setpriority(PRIO_PROCESS, (id_t)syscall(SYS_gettid), before->nice);
    if (before->slack)
        prctl(PR_SET_TIMERSLACK, before->slack_ns);
    if (before->locked)
        munlockall();
    if (before->pinned)
        sched_setaffinity(0, sizeof before->cores, &before->cores);
}
