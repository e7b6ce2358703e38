/* SPDX-License-Identifier: Apache-2.0 */
#include "render/gl/worker.h"

#include <pthread.h>
#include <signal.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

struct ost_gl_worker {
    pthread_t thread;
    pthread_mutex_t mutex;
    pthread_cond_t changed;
    ost_gl_work *work; /* function to execute; NULL while idle */
    void *user;
    ost_error *err;
    ost_status status;
    bool stop;
};

static void *run_jobs(void *user)
{
    ost_gl_worker *w = user;
    pthread_mutex_lock(&w->mutex);
    for (;;) {
        while (!w->work && !w->stop)
            pthread_cond_wait(&w->changed, &w->mutex);
        if (!w->work)
            break;
        w->status = w->work(w->user, w->err);
        w->work = NULL;
        pthread_cond_broadcast(&w->changed);
    }
    pthread_mutex_unlock(&w->mutex);
    return NULL;
}

ost_status ost_gl_worker_start(ost_gl_worker **out, ost_error *err)
{
    sigset_t all, before;
    *out = NULL;
    ost_gl_worker *w = calloc(1, sizeof *w);
    if (!w)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for OpenGL's thread");
    pthread_mutex_init(&w->mutex, NULL);
    pthread_cond_init(&w->changed, NULL);
    /* The worker blocks all signals, so that other threads handle them. Threads that a driver starts inherit this
       mask. */
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before);
    const int error = pthread_create(&w->thread, NULL, run_jobs, w);
    pthread_sigmask(SIG_SETMASK, &before, NULL);
    if (error) {
        pthread_mutex_destroy(&w->mutex);
        pthread_cond_destroy(&w->changed);
        free(w);
        return ost_fail(err, OST_ERR_UNAVAILABLE, "cannot create a thread for OpenGL: %s", strerror(error));
    }
    *out = w;
    return OST_OK;
}

void ost_gl_worker_stop(ost_gl_worker *worker)
{
    if (!worker)
        return;
    pthread_mutex_lock(&worker->mutex);
    worker->stop = true;
    pthread_cond_broadcast(&worker->changed);
    pthread_mutex_unlock(&worker->mutex);
    pthread_join(worker->thread, NULL);
    pthread_mutex_destroy(&worker->mutex);
    pthread_cond_destroy(&worker->changed);
    free(worker);
}

ost_status ost_gl_worker_do(ost_gl_worker *w, ost_gl_work *work, void *user, ost_error *err)
{
    if (!w)
        return work(user, err);
    pthread_mutex_lock(&w->mutex);
    w->work = work;
    w->user = user;
    w->err = err;
    pthread_cond_broadcast(&w->changed);
    while (w->work)
        pthread_cond_wait(&w->changed, &w->mutex);
    const ost_status status = w->status;
    pthread_mutex_unlock(&w->mutex);
    return status;
}
