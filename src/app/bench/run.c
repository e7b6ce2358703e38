/* SPDX-License-Identifier: Apache-2.0 */
#include "app/bench/run.h"

#include <stdio.h>
#include <string.h>

#include "app/bench/rows.h"
#include "app/common/options.h"
#include "app/common/print.h"
#include "app/common/progress.h"
#include "app/common/result.h"

/* Totals of all rows. `wrong` is true if the grid of a row differs from that of the reference. */
typedef struct tally {
    size_t rows, run;
    bool wrong;
    char reason[BENCH_TEXT]; /* reason why the first of the skipped rows was skipped */
} tally;

/* Prints the rows of a suite. Before the first rows, prints the heading. */
static void show_rows(app_state *app, const bench_options *options, const char *suite, const bench_table *table,
                      tally *all, bool markdown)
{
    const bool first = all->rows == 0;
    progress_end();
    if (table->count && first && markdown)
        bench_print_markdown_heading(app, options, suite);
    else if (table->count && first)
        bench_print_heading(app, options);
    else if (table->count && !markdown)
        print_line(app, "%s", "");
    for (size_t i = 0; i < table->count; i++) {
        append(json_object_get(app->result, "rows"), bench_row_json(&table->rows[i]));
        if (markdown)
            bench_print_markdown_row(app, &table->rows[i]);
        else
            bench_print_row(app, &table->rows[i]);
        all->wrong = all->wrong || !table->rows[i].equal;
        all->run += !table->rows[i].reason[0];
        if (table->rows[i].reason[0] && !all->reason[0])
            memcpy(all->reason, table->rows[i].reason, sizeof all->reason);
    }
    all->rows += table->count;
    if (!markdown) {
        bench_print_baselines(app, table);
        bench_print_disturbed(app, table);
    }
}

ost_status bench_run_suites(app_state *app, const bench_options *options, const char *suite, bool markdown,
                            ost_error *err)
{
    ost_backend *backend = NULL;
    tally all = {.rows = 0};
    static const bench_options every_row; /* options without a filter, so that they select every row */
    /* an unknown or unavailable backend is an error of the command, so the backend is opened before any row runs */
    ost_status status = bench_backend(options, options->threads, &backend, err);
    ost_backend_close(backend);
    for (const bench_suite *s = bench_suites; s->name && status == OST_OK; s++) {
        bench_table table = {0};
        if (strcmp(suite, "all") != 0 && strcmp(suite, s->name) != 0)
            continue;
        status = s->run(options, &table, err);
        /* If a suite cannot be prepared, a row with the suite's name records the failure, and the next suite is run. */
        status = bench_row_not_run(&every_row, &table, &s->name, 1, "ms", options->threads, status, err);
        show_rows(app, options, suite, &table, &all, markdown);
        fflush(stdout);
        bench_table_free(&table);
    }
    if (status == OST_OK && all.rows == 0)
        return usage_error(app, err, "no row of suite %s matches '%s'", suite,
                           options->filter ? options->filter : "");
    if (status == OST_OK && all.wrong)
        return ost_fail(err, OST_ERR_DIFFER, "a row's grid differs from the reference");
    put_integer(app->result, "rows_run", (int64_t)all.run);
    put_integer(app->result, "rows_not_run", (int64_t)(all.rows - all.run));
    if (status == OST_OK && all.run == 0) {
        app->answered = true;
        return ost_fail(err, OST_ERR_UNAVAILABLE, "no row could be run: %s", all.reason);
    }
    return status;
}

bool bench_suite_is_built(const char *suite)
{
    if (strcmp(suite, "all") == 0)
        return true;
    for (const bench_suite *s = bench_suites; s->name; s++)
        if (strcmp(suite, s->name) == 0)
            return true;
    return false;
}
