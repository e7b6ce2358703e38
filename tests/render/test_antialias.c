/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests the antialiasing of edges. With every instruction set, each pixel must equal that of a second implementation,
 * which searches every run pixel by pixel and integrates the line above the run. The test includes pictures of which
 * only a part is computed again. For straight lines and discs, the error relative to the exact coverage of each pixel
 * is also tested.
 *
 * Covers: REQ-ANTIALIAS
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "harness.h"
#include "render/points/antialias.h"

enum { WIDTH_MAX = 100, HEIGHT_MAX = 60, STRIDE = 112, PIXELS = STRIDE * HEIGHT_MAX };

typedef struct picture {
    int width, height;
    uint32_t colour[PIXELS + 1];
} picture;

static uint32_t *pixel(picture *p, int x, int y)
{
    return &p->colour[y * STRIDE + x];
}

static uint32_t random_colour(test_rng *rng)
{
    return (uint32_t)rng_range(rng, 0, 0xffffff);
}

/* Makes a picture of overlapping half planes and boxes with some single pixels. Unused columns have random colours. */
static picture *make_picture(test_rng *rng)
{
    picture *p = calloc(1, sizeof *p);
    assert_non_null(p);
    p->width = (int)rng_range(rng, 1, WIDTH_MAX);
    p->height = (int)rng_range(rng, 1, HEIGHT_MAX);
    const uint32_t ground = random_colour(rng);
    for (int i = 0; i < PIXELS + 1; i++)
        p->colour[i] = i % STRIDE < p->width && i < p->height * STRIDE ? ground : random_colour(rng);
    for (int64_t n = rng_range(rng, 0, 6); n > 0; n--) {
        const int64_t a = rng_range(rng, -20, 20), b = rng_range(rng, -20, 20),
                      c = a * rng_range(rng, 0, p->width) + b * rng_range(rng, 0, p->height);
        const int x0 = (int)rng_range(rng, -10, p->width), y0 = (int)rng_range(rng, -10, p->height),
                  w = (int)rng_range(rng, 1, 40), h = (int)rng_range(rng, 1, 40);
        const uint32_t colour = random_colour(rng);
        const bool box = rng_range(rng, 0, 1);
        for (int y = 0; y < p->height; y++)
            for (int x = 0; x < p->width; x++)
                if (box ? x >= x0 && x < x0 + w && y >= y0 && y < y0 + h : a * x + b * y > c)
                    *pixel(p, x, y) = colour;
    }
    for (int64_t n = rng_range(rng, 0, 40); n > 0; n--)
        *pixel(p, (int)rng_range(rng, 0, p->width - 1), (int)rng_range(rng, 0, p->height - 1)) = random_colour(rng);
    return p;
}

/* ------------------------------------------------------------------ oracle */

static bool is_in(const picture *p, int x, int y)
{
    return x >= 0 && x < p->width && y >= 0 && y < p->height;
}

/* Returns true if the colours of two picture pixels differ by at least 24 in any channel. */
static bool differ(const picture *p, int x, int y, int x2, int y2)
{
    if (!is_in(p, x, y) || !is_in(p, x2, y2))
        return false;
    bool any = false;
    for (int shift = 0; shift < 24; shift += 8)
        any |= abs((int)(p->colour[y * STRIDE + x] >> shift & 255) -
                   (int)(p->colour[y2 * STRIDE + x2] >> shift & 255)) >= 24;
    return any;
}

/* Returns the area between x = k and x = k + 1 under a line. The line falls from 1/2 at x = 0 to 0 at the middle of the
   run. */
static double area_under(int k, int length)
{
    const double middle = length / 2.0, to = fmin(k + 1, middle);
    return k >= middle ? 0 : (to - k) * (0.5 - 0.5 * (to + k) / (2 * middle));
}

/*
 * Returns the weight of the neighbour at (x + u, y + v) in the smoothed pixel (x, y), in 256ths. The edge between the
 * two pixels runs along (|v|, |u|).
 */
static int weight_of(const picture *p, int x, int y, int u, int v)
{
    const int along_x = v != 0, along_y = u != 0;
    int steps[2] = {0, 0}, share = 0;
    bool bend[2];
    if (!differ(p, x, y, x + u, y + v))
        return 0;
    for (int end = 0; end < 2; end++) {
        const int dx = end ? along_x : -along_x, dy = end ? along_y : -along_y;
        int n = 0;
        while (n < 16 && differ(p, x + (n + 1) * dx, y + (n + 1) * dy, x + u + (n + 1) * dx, y + v + (n + 1) * dy))
            n++;
        /* true if the edge turns into the pixel's own row, and not into the neighbour's row */
        const int last_x = x + n * dx, last_y = y + n * dy;
        bend[end] = n < 16 && differ(p, last_x, last_y, last_x + dx, last_y + dy) &&
                    !differ(p, last_x + u, last_y + v, last_x + u + dx, last_y + v + dy);
        steps[end] = n < 15 ? n : 15;
    }
    for (int end = 0; end < 2; end++)
        if (steps[end] <= steps[!end] && bend[end])
            share += (int)floor(256 * area_under(steps[end], steps[0] + steps[1] + 1) + 0.5 + 1e-9);
    return share;
}

static uint32_t expected(const picture *p, int x, int y)
{
    const int up = weight_of(p, x, y, 0, -1), down = weight_of(p, x, y, 0, 1), left = weight_of(p, x, y, -1, 0),
              right = weight_of(p, x, y, 1, 0);
    const bool rows = (up > down ? up : down) >= (left > right ? left : right);
    const int at = y * STRIDE + x, first = rows ? up : left, second = rows ? down : right,
              step = rows ? STRIDE : 1;
    uint32_t out = 0;
    for (int shift = 0; shift < 24; shift += 8) {
        const int own = (int)(p->colour[at] >> shift & 255);
        int sum = own * (256 - first - second);
        sum += first ? first * (int)(p->colour[at - step] >> shift & 255) : 0;
        sum += second ? second * (int)(p->colour[at + step] >> shift & 255) : 0;
        out |= (uint32_t)((sum + 128) / 256) << shift;
    }
    return out;
}

/* ------------------------------------------------------------------- tests */

static void smooth(const ost_antialias *a, const picture *from, uint32_t *to, const ost_cells *cells)
{
    for (int row = 0; row < cells->rows; row++)
        ost_antialias_edges(a, from->colour, STRIDE, cells, row);
    for (int row = 0; row < cells->rows; row++)
        ost_antialias_smooth(a, from->colour, to, STRIDE, cells, row);
}

static void assert_smooth(const picture *p, const uint32_t *got)
{
    for (int y = 0; y < p->height; y++)
        for (int x = 0; x < p->width; x++)
            if ((got[y * STRIDE + x] & 0xffffff) != expected(p, x, y))
                fail_msg("picture of %d x %d, pixel (%d, %d): colour %06x, expected %06x", p->width, p->height, x, y,
                         (unsigned)got[y * STRIDE + x], (unsigned)expected(p, x, y));
}

/* Draws a picture, changes a part of it, and computes only the changed cells and their surroundings again. */
static void pictures_equal_second_implementation(void **state)
{
    (void)state;
    static const ost_isa isas[] = {OST_ISA_SCALAR, OST_ISA_AVX2, OST_ISA_AVX512};
    test_rng rng = rng_seeded("antialias");
    uint32_t *got = calloc(PIXELS, sizeof *got);
    int drawn = 0, changed = 0;
    assert_non_null(got);
    for (int round = 0; round < 300; round++) {
        ost_antialias a;
        ost_cells cells;
        if (!ost_isa_available(isas[round % 3]))
            continue;
        picture *p = make_picture(&rng), *other = make_picture(&rng);
        assert_true(ost_antialias_init(&a, p->width, p->height, isas[round % 3]));
        assert_true(ost_cells_init(&cells, p->width, p->height));
        ost_cells_fill(&cells);
        smooth(&a, p, got, &cells);
        assert_smooth(p, got);
        for (int y = 0; y < p->height; y++)
            for (int x = 0; x < p->width; x++)
                changed += (got[y * STRIDE + x] & 0xffffff) != *pixel(p, x, y);
        ost_cells_clear(&cells);
        for (int64_t n = rng_range(&rng, 1, 3); n > 0; n--) {
            const int x = (int)rng_range(&rng, 0, p->width - 1), y = (int)rng_range(&rng, 0, p->height - 1);
            *pixel(p, x, y) = *pixel(other, x, y);
            ost_cells_dot(&cells, x, y);
        }
        ost_cells_grow(&cells, OST_ANTIALIAS_CELLS_ACROSS, OST_ANTIALIAS_CELLS_DOWN);
        smooth(&a, p, got, &cells);
        assert_smooth(p, got);
        drawn++;
        ost_antialias_free(&a);
        ost_cells_free(&cells);
        free(p);
        free(other);
    }
    print_message("%d pictures, %d smooth pixels\n", drawn, changed);
    assert_true(changed > 10000);
    free(got);
}

static picture *blank(int width, int height, uint32_t colour)
{
    picture *p = calloc(1, sizeof *p);
    assert_non_null(p);
    p->width = width;
    p->height = height;
    for (int i = 0; i < PIXELS; i++)
        p->colour[i] = colour;
    return p;
}

/* Smooths a complete picture. */
static void smooth_all(const picture *p, uint32_t *got)
{
    ost_antialias a;
    ost_cells cells;
    assert_true(ost_antialias_init(&a, p->width, p->height, OST_ISA_SCALAR));
    assert_true(ost_cells_init(&cells, p->width, p->height));
    ost_cells_fill(&cells);
    smooth(&a, p, got, &cells);
    ost_antialias_free(&a);
    ost_cells_free(&cells);
}

/* Antialiasing must change neither straight edges along rows and columns nor edges between similar colours. */
static void axis_parallel_edges_are_unchanged(void **state)
{
    (void)state;
    picture *p = blank(WIDTH_MAX, HEIGHT_MAX, 0x202020);
    uint32_t *got = calloc(PIXELS, sizeof *got);
    assert_non_null(got);
    for (int y = 0; y < HEIGHT_MAX; y++)
        for (int x = 0; x < WIDTH_MAX; x++)
            *pixel(p, x, y) = x < 40 ? 0xffffff : y < 20 ? (x + y) % 2 ? 0x404040 : 0x575757 : 0x404040;
    smooth_all(p, got);
    for (int y = 0; y < HEIGHT_MAX; y++)
        assert_memory_equal(pixel(p, 0, y), got + (ptrdiff_t)y * STRIDE, WIDTH_MAX * sizeof *got);
    free(p);
    free(got);
}

/* Returns true if a shape contains the point (x, y). */
typedef bool shape_has(const double shape[3], double x, double y);
static bool line_has(const double s[3], double x, double y)
{
    return s[0] * x + s[1] * y > s[2];
}
static bool disc_has(const double s[3], double x, double y)
{
    return hypot(x - s[0], y - s[1]) < s[2];
}

static double coverage(shape_has *has, const double shape[3], int x, int y)
{
    enum { N = 32 };
    int count = 0;
    for (int i = 0; i < N * N; i++)
        count += has(shape, x + (i % N + 0.5) / N, y + (i / N + 0.5) / N);
    return (double)count / (N * N);
}

typedef struct errors {
    /* sums of squared errors before and after antialiasing; sum of errors after antialiasing */
    double before, after, mean;
    int pixels;                 /* number of partly covered pixels */
} errors;

/* Draws a shape of grey level 200 on black, and adds the errors of the picture before and after antialiasing to *e. */
static void add_errors(shape_has *has, const double shape[3], errors *e)
{
    enum { BRIGHT = 200, MARGIN = 18 };
    picture *p = blank(WIDTH_MAX, HEIGHT_MAX, 0);
    uint32_t *got = calloc(PIXELS, sizeof *got);
    assert_non_null(got);
    for (int y = 0; y < HEIGHT_MAX; y++)
        for (int x = 0; x < WIDTH_MAX; x++)
            *pixel(p, x, y) = has(shape, x + 0.5, y + 0.5) ? BRIGHT * 0x010101 : 0;
    smooth_all(p, got);
    for (int y = MARGIN; y < HEIGHT_MAX - MARGIN; y++)
        for (int x = MARGIN; x < WIDTH_MAX - MARGIN; x++) {
            const double exact = coverage(has, shape, x, y),
                         after = (double)(got[y * STRIDE + x] & 255) / BRIGHT - exact;
            e->before += pow((double)(*pixel(p, x, y) & 255) / BRIGHT - exact, 2);
            e->after += pow(after, 2);
            e->mean += after;
            e->pixels += exact > 0 && exact < 1;
        }
    free(p);
    free(got);
}

static void assert_better(const char *what, const errors *e, double most, double most_mean)
{
    print_message("%s: root mean square error of %d pixels at edges %.3f, with antialiasing %.3f, mean %.4f\n", what,
                  e->pixels, sqrt(e->before / e->pixels), sqrt(e->after / e->pixels), e->mean / e->pixels);
    assert_true(e->pixels > 500);
    assert_true(e->after < most * most * e->before);
    assert_true(fabs(e->mean / e->pixels) < most_mean);
}

/*
 * Tests that antialiasing reduces the errors. Without antialiasing, a pixel at an edge is wrong by up to half of its
 * area. Discs may keep larger errors: at the four sides of a small disc, the ends of the runs bend inwards, so that the
 * disc becomes slightly smaller.
 */
static void errors_of_lines_and_discs_are_reduced(void **state)
{
    (void)state;
    test_rng rng = rng_seeded("lines");
    errors lines = {0}, discs = {0};
    for (int i = 0; i < 60; i++) {
        const double angle = 2 * 3.14159265358979 * (double)rng_range(&rng, 0, 9999) / 10000,
                     a = cos(angle), b = sin(angle),
                     shift = (double)rng_range(&rng, -1000, 1000) / 100;
        add_errors(line_has, (double[]){a, b, a * WIDTH_MAX / 2 + b * HEIGHT_MAX / 2 + shift}, &lines);
        add_errors(disc_has,
                   (double[]){WIDTH_MAX / 2.0 + (double)rng_range(&rng, 0, 99) / 100,
                              HEIGHT_MAX / 2.0 + (double)rng_range(&rng, 0, 99) / 100,
                              (double)rng_range(&rng, 400, 1100) / 100},
                   &discs);
    }
    assert_better("lines", &lines, 0.45, 0.03);
    assert_better("discs", &discs, 0.75, 0.12);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pictures_equal_second_implementation),
        cmocka_unit_test(axis_parallel_edges_are_unchanged),
        cmocka_unit_test(errors_of_lines_and_discs_are_reduced),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
