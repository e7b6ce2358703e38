/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Figures side by side in one run: what every suite shares.
 *
 *   suite --> rows --> table, JSON, Markdown (src/app/cmd_bench.c)
 *
 *   a row    ours      medians of repetitions that alternate with the
 *            baseline  baseline's in the same process: A B A B ...
 *            equal     ours gave the reference's grid, compared byte by byte,
 *                      before a single figure is shown
 *
 * A suite never leaves a row out: one that cannot run here says why, and the others go on.  A row of
 * a wrong result has no figures and makes the command fail.
 * docs/performance.md explains the method and each row.
 */
#ifndef OST_BENCH_BENCH_H
#define OST_BENCH_BENCH_H

#include <osteon/backend.h>

typedef struct bench_options {
    const char *backend; /* "cpu", "cpu:isa=avx2", "ref" */
    int threads;         /* of rows that do not end in /1 */
    int repeat;          /* 0: each row's own number */
    bool quick;          /* few repetitions, small inputs; the same row names */
    double scale;        /* share of the 12,040,704 lines of parse/text */
    const char *filter;  /* rows whose name holds this, NULL: all */
    void (*show)(void *user, const char *row); /* before a row is measured; may be NULL */
    void *user;
} bench_options;

/* ------------------------------------------------------------------ figures */

/* Times of repetitions. Zero-initialise, free at the end. */
typedef struct bench_series {
    size_t count, capacity;
    double *ns; /* owned */
} bench_series;

int64_t bench_now(void); /* CLOCK_MONOTONIC, ns */
void bench_series_add(bench_series *series, double ns);
void bench_series_free(bench_series *series);
/* The value that share of the series lies below, by the nearest rank; 0 of nothing. Sorts the series. */
double bench_series_at(bench_series *series, double share);
double bench_series_mean(const bench_series *series);

typedef struct bench_figures {
    size_t count; /* repetitions; 0: not measured */
    double median, min, max; /* in the row's unit */
} bench_figures;

enum { BENCH_NAME = 48, BENCH_TEXT = 224, BENCH_EXTRA_MAX = 16 };
typedef struct bench_row {
    char name[BENCH_NAME];
    const char *unit;      /* "us" or "ms" */
    int threads;
    bool equal;            /* to the reference; false: an error */
    char reason[BENCH_TEXT];          /* why ours was not measured; "" when it was */
    char baseline_reason[BENCH_TEXT]; /* why there is no baseline */
    char baseline_is[BENCH_TEXT];     /* what it is */
    bench_figures ours, baseline;
    int extra_count;
    struct {
        char key[32];
        double value;
    } extra[BENCH_EXTRA_MAX];
} bench_row;

typedef struct bench_table {
    size_t count, capacity;
    bench_row *rows; /* owned */
} bench_table;

void bench_table_free(bench_table *table);

/* Whether the filter wants the row; if so it is announced. */
bool bench_wanted(const bench_options *options, const char *name);
/* A row of this name, equal and without figures, at the table's end. The pointer holds until the next one. NULL without memory. */
bench_row *bench_row_add(bench_table *table, const char *name, const char *unit, int threads);
/*
 * Makes of a row's failure a row with the error's text as its reason, so that the suite goes on.  Returns OST_OK then; OST_OK,
 * OST_ERR_CANCELLED and OST_ERR_INTERNAL (a defect in osteon) are returned as they are.  A name that is NULL, that the filter
 * leaves out, or whose row is there already, adds nothing.
 */
ost_status bench_row_not_run(const bench_options *options, bench_table *table, const char *const names[], int count, const char *unit, int threads,
                             ost_status status, ost_error *err);
/* unit_ns: nanoseconds in the row's unit. */
void bench_row_ours(bench_row *row, bench_series *series);
void bench_row_baseline(bench_row *row, bench_series *series, const char *what);
void bench_row_extra(bench_row *row, const char *key, double value);
/* Baseline over ours; 0 when one of them is missing. */
double bench_row_ratio(const bench_row *row);
/* The same of the least times: what is left of it when other work on the machine made the longer one longer. */
double bench_row_ratio_of_minima(const bench_row *row);
/* Whether a median is more than half above its minimum: the machine was busy, or the row is short and cold. */
bool bench_row_disturbed(const bench_row *row);

/* Repetitions: what was asked for, else few when quick, else normal. */
int bench_repeat(const bench_options *options, int normal);

/* ------------------------------------------------------------------ machine */

int bench_cpus(void); /* that this process may use */
const char *bench_cpu_model(char text[BENCH_TEXT]);
/* The instruction set that the backend uses, or "scalar" for one without a choice. */
const char *bench_isa(const bench_options *options);
/* Bytes that can be had without pushing anything out; a large number where nobody says. */
int64_t bench_memory(void);

/* The options' backend with its number of threads set, where it has such an option. */
ost_status bench_backend(const bench_options *options, int threads, ost_backend **out, ost_error *err);

/* ------------------------------------------------------------------- suites */

typedef struct bench_suite {
    const char *name;
    ost_status (*run)(const bench_options *options, bench_table *table, ost_error *err);
} bench_suite;

/* Ends with a NULL name. */
extern const bench_suite bench_suites[];

ost_status bench_removal(const bench_options *options, bench_table *table, ost_error *err);
ost_status bench_tick(const bench_options *options, bench_table *table, ost_error *err);
ost_status bench_transfer(const bench_options *options, bench_table *table, ost_error *err);
ost_status bench_parse(const bench_options *options, bench_table *table, ost_error *err);
ost_status bench_voxelize(const bench_options *options, bench_table *table, ost_error *err);
ost_status bench_render(const bench_options *options, bench_table *table, ost_error *err);
ost_status bench_opencl(const bench_options *options, bench_table *table, ost_error *err);

#endif
