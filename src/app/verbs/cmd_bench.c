/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Implements `osteon bench`: runs the suites of bench/ and prints their rows as a table, as the
 * table of docs/performance.md (--markdown), or as JSON.
 */
#include <stdio.h>
#include <string.h>

#include "config.h"

#include "app/common/options.h"
#include "app/common/progress.h"
#include "app/common/result.h"
#include "app/common/print.h"
#include "app/verbs/bench_against.h"
#include "bench/bench.h"

#if defined __clang__
#define COMPILER "clang " __clang_version__
#else
#define COMPILER "gcc " __VERSION__
#endif

enum { FIGURE = 32, RANGE = 2 * FIGURE + 2 };

/* -------------------------------------------------------------------- JSON */

static void put_figures(json_t *o, const char *name, const bench_figures *f)
{
    char key[64];
    const bool known = f->count > 0;
    put(o, name, known ? json_real(f->median) : json_null());
    snprintf(key, sizeof key, "%s_min", name);
    put(o, key, known ? json_real(f->min) : json_null());
    snprintf(key, sizeof key, "%s_max", name);
    put(o, key, known ? json_real(f->max) : json_null());
    snprintf(key, sizeof key, "%s_repetitions", name);
    put_integer(o, key, (int64_t)f->count);
}

/* Stores a number as a JSON integer if it is integral, otherwise as a real. */
static void put_extra(json_t *o, const char *key, double value)
{
    if (value >= 0 && value < 9e15 && (double)(int64_t)value == value)
        put_integer(o, key, (int64_t)value);
    else
        put_real(o, key, value);
}

static json_t *json_of_row(const bench_row *row)
{
    json_t *o = json_object();
    const double ratio = bench_row_ratio(row);
    put_text(o, "name", row->name);
    put_text(o, "unit", row->unit);
    put_integer(o, "threads", row->threads);
    put_bool(o, "run", !row->reason[0]);
    put(o, "equal", row->reason[0] ? json_null() : json_boolean(row->equal));
    put_figures(o, "ours", &row->ours);
    put_figures(o, "baseline", &row->baseline);
    put(o, "ratio", ratio > 0 ? json_real(ratio) : json_null());
    put(o, "ratio_of_minima", ratio > 0 ? json_real(bench_row_ratio_of_minima(row)) : json_null());
    if (row->reason[0])
        put_text(o, "reason", row->reason);
    if (row->baseline_reason[0])
        put_text(o, "baseline_reason", row->baseline_reason);
    if (row->baseline_is[0])
        put_text(o, "baseline_is", row->baseline_is);
    for (int i = 0; i < row->extra_count; i++)
        put_extra(o, row->extra[i].key, row->extra[i].value);
    return o;
}

static void put_setting(app_state *app, const bench_options *options, const char *suite)
{
    char cpu[BENCH_TEXT];
    json_t *o = app->result;
    put_text(o, "suite", suite);
    put_text(o, "backend", options->backend);
    put_text(o, "isa", bench_isa(options));
    put_integer(o, "threads", options->threads);
    put_text(o, "cpu", bench_cpu_model(cpu));
    put_integer(o, "cpus", bench_cpus());
    put_text(o, "clock", "CLOCK_MONOTONIC");
    put_text(o, "compiler", COMPILER);
    put_text(o, "baseline_flags", OST_BENCH_CFLAGS);
    put_bool(o, "quick", options->quick);
    put(o, "rows", json_array());
}

/* ------------------------------------------------------------------- table */

/* Formats a value with three or four significant digits. */
static const char *figure(char text[FIGURE], double value)
{
    int places = value >= 100 ? 0 : value >= 10 ? 1 : value >= 1 ? 2 : 3;
    snprintf(text, FIGURE, "%.*f", places, value);
    return text;
}

static const char *range(char text[RANGE], const bench_figures *f)
{
    char a[FIGURE], b[FIGURE];
    snprintf(text, RANGE, "%s..%s", figure(a, f->min), figure(b, f->max));
    return text;
}

static const double *extra_of(const bench_row *row, const char *key)
{
    for (int i = 0; i < row->extra_count; i++)
        if (strcmp(row->extra[i].key, key) == 0)
            return &row->extra[i].value;
    return NULL;
}

static void print_distribution(const app_state *app, const bench_row *row)
{
    const double *p50 = extra_of(row, "p50"), *p99 = extra_of(row, "p99"), *max = extra_of(row, "max");
    const double *mean = extra_of(row, "undisturbed_mean"), *best99 = extra_of(row, "undisturbed_p99"),
                 *best = extra_of(row, "undisturbed_max");
    char t[6][FIGURE];
    if (!p50 || !p99 || !max || !mean || !best99 || !best)
        return;
    print_line(app, "    a tick: p50 %s, p99 %s, max %s; least of all repetitions: mean %s, p99 %s, max %s",
               figure(t[0], *p50), figure(t[1], *p99), figure(t[2], *max), figure(t[3], *mean), figure(t[4], *best99),
               figure(t[5], *best));
}

static void print_deadlines(const app_state *app, const bench_row *row)
{
    const double *ticks = extra_of(row, "ticks"), *missed = extra_of(row, "missed"), *p99 = extra_of(row, "p99_us"),
                 *p999 = extra_of(row, "p99_9_us");
    char a[FIGURE], b[FIGURE];
    if (ticks && missed && p99 && p999)
        print_line(app, "    deadlines missed: %.0f in %.0f ticks; delay at 99 %% %s us, at 99.9 %% %s us", *missed,
                   *ticks, figure(a, *p99), figure(b, *p999));
}

static void print_row(const app_state *app, const bench_row *row)
{
    char ours[FIGURE], ours_range[RANGE], baseline[FIGURE] = "-", baseline_range[RANGE] = "-", ratio[FIGURE] = "-",
                                          best[FIGURE] = "-";
    if (row->reason[0]) {
        print_line(app, "%-30s not run: %s", row->name, row->reason);
        return;
    }
    if (!row->equal) {
        print_line(app, "%-30s WRONG: the grid differs from the reference", row->name);
        return;
    }
    if (row->baseline.count) {
        figure(baseline, row->baseline.median);
        range(baseline_range, &row->baseline);
        figure(ratio, bench_row_ratio(row));
        figure(best, bench_row_ratio_of_minima(row));
    }
    print_line(app, "%-30s %2s %8s %-15s %8s %-15s %7s %7s", row->name, row->unit, figure(ours, row->ours.median),
               range(ours_range, &row->ours), baseline, baseline_range, ratio, best);
    print_distribution(app, row);
    print_deadlines(app, row);
}

/* Prints a warning if other programs disturbed the measurement of rows. If they interrupted a row's baseline, the ratio
   of this row is too high. */
static void print_disturbed(const app_state *app, const bench_table *table)
{
    size_t disturbed = 0;
    for (size_t i = 0; i < table->count; i++)
        disturbed += bench_row_disturbed(&table->rows[i]);
    if (disturbed) {
        print_line(app, "  In %zu of %zu rows the median is more than half above the minimum: the machine was busy.",
                   disturbed, table->count);
        print_line(app, "  'of min' is less affected, if there were enough repetitions (--repeat N).");
    }
}

/* Prints every baseline of a suite once, and the reasons why baselines are missing. */
static void print_baselines(const app_state *app, const bench_table *table)
{
    for (size_t i = 0; i < table->count; i++) {
        const bench_row *row = &table->rows[i];
        const char *text = row->baseline_reason[0] ? row->baseline_reason : row->baseline_is;
        bool printed = !text[0] || row->reason[0] || !row->equal;
        for (size_t k = 0; k < i && !printed; k++) {
            const bench_row *other = &table->rows[k];
            printed = strcmp(text, other->baseline_reason[0] ? other->baseline_reason : other->baseline_is) == 0;
        }
        if (!printed)
            print_line(app, "  baseline%s of %s: %s", row->baseline_reason[0] ? " missing" : "", row->name, text);
    }
}

static void print_heading(const app_state *app, const bench_options *options)
{
    char cpu[BENCH_TEXT];
    print_line(app, "backend %s (%s), %d thread%s (one: tick, rows in /1), %s", options->backend, bench_isa(options),
               options->threads, options->threads == 1 ? "" : "s", bench_cpu_model(cpu));
    print_line(app, "medians and min..max of repetitions that alternate with the baseline's; every grid was first");
    print_line(app, "compared with the reference's, byte by byte; clock CLOCK_MONOTONIC; baselines: %s",
               OST_BENCH_CFLAGS);
    if (options->quick)
        print_line(app, "--quick: few repetitions and small inputs; not for quoting");
    print_line(app, "%s", "");
    print_line(app, "%-30s %2s %8s %-15s %8s %-15s %7s %7s", "row", "", "ours", "min..max", "baseline", "min..max",
               "ratio", "of min");
}

/* ---------------------------------------------------------------- Markdown */

static void print_markdown_heading(const app_state *app, const bench_options *options, const char *suite)
{
    char cpu[BENCH_TEXT];
    print_line(
        app,
        "`osteon bench --suite %s --backend %s --threads %d%s --markdown`: %s, instruction set %s, %s, baselines %s.",
        suite, options->backend, options->threads, options->quick ? " --quick" : "", bench_cpu_model(cpu),
        bench_isa(options), COMPILER, OST_BENCH_CFLAGS);
    print_line(app, "%s", "");
    print_line(app, "| row | unit | ours | min..max | baseline | min..max | ratio | of minima | repetitions |");
    print_line(app, "|---|---|---:|---|---:|---|---:|---:|---:|");
}

static void print_markdown_row(const app_state *app, const bench_row *row)
{
    char ours[FIGURE], ours_range[RANGE], baseline[FIGURE] = "", baseline_range[RANGE] = "", ratio[FIGURE] = "",
                                          least[FIGURE] = "";
    if (row->reason[0] || !row->equal) {
        print_line(app, "| `%s` | %s | %s | | | | | | |", row->name, row->unit, row->reason[0] ? row->reason : "wrong");
        return;
    }
    if (row->baseline.count) {
        figure(baseline, row->baseline.median);
        range(baseline_range, &row->baseline);
        figure(ratio, bench_row_ratio(row));
        figure(least, bench_row_ratio_of_minima(row));
    }
    print_line(app, "| `%s` | %s | %s | %s | %s | %s | %s | %s | %zu |", row->name, row->unit,
               figure(ours, row->ours.median), range(ours_range, &row->ours), baseline, baseline_range, ratio, least,
               row->ours.count);
    const double *p99 = extra_of(row, "p99"), *max = extra_of(row, "max"), *best = extra_of(row, "undisturbed_p99");
    char a[FIGURE], b[FIGURE], c[FIGURE];
    if (p99 && max && best)
        print_line(app, "| p99, max a tick | %s | %s, %s | least of all repetitions, p99: %s | | | | | |", row->unit,
                   figure(a, *p99), figure(b, *max), figure(c, *best));
}

/* --------------------------------------------------------------------- verb */

static void show_row(void *user, const char *row)
{
    (void)user;
    progress_show(NULL, row, 0);
}

/* Counts of all rows of the benchmark, and the first error. */
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
        print_markdown_heading(app, options, suite);
    else if (table->count && first)
        print_heading(app, options);
    else if (table->count && !markdown)
        print_line(app, "%s", "");
    for (size_t i = 0; i < table->count; i++) {
        append(json_object_get(app->result, "rows"), json_of_row(&table->rows[i]));
        if (markdown)
            print_markdown_row(app, &table->rows[i]);
        else
            print_row(app, &table->rows[i]);
        all->wrong = all->wrong || !table->rows[i].equal;
        all->run += !table->rows[i].reason[0];
        if (table->rows[i].reason[0] && !all->reason[0])
            memcpy(all->reason, table->rows[i].reason, sizeof all->reason);
    }
    all->rows += table->count;
    if (!markdown) {
        print_baselines(app, table);
        print_disturbed(app, table);
    }
}

static ost_status run_suites(app_state *app, const bench_options *options, const char *suite, bool markdown,
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

static bool suite_is_built(const char *suite)
{
    if (strcmp(suite, "all") == 0)
        return true;
    for (const bench_suite *s = bench_suites; s->name; s++)
        if (strcmp(suite, s->name) == 0)
            return true;
    return false;
}

ost_status cmd_bench(app_state *app, int argc, char **argv, ost_error *err)
{
    static const char suites[] = "removal|tick|transfer|parse|voxelize|candidates|opencl|render|servo|all";
    static const char *const names[] = {"removal",    "tick",   "transfer", "parse", "voxelize",
                                        "candidates", "opencl", "render",   "servo", "all"};
    int suite = 9;
    int64_t repeat = 0;
    bool markdown = false;
    const char *earlier = NULL, *slowdown = NULL;
    bench_against against;
    option_decimal scale = {.text = NULL};
    bench_options how = {0};
    const option options[] = {
        {.name = "suite", .kind = OPTION_CHOICE, .out = &suite, .value = suites,
         .help = "suite of rows to measure (default: all)"},
        {.name = "filter", .kind = OPTION_TEXT, .out = &how.filter, .value = "TEXT",
         .help = "measure the rows whose name contains TEXT"},
        {.name = "repeat", .kind = OPTION_INTEGER, .out = &repeat, .value = "N", .min = 1, .max = 100000,
         .help = "repetitions of every row (default: a number defined for each row)"},
        {.name = "quick", .kind = OPTION_FLAG, .out = &how.quick,
         .help = "use three repetitions and small inputs, to check that everything runs"},
        {.name = "scale", .kind = OPTION_DECIMAL, .out = &scale, .value = "SHARE",
         .help = "fraction of the 12,040,704 lines that parse/text reads (default: 1, 424 MB in TMPDIR)"},
        {.name = "against", .kind = OPTION_TEXT, .out = &earlier, .value = "FILE",
         .help = "compare the ratios with those in FILE, which an earlier run with --json printed"},
        {.name = "max-slowdown", .kind = OPTION_TEXT, .out = &slowdown, .value = "PERCENT",
         .help = "with --against: greatest slowdown of a row that is not an error (default: 10%)"},
        {.name = "markdown", .kind = OPTION_FLAG, .out = &markdown, .help = "print the table of docs/performance.md"},
        {.name = NULL}};
    const usage_text usage = {
        .synopsis = "[--suite NAME] [options]",
        .about = "Measures osteon and its baselines in the same run. The baselines are the thesis'\n"
                 "kernel in C for removal, a copy for transfer, fscanf for parsing, Embree for\n"
                 "voxelization, and the thesis' kernel in OpenCL for OpenCL. Before a row is\n"
                 "measured, its grid is compared with that of the reference, byte by byte.",
        .options = options,
        .notes = "Figures are medians, with minimum and maximum; ratio is the baseline's time divided\n"
                 "by osteon's. Rows that end in /1 and those of the suite tick use one thread; all\n"
                 "others use --threads (default: all). Other work on the machine changes the figures,\n"
                 "the minima least. docs/performance.md explains the rows, their limits and their\n"
                 "goals.\n"
                 "A row that cannot run on this machine (for example because the device or the host\n"
                 "has too little memory) is printed as not run, with the reason. The other rows are\n"
                 "still measured.\n"
                 "--against compares the ratios of the shortest times, which depend less on the machine\n"
                 "and its load than the times do. A row without a baseline is not compared.\n"
                 "Exit status 0: rows were measured; 1: the grid of a row differs from that of the\n"
                 "reference, or a row is slower than --max-slowdown allows; 2: wrong usage; 3: no row\n"
                 "could run, or the backend is not available.",
        .example = "  osteon bench --suite removal --filter reamer/32\n  osteon bench --suite voxelize --backend "
                   "cpu:voxelizer=embree\n"
                   "  osteon bench --suite removal --json >old.json\n"
                   "  osteon bench --suite removal --against old.json --max-slowdown 10%",
    };
    ost_status status;
    if (!options_parse(app, &usage, argc, argv, &status, err))
        return status;
    if (!suite_is_built(names[suite]))
        return ost_fail(err, OST_ERR_UNAVAILABLE, "suite %s is not part of this build", names[suite]);
    int64_t millionths = 1000000;
    if (scale.text &&
        (!ost_decimal_scale(&scale.value, 1000000, &millionths, NULL) || millionths < 1 || millionths > 1000000))
        return usage_error(app, err, "--scale %s: must be from 0.000001 to 1", scale.text);
    how.scale = (double)millionths / 1e6;
    how.backend = app->backend;
    how.threads = app->threads ? (int)app->threads : bench_cpus();
    how.repeat = (int)repeat;
    how.show = show_row;

    status = bench_against_read(app, earlier, slowdown, how.quick, &against, err);
    if (status != OST_OK)
        return status;
    put_setting(app, &how, names[suite]);
    status = run_suites(app, &how, names[suite], markdown, err);
    if (status == OST_OK && earlier)
        status = bench_against_compare(app, &against, err);
    bench_against_free(&against);
    return status;
}
