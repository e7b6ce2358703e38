/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Starts a background thread in which all signals are blocked. The threads that it starts inherit the blocked signals.
 * All signals are thus delivered to the main thread, which can end the operation.
 */
#ifndef OST_IO_THREAD_H
#define OST_IO_THREAD_H

#include <pthread.h>
#include <signal.h>

/* Starts a thread that calls work(user). Returns 0 or an error number, as pthread_create does. */
static inline int ost_thread_begin(pthread_t *thread, void *(*work)(void *), void *user)
{
    sigset_t all, before;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before);
    const int error = pthread_create(thread, NULL, work, user);
    pthread_sigmask(SIG_SETMASK, &before, NULL);
    return error;
}

#endif
