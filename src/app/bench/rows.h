/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Stores the rows of `osteon bench` in the JSON object of --json, and prints them as a table or, with --markdown, as
 * a Markdown table.
 *
 *   json.c    the settings and the rows in JSON
 *   table.c   both tables
 */
#ifndef OST_APP_BENCH_ROWS_H
#define OST_APP_BENCH_ROWS_H

#include "app/common/app.h"
#include "bench/bench.h"

/* The compiler that built the command and the baselines. */
#if defined __clang__
#define BENCH_COMPILER "clang " __clang_version__
#else
#define BENCH_COMPILER "gcc " __VERSION__
#endif

/* Stores the settings of the run, and an empty array for the rows, in the result of the verb. */
void bench_put_setting(app_state *app, const bench_options *options, const char *suite);
/* Returns a new JSON object that describes a row. The caller owns the object. */
json_t *bench_row_json(const bench_row *row);

/* Prints the settings of the run and the names of the columns. */
void bench_print_heading(const app_state *app, const bench_options *options);
/* Prints a row, or the reason why the row was not run. Further lines contain the distribution of its times. */
void bench_print_row(const app_state *app, const bench_row *row);
/* Prints every baseline of a suite once, and the reasons why baselines are missing. */
void bench_print_baselines(const app_state *app, const bench_table *table);
/* Prints a warning if other programs disturbed the measurement of rows. */
void bench_print_disturbed(const app_state *app, const bench_table *table);

/* Prints the settings of the run and the names of the columns in Markdown. */
void bench_print_markdown_heading(const app_state *app, const bench_options *options, const char *suite);
/* Prints a row in Markdown. */
void bench_print_markdown_row(const app_state *app, const bench_row *row);

#endif
