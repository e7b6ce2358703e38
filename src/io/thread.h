/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Starts a background thread with all signals blocked, both in this thread and in
 * the threads that it or a library starts from it. Signals are thus delivered to
 * the main thread, which can end the operation.
 */
#ifndef OST_IO_THREAD_H
#define OST_IO_THREAD_H

#include <pthread.h>
#include <signal.h>

/* Returns 0 or an error number, as pthread_create does. */
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
