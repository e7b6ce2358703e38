/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A thread that owns the context and executes functions for other threads, which wait for the
 * result.
 *
 * A context belongs to one thread, and a thread can have only one context. The main thread already has a window's
 * context, and libglvnd does not allow a second context of a different type on the same thread. Because the worker owns
 * the context, any thread can draw.
 */
#ifndef OST_RENDER_GL_WORKER_H
#define OST_RENDER_GL_WORKER_H

#include <osteon/status.h>

typedef struct ost_gl_worker ost_gl_worker;
typedef ost_status ost_gl_work(void *user, ost_error *err);

ost_status ost_gl_worker_start(ost_gl_worker **out, ost_error *err);
void ost_gl_worker_stop(ost_gl_worker *worker); /* accepts NULL */
/* Executes work on the worker's thread and waits for its result. Without a worker, executes the work on the calling
   thread. Must be called by only one thread at a time. */
ost_status ost_gl_worker_do(ost_gl_worker *worker, ost_gl_work *work, void *user, ost_error *err);

#endif
