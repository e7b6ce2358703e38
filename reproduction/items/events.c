/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tables 3.3 to 3.5: the static events of the thesis, from the rows of `osteon bench` (bench/suite_removal.c).
 *
 *   osteon           the event, executed through the public interface of the library
 *   thesis' kernel   the same event: in C on the processor or, with the backend cl, in OpenCL on the same device
 *
 * osteon and the thesis' kernel are measured alternately on the same bone. The thesis' statements can therefore be
 * judged for both algorithms on the same machine.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench/scene.h"
#include "reproduction/item.h"
#include "reproduction/stated.h"

/* Two times are treated as equal if they differ by at most this fraction of the shorter time. */
#define TOLERANCE 0.05

enum { SIZE, CHUNKS, VOXELS, EVENT, LEAST, STEADY, LOOP, LOOP_LEAST, LOOP_CHUNK, RATIO, REMOVED };

static bool on_device(const reproduction *r)
{
    return strncmp(r->bench.backend, "cl", 2) == 0 && (!r->bench.backend[2] || r->bench.backend[2] == ':');
}

static const bench_row *find_row(const bench_table *table, const char *name)
{
    for (size_t i = 0; i < table->count; i++)
        if (strcmp(table->rows[i].name, name) == 0)
            return &table->rows[i];
    return NULL;
}

static double extra_of(const bench_row *row, const char *key)
{
    for (int i = 0; i < row->extra_count; i++)
        if (strcmp(row->extra[i].key, key) == 0)
            return row->extra[i].value;
    return 0;
}

static void show_row(void *user, const char *row)
{
    reproduction_show(user, row, 0);
}

/* Runs the benchmark rows whose names contain the filter. */
static ost_status run_rows(reproduction *r, const char *filter, bench_table *table, ost_error *err)
{
    bench_options options = r->bench;
    options.filter = filter;
    options.show = show_row;
    options.user = r;
    return on_device(r) && strncmp(filter, "opencl/", 7) == 0 ? bench_opencl(&options, table, err)
                                                              : bench_removal(&options, table, err);
}

/* Returns an error if the row was not measured or its result is wrong. */
static ost_status check_row(const bench_row *row, const char *name, ost_error *err)
{
    if (!row)
        return ost_fail(err, OST_ERR_INTERNAL, "%s: osteon bench has no such row", name);
    if (row->reason[0])
        return ost_fail(err, OST_ERR_UNAVAILABLE, "%s: %s", name, row->reason);
    return row->equal ? OST_OK : ost_fail(err, OST_ERR_DIFFER, "%s: the grid differs from the reference's", name);
}

static void add_columns(result *out, const char *size_key, const char *size_title, const char *unit)
{
    result_add_column(out, size_key, size_title, unit);
    result_add_column(out, "chunks", "chunks hit", "");
    result_add_column(out, "tool_voxels", "voxels of the tool", "");
    result_add_column(out, "osteon_us", "osteon, fresh", "us");
    result_add_column(out, "osteon_min_us", "osteon, shortest", "us");
    result_add_column(out, "osteon_steady_us", "osteon, nothing left to remove", "us");
    result_add_column(out, "event_us", "kernel of the thesis", "us");
    result_add_column(out, "event_min_us", "kernel, shortest", "us");
    result_add_column(out, "chunk_us", "kernel, per chunk", "us");
    result_add_column(out, "ratio", "kernel / osteon", "");
    result_add_column(out, "removed_voxels", "removed voxels", "");
}

static void add_event(result *out, const bench_row *fresh, const bench_row *steady)
{
    const double chunks = extra_of(fresh, "chunks");
    result_set(out, CHUNKS, chunks);
    result_set(out, EVENT, fresh->ours.median);
    result_set(out, LEAST, fresh->ours.min);
    if (steady && !steady->reason[0])
        result_set(out, STEADY, steady->ours.median);
    result_set(out, REMOVED, extra_of(fresh, "removed_voxels"));
    if (!fresh->baseline.count)
        return;
    result_set(out, LOOP, fresh->baseline.median);
    result_set(out, LOOP_LEAST, fresh->baseline.min);
    result_set(out, RATIO, bench_row_ratio(fresh));
    if (chunks > 0)
        result_set(out, LOOP_CHUNK, fresh->baseline.median / chunks);
}

static void remark_event(const reproduction *r, result *out)
{
    result_add_remark(
        out,
        "The thesis gives no poses. The tool's pose in a bone that is full of active voxels was chosen so "
        "that the numbers of chunks are those of the thesis. The thesis measured its kernel on a GTX "
        "1070, one launch per chunk; here the same kernel runs %s.",
        on_device(r) ? "in OpenCL on the device of the backend cl"
                     : "in C on the processor. osteon and the kernel use one thread, as a servo loop does");
    result_add_remark(out, "Fresh: all voxels are there, and the bone is in the caches. Medians of repetitions that "
                           "alternate with the kernel's; every grid was first compared with the reference's.");
}

/* --------------------------------------------------------- Tables 3.3 and 3.4 */

/* Compares two rows by their median times and by their shortest times. Returns the order (-1, 0 or 1) if both
   comparisons agree, and 0 if they disagree. */
static int order_rows(const result *out, int a, int b, int median, int least)
{
    const result_cell *x = out->row[a].cell, *y = out->row[b].cell;
    const int by_median = result_order(x[median].value, y[median].value, TOLERANCE),
              by_least = result_order(x[least].value, y[least].value, TOLERANCE);
    return by_median == by_least ? by_median : 0;
}

/* Returns the verdict, or RESULT_UNDECIDED for --quick, because few repetitions are not sufficient for a verdict. */
static result_verdict judged(const reproduction *r, result_verdict verdict)
{
    return r->bench.quick ? RESULT_UNDECIDED : verdict;
}

/* Judges the statement that the chunk size with index `best` is the fastest of the three. */
static void judge_best(const reproduction *r, result *out, int best, int median, int least, const char *who,
                       const char *source, const char *claim, const char *why)
{
    int worse = 0, better = 0;
    for (int i = 0; i < 3; i++) {
        const int order = order_rows(out, best, i, median, least);
        worse += i != best && order > 0;
        better += i != best && order < 0;
    }
    const result_verdict verdict = judged(r, worse         ? RESULT_CONTRADICTED
                                             : better == 2 ? RESULT_CONFIRMED
                                                           : RESULT_UNDECIDED);
    result_add_finding(
        out, verdict, source, claim, "%s: shortest times of %.1f, %.1f and %.1f us with 16^3, 32^3 and 64^3%s. %s", who,
        out->row[0].cell[least].value, out->row[1].cell[least].value, out->row[2].cell[least].value,
        r->bench.quick                ? " (--quick: no verdict)"
        : verdict == RESULT_UNDECIDED ? "; the order differs by less than 5 % or between medians and shortest "
                                        "times"
                                      : "",
        why);
}

static void judge_sizes(const reproduction *r, result *out, ost_tool_kind kind)
{
    const bool reamer = kind == OST_TOOL_REAMER;
    const char *source = reamer ? "section 3.2.2, Table 3.3" : "section 3.2.2, Table 3.4";
    const char *claim = reamer ? "Chunks of 32^3 voxels are the fastest in general."
                               : "Chunks of 16^3 voxels are the fastest for small tools.";
    if (out->row[0].cell[LOOP].known) {
        const result_cell *c[3] = {out->row[0].cell, out->row[1].cell, out->row[2].cell};
        char why[RESULT_TEXT];
        snprintf(why, sizeof why,
                 "The kernel visits every voxel of the chunks that are hit: %.0f, %.0f and %.0f thousand voxels%s.",
                 c[0][CHUNKS].value * 4.096, c[1][CHUNKS].value * 32.768, c[2][CHUNKS].value * 262.144,
                 on_device(r) ? "" : ", and on the processor a chunk costs no launch");
        judge_best(r, out, reamer ? 1 : 0, LOOP, LOOP_LEAST, "The thesis' kernel on this machine", source, claim, why);
        judge_best(
            r, out, reamer ? 1 : 0, EVENT, LEAST, "osteon", source, claim,
            "osteon visits only the blocks of voxels that the tool can reach, which are the same for every size of "
            "the chunks; what remains is the work per chunk.");
        const bool worst = order_rows(out, 2, 0, LOOP, LOOP_LEAST) > 0 && order_rows(out, 2, 1, LOOP, LOOP_LEAST) > 0;
        const int spread = (int)(100 * (c[2][LOOP_LEAST].value / c[2][CHUNKS].value / 8 /
                                            (c[1][LOOP_LEAST].value / c[1][CHUNKS].value) -
                                        1));
        result_add_finding(
            out, judged(r, worst ? RESULT_CONFIRMED : RESULT_CONTRADICTED), source,
            "Chunks of 64^3 voxels are the slowest.",
            "The thesis' kernel takes %.1f us with 64^3, and %.1f and %.1f us with 16^3 and 32^3, because a "
            "chunk is visited completely or not at all. Its time per voxel differs by %d %% between 32^3 "
            "and 64^3.",
            c[2][LOOP_LEAST].value, c[0][LOOP_LEAST].value, c[1][LOOP_LEAST].value, spread);
    }
}

static ost_status item_event(reproduction *r, result *out, ost_tool_kind kind, ost_error *err)
{
    static const int sizes[] = {16, 32, 64};
    const char *tool = ost_tool_kind_name(kind), *suite = on_device(r) ? "opencl" : "removal";
    const stated_event *stated = kind == OST_TOOL_REAMER ? stated_reamer : stated_peg;
    char filter[BENCH_NAME];
    bench_table table = {.rows = NULL};
    bench_scene scene;
    add_columns(out, "chunk_voxels", "chunk side (voxels)", "");
    snprintf(filter, sizeof filter, "%s/%s/", suite, tool);
    ost_status status = run_rows(r, filter, &table, err);
    if (status == OST_OK)
        status = bench_scene_init(&scene, kind, OST_PM_PER_MM / 2, SCENE_SIDE, err);
    const double tool_voxels = status == OST_OK ? (double)ost_dims_count(scene.tool.geometry.dims) : 0;
    if (status == OST_OK)
        bench_scene_free(&scene);
    for (int i = 0; i < 3 && status == OST_OK; i++) {
        char fresh[BENCH_NAME], steady[BENCH_NAME];
        snprintf(fresh, sizeof fresh, "%s/%s/%d/fresh%s", suite, tool, sizes[i], on_device(r) ? "" : "/1");
        snprintf(steady, sizeof steady, "%s/%s/%d/steady%s", suite, tool, sizes[i], on_device(r) ? "" : "/1");
        const bench_row *row = find_row(&table, fresh);
        status = check_row(row, fresh, err);
        if (status != OST_OK)
            break;
        result_add_row(out);
        result_set(out, SIZE, sizes[i]);
        add_event(out, row, find_row(&table, steady));
        result_set(out, VOXELS, tool_voxels);
        result_set_thesis(out, CHUNKS, stated[i].chunks);
        result_set_thesis(out, LOOP, 1e3 * stated[i].event_ms);
        result_set_thesis(out, LOOP_CHUNK, 1e3 * stated[i].chunk_ms);
    }
    bench_table_free(&table);
    if (status == OST_OK && !out->out_of_memory)
        judge_sizes(r, out, kind);
    remark_event(r, out);
    result_plot *p =
        result_add_plot(out, RESULT_PLOT_LINES,
                        kind == OST_TOOL_REAMER ? "Static event of the reamer" : "Static event of the peg drill",
                        "side of a chunk (voxels)", "time of an event (us)");
    p->x = SIZE;
    p->value[p->values++] = EVENT;
    p->value[p->values++] = LOOP;
    p->log_x = p->log_y = true;
    return status;
}

ost_status item_event_reamer(reproduction *r, result *out, ost_error *err)
{
    return item_event(r, out, OST_TOOL_REAMER, err);
}

ost_status item_event_peg(reproduction *r, result *out, ost_error *err)
{
    return item_event(r, out, OST_TOOL_PEG, err);
}

/* ----------------------------------------------------------------- Table 3.5 */

static void judge_tool_voxels(const reproduction *r, result *out, int median, int least, const char *who,
                              const char *why)
{
    double low = out->row[0].cell[least].value, high = low, median_low = out->row[0].cell[median].value,
           median_high = median_low;
    for (size_t i = 1; i < out->row_count; i++) {
        const double t = out->row[i].cell[least].value, m = out->row[i].cell[median].value;
        low = t < low ? t : low;
        high = t > high ? t : high;
        median_low = m < median_low ? m : median_low;
        median_high = m > median_high ? m : median_high;
    }
    const double spread = high / low - 1;
    const result_cell *coarse = out->row[0].cell, *fine = out->row[out->row_count - 1].cell;
    result_add_finding(
        out, judged(r, spread < 0.1 ? RESULT_CONFIRMED : RESULT_CONTRADICTED), "section 3.2.6, Table 3.5",
        "The time of an event does not depend on the resolution of the tool.",
        "%s: the shortest times of tools with %.0f to %.0f voxels differ by %.0f %% (medians: %.0f %%).%s", who,
        coarse[VOXELS].value, fine[VOXELS].value, 100 * spread, 100 * (median_high / median_low - 1),
        spread < 0.1 ? "" : why);
}

ost_status item_tool_voxels(reproduction *r, result *out, ost_error *err)
{
    static const struct {
        const char *name;
        double mm;
    } voxels[] = {{"1", 1}, {"0.75", 0.75}, {"0.5", 0.5}, {"0.25", 0.25}};
    bench_table table = {.rows = NULL};
    add_columns(out, "tool_voxel_mm", "tool voxel", "mm");
    ost_status status = run_rows(r, "removal/voxel/", &table, err);
    for (size_t i = 0; i < sizeof voxels / sizeof voxels[0] && status == OST_OK; i++) {
        char fresh[BENCH_NAME], steady[BENCH_NAME];
        bench_scene scene;
        snprintf(fresh, sizeof fresh, "removal/voxel/%s/fresh/1", voxels[i].name);
        snprintf(steady, sizeof steady, "removal/voxel/%s/steady/1", voxels[i].name);
        const bench_row *row = find_row(&table, fresh);
        status = check_row(row, fresh, err);
        if (status == OST_OK)
            status = bench_scene_init(&scene, OST_TOOL_REAMER, (ost_pm)(voxels[i].mm * 100) * (OST_PM_PER_MM / 100),
                                      SCENE_SIDE, err);
        if (status != OST_OK)
            break;
        result_add_row(out);
        result_set(out, SIZE, voxels[i].mm);
        add_event(out, row, find_row(&table, steady));
        result_set(out, VOXELS, (double)ost_dims_count(scene.tool.geometry.dims));
        bench_scene_free(&scene);
        if (i < 3) {
            result_set_thesis(out, CHUNKS, stated_tool_voxels[i].chunks);
            result_set_thesis(out, VOXELS, stated_tool_voxels[i].voxels);
            result_set_thesis(out, LOOP, 1e3 * stated_tool_voxels[i].event_ms);
            result_set_thesis(out, LOOP_CHUNK, 1e3 * stated_tool_voxels[i].chunk_ms);
        }
    }
    bench_table_free(&table);
    if (status == OST_OK && !out->out_of_memory) {
        if (out->row[0].cell[LOOP].known)
            judge_tool_voxels(
                r, out, LOOP, LOOP_LEAST, "The thesis' kernel in C, one thread",
                " The number of visited voxels is constant, but a finer tool's grid does not fit into the "
                "nearer caches.");
        judge_tool_voxels(
            r, out, EVENT, LEAST, "osteon, one thread",
            " With 0.25 mm, there are 1.88 tool voxels per bone voxel, so that a brick of 4^3 voxels does not "
            "fit into a window of osteon's tables, and its voxels are looked up one by one.");
    }
    remark_event(r, out);
    result_add_remark(out,
                      "Table 3.5 of the thesis exchanges its rows for the time per chunk and the total time; they are "
                      "shown here in the order that 18 chunks imply. 0.25 mm "
                      "is not in the thesis.");
    result_plot *p = result_add_plot(out, RESULT_PLOT_LINES, "Static event of the reamer, chunks of 32^3",
                                     "edge of a tool voxel (mm)", "time of an event (us)");
    p->x = SIZE;
    p->value[p->values++] = EVENT;
    p->value[p->values++] = LOOP;
    p->log_x = p->log_y = true;
    return status;
}
