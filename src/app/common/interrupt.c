/* SPDX-License-Identifier: Apache-2.0 */
#include "app/common/interrupt.h"

#include <signal.h>
#include <stdatomic.h>
#include <stddef.h>

enum { SIGNALS = 3 };
static const int signals[SIGNALS] = {SIGINT, SIGTERM, SIGHUP};
static struct sigaction usual[SIGNALS];
/* This flag is set by a signal handler or by the thread of a window. The thread of the servo loop reads it. */
static atomic_int requested;
_Static_assert(ATOMIC_INT_LOCK_FREE == 2, "a handler may set it");

static void on_signal(int number)
{
    atomic_store(&requested, 1);
    /* The previous dispositions are restored, so that a second signal terminates the process. */
    for (int i = 0; i < SIGNALS; i++)
        if (signals[i] == number)
            sigaction(number, &usual[i], NULL);
}

void interrupt_begin(void)
{
    struct sigaction action = {.sa_handler = on_signal};
    sigemptyset(&action.sa_mask);
    atomic_store(&requested, 0);
    for (int i = 0; i < SIGNALS; i++)
        /* A signal that was ignored at the start, for example by nohup, remains ignored. */
        if (sigaction(signals[i], NULL, &usual[i]) == 0 && usual[i].sa_handler != SIG_IGN)
            sigaction(signals[i], &action, NULL);
}

void interrupt_end(void)
{
    for (int i = 0; i < SIGNALS; i++)
        sigaction(signals[i], &usual[i], NULL);
}

void interrupt_request(void)
{
    atomic_store(&requested, 1);
}

bool interrupt_requested(void)
{
    return atomic_load(&requested) != 0;
}
