/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A campaign runs every case of a plan on every backend, each backend in its
 * own process, and compares the traces with the reference's by memcmp.
 *
 *   plan, subjects --campaign_run--> results[case][subject], tracks of the reference
 *
 * The cases run in batches, which limits the number of traces on the disk.
 * In each batch the reference runs first, then the other backends, up to `jobs`
 * workers at a time. The reference of the next batch runs meanwhile.
 *
 *   batch 0   ref | avx2, scalar, cl ...            --batch done--> evidence of its cases
 *   batch 1         ref | ...                       then its traces are deleted
 *
 * A backend whose process crashes is started again with the case after the one
 * in which it crashed. After a failure or a timeout it is not started again, and
 * its remaining cases get the same verdict.
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
    CASE_FAILED,  /* a stage failed on this backend but not on the reference; text has the error line */
    CASE_CRASHED, /* ended by a signal other than SIGKILL; a SIGKILL from outside ends the campaign instead */
    CASE_LATE,
    CASE_NOT_RUN, /* the backend is not available here */
    CASE_VERDICTS
} case_verdict;

const char *case_verdict_name(case_verdict verdict);

typedef struct case_result {
    case_verdict verdict;
    compare_difference difference; /* valid for CASE_DIFFERS */
    margins *margins;              /* owned; for CASE_DIFFERS; NULL if not measured */
    uint32_t own_steps;            /* number of records of the stages `snap` and `steps` that the backend made itself */
    finding *found;                /* owned; details of the difference for CASE_DIFFERS; NULL if there are none */
    char text[200];
    ost_digest made; /* SHA-256 of the digest lines of this backend's results (digests_of_case); valid if has_made */
    bool has_made;   /* true if the backend's trace contains the case: the verdict is equal, differs or failed */
    double seconds;  /* running time of the backend in this case, including the making of its input; 0: not measured */
    char *lines;     /* owned; the digest lines; NULL if they equal the reference's or has_made is false */
} case_result;

struct campaign;
typedef struct campaign_options {
    const char *program;  /* path of this program's file */
    int jobs;             /* maximum number of concurrent workers; 0: the number of cores that this process may use */
    double limit_s;       /* time limit in seconds for a backend's complete run */
    bool apart;           /* true: every stage gets the reference's input (perform_apart); dumps are not allowed */
    void (*show)(void *user, const char *what, double share); /* may be NULL */
    void *user;
    /* Called for each difference while both traces exist, in the order of the backends and cases of a batch. The
       difference is in c->results. May be NULL. */
    void (*differs)(void *keeper, const struct campaign *c, int case_index, int subject_index, const trace *got,
                    compare_range in_got);
    void *keeper;
    /* Called when cases [first, first + count) have been judged; the reference's trace of these cases is freed
       afterwards. May be NULL. */
    ost_status (*done)(void *keeper, const struct campaign *c, int first, int count, ost_error *err);
    void *done_keeper;
} campaign_options;

typedef struct campaign {
    const plan *plan;
    const subject_list *subjects;
    /* owned; index case * subjects + subject; the reference's results record whether the reference ran */
    case_result *results;
    /* trace of the batch that is being judged; empty outside the callbacks `differs` and `done` */
    trace reference;
    /* owned; digest lines (digests_of_case) of each case in the trace `reference`; NULL for other cases */
    char **lines;
    /* owned; for each case its range in the trace `reference`; count 0 if the case is not in this batch */
    compare_range *ranges;
    path_list *paths;      /* owned; for each subject, the paths recorded by its workers that ended regularly */
    time_t begun;
    double *seconds;       /* owned; for each subject, the sum of the running times of its workers */
    int jobs;              /* maximum number of concurrent workers */
    uint64_t trace_bytes;  /* maximum size of the traces on the disk at one time */
    uint64_t records, bytes; /* numbers of records and bytes compared, over all backends */
    uint64_t stage_records[TRACE_STAGES]; /* number of records of the reference for each stage */
    int counts[CASE_VERDICTS]; /* number of each verdict over all backends except the reference */
    int refused;               /* number of cases that the reference refused; its verdict for them is CASE_FAILED */
    int shown;                 /* number of equal results, in cases that the reference did not refuse */
} campaign;

ost_status campaign_run(const plan *p, const subject_list *subjects, const campaign_options *options, campaign *out,
                        ost_error *err);
void campaign_free(campaign *c);

/* Returns the number of cores that this process may use. */
int campaign_cores(void);

/* Returns true if every available backend is equal to the reference in every case, and at least one backend is equal
   in a case that the reference did not refuse. */
bool campaign_equal(const campaign *c);

#endif
