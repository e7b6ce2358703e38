/* SPDX-License-Identifier: Apache-2.0 */
#include "app/common/all_cores.h"

#include <sched.h>
#include <stdbool.h>

#include "io/thread.h"

static struct {
    cpu_set_t set;
    bool known;
} cores;

typedef struct task {
    void (*work)(void *user);
    void *user;
} task;

void all_cores_begin(void)
{
    cores.known = sched_getaffinity(0, sizeof cores.set, &cores.set) == 0;
}

/* If sched_setaffinity fails, the work is done on the cores on which the thread may already run. */
static void *run(void *user)
{
    const task *t = user;
    if (cores.known)
        (void)sched_setaffinity(0, sizeof cores.set, &cores.set);
    t->work(t->user);
    return NULL;
}

void all_cores_do(void (*work)(void *user), void *user)
{
    task t = {work, user};
    pthread_t thread;
    if (ost_thread_begin(&thread, run, &t) == 0)
        pthread_join(thread, NULL);
    else
        work(user);
}
