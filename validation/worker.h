/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Runs a backend in a separate process, the worker. A driver may install signal handlers, change the
 * rounding of floats, crash or hang. This affects only the worker in which the driver runs, and the results
 * that the worker had already computed are in its trace.
 *
 *   worker_start --exec--> osteon validate --worker SPEC --trace FILE ... --worker_run--> trace
 *        |                                                                         |
 *   worker_wait_any: way in which it ended <---------------------------------------'
 *
 * If the parent process ends for any reason, its workers also end.
 */
#ifndef OST_VALIDATION_WORKER_H
#define OST_VALIDATION_WORKER_H

#include <stdbool.h>
#include <sys/types.h>

#include "validation/plan.h"

/* Called in the worker. Runs the cases [from, to) of the plan on the backend `spec`, and writes a line to stderr for
   each stage that fails. If `given` is NULL, the input of a stage is the result of the previous stage. If `given` is
   not NULL, it is the path of the reference's trace of these cases, and every stage gets its input from the grids in
   that trace (perform_apart). */
ost_status worker_run(const plan *p, int from, int to, const char *spec, const char *trace_path, const char *given,
                      ost_error *err);

typedef enum worker_end {
    WORKER_DONE,
    WORKER_FAILED,  /* the exit status was not 0; `text` is the last line that the worker wrote to stderr */
    WORKER_CRASHED, /* a signal ended the worker */
    WORKER_LATE     /* the worker was killed because it exceeded its time limit */
} worker_end;

typedef struct worker_result {
    worker_end end;
    int code;        /* exit status or signal */
    double seconds;
    char text[512];  /* the last line that the worker wrote to stderr */
} worker_result;

typedef struct worker {
    pid_t pid;
    int stderr_fd;   /* read end of a pipe from the worker's stderr */
    double begun, limit_s;
    bool complete;   /* true if the line in `text` is complete */
    size_t used;
    char text[512];  /* the last line that the worker wrote to stderr, cut off after 511 bytes */
} worker;

/* Exit status of a worker that could not allocate memory or open a descriptor or a file. No verdict on the backend
   follows from such a run. */
enum { WORKER_EXIT_RESOURCES = 4 };
enum { WORKERS_MAX = 128 }; /* maximum number of workers per call of worker_wait_any */
/* the worker's file descriptors for its trace and for the store of the user's cases */
enum { WORKER_TRACE = 3, WORKER_USER = 4 };

/* Writes the path of this program's file, which is passed to workers as argv[0]. */
ost_status worker_program(char path[], size_t size, ost_error *err);
/* Starts a worker. argv ends with NULL; argv[0] is the program's file. trace_fd and user_fd become the worker's
   descriptors WORKER_TRACE and WORKER_USER; -1 means none. worker_wait_any kills the worker after limit_s seconds. */
ost_status worker_start(char *const argv[], int trace_fd, int user_fd, double limit_s, worker *out, ost_error *err);
/* Waits until one of the workers ends or exceeds its time limit. Sets *which to this worker's index. The other
   workers continue. */
ost_status worker_wait_any(worker *const workers[], int count, int *which, worker_result *out, ost_error *err);
ost_status worker_wait(worker *w, worker_result *out, ost_error *err);
/* Kills the worker and waits until it has ended. */
void worker_stop(worker *w);

#endif
