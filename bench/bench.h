/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Measurements of osteon and of a baseline in one run: the parts that all suites share.
 *
 *   suite --> rows --> table, JSON, Markdown (src/app/bench/)
 *
 *   a row    ours      median times of osteon and of the baseline, whose repetitions
 *            baseline  alternate in the same process: A B A B ...
 *            equal     true if osteon's grid is identical to the reference's grid; the two
 *                      grids are compared byte by byte before any figure is shown
 *
 * A suite omits no row. A row that cannot run here contains the reason, and the other rows are
 * still measured. A row with a wrong result contains no figures and makes the command fail.
 * docs/performance.md explains the method and each row.
 */
#ifndef OST_BENCH_BENCH_H
#define OST_BENCH_BENCH_H

#include <osteon/backend.h>

typedef struct bench_options {
    const char *backend; /* options string of the backend, such as "cpu", "cpu:isa=avx2" or "ref" */
    int threads;         /* number of threads for all rows except those whose name ends in /1 */
    int repeat;          /* number of repetitions; 0 selects the default of each row */
    /* true for few repetitions and small inputs; the names of the rows do not change */
    bool quick;
    double scale;        /* the row parse/text reads this fraction of its 12,040,704 text lines */
    /* only rows whose names contain this text are measured; NULL for all rows */
    const char *filter;
    void (*show)(void *user, const char *row); /* called before a row is measured; may be NULL */
    void *user;
} bench_options;

/* ------------------------------------------------------------------ figures */

/* The times of all repetitions of a measurement. A series must be zero-initialized before use and freed after use. */
typedef struct bench_series {
    size_t count, capacity;
    double *ns; /* owned */
} bench_series;

int64_t bench_now(void); /* returns the time of CLOCK_MONOTONIC in ns */
void bench_series_add(bench_series *series, double ns);
void bench_series_free(bench_series *series);
/* Sorts the series and returns its quantile `share` (0 to 1) by nearest rank, or 0 if the series is
   empty. */
double bench_series_at(bench_series *series, double share);
double bench_series_mean(const bench_series *series);

typedef struct bench_figures {
    size_t count; /* number of repetitions; 0 if nothing was measured */
    double median, min, max; /* times in the row's unit */
} bench_figures;

enum { BENCH_NAME = 48, BENCH_TEXT = 224, BENCH_EXTRA_MAX = 16 };
typedef struct bench_row {
    char name[BENCH_NAME];
    const char *unit;      /* "us" or "ms" */
    int threads;
    /* true if osteon's result equals the reference's result; false is an error */
    bool equal;
    char reason[BENCH_TEXT];          /* reason why osteon was not measured; "" if osteon was measured */
    char baseline_reason[BENCH_TEXT]; /* reason why there is no baseline */
    char baseline_is[BENCH_TEXT];     /* description of the baseline */
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

/* If options->filter selects the row with this name, calls options->show and returns true. */
bool bench_wanted(const bench_options *options, const char *name);
/* Appends a row with this name, without figures, and sets its `equal` to true. The pointer is valid until the next
   call. Returns NULL if memory is exhausted. */
bench_row *bench_row_add(bench_table *table, const char *name, const char *unit, int threads);
/*
 * If `status` is OST_OK, OST_ERR_CANCELLED or OST_ERR_INTERNAL (a defect in osteon), returns it and adds no row. For
 * any other status, adds the named rows with the error's text as their reason, and returns OST_OK, so that the suite
 * continues. A name is skipped if it is NULL, if the filter excludes it, or if its row already exists.
 */
ost_status bench_row_not_run(const bench_options *options, bench_table *table, const char *const names[], int count,
                             const char *unit, int threads, ost_status status, ost_error *err);
/* bench_row_ours and bench_row_baseline convert the median, minimum and maximum of a series to the row's unit and store
   them in the row. `what` describes the baseline. */
void bench_row_ours(bench_row *row, bench_series *series);
void bench_row_baseline(bench_row *row, bench_series *series, const char *what);
void bench_row_extra(bench_row *row, const char *key, double value);
/*
 * Returns the baseline's median time divided by osteon's median time. Returns 0 if one of the two medians is missing.
 */
double bench_row_ratio(const bench_row *row);
/* Returns the baseline's minimum time divided by osteon's minimum time. Background load affects this ratio less than
   the ratio of the medians. */
double bench_row_ratio_of_minima(const bench_row *row);
/* Returns true if osteon's or the baseline's median is more than 1.5 times its minimum. Possible reasons are background
   load or, for a short operation, cold caches. */
bool bench_row_disturbed(const bench_row *row);

/* Returns the number of repetitions of a row: options->repeat or, if this is 0, `normal`. options->quick limits
   `normal` to 3. */
int bench_repeat(const bench_options *options, int normal);

/* ------------------------------------------------------------------ machine */

int bench_cpus(void); /* number of processors that this process may use */
const char *bench_cpu_model(char text[BENCH_TEXT]);
/* Returns the name of the instruction set that the cpu backend uses, or "scalar" for any other backend. */
const char *bench_isa(const bench_options *options);
/* Returns the number of bytes of memory that can be allocated without swapping. Returns a large number if the system
   does not report it. */
int64_t bench_memory(void);

/* Opens the backend that the options name. If the backend has no option for the number of threads, `threads` is
   ignored. */
ost_status bench_backend(const bench_options *options, int threads, ost_backend **out, ost_error *err);

/* ------------------------------------------------------------------- suites */

typedef struct bench_suite {
    const char *name;
    ost_status (*run)(const bench_options *options, bench_table *table, ost_error *err);
} bench_suite;

/* The list of suites. The last element has the name NULL. */
extern const bench_suite bench_suites[];

ost_status bench_removal(const bench_options *options, bench_table *table, ost_error *err);
ost_status bench_tick(const bench_options *options, bench_table *table, ost_error *err);
ost_status bench_transfer(const bench_options *options, bench_table *table, ost_error *err);
ost_status bench_parse(const bench_options *options, bench_table *table, ost_error *err);
ost_status bench_voxelize(const bench_options *options, bench_table *table, ost_error *err);
ost_status bench_candidates(const bench_options *options, bench_table *table, ost_error *err);
ost_status bench_render(const bench_options *options, bench_table *table, ost_error *err);
ost_status bench_servo(const bench_options *options, bench_table *table, ost_error *err);
ost_status bench_opencl(const bench_options *options, bench_table *table, ost_error *err);

#endif
