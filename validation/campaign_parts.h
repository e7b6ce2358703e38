/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The state of a running campaign. At most ALIVE batches of cases are open at
 * a time, each with the reference's trace and one task per backend.
 *
 *   campaign.c           chooses the next task, until every batch is done
 *   campaign_worker.c    starts the worker of the task; reads the trace that the worker wrote
 *   campaign_results.c   compares the trace with the reference's
 *   campaign_dump.c      reads a folder of grids (a dump) instead of running a worker
 *   campaign_batch.c     begins and ends a batch; locates the differences at the end of a batch
 */
#ifndef OST_VALIDATION_CAMPAIGN_PARTS_H
#define OST_VALIDATION_CAMPAIGN_PARTS_H

#include "validation/campaign.h"
#include "validation/verdict.h"

/* A trace with at least one difference. It is kept until its batch is freed. */
typedef struct stored_trace {
    int subject_index, from, judged;
    trace got;
    struct stored_trace *next;
} stored_trace;

/* The cases of a batch that a backend has not completed yet. */
typedef struct task {
    int from; /* next case to run; equal to the end of the batch when all cases are done */
    bool running;
} task;

typedef struct batch {
    int first, end;
    /* `open` is true if the batch has begun; `ready` is true if the reference has run all cases of the batch */
    bool open, ready;
    trace reference;
    /*
     * descriptor of the reference's trace, which the workers of the other backends read; -1 if options->apart is
     * false
     */
    int given;
    task *tasks;      /* owned; one per subject */
    stored_trace *stored_traces;
} batch;

typedef struct slot {
    worker w;
    int batch, subject_index, trace; /* batch, index of the backend, and file descriptor of the worker's trace */
} slot;

/* Maximum number of open batches. While the oldest open batch is compared, the reference already runs the next ones,
   so that a slow case of the reference does not delay the other backends. */
enum { ALIVE = 4 };
enum { NOBODY = -1 };

typedef struct runner {
    campaign *c;
    const campaign_options *o;
    /*
     * total number of batches, number of batches begun, and number of batches done; the batches [done, begun) are open
     */
    int batches, begun, done;
    batch alive[ALIVE];       /* the open batches; batch n is element n % ALIVE */
    int *ends;                /* owned; for each batch, the index after its last case */
    /* owned; for each backend, true if it failed permanently, so that no more workers are started */
    bool *gone;
    /* owned; for each backend that failed permanently, the result of all its remaining cases */
    case_result *last_words;
    slot slots[WORKERS_MAX];
    int running, finished;    /* number of running workers, and of completed pairs of case and backend */
    int judged;               /* index of the backend whose trace is being judged, or NOBODY */
} runner;

/* ---- campaign_batch.c */

/* Returns a batch by its number, which must be in [done, begun). */
batch *batch_of(runner *r, int number);
/* Opens the next batch and creates its tasks. Cases of backends that are not available are judged as not run. */
ost_status batch_begin(runner *r, ost_error *err);
/* Moves a trace with differences from *got to the batch, and leaves *got empty. */
ost_status batch_store_trace(batch *b, int subject_index, int from, int judged, trace *got, ost_error *err);
/* Returns true if all backends have completed an open batch. */
bool batch_is_done(const runner *r, const batch *b);
/* Ends the oldest batch. Calls options->differs for each difference and then options->done, and frees the traces. */
ost_status batch_end(runner *r, ost_error *err);
void batch_free(batch *b);

/* ---- campaign_worker.c */

/* Starts a worker for the cases of a batch that a backend has not completed. */
ost_status runner_start(runner *r, int number, int subject_index, ost_error *err);
/* Removes slot number `which` after its worker ended with the result *end, and returns the slot's content. The task
   counts as running until runner_judge is called. */
slot runner_take(runner *r, int which, const worker_result *end);
/* Reads, judges and closes the trace of a worker that has ended. */
ost_status runner_judge(runner *r, const slot *ended, const worker_result *end, ost_error *err);

/* ---- campaign_results.c */

/*
 * Stores the results of the reference. If the reference did not finish, nothing can be compared, and the function
 * fails.
 */
ost_status results_of_reference(runner *r, batch *b, trace *got, const worker_result *end, ost_error *err);
/* Stores the verdicts of the cases in a backend's trace. If the worker ended prematurely, also stores a verdict for
   the case that it was running. */
ost_status results_of_subject(runner *r, batch *b, int subject_index, trace *got, const worker_result *end,
                              ost_error *err);
/* Judges cases [from, until) of a backend's trace. Sets *judged to the number of these cases that are complete in the
   trace. */
ost_status results_judge(runner *r, const batch *b, int subject_index, const trace *got, int from, int until,
                         int *judged, bool *differs, ost_error *err);

/* ---- campaign_dump.c */

/* Returns the folder of a backend that is a dump; NULL for any other backend. */
const char *dump_of(const campaign *c, int subject_index);
/* Checks that every dump contains results of this campaign's cases. */
ost_status dumps_check(const campaign *c, ost_error *err);
/* Judges a dump in place of a worker, and stores the verdicts of a batch. */
ost_status dump_to_results(runner *r, batch *b, int subject_index, ost_error *err);

#endif
