/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A campaign: every case of a plan on every backend, each in its own process,
 * compared with the reference's trace by memcmp.
 *
 *   plan, subjects --campaign_run--> results[case][subject], tracks of the reference
 *
 * The list is worked off in batches, so that the traces on the disk stay few.
 * In each the reference runs first and the others after it, so many workers at
 * a time; the next batch's reference runs meanwhile.
 *
 *   batch 0   ref | avx2, scalar, cl ...            --batch done--> evidence of its cases
 *   batch 1         ref | ...                       then its traces go
 *
 * A backend that ends before its time is started again behind the case that
 * ended it.
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
    CASE_FAILED,  /* a stage failed on this backend and not on the reference: the line is in text */
    CASE_CRASHED, /* ended by a signal other than SIGKILL, which comes from outside and ends the campaign */
    CASE_LATE,
    CASE_NOT_RUN, /* the backend is not available here */
    CASE_VERDICTS
} case_verdict;

const char *case_verdict_name(case_verdict verdict);

typedef struct case_result {
    case_verdict verdict;
    compare_difference difference; /* of CASE_DIFFERS */
    margins *margins;              /* owned; of CASE_DIFFERS; NULL: not measured */
    uint32_t own_steps;            /* records of stages snap and steps that the backend made itself */
    finding *found;                /* owned; of CASE_DIFFERS; NULL: nothing more is known */
    char text[200];
    ost_digest made; /* SHA-256 of the lines of what this backend made (digests_of_case); where has_made */
    bool has_made;   /* its trace has the case: the verdict is equal, differs or failed */
    double seconds;  /* that the backend took, its input's making included; 0: not measured */
    char *lines;     /* owned; those lines; NULL: they are the reference's, or has_made is false */
} case_result;

struct campaign;
typedef struct campaign_options {
    const char *program;  /* this program's file */
    int jobs;             /* workers at a time; 0: as many as this process may use cores */
    double limit_s;       /* for a backend's whole run */
    bool apart;           /* every stage gets the reference's input (perform_apart); no dumps then */
    void (*show)(void *user, const char *what, double share); /* may be NULL */
    void *user;
    /* What differs, while both traces are there, in the order of backends and cases of a batch: c->results has the difference. May be NULL. */
    void (*differs)(void *keeper, const struct campaign *c, int case_index, int whom, const trace *got, compare_range in_got);
    void *keeper;
    /* Cases [first, first + count) are judged and the reference's trace of them is there, for the last time. */
    ost_status (*done)(void *keeper, const struct campaign *c, int first, int count, ost_error *err);
    void *done_keeper;
} campaign_options;

typedef struct campaign {
    const plan *plan;
    const subject_list *subjects;
    case_result *results; /* owned; [case * subjects + subject]; the reference's say whether it ran */
    trace reference;       /* of the batch that is judged; empty outside of differs and done */
    char **lines;          /* owned; of each case in it, the reference's lines (digests_of_case); else NULL */
    compare_range *ranges; /* owned; of each case in it, count 0 where it is not in this batch */
    path_list *paths;      /* owned; of each subject: what its workers entered, but for those that ended before their time */
    time_t begun;
    double *seconds;       /* owned; of each subject: that its workers ran, beside others */
    int jobs;              /* workers at a time */
    uint64_t trace_bytes;  /* most that lay on the disk at a time */
    uint64_t records, bytes; /* compared, over all */
    uint64_t stage_records[TRACE_STAGES]; /* of the reference */
    int counts[CASE_VERDICTS]; /* over all but the reference */
    int refused;               /* cases that the reference refused: its results say which */
    int shown;                 /* equal results of the others */
} campaign;

ost_status campaign_run(const plan *p, const subject_list *subjects, const campaign_options *options, campaign *out, ost_error *err);
void campaign_free(campaign *c);

/* Cores that this process may use. */
int campaign_cores(void);

/* Every available backend equal in every case, and one of them in a case that the reference did not refuse. */
bool campaign_equal(const campaign *c);

#endif
