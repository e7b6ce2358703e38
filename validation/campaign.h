/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A campaign runs every case of a plan on every backend, each backend in its own process. Each trace is compared with
 * the reference's trace by memcmp.
 *
 *   plan, subjects --campaign_run--> results[case][subject], counts and times
 *
 * The cases run in batches, which limits the number of traces on the disk. In each batch the reference runs first,
 * then the other backends, up to `jobs` workers at a time. Meanwhile, the reference runs the next batch.
 *
 *   batch 0   ref | avx2, scalar, cl ...            --batch done--> evidence of its cases
 *   batch 1         ref | ...                       then its traces are deleted
 *
 * A backend whose process crashes is started again with the case after the one in which it crashed. A backend that
 * fails or exceeds its time limit is not started again, and its remaining cases get the same verdict.
 */
#ifndef OST_VALIDATION_CAMPAIGN_H
#define OST_VALIDATION_CAMPAIGN_H

#include <time.h>

#include <osteon/digest.h>

#include "validation/locate/finding.h"
#include "validation/margin.h"
#include "validation/paths.h"
#include "validation/plan.h"
#include "validation/subjects.h"
#include "validation/worker.h"

typedef enum case_verdict {
    CASE_EQUAL,
    CASE_DIFFERS,
    CASE_FAILED,  /* a stage failed on this backend but not on the reference; `text` contains the error line */
    CASE_CRASHED, /* a signal other than SIGKILL ended the worker; SIGKILL from outside makes the campaign fail */
    CASE_LATE,
    CASE_NOT_RUN, /* the machine or the build does not have this backend */
    CASE_VERDICTS
} case_verdict;

const char *case_verdict_name(case_verdict verdict);

typedef struct case_result {
    case_verdict verdict;
    compare_difference difference; /* valid if verdict is CASE_DIFFERS */
    margins *margins;              /* owned; set if verdict is CASE_DIFFERS and margins were measured, otherwise NULL */
    /* number of records of the stages `snap` and `steps` that the backend computed with its own code */
    uint32_t own_steps;
    /* owned; details of the difference, or NULL */
    finding *found;
    char text[200];
    /* SHA-256 of the backend's digest lines for the case (digests_of_case); valid if has_made is true */
    ost_digest made;
    /* true if the backend's trace contains the case, so that the verdict is equal, differs or failed */
    bool has_made;
    /* running time of the backend in this case, including the time to generate the case's input; 0 if not measured */
    double seconds;
    char *lines;     /* owned; digest lines; NULL if has_made is false or the lines equal those of the reference */
} case_result;

struct campaign;
typedef struct campaign_options {
    const char *program;  /* path of the program that runs as a worker */
    /* maximum number of concurrent workers; 0 means the number of cores that this process may use */
    int jobs;
    double limit_s;       /* time limit in seconds for each backend, over all its cases */
    /* true if every stage starts from the reference's input (perform_apart); dumps are then not allowed */
    bool apart;
    void (*show)(void *user, const char *what, double share); /* may be NULL */
    void *user;
    /* Called for each difference, in order of backend and then of case within a batch, while the traces of the
       reference and of the backend still exist. The difference is in c->results. May be NULL. */
    void (*differs)(void *keeper, const struct campaign *c, int case_index, int subject_index, const trace *got,
                    compare_range in_got);
    void *keeper;
    /* Called when cases [first, first + count) have been judged. The reference's trace of these cases is freed after
       the call. May be NULL. */
    ost_status (*done)(void *keeper, const struct campaign *c, int first, int count, ost_error *err);
    void *done_keeper;
} campaign_options;

typedef struct campaign {
    const plan *plan;
    const subject_list *subjects;
    /* owned; the index is case * subjects + subject; the entries of subject 0, the reference, record whether it ran */
    case_result *results;
    /* the reference's trace of the current batch; valid only within the callbacks `differs` and `done` */
    trace reference;
    /* owned; for each case in the trace `reference`, its digest lines (digests_of_case); NULL for other cases */
    char **lines;
    /* owned; for each case, its range in the trace `reference`; count is 0 if the case is not in this batch */
    compare_range *ranges;
    /* owned; for each subject, the path counts of the backend, summed over its workers that ended normally */
    path_list *paths;
    time_t begun;
    double *seconds;       /* owned; for each backend, the total time of its workers in seconds */
    int jobs;              /* maximum number of workers that run at the same time */
    uint64_t trace_bytes;  /* maximum total size in bytes of the traces that exist at the same time */
    uint64_t records, bytes; /* number of compared records, and of compared bytes, over all backends */
    uint64_t stage_records[TRACE_STAGES]; /* for each stage, the number of the reference's records */
    int counts[CASE_VERDICTS]; /* for each verdict, the number of results of all backends except the reference */
    /* number of cases that the reference refused; the verdict of the reference in these cases is CASE_FAILED */
    int refused;
    /* number of equal results in cases that the reference did not refuse; only these are evidence */
    int shown;
} campaign;

ost_status campaign_run(const plan *p, const subject_list *subjects, const campaign_options *options, campaign *out,
                        ost_error *err);
void campaign_free(campaign *c);

/* Returns the number of cores that this process may use. */
int campaign_cores(void);

/* Returns true if every available backend equals the reference in every case, and the reference did not refuse all of
   these cases. */
bool campaign_equal(const campaign *c);

#endif
