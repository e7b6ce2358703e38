/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A thread beside the one that people talk to: signals are for that one, which
 * can end what goes on, so every signal is blocked in this one and in those
 * that it, or a library in it, starts.
 */
#ifndef OST_IO_THREAD_H
#define OST_IO_THREAD_H

#include <pthread.h>
#include <signal.h>

/* As pthread_create: 0, or the error. */
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
