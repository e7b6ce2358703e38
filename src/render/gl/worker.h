/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A thread that has the context, and does what others ask while they wait.
 *
 * A context belongs to a thread, and a thread has one: beside a window, whose
 * own context the main thread has, EGL gives none (libglvnd refuses a second
 * kind).  So who draws and who looks may be anybody.
 */
#ifndef OST_RENDER_GL_WORKER_H
#define OST_RENDER_GL_WORKER_H

#include <osteon/status.h>

typedef struct ost_gl_worker ost_gl_worker;
typedef ost_status ost_gl_work(void *user, ost_error *err);

ost_status ost_gl_worker_start(ost_gl_worker **out, ost_error *err);
void ost_gl_worker_stop(ost_gl_worker *worker); /* NULL is allowed */
/* By the worker; one at a time. */
ost_status ost_gl_worker_do(ost_gl_worker *worker, ost_gl_work *work, void *user, ost_error *err);

#endif
