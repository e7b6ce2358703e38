/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A backend in a process of its own.  A driver may install signal handlers,
 * change how floats are rounded, crash or hang; it does so alone, and what it
 * had made until then is in its trace.
 *
 *   worker_start --exec--> osteon validate --worker SPEC --trace FILE ... --worker_run--> trace
 *        |                                                                         |
 *   worker_wait: how it ended <-----------------------------------------------------'
 */
#ifndef OST_VALIDATION_WORKER_H
#define OST_VALIDATION_WORKER_H

#include <sys/types.h>

#include "validation/plan.h"

/* In the worker: cases of the plan from number `from` on, on the backend of this spec; lines about failed stages go to stderr. */
ost_status worker_run(const plan *p, int from, const char *spec, const char *trace_path, ost_error *err);

typedef enum worker_end {
    WORKER_DONE,
    WORKER_FAILED,  /* exit status not 0: what it said is in text */
    WORKER_CRASHED, /* ended by a signal */
    WORKER_LATE     /* stopped after its time */
} worker_end;

typedef struct worker {
    pid_t pid;
    int said;        /* its stderr, a pipe */
} worker;

typedef struct worker_result {
    worker_end end;
    int code;        /* exit status or signal */
    double seconds;
    char text[512];  /* the last line it said */
} worker_result;

/* argv ends with NULL; argv[0] is the program's file. */
ost_status worker_start(char *const argv[], worker *out, ost_error *err);
/* Stops it after limit seconds. */
ost_status worker_wait(worker *w, double limit_s, worker_result *out, ost_error *err);

#endif
