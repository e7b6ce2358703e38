/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Figures 3.8 to 3.12: the time of an event with the chunk system, for different numbers of chunks, and with the
 * methods that process the tool's voxels instead of the bone's (reproduction/methods/).
 *
 *   by_chunks       Figs. 3.8 and 3.10 to 3.12: the peg drill in a bone in which 1 to 64 chunks have active voxels
 *   by_resolution   Figs. 3.10 to 3.12: the static event of the peg drill; tool and bone have 64^3 to 1024^3 voxels
 *
 * Both tables are measured once per run. The time of a tool-to-bone method does not depend on the number of chunks, so
 * its line in a plot is horizontal.
 *
 * The file has more than 500 lines because its figures share their measurements and helpers.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "reproduction/item.h"
#include "reproduction/stated.h"

enum { METHOD, TOOL_SIDE, BONE_SIDE, CHUNKS, TIME, LEAST, VISITED, MISSED, KERNEL_TO, OSTEON_TO };
#define TOLERANCE 0.05
static const int counts[] = {1, 2, 4, 6, 8, 12, 16, 20, 24, 32, 48, 64};
static const int32_t sides[] = {64, 256, 1024}, sides_quick[] = {64, 128};
enum { COUNTS = sizeof counts / sizeof counts[0], SIDES = 3, SIDES_QUICK = 2 };

static void show_case(void *user, const char *text)
{
    reproduction_show(user, text, 0);
}

/*
 * Returns the name of the method to use in this run. With the backend cl, this is the method's variant for OpenCL
 * devices.
 */
static const char *method_name(const reproduction *r, const char *base, char name[48])
{
    snprintf(name, 48, "%s%s", base, r->cl[0] ? "-cl" : "");
    return name;
}

static methods_options options_of(reproduction *r, const char *names)
{
    return (methods_options){.backend = r->cl[0] ? "cpu" : r->bench.backend,
                             .cl = r->cl[0] ? r->cl : NULL,
                             .threads = 1,
                             .repeat = r->bench.repeat,
                             .quick = r->bench.quick,
                             .methods = names,
                             .show = show_case,
                             .user = r};
}

/* Measures the events with 1 to 64 chunks, unless they have already been measured. */
static ost_status measure_by_chunks(reproduction *r, ost_error *err)
{
    char names[128], a[48], b[48];
    if (r->by_chunks.count)
        return OST_OK;
    snprintf(names, sizeof names, "%s,%s", method_name(r, "osteon", a), method_name(r, "thesis_chunks", b));
    const methods_options options = options_of(r, names);
    ost_status status = methods_chunk_counts(&options, OST_TOOL_PEG, counts, COUNTS, &r->by_chunks, err);
    if (status != OST_OK)
        methods_table_free(&r->by_chunks);
    return status;
}

static ost_status measure_by_resolution(reproduction *r, ost_error *err)
{
    static const char *const bases[] = {"osteon", "thesis_chunks", "reza", "zheng", "yau"};
    char names[256] = "", name[48];
    if (r->by_resolution.count)
        return OST_OK;
    for (size_t i = 0; i < sizeof bases / sizeof bases[0]; i++) {
        const size_t at = strlen(names);
        snprintf(names + at, sizeof names - at, "%s%s", i ? "," : "", method_name(r, bases[i], name));
    }
    const methods_options options = options_of(r, names);
    const int32_t *const list = r->bench.quick ? sides_quick : sides;
    const int count = r->bench.quick ? SIDES_QUICK : SIDES;
    ost_status status = methods_resolutions(&options, OST_TOOL_PEG, list, count, list, count, &r->by_resolution, err);
    if (status != OST_OK)
        methods_table_free(&r->by_resolution);
    return status;
}

static bool is_method(const reproduction *r, const methods_row *row, const char *base)
{
    char name[48];
    return strcmp(row->method->name, method_name(r, base, name)) == 0;
}

/* Returns OST_ERR_DIFFER if a measured method did not remove exactly the voxels that its definition demands. */
static ost_status check_rows(const methods_table *table, ost_error *err)
{
    for (size_t i = 0; i < table->count; i++)
        if (!table->rows[i].reason[0] && !table->rows[i].exact)
            return ost_fail(err, OST_ERR_DIFFER, "%s: the removed voxels are not those of the method's definition",
                            table->rows[i].method->name);
    return OST_OK;
}

static void add_columns(result *out)
{
    result_add_column(out, "method", "method", "text");
    result_add_column(out, "tool_side", "tool side (voxels)", "");
    result_add_column(out, "bone_side", "bone side (voxels)", "");
    result_add_column(out, "chunks", "chunks", "");
    result_add_column(out, "event_us", "event", "us");
    result_add_column(out, "event_min_us", "shortest", "us");
    result_add_column(out, "visited", "voxels or points visited", "");
    result_add_column(out, "missed_percent", "missed voxels", "%");
}

static void add_row(result *out, const methods_row *row, const char *label, double chunks)
{
    result_add_row(out);
    result_set_text(out, METHOD, "%s", label);
    result_set(out, TOOL_SIDE, row->tool_side);
    result_set(out, BONE_SIDE, row->bone_side);
    result_set(out, CHUNKS, chunks);
    result_set(out, TIME, row->fresh.median);
    result_set(out, LEAST, row->fresh.min);
    if (row->visited)
        result_set(out, VISITED, (double)row->visited);
    if (row->expected)
        result_set(out, MISSED, 100 * (double)row->missed / (double)row->expected);
}

static const char *label_of(const reproduction *r, const methods_row *row)
{
    const bool reamer = strcmp(row->tool, ost_tool_kind_name(OST_TOOL_REAMER)) == 0;
    if (is_method(r, row, "osteon"))
        return reamer ? "osteon, reamer" : "osteon, peg drill";
    return reamer ? "chunks of the thesis, reamer" : "chunks of the thesis, peg drill";
}

static void add_by_chunks(const reproduction *r, result *out, const methods_table *table)
{
    static const char *const bases[] = {"thesis_chunks", "osteon"};
    for (size_t b = 0; b < sizeof bases / sizeof bases[0]; b++)
        for (size_t i = 0; i < table->count; i++) {
            const methods_row *row = &table->rows[i];
            if (is_method(r, row, bases[b]) && !row->reason[0])
                add_row(out, row, label_of(r, row), row->chunks);
        }
}

static void remark_reasons(const methods_table *table, result *out)
{
    for (size_t i = 0; i < table->count; i++) {
        const methods_row *row = &table->rows[i];
        bool known = !row->reason[0];
        for (size_t k = 0; k < i && !known; k++)
            known = strcmp(table->rows[k].reason, row->reason) == 0;
        if (known)
            continue;
        if (row->tool_side)
            result_add_remark(out, "Not measured: %s, a tool of %d^3 and a bone of %d^3 voxels: %s.", row->method->name,
                              (int)row->tool_side, (int)row->bone_side, row->reason);
        else
            result_add_remark(out, "Not measured: %d and more chunks: %s.", row->chunks, row->reason);
    }
}

static void plot_by_chunks(result *out, const char *title)
{
    result_plot *p =
        result_add_plot(out, RESULT_PLOT_LINES, title, "chunks that the event processes", "time of an event (us)");
    p->x = CHUNKS;
    p->group = METHOD;
    p->value[p->values++] = TIME;
    p->log_x = p->log_y = true;
}

/* -------------------------------------------------------------- Figure 3.8 */

/*
 * Returns the time of a method for a number of chunks, by linear interpolation. Returns 0 if the time was not measured.
 */
static double time_at(const reproduction *r, const char *base, double chunks, bool least)
{
    const methods_row *below = NULL, *above = NULL;
    for (size_t i = 0; i < r->by_chunks.count; i++) {
        const methods_row *row = &r->by_chunks.rows[i];
        if (!is_method(r, row, base) || row->reason[0])
            continue;
        if (row->chunks <= chunks && (!below || row->chunks > below->chunks))
            below = row;
        if (row->chunks >= chunks && (!above || row->chunks < above->chunks))
            above = row;
    }
    if (!below || !above)
        return 0;
    const double a = least ? below->fresh.min : below->fresh.median, b = least ? above->fresh.min : above->fresh.median;
    if (above->chunks == below->chunks)
        return a;
    return a + (b - a) * (chunks - below->chunks) / (above->chunks - below->chunks);
}

/* Returns the greatest number of chunks that was measured. */
static int most_chunks(const reproduction *r)
{
    int most = 1;
    for (size_t i = 0; i < r->by_chunks.count; i++)
        if (!r->by_chunks.rows[i].reason[0] && r->by_chunks.rows[i].chunks > most)
            most = r->by_chunks.rows[i].chunks;
    return most;
}

static result_verdict judged(const reproduction *r, bool confirmed)
{
    return r->bench.quick ? RESULT_UNDECIDED : confirmed ? RESULT_CONFIRMED : RESULT_CONTRADICTED;
}

ost_status item_chunk_counts(reproduction *r, result *out, ost_error *err)
{
    char names[128], a[48], b[48];
    methods_table reamer = {.rows = NULL};
    snprintf(names, sizeof names, "%s,%s", method_name(r, "osteon", a), method_name(r, "thesis_chunks", b));
    const methods_options options = options_of(r, names);
    ost_status status = measure_by_chunks(r, err);
    if (status == OST_OK)
        status = check_rows(&r->by_chunks, err);
    if (status == OST_OK)
        status = methods_chunk_counts(&options, OST_TOOL_REAMER, counts, COUNTS, &reamer, err);
    if (status == OST_OK)
        status = check_rows(&reamer, err);
    if (status != OST_OK) {
        methods_table_free(&reamer);
        return status;
    }
    const int most = most_chunks(r);
    add_columns(out);
    add_by_chunks(r, out, &r->by_chunks);
    add_by_chunks(r, out, &reamer);
    methods_table_free(&reamer);
    const double one = time_at(r, "thesis_chunks", 6, true) / 6, many = time_at(r, "thesis_chunks", most, true) / most,
                 ours = time_at(r, "osteon", 20, true), twenty = time_at(r, "thesis_chunks", 20, true);
    if (one > 0 && many > 0)
        result_add_finding(out, judged(r, many / one < 1.25 && one / many < 1.25), "section 3.2.2",
                           "The time of an event is proportional to the number of chunks.",
                           "The thesis' kernel takes %.1f us per chunk with 6 chunks and %.1f us with %d (shortest "
                           "times). The farther "
                           "chunks have fewer voxels in the tool's box, for which it looks up the tool.",
                           one, many, most);
    if (ours > 0 && twenty > 0)
        result_add_finding(out, judged(r, twenty < 1000), "sections 2.5, 3.2.3",
                           "An event of up to 20 chunks fits into a tick of the haptic loop, 1 ms.",
                           "With 20 chunks, the thesis' kernel takes %.0f us and osteon %.0f us on %s.", twenty, ours,
                           r->cl[0] ? "this device" : "one core of this processor");
    result_add_remark(
        out, "A tool inside a bone of 256^3 voxels, of which only the stated number of chunks has active voxels. The "
             "thesis plots four computers; --merge adds further machines and devices.");
    remark_reasons(&r->by_chunks, out);
    plot_by_chunks(out, "Event by number of chunks");
    return OST_OK;
}

/* ----------------------------------------------------- Figures 3.10 to 3.12 */

/* Returns the greatest number of chunks for which a bone-to-tool method takes at most `time`. Returns 0 if there is
   none. */
static int crossing(const reproduction *r, const char *base, double time)
{
    int last = 0;
    for (int n = 1; n <= most_chunks(r); n++) {
        const double t = time_at(r, base, n, true);
        if (t > 0 && t > time)
            return last;
        last = t > 0 ? n : last;
    }
    return last;
}

static void describe_crossing(const reproduction *r, char text[64], int n)
{
    if (n == 0)
        snprintf(text, 64, "for no number of chunks");
    else if (n == most_chunks(r))
        snprintf(text, 64, "for all numbers of chunks, up to %d", n);
    else
        snprintf(text, 64, "for up to %d chunk%s", n, n == 1 ? "" : "s");
}

/* Judges the thesis' statements about the crossing, that is, the greatest number of chunks for which the chunk system
   is at least as fast as the method named by `base`. Compares the lowest resolution with the highest. */
static void judge_crossing(const reproduction *r, result *out, const char *base, const char *who)
{
    const methods_row *highest = NULL, *lowest = NULL;
    char theirs[64], ours[64], claim[RESULT_TEXT];
    for (size_t i = 0; i < r->by_resolution.count; i++) {
        const methods_row *row = &r->by_resolution.rows[i];
        if (!is_method(r, row, base) || row->reason[0])
            continue;
        if (!highest || (int64_t)row->tool_side * row->bone_side > (int64_t)highest->tool_side * highest->bone_side)
            highest = row;
        if (!lowest || (int64_t)row->tool_side * row->bone_side < (int64_t)lowest->tool_side * lowest->bone_side)
            lowest = row;
    }
    if (!highest || !lowest)
        return;
    const int n = crossing(r, "thesis_chunks", highest->fresh.min), own = crossing(r, "osteon", highest->fresh.min);
    char lower[64];
    const int low = crossing(r, "thesis_chunks", lowest->fresh.min);
    describe_crossing(r, lower, low);
    describe_crossing(r, theirs, n);
    describe_crossing(r, ours, own);
    snprintf(claim, sizeof claim,
             "The chunk system matches or beats %s's method only if few chunks are hit and the resolutions are high.",
             who);
    result_add_finding(
        out, judged(r, n > low), "section 3.2.3", claim,
        "With %d and %d voxels per side of tool and bone, the method takes %.1f us, and the thesis' kernel is "
        "at least as fast %s. With %d and %d, it takes %.0f us, and the thesis' kernel is at least as fast "
        "%s, osteon %s.",
        (int)lowest->tool_side, (int)lowest->bone_side, lowest->fresh.min, lower, (int)highest->tool_side,
        (int)highest->bone_side, highest->fresh.min, theirs, ours);
    if (strcmp(base, "reza") == 0)
        result_add_finding(
            out, judged(r, n >= STATED_CROSSING_CHUNKS / 2 && n < most_chunks(r)), "section 3.2.3",
            "At 1024^3, the chunk system is faster than Reza's method for up to 12 chunks.",
            "The crossing point is %s %d chunks. At this resolution, the method reads its points and the bone "
            "from memory that no cache holds; the chunks of this measurement are in the caches.",
            n == most_chunks(r) ? "beyond" : "at", n);
}

/* Judges how the time of a method grows with the tool's resolution for a fixed bone. */
static void judge_growth(const reproduction *r, result *out, const char *base, const char *who)
{
    const methods_row *first = NULL, *last = NULL;
    for (size_t i = 0; i < r->by_resolution.count; i++) {
        const methods_row *row = &r->by_resolution.rows[i];
        if (!is_method(r, row, base) || row->reason[0] || (first && row->bone_side != first->bone_side))
            continue;
        first = first ? first : row;
        last = row;
    }
    if (!first || first == last || !(first->fresh.min > 0))
        return;
    char claim[RESULT_TEXT];
    snprintf(claim, sizeof claim, "The time of %s's method grows with the resolution of the tool.", who);
    result_add_finding(out, judged(r, result_order(last->fresh.min, first->fresh.min, TOLERANCE) > 0), "section 3.2.6",
                       claim, "%.1f us with a tool of %d voxels per side (%lld points), %.1f us with %d (%lld points).",
                       first->fresh.min, (int)first->tool_side, (long long)first->tool_points, last->fresh.min,
                       (int)last->tool_side, (long long)last->tool_points);
}

static ost_status compare(reproduction *r, result *out, const char *base, const char *who, ost_error *err)
{
    ost_status status = measure_by_chunks(r, err);
    if (status == OST_OK)
        status = check_rows(&r->by_chunks, err);
    if (status == OST_OK)
        status = measure_by_resolution(r, err);
    if (status == OST_OK)
        status = check_rows(&r->by_resolution, err);
    if (status != OST_OK)
        return status;
    add_columns(out);
    result_add_column(out, "kernel_to_chunks", "kernel of the thesis at least as fast up to", "");
    result_add_column(out, "osteon_to_chunks", "osteon at least as fast up to", "");
    add_by_chunks(r, out, &r->by_chunks);
    for (size_t i = 0; i < r->by_resolution.count; i++) {
        const methods_row *row = &r->by_resolution.rows[i];
        char label[RESULT_LABEL];
        if (!is_method(r, row, base) || row->reason[0])
            continue;
        snprintf(label, sizeof label, "%s, tool %d^3, bone %d^3", who, (int)row->tool_side, (int)row->bone_side);
        add_row(out, row, label, 1);
        add_row(out, row, label, most_chunks(r));
        result_set(out, KERNEL_TO, crossing(r, "thesis_chunks", row->fresh.min));
        result_set(out, OSTEON_TO, crossing(r, "osteon", row->fresh.min));
    }
    judge_crossing(r, out, base, who);
    judge_growth(r, out, base, who);
    result_add_remark(out,
                      "Our own implementation of the method, from its description: it transforms the surface points of "
                      "the tool and removes the bone voxels that contain them. Its time does not depend on the number "
                      "of chunks, so that its lines are horizontal. One thread, or the device of the backend cl.");
    result_add_remark(out,
                      "Missed voxels are those that osteon removes and the method does not: points that are farther "
                      "apart than the bone's voxels leave holes, and a tool that is only a surface leaves its inside "
                      "until the tool moves.");
    remark_reasons(&r->by_resolution, out);
    char title[RESULT_LABEL];
    snprintf(title, sizeof title, "Chunks against the method of %s", who);
    plot_by_chunks(out, title);
    return OST_OK;
}

ost_status item_reza(reproduction *r, result *out, ost_error *err)
{
    return compare(r, out, "reza", "Reza", err);
}

ost_status item_zheng(reproduction *r, result *out, ost_error *err)
{
    return compare(r, out, "zheng", "Zheng", err);
}

ost_status item_yau(reproduction *r, result *out, ost_error *err)
{
    return compare(r, out, "yau", "Yau", err);
}

/* -------------------------------------------------------------- Figure 3.9 */

/*
 * Returns the nominal size in `list` that is closest to `side`, the actual side of a grid in voxels. A grid is slightly
 * larger than its nominal size.
 */
static int32_t nearest_side(const int32_t *list, int count, int32_t side)
{
    int32_t nearest = list[0];
    for (int i = 1; i < count; i++)
        if (abs(list[i] - side) < abs(nearest - side))
            nearest = list[i];
    return nearest;
}

enum { VOXELS_METHOD, VOXELS_SIDE, VOXELS_TIME, VOXELS_LEAST, VOXELS_VISITED };

static void add_voxels(result *out, const methods_row *row, const char *label, double side)
{
    result_add_row(out);
    result_set_text(out, VOXELS_METHOD, "%s", label);
    result_set(out, VOXELS_SIDE, side);
    result_set(out, VOXELS_TIME, row->fresh.median);
    result_set(out, VOXELS_LEAST, row->fresh.min);
    if (row->visited)
        result_set(out, VOXELS_VISITED, (double)row->visited);
}

static void judge_voxels(const reproduction *r, result *out)
{
    const result_cell *chunks = NULL, *reza = NULL;
    for (size_t i = 0; i < out->row_count; i++) {
        const result_cell *cell = out->row[i].cell;
        if (cell[VOXELS_SIDE].value != 64)
            continue;
        if (strcmp(cell[VOXELS_METHOD].text, "chunks of the thesis, reamer") == 0)
            chunks = cell;
        if (strcmp(cell[VOXELS_METHOD].text, "Reza") == 0)
            reza = cell;
    }
    if (!chunks || !reza || !(reza[VOXELS_LEAST].value > 0))
        return;
    const double ratio = chunks[VOXELS_LEAST].value / reza[VOXELS_LEAST].value;
    result_add_finding(
        out, judged(r, ratio > 1), "section 3.2.3",
        "For 64^3 voxels, the chunk system is slower than Reza's method (0.44 ms against 0.19 ms).",
        "%.0f us against %.0f us: %.1f times as long (thesis: %.1f times). The method visits only the surface "
        "points of the tool's 64^3 voxels, the chunk system all voxels of 8 chunks.",
        chunks[VOXELS_LEAST].value, reza[VOXELS_LEAST].value, ratio, STATED_CHUNKS_64_MS / STATED_REZA_64_MS);
}

ost_status item_voxel_counts(reproduction *r, result *out, ost_error *err)
{
    static const struct {
        const char *base, *label;
    } compared[] = {{"reza", "Reza"}, {"zheng", "Zheng"}, {"yau", "Yau"}};
    static const int chunk_counts[] = {1, 8, 64}; /* together 32^3, 64^3 and 128^3 voxels */
    static const int32_t tool_sides[] = {32, 64, 128, 256}, bone_sides[] = {128};
    methods_table chunks = {.rows = NULL}, tools = {.rows = NULL};
    char names[256], a[48], b[48], c[48];
    result_add_column(out, "method", "method", "text");
    result_add_column(out, "side_voxels", "voxels: side of the cube", "");
    result_add_column(out, "event_us", "event", "us");
    result_add_column(out, "event_min_us", "shortest", "us");
    result_add_column(out, "visited", "voxels or points visited", "");
    snprintf(names, sizeof names, "%s,%s", method_name(r, "osteon", a), method_name(r, "thesis_chunks", b));
    methods_options options = options_of(r, names);
    ost_status status = methods_chunk_counts(&options, OST_TOOL_REAMER, chunk_counts, 3, &chunks, err);
    snprintf(names, sizeof names, "%s,%s,%s", method_name(r, "reza", a), method_name(r, "zheng", b),
             method_name(r, "yau", c));
    if (status == OST_OK)
        status = methods_resolutions(&options, OST_TOOL_REAMER, tool_sides, r->bench.quick ? 2 : 4, bone_sides, 1,
                                     &tools, err);
    if (status == OST_OK)
        status = check_rows(&chunks, err);
    if (status == OST_OK)
        status = check_rows(&tools, err);
    for (int m = 0; m < 2 && status == OST_OK; m++)
        for (size_t i = 0; i < chunks.count; i++)
            if (is_method(r, &chunks.rows[i], m ? "osteon" : "thesis_chunks") && !chunks.rows[i].reason[0])
                add_voxels(out, &chunks.rows[i], label_of(r, &chunks.rows[i]),
                           chunks.rows[i].chunks >= 64  ? 128
                           : chunks.rows[i].chunks >= 8 ? 64
                                                        : 32);
    for (size_t m = 0; m < sizeof compared / sizeof compared[0] && status == OST_OK; m++)
        for (size_t i = 0; i < tools.count; i++)
            if (is_method(r, &tools.rows[i], compared[m].base) && !tools.rows[i].reason[0])
                add_voxels(out, &tools.rows[i], compared[m].label,
                           nearest_side(tool_sides, 4, tools.rows[i].tool_side));
    if (status == OST_OK)
        judge_voxels(r, out);
    remark_reasons(&chunks, out);
    remark_reasons(&tools, out);
    methods_table_free(&chunks);
    methods_table_free(&tools);
    result_add_remark(
        out, "The reamer. For the chunk system, the voxels are those of 1, 8 and 64 chunks; for the other methods, "
             "those of the tool's grid, of which they visit only the surface points, in a bone of 128^3 "
             "voxels.");
    result_plot *p = result_add_plot(out, RESULT_PLOT_LINES, "Event of the reamer by number of voxels",
                                     "side of the cube of voxels", "time of an event (us)");
    p->x = VOXELS_SIDE;
    p->group = VOXELS_METHOD;
    p->value[p->values++] = VOXELS_TIME;
    p->log_x = p->log_y = true;
    return status;
}
