/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests plots as SVG: axes must include all values, series must have markers, and text must be escaped.
 *
 * Covers: REQ-REPRODUCE-FILES
 */
#include "harness.h"

#include <math.h>

#include "core/memory_stream.h"
#include "reproduction/plot.h"

/* Draws a plot to memory that the caller must free. */
static char *draw_to_memory(const plot *p)
{
    ost_memory_stream memory;
    FILE *to = ost_memory_stream_open(&memory);
    assert_non_null(to);
    plot_write(to, p);
    assert_true(ost_memory_stream_close(to, &memory));
    return memory.bytes;
}

static int count(const char *text, const char *word)
{
    int n = 0;
    for (const char *at = text; (at = strstr(at, word)); at += strlen(word))
        n++;
    return n;
}

/* Checks that elements are closed in the reverse order of their opening and that attributes are quoted. */
static void assert_well_formed(const char *svg)
{
    char stack[16][16];
    int depth = 0;
    for (const char *at = strchr(svg, '<'); at; at = strchr(at, '<')) {
        const char *end = strchr(at, '>');
        assert_non_null(end);
        int quotes = 0;
        for (const char *c = at; c < end; c++)
            quotes += *c == '"';
        assert_int_equal(quotes % 2, 0);
        if (at[1] == '/') {
            assert_true(depth > 0);
            depth--;
            assert_int_equal(strncmp(at + 2, stack[depth], strlen(stack[depth])), 0);
            assert_int_equal(at[2 + strlen(stack[depth])], '>');
        } else if (end[-1] != '/') {
            assert_true(depth < 16);
            snprintf(stack[depth++], sizeof stack[0], "%.*s", (int)strcspn(at + 1, " >"), at + 1);
        }
        at = end;
    }
    assert_int_equal(depth, 0);
}

static void test_axes_show_all_values(void **state)
{
    (void)state;
    test_rng rng = rng_seeded("axes");
    for (int i = 0; i < 20000; i++) {
        const bool log = rng_range(&rng, 0, 1), zero = rng_range(&rng, 0, 1);
        const double size = pow(10, (double)rng_range(&rng, -9000, 9000) / 1000);
        double least = size * (double)rng_range(&rng, log ? 1 : -1000, 1000);
        double most = least + size * (double)rng_range(&rng, 0, 3) * (double)rng_range(&rng, 0, 100000);
        const plot_axis axis = plot_axis_make(least, most, log, zero);
        const double slack = 1e-6 * (axis.most - axis.least);
        assert_true(axis.least < axis.most);
        assert_true(axis.least <= least + slack && axis.most >= most - slack);
        assert_true(axis.count >= 2 && axis.count <= PLOT_TICKS);
        for (int t = 0; t < axis.count; t++) {
            assert_true(axis.tick[t] >= axis.least - slack && axis.tick[t] <= axis.most + slack);
            assert_true(t == 0 || axis.tick[t] > axis.tick[t - 1]);
        }
        assert_true(fabs(plot_axis_at(&axis, axis.least)) < 1e-9);
        assert_true(fabs(plot_axis_at(&axis, axis.most) - 1) < 1e-9);
        assert_true(!zero || log || least < 0 || axis.least <= 0);
    }
}

static void test_log_axis(void **state)
{
    (void)state;
    const plot_axis coarse = plot_axis_make(3, 4000, true, false), fine = plot_axis_make(3, 40, true, false);
    assert_true(fabs(coarse.least - 1) < 1e-9 && fabs(coarse.most - 10000) < 1e-6);
    assert_int_equal(coarse.count, 5);
    assert_true(fabs(fine.least - 2) < 1e-9 && fabs(fine.most - 50) < 1e-9);
    assert_int_equal(fine.count, 5); /* the ticks are 2, 5, 10, 20 and 50 */
}

static void test_lines(void **state)
{
    (void)state;
    static const double x[] = {1, 10, 100}, y[] = {5, 0, 7}, thesis[] = {1, 2, 3};
    plot p = {.title = "a <b> & \"c\"",
              .x_label = "x (mm)",
              .y_label = "y (us)",
              .log_x = true,
              .log_y = true,
              .count = 2,
              .series = {{.label = "ours", .count = 3, .x = x, .y = y},
                         {.label = "thesis: <GTX>", .thesis = true, .count = 3, .x = x, .y = thesis}}};
    char *svg = draw_to_memory(&p);
    assert_well_formed(svg);
    assert_non_null(strstr(svg, "a &lt;b&gt; &amp; &quot;c&quot;"));
    assert_non_null(strstr(svg, "thesis: &lt;GTX&gt;"));
    /*
     * A logarithmic axis cannot show the value 0. The series `ours` contains a 0, so it has two markers for values and
     * one in the legend. The series of the thesis has three markers for values and one in the legend.
     */
    assert_int_equal(count(svg, "fill=\"#0072B2\" stroke=\"#0072B2\""), 3);
    assert_int_equal(count(svg, "fill=\"#ffffff\" stroke=\"#000000\""), 4);
    free(svg);
}

static void test_bars(void **state)
{
    (void)state;
    static const double x[] = {0, 1}, y[] = {5, 9};
    static const char *const names[] = {"foam", "R&D"};
    plot p = {.title = "t",
              .x_label = "model",
              .y_label = "MB",
              .bars = true,
              .category = names,
              .categories = 2,
              .count = 1,
              .series = {{.label = "ours", .count = 2, .x = x, .y = y}}};
    char *svg = draw_to_memory(&p);
    assert_well_formed(svg);
    assert_non_null(strstr(svg, "R&amp;D"));
    /* two bars; there is no legend, because the title names the only series */
    assert_int_equal(count(svg, "fill=\"#0072B2\""), 2);
    free(svg);
}

static void test_empty(void **state)
{
    (void)state;
    static const double x[] = {1}, y[] = {-1};
    plot p = {.title = "t",
              .x_label = "",
              .y_label = "",
              .log_y = true,
              .count = 1,
              .series = {{.label = "none", .count = 1, .x = x, .y = y}}};
    char *svg = draw_to_memory(&p);
    assert_well_formed(svg);
    assert_non_null(strstr(svg, "No value was measured."));
    free(svg);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_axes_show_all_values), cmocka_unit_test(test_log_axis),
                                       cmocka_unit_test(test_lines), cmocka_unit_test(test_bars),
                                       cmocka_unit_test(test_empty)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
