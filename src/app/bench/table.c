/* SPDX-License-Identifier: Apache-2.0 */
/* Prints the rows of a benchmark as a plain-text or Markdown table. */
#include "app/bench/rows.h"

#include <stdio.h>
#include <string.h>

#include "config.h"

#include "app/common/print.h"

enum { FIGURE = 32, RANGE = 2 * FIGURE + 2 };

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

/* -------------------------------------------------------------------- text */

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

void bench_print_row(const app_state *app, const bench_row *row)
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
void bench_print_disturbed(const app_state *app, const bench_table *table)
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
void bench_print_baselines(const app_state *app, const bench_table *table)
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

void bench_print_heading(const app_state *app, const bench_options *options)
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

void bench_print_markdown_heading(const app_state *app, const bench_options *options, const char *suite)
{
    char cpu[BENCH_TEXT];
    print_line(
        app,
        "`osteon bench --suite %s --backend %s --threads %d%s --markdown`: %s, instruction set %s, %s, baselines %s.",
        suite, options->backend, options->threads, options->quick ? " --quick" : "", bench_cpu_model(cpu),
        bench_isa(options), BENCH_COMPILER, OST_BENCH_CFLAGS);
    print_line(app, "%s", "");
    print_line(app, "| row | unit | ours | min..max | baseline | min..max | ratio | of minima | repetitions |");
    print_line(app, "|---|---|---:|---|---:|---|---:|---:|---:|");
}

void bench_print_markdown_row(const app_state *app, const bench_row *row)
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
