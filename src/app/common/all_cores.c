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

/* A thread that cannot use more cores does the work on those that it has. */
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
