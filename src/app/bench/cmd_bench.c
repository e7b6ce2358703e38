/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Implements `osteon bench`: runs the suites of bench/ and prints their rows as a table, as a
 * Markdown table (--markdown), or as JSON.
 *
 *   options --> run.c: a suite at a time --> rows.h: table, Markdown, JSON
 *                                        --> against.h: comparison with an earlier run (--against)
 */
#include "app/bench/against.h"
#include "app/bench/rows.h"
#include "app/bench/run.h"
#include "app/common/options.h"
#include "app/common/progress.h"

static void show_row(void *user, const char *row)
{
    (void)user;
    progress_show(NULL, row, 0);
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
        {.name = "markdown", .kind = OPTION_FLAG, .out = &markdown, .help = "print a Markdown table"},
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
                 "the minima least. docs/reference/benchmarks.md explains the suites, and\n"
                 "docs/performance.md lists results, limits and goals.\n"
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
    if (!bench_suite_is_built(names[suite]))
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
    bench_put_setting(app, &how, names[suite]);
    status = bench_run_suites(app, &how, names[suite], markdown, err);
    if (status == OST_OK && earlier)
        status = bench_against_compare(app, &against, err);
    bench_against_free(&against);
    return status;
}
