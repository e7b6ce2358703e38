/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The result of one item, that is, of a table or a figure of the thesis. Its rows contain the values of this run and
 * the values that the thesis states. A result also has plots, pictures, remarks and findings.
 *
 *   item's measurement --> result --> CSV, JSON, SVG (write.h), report (report.h)
 *   JSON of other runs --> result --merge--> result with the rows of several machines
 *
 * Every row refers to the machine on which it was measured. A result of one run has one machine; a merged
 * result has several.
 *
 * Memory: the first failed allocation is stored in out_of_memory, and later calls then have no effect. The writers
 * check this member, so an item need not check every call. Threads: a result is used by one thread at a time.
 */
#ifndef OST_REPRODUCTION_RESULT_H
#define OST_REPRODUCTION_RESULT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <osteon/status.h>

enum {
    RESULT_COLUMNS = 16,
    RESULT_KEY = 48,
    RESULT_LABEL = 96,
    RESULT_TEXT = 640,
    RESULT_PLOT_VALUES = 4,
    RESULT_MACHINES = 32
};

/* The machine, the device and the settings of a run. */
typedef struct result_machine {
    char label[RESULT_LABEL]; /* short name in rows and legends, such as "AMD EPYC, cpu avx512, 2 threads" */
    char cpu[RESULT_LABEL];
    char backend[RESULT_LABEL]; /* the argument of --backend */
    char device[RESULT_LABEL];  /* name and driver of the OpenCL device; "" if the backend has none */
    char isa[16];
    char compiler[RESULT_LABEL];
    char version[32];           /* version of osteon */
    int threads, processors;
    double memory_gb;           /* memory that was free when the run began, in GB */
    bool quick;                 /* true if the run was made with --quick */
} result_machine;

typedef struct result_column {
    char key[RESULT_KEY];     /* name in CSV and JSON; the name ends with the unit, as in "event_us" */
    char title[RESULT_LABEL]; /* heading in the report */
    char unit[16];            /* "us", "ms", "MB", "mm" or ""; "" for a number without a unit */
    bool text;                /* true if the cells contain strings */
    bool has_thesis;          /* true if at least one cell has a value that the thesis states */
} result_column;

typedef struct result_cell {
    bool known;    /* true if `value` was measured or computed in this run */
    bool stated;   /* true if `thesis` is a value that the thesis states */
    double value, thesis;
    char text[RESULT_LABEL];
} result_cell;

typedef struct result_row {
    int machine;
    result_cell cell[RESULT_COLUMNS];
} result_row;

/* The verdict on a statement of the thesis. */
typedef enum result_verdict {
    RESULT_CONFIRMED,
    RESULT_CONTRADICTED,
    RESULT_UNDECIDED, /* the difference is within the uncertainty of the measurement */
    RESULT_ANSWERED,  /* this run answers a question that the thesis leaves open */
    RESULT_VERDICTS
} result_verdict;
extern const char *const result_verdict_names[RESULT_VERDICTS];

typedef struct result_finding {
    int machine;
    result_verdict verdict;
    char claim[RESULT_TEXT];  /* the statement of the thesis, as a sentence */
    char source[RESULT_LABEL]; /* section or table in which the thesis makes the statement */
    char reason[RESULT_TEXT]; /* the measured result, and why it agrees or disagrees with the statement */
} result_finding;

typedef struct result_remark {
    int machine;
    char text[RESULT_TEXT];
} result_remark;

typedef enum result_plot_kind { RESULT_PLOT_LINES, RESULT_PLOT_BARS } result_plot_kind;

/*
 * Selects columns for a plot. Each column in `value` results in one series for every combination of a machine and a
 * text in the column `group`. The values that the thesis states form additional series.
 */
typedef struct result_plot {
    result_plot_kind kind;
    char title[RESULT_LABEL], x_label[RESULT_LABEL], y_label[RESULT_LABEL];
    /* column with the positions along the x axis; in a plot with bars, a column of strings or numbers */
    int x;
    int group;                        /* column of strings by which the rows are grouped; -1 if they are not grouped */
    int value[RESULT_PLOT_VALUES], values;
    bool log_x, log_y;
} result_plot;

/* A picture: a PNG or an SVG. */
typedef struct result_picture {
    char file[RESULT_KEY]; /* name in the output folder, such as "figure-1.4-scapula.png" */
    char caption[RESULT_TEXT];
    uint8_t *bytes;        /* owned */
    size_t size;
} result_picture;

typedef struct result {
    char id[RESULT_KEY];      /* "table-3.3" */
    char title[RESULT_TEXT];
    bool out_of_memory;
    int machine_count, column_count, plot_count;
    result_machine machine[RESULT_MACHINES];
    result_column column[RESULT_COLUMNS];
    result_plot plot[4];
    size_t row_count, row_capacity, finding_count, remark_count, picture_count;
    result_row *row;          /* owned, like the arrays below */
    result_finding *finding;
    result_remark *remark;
    result_picture *picture;
    result_row spare;         /* the row that result_add_row returns if memory is exhausted */
} result;

/* Initializes a result without rows. The machine is copied. */
void result_init(result *r, const char *id, const char *title, const result_machine *machine);
void result_free(result *r);

/* Appends a column and returns its index. If `unit` is "text", the cells contain strings. */
int result_add_column(result *r, const char *key, const char *title, const char *unit);
/* Appends a row of empty cells for the first machine. The pointer is valid until the next call. */
result_row *result_add_row(result *r);
/* Each of these functions sets one part of a cell in the last row. */
void result_set(result *r, int column, double value);
void result_set_thesis(result *r, int column, double value);
void result_set_text(result *r, int column, const char *format, ...) OST_PRINTF(3, 4);

void result_add_remark(result *r, const char *format, ...) OST_PRINTF(2, 3);
void result_add_finding(result *r, result_verdict verdict, const char *source, const char *claim, const char *format,
                        ...) OST_PRINTF(5, 6);
/* Appends a picture and takes ownership of `bytes`, which must have been allocated with malloc. */
void result_add_picture(result *r, const char *file, const char *caption, uint8_t *bytes, size_t size);
/* Appends a plot and returns it. The caller must set x, value and values; group is -1. */
result_plot *result_add_plot(result *r, result_plot_kind kind, const char *title, const char *x_label,
                             const char *y_label);

/* Appends the rows, findings, remarks and pictures of `from`, with their machines. Pictures that `into` already
   contains are omitted. Returns OST_ERR_INPUT if the columns are different. */
ost_status result_merge(result *into, const result *from, ost_error *err);

/* Returns OST_ERR_MEMORY if an allocation failed. */
ost_status result_check(const result *r, ost_error *err);

/*
 * Compares two times of one run. Returns 0 if they differ by at most `tolerance` times the shorter time. Otherwise,
 * returns -1 if `a` is shorter and 1 if `b` is shorter.
 */
int result_order(double a, double b, double tolerance);

#endif
