/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A thread that owns the OpenGL context and executes functions for other threads, which wait for the results.
 *
 * A context is current on one thread at a time, and a thread has one current context. The main thread may already have
 * a window's context, and libglvnd does not allow a second context of a different type on the same thread. With a
 * worker, any thread can draw.
 */
#ifndef OST_RENDER_GL_WORKER_H
#define OST_RENDER_GL_WORKER_H

#include <osteon/status.h>

typedef struct ost_gl_worker ost_gl_worker;
typedef ost_status ost_gl_work(void *user, ost_error *err);

ost_status ost_gl_worker_start(ost_gl_worker **out, ost_error *err);
void ost_gl_worker_stop(ost_gl_worker *worker); /* accepts NULL */
/* Executes work on the worker's thread, or on the calling thread if there is no worker, and waits for its result.
   Must not be called by several threads at once. */
ost_status ost_gl_worker_do(ost_gl_worker *worker, ost_gl_work *work, void *user, ost_error *err);

#endif
