/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A campaign while it runs: a few batches of cases are alive at a time, each
 * with the reference's trace and one task a backend.
 *
 *   campaign.c           chooses the next task, until every batch is done
 *   campaign_worker.c    starts its worker; reads the trace that it left
 *   campaign_results.c   judges the trace against the reference's
 *   campaign_dump.c      reads a folder of grids in a worker's place
 *   campaign_batch.c     begins a batch; ends it, and lets its differences be located
 */
#ifndef OST_VALIDATION_CAMPAIGN_PARTS_H
#define OST_VALIDATION_CAMPAIGN_PARTS_H

#include "validation/campaign.h"
#include "validation/verdict.h"

/* A trace of one worker in which something differs; it is freed with its batch. */
typedef struct kept_trace {
    int whom, from, judged;
    trace got;
    struct kept_trace *next;
} kept_trace;

/* The cases of a batch that one backend has not done yet. */
typedef struct task {
    int from; /* next case; the batch's end when all are done */
    bool running;
} task;

typedef struct batch {
    int first, end; /* cases */
    bool open, ready; /* begun; the reference is done */
    trace reference;
    int given;         /* apart: its descriptor, for the workers of the others; else -1 */
    task *tasks;      /* owned; of each subject */
    kept_trace *kept;
} batch;

typedef struct slot {
    worker w;
    int batch, whom, trace; /* trace: its descriptor */
} slot;

enum { ALIVE = 2 }; /* batches at a time: one that is compared, and the next one's reference */

/* The state of one run. */
typedef struct runner {
    campaign *c;
    const campaign_options *o;
    int batches, begun, done; /* of all batches: those from done to begun are alive */
    batch alive[ALIVE];       /* number n at n % ALIVE */
    int *ends;                /* owned; where each batch ends */
    bool *gone;               /* owned; backends that failed for good: the rest of their cases is judged */
    case_result *last_words;  /* owned; of those */
    slot slots[WORKERS_MAX];
    int running, finished;    /* workers; cells of cases and backends */
} runner;

/* ---- campaign_batch.c */

/* Returns the batch of this number, which is alive. */
batch *batch_of(runner *r, int number);
/* Opens the next batch: its tasks, with the cases of absent backends already judged as not run. */
ost_status batch_begin(runner *r, ost_error *err);
/* Takes a trace over, in which cases of a backend differ, and leaves *got empty. */
ost_status batch_keep_trace(batch *b, int whom, int from, int judged, trace *got, ost_error *err);
/* Returns true if every task of an open batch is done. */
bool batch_is_done(const runner *r, const batch *b);
/* Ends the oldest batch: options->differs for each difference, options->done, then its traces are freed. */
ost_status batch_end(runner *r, ost_error *err);
void batch_free(batch *b);

/* ---- campaign_worker.c */

/* Starts a worker for the rest of a backend's cases in a batch. */
ost_status runner_start(runner *r, int number, int whom, ost_error *err);
/* Takes the trace and the end of the worker in slot `which`, and frees the slot. */
ost_status runner_ended(runner *r, int which, const worker_result *end, ost_error *err);

/* ---- campaign_results.c */

/* Enters what the reference made; it fails if the reference did not finish, since nothing can be compared then. */
ost_status results_of_reference(runner *r, batch *b, trace *got, const worker_result *end, ost_error *err);
/* Enters the verdicts of a backend's trace and, where it ended before its time, of the case in which it ended. */
ost_status results_of_subject(runner *r, batch *b, int whom, trace *got, const worker_result *end, ost_error *err);
/* Judges cases [from, until) of a backend's trace; *judged receives how many of them it has complete. */
ost_status results_judge(runner *r, const batch *b, int whom, const trace *got, int from, int until, int *judged, bool *differs,
                         ost_error *err);

/* ---- campaign_dump.c */

/* Returns the folder of a subject that is a dump, else NULL. */
const char *dump_of(const campaign *c, int whom);
/* Checks that every dump was made of this campaign's cases. */
ost_status dumps_check(const campaign *c, ost_error *err);
/* Enters the verdicts of a batch from a dump, which needs no worker. */
ost_status dump_to_results(runner *r, batch *b, int whom, ost_error *err);

#endif
