/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A backend in a process of its own.  A driver may install signal handlers,
 * change how floats are rounded, crash or hang; it does so alone, and what it
 * had made until then is in its trace.
 *
 *   worker_start --exec--> osteon validate --worker SPEC --trace FILE ... --worker_run--> trace
 *        |                                                                         |
 *   worker_wait_any: how it ended <------------------------------------------------'
 *
 * A worker ends with its parent, whatever ended that.
 */
#ifndef OST_VALIDATION_WORKER_H
#define OST_VALIDATION_WORKER_H

#include <stdbool.h>
#include <sys/types.h>

#include "validation/plan.h"

/* In the worker: cases of the plan [from, to) on the backend of this spec; lines about failed stages go to stderr.
   given: the reference's trace of them, whose grids every stage gets (perform_apart); NULL: each gets what the one before it made. */
ost_status worker_run(const plan *p, int from, int to, const char *spec, const char *trace_path, const char *given, ost_error *err);

typedef enum worker_end {
    WORKER_DONE,
    WORKER_FAILED,  /* exit status not 0: what it said is in text */
    WORKER_CRASHED, /* ended by a signal */
    WORKER_LATE     /* stopped after its time */
} worker_end;

typedef struct worker_result {
    worker_end end;
    int code;        /* exit status or signal */
    double seconds;
    char text[512];  /* the last line it said */
} worker_result;

typedef struct worker {
    pid_t pid;
    int said;        /* its stderr, a pipe */
    double begun, limit_s;
    bool complete;   /* the line in text has ended */
    size_t used;
    char text[512];  /* the last whole line of what it says; only so much is kept */
} worker;

/* Exit status of a worker that got no memory, descriptor or file: it says nothing about a backend. */
enum { WORKER_EXIT_RESOURCES = 4 };
enum { WORKERS_MAX = 128 }; /* waited for together */
enum { WORKER_TRACE = 3, WORKER_USER = 4 }; /* the worker's descriptors of its trace and of the user's own cases (user_store.h) */

/* This program's own file, for argv[0]. */
ost_status worker_program(char path[], size_t size, ost_error *err);
/* argv ends with NULL; argv[0] is the program's file. trace_fd, user_fd: descriptors that the worker has as those above, or -1. It is stopped after limit seconds. */
ost_status worker_start(char *const argv[], int trace_fd, int user_fd, double limit_s, worker *out, ost_error *err);
/* Waits until one of them ends; the others go on. */
ost_status worker_wait_any(worker *const workers[], int count, int *which, worker_result *out, ost_error *err);
ost_status worker_wait(worker *w, worker_result *out, ost_error *err);
/* Ends it, whatever it is at. */
void worker_stop(worker *w);

#endif
