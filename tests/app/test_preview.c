/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests the picture of --preview. The expected values follow from the layout in preview.c: a grid of 60^3 voxels of
 * 1 mm is shown completely in three planes of 500 x 500 pixels, with 8.33 pixels per millimetre. The top row of the
 * planes is the picture's row 56.
 * Covers: REQ-PREVIEW
 */
#include "harness.h"

#include <math.h>
#include <string.h>

#include "app/picture/preview.h"

enum { N = 60, TOP = 56, SIDE = 500, GAP = 8, LEFT = (PREVIEW_WIDTH - 3 * SIDE - 2 * GAP) / 2 };
enum { BLUE = 0x56b4e9, YELLOW = 0xf0e442, VERMILION = 0xd55e00 }; /* 0xRRGGBB */

typedef struct scene {
    ost_volume ct, parts;
    ost_meta meta;
    chart_table table;
    preview_input in;
} scene;

static size_t index_of(int x, int y, int z)
{
    return (size_t)x + N * ((size_t)y + (size_t)N * (size_t)z);
}

static void fill(ost_volume *v, int lo, int hi, int z_lo, int z_hi, int16_t value)
{
    for (int z = z_lo; z < z_hi; z++)
        for (int y = lo; y < hi; y++)
            for (int x = lo; x < hi; x++)
                v->voxels[index_of(x, y, z)] = value;
}

/* Makes a CT with three cubes: one of 20 mm with label 1, one of 4 mm near a corner with label 2, and a dense one
   without a label. */
static scene *make_scene(void)
{
    ost_error err = {0};
    const ost_geometry g = {{N, N, N}, {OST_PM_PER_MM, OST_PM_PER_MM, OST_PM_PER_MM}, {0, 0, 0}};
    scene *s = calloc(1, sizeof *s);
    assert_non_null(s);
    assert_ok(ost_volume_init(&s->ct, &g, &err));
    assert_ok(ost_volume_init(&s->parts, &g, &err));
    fill(&s->ct, 20, 40, 20, 40, 700);
    fill(&s->ct, 5, 9, 50, 54, 700);
    fill(&s->ct, 44, 50, 25, 30, 700);
    fill(&s->parts, 20, 40, 20, 40, 1);
    fill(&s->parts, 5, 9, 50, 54, 2);
    chart_add(&s->table, "file", "NRRD");
    s->in = (preview_input){.out = "folder/labels.nrrd", .ct = &s->ct, .parts = &s->parts, .labels = true,
                            .threshold = 120, .left_out = true, .meta = &s->meta, .threads = 1, .table = &s->table};
    return s;
}

static void free_scene(scene *s)
{
    ost_volume_free(&s->ct);
    ost_volume_free(&s->parts);
    free(s);
}

static ost_picture draw(const scene *s)
{
    ost_error err = {0};
    ost_picture p;
    assert_ok(preview_draw(&s->in, &p, &err));
    assert_int_equal(p.width, PREVIEW_WIDTH);
    assert_int_equal(p.height, PREVIEW_HEIGHT);
    return p;
}

static bool has_colour(const ost_picture *p, int x, int y, int colour)
{
    const uint8_t *at = p->rgb + 3 * ((size_t)y * (size_t)p->width + (size_t)x);
    return at[0] == colour >> 16 && at[1] == (colour >> 8 & 255) && at[2] == (colour & 255);
}

static int count(const ost_picture *p, int x, int y, int width, int height, int colour)
{
    int n = 0;
    for (int j = y; j < y + height; j++)
        for (int i = x; i < x + width; i++)
            n += has_colour(p, i, j, colour);
    return n;
}

/* Counts the pixels of a colour in one of the three planes. */
static int in_plane(const ost_picture *p, int plane, int colour)
{
    return count(p, LEFT + plane * (SIDE + GAP), TOP, SIDE, SIDE, colour);
}

/*
 * Each plane shows the section of the cube of label 1, which is a square of 20 mm, or 166.7 pixels.
 * The outline of the square is 2 pixels wide, so it has 4 x 2 x (166.7 - 2) = 1317 pixels.
 */
static void test_outline(void **state)
{
    (void)state;
    scene *s = make_scene();
    ost_picture p = draw(s);
    for (int plane = 0; plane < 3; plane++) {
        assert_in_range(in_plane(&p, plane, BLUE), 1317 - 20, 1317 + 20);
        assert_int_equal(in_plane(&p, plane, YELLOW), 0);
    }
    ost_picture_free(&p);
    free_scene(s);
}

/*
 * If the glenoid's centre is set, the planes pass through the centre, which in this test is in the cube of
 * label 2. The section of this cube has sides of 4 mm, or 33.3 pixels. Its outline has 4 x 2 x 31.3
 * pixels.
 */
static void test_planes_through_the_glenoid(void **state)
{
    (void)state;
    ost_error err = {0};
    scene *s = make_scene();
    assert_ok(ost_meta_set(&s->meta, OST_META_GLENOID_AT, "6 6 51", &err));
    assert_ok(ost_meta_set(&s->meta, OST_META_GLENOID_AXIS, "0 1 0", &err));
    ost_picture p = draw(s);
    for (int plane = 0; plane < 3; plane++) {
        assert_in_range(in_plane(&p, plane, YELLOW), 251 - 20, 251 + 20);
        assert_int_equal(in_plane(&p, plane, BLUE), 0);
    }
    ost_picture_free(&p);
    s->meta = (ost_meta){0};
    s->in.at_given = true;
    s->in.at = (ost_pm3){7 * OST_PM_PER_MM, 7 * OST_PM_PER_MM, 52 * OST_PM_PER_MM};
    p = draw(s);
    assert_true(in_plane(&p, 0, YELLOW) > 200);
    ost_picture_free(&p);
    free_scene(s);
}

/*
 * The dense cube without a label must be outlined in each plane that intersects it, unless the options disable this
 * outline.
 */
static void test_left_out(void **state)
{
    (void)state;
    scene *s = make_scene();
    s->in.at_given = true;
    s->in.at = (ost_pm3){46 * OST_PM_PER_MM, 46 * OST_PM_PER_MM, 27 * OST_PM_PER_MM};
    for (int wanted = 0; wanted < 2; wanted++) {
        s->in.left_out = wanted;
        ost_picture p = draw(s);
        const int n = count(&p, 0, TOP, PREVIEW_WIDTH, SIDE, VERMILION);
        assert_true(wanted ? n > 3 * 200 : n == 0);
        ost_picture_free(&p);
    }
    free_scene(s);
}

/* The picture depends neither on the threads nor on the folder of the output. */
static void test_same_bytes(void **state)
{
    (void)state;
    scene *s = make_scene();
    ost_picture a = draw(s);
    s->in.threads = 3;
    s->in.out = "/another/folder/labels.nrrd";
    ost_picture b = draw(s);
    assert_memory_equal(a.rgb, b.rgb, (size_t)3 * PREVIEW_WIDTH * PREVIEW_HEIGHT);
    ost_picture_free(&b);
    s->in.out = "other.nrrd";
    b = draw(s);
    assert_true(memcmp(a.rgb, b.rgb, (size_t)3 * PREVIEW_WIDTH * PREVIEW_HEIGHT) != 0);
    ost_picture_free(&a);
    ost_picture_free(&b);
    free_scene(s);
}

/*
 * The bone has 60^3 voxels of 1 mm, and the CT has 15^3 voxels of 4 mm. Let x be the distance in mm from the
 * centre of the bone's first voxel. The centre of the CT's first voxel is at x = 0.5. The density of the CT
 * is 0 HU there and increases by 20 HU per mm. With interpolation, the grey at x is (20 (x - 0.5) + 500) /
 * 1800 of white. Without interpolation, the grey is that of the nearest voxel of the CT. The centre of this
 * voxel is up to 1.5 mm away along x, so the density differs by up to 30 HU, or 4.25 grey levels.
 */
static void test_densities(void **state)
{
    (void)state;
    ost_error err = {0};
    scene *s = make_scene();
    const ost_pm four = 4 * OST_PM_PER_MM, half = OST_PM_PER_MM / 2;
    const ost_geometry g = {{15, 15, 15}, {four, four, four}, {half, half, half}};
    ost_volume_free(&s->ct);
    assert_ok(ost_volume_init(&s->ct, &g, &err));
    for (int i = 0; i < 15 * 15 * 15; i++)
        s->ct.voxels[i] = (int16_t)(80 * (i % 15));
    memset(s->parts.voxels, 0, N * N * N * sizeof *s->parts.voxels);
    fill(&s->parts, 20, 22, 20, 22, 500);
    s->in.labels = s->in.left_out = false;
    for (int nearest = 0; nearest < 2; nearest++) {
        s->in.nearest = nearest;
        ost_picture p = draw(s);
        int worst = 0, last = -1, steps = 0;
        /* The picture shows the labelled part, which ends at 22 mm, with a margin of 25 mm. The grid begins at 0 mm.
           Therefore the picture shows 0 to 47 mm in each direction. */
        const double mm = 47.0 / SIDE;
        for (int x = 40; x < SIDE - 40; x++) {
            const double expected = (20 * (x * mm - 0.5 - 0.5) + 500) / 1800 * 255;
            const int grey = p.rgb[3 * ((size_t)(TOP + 60) * PREVIEW_WIDTH + (size_t)(LEFT + x))];
            const int off = (int)fabs(grey - expected);
            worst = off > worst ? off : worst;
            steps += grey != last;
            last = grey;
        }
        if (nearest)
            assert_in_range(worst, 3, 5);
        else
            assert_true(worst <= 1 && steps > 80);
        ost_picture_free(&p);
    }
    free_scene(s);
}

/* If the bone has no labelled parts, the complete grid is shown. */
static void test_no_part(void **state)
{
    (void)state;
    scene *s = make_scene();
    memset(s->parts.voxels, 0, N * N * N * sizeof *s->parts.voxels);
    ost_picture p = draw(s);
    assert_int_equal(count(&p, 0, 0, PREVIEW_WIDTH, PREVIEW_HEIGHT, BLUE), 0);
    ost_picture_free(&p);
    free_scene(s);
}

/* Texts of any length must stay within the box of their table. Rows for which there is no space are counted. */
static void test_table(void **state)
{
    (void)state;
    ost_error err = {0};
    chart page;
    chart_table *table = calloc(1, sizeof *table);
    char word[300], words[400] = "";
    assert_non_null(table);
    memset(word, 'W', sizeof word - 1);
    word[sizeof word - 1] = '\0';
    while (strlen(words) < 300)
        strcat(words, "a few words ");
    chart_add(table, "word", "%s", word);
    chart_add(table, "warning", "%s", words)->warning = true;
    chart_add(table, "", "blue")->colour = 0xe9b456;
    for (int i = 0; i < 2 * CHART_ROWS_MAX; i++)
        chart_add(table, "row", "%d", i);
    assert_int_equal(table->count, CHART_ROWS_MAX);
    assert_int_equal(table->count + table->omitted, 3 + 2 * CHART_ROWS_MAX);
    assert_ok(chart_begin(&page, 800, 600, &err));
    const uint32_t empty = page.sheet.pixels[0] & 0xffffff;
    chart_put_table(&page, table, 100, 100, 600, 400);
    int outside = 0, amber = 0, blue = 0;
    for (int y = 0; y < 600; y++)
        for (int x = 0; x < 800; x++) {
            const uint32_t colour = page.sheet.pixels[800 * y + x] & 0xffffff;
            outside += colour != empty && (x < 98 || x > 702 || y < 98 || y > 506);
            amber += colour == 0x50c8ff;
            blue += colour == 0xe9b456;
        }
    assert_int_equal(outside, 0);
    assert_true(amber > 200);
    assert_int_equal(blue, 14 * 14);
    chart_free(&page);
    free(table);
}

/* The table repeats the warnings of a verb, but omits the file name at their beginning. */
static void test_warnings(void **state)
{
    (void)state;
    chart_table *table = calloc(1, sizeof *table);
    app_state app = {.verb = "import", .warnings = json_array()};
    assert_non_null(table);
    json_array_append_new(app.warnings, json_string("folder/ct.nrrd: is large"));
    json_array_append_new(app.warnings, json_string("another"));
    preview_add_warnings(&app, "folder/ct.nrrd", table);
    assert_int_equal(table->count, 2);
    assert_string_equal(table->row[0].text, "is large");
    assert_string_equal(table->row[1].text, "another");
    assert_true(table->row[0].warning);
    json_decref(app.warnings);
    free(table);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_outline),
        cmocka_unit_test(test_planes_through_the_glenoid),
        cmocka_unit_test(test_left_out),
        cmocka_unit_test(test_same_bytes),
        cmocka_unit_test(test_densities),
        cmocka_unit_test(test_no_part),
        cmocka_unit_test(test_table),
        cmocka_unit_test(test_warnings),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
