/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests pictures made without a display: letters, scale bars and lines in a picture, the slices of a volume, and the
 * encoding as PNG.
 */
#include "picture_ball.h"

#include "config.h"

#include <unistd.h>

#include <osteon/render.h>

#include "render/marks.h"
#include "render/slices.h"

static void test_sizes(void **state)
{
    (void)state;
    ost_error err = {0};
    ost_picture p;
    assert_int_equal(ost_picture_init(&p, 0, 5, &err), OST_ERR_RANGE);
    assert_int_equal(ost_picture_init(&p, 5, 1 << 20, &err), OST_ERR_RANGE);
    assert_null(p.rgb);
    assert_ok(ost_picture_init(&p, 3, 2, &err));
    for (int i = 0; i < 18; i++)
        assert_int_equal(p.rgb[i], 0);
    ost_picture_free(&p);
    ost_picture_free(&p);
}

static void test_letters(void **state)
{
    (void)state;
    char l[4];
    ost_orientation_letters((double[3]){-1, 0, 0}, l);
    assert_string_equal(l, "R");
    ost_orientation_letters((double[3]){0, 2, 0}, l);
    assert_string_equal(l, "P");
    ost_orientation_letters((double[3]){0.1, -0.1, -1}, l);
    assert_string_equal(l, "I");
    ost_orientation_letters((double[3]){0.6, -0.8, 0}, l);
    assert_string_equal(l, "AL");
    ost_orientation_letters((double[3]){-1, 0.9, 0.8}, l);
    assert_string_equal(l, "RPS");
}

static const uint32_t INK = 0xffffff, OPAQUE_INK = 0xffffffff;

static ost_lettering *letters(void)
{
    ost_error err = {0};
    ost_lettering *l;
    assert_ok(ost_lettering_create(8, &l, &err));
    return l;
}

/*
 * The bar's length in mm is 1, 2 or 5 times a power of ten. The bar has the greatest such length that
 * fits. At 0.5 mm per pixel, a bar of 20 mm, which is 40 pixels long, fits into 60 pixels. Its ends are
 * vertical strokes.
 */
static void test_scale_bar(void **state)
{
    (void)state;
    uint32_t pixels[40 * 100] = {0};
    const ost_sheet sheet = {pixels, 100, 100, 40, NULL};
    ost_lettering *l = letters();
    for (int from_left = 0; from_left < 2; from_left++) {
        const int x0 = from_left ? 10 : 50;
        memset(pixels, 0, sizeof pixels);
        ost_scale_bar(l, &sheet, from_left ? 10 : 90, 35, from_left, 60, 0.5, 1, INK);
        int lit = 0;
        for (int x = 0; x < 100; x++)
            lit += pixels[100 * 34 + x] == OPAQUE_INK;
        assert_int_equal(lit, 40);
        for (int x = 0; x < 40; x += 39) {
            assert_int_equal(pixels[100 * 34 + x0 + x], OPAQUE_INK);
            assert_int_equal(pixels[100 * 30 + x0 + x], OPAQUE_INK);
        }
        assert_int_equal(pixels[100 * 30 + x0 + 20], 0);
        assert_int_equal(pixels[100 * 35 + x0], 0);
    }
    ost_scale_bar(l, &sheet, 10, 10, true, 60, 0, 1, INK); /* if the scale is unknown, nothing is drawn */
    assert_int_equal(pixels[100 * 9 + 10], 0);
    ost_lettering_free(l);
}

/*
 * The sheet of 8 x 8 pixels is a part of a buffer of 16 x 24 pixels. Drawing across each edge of the sheet
 * must not change any pixel outside the sheet.
 */
static void test_clipping(void **state)
{
    (void)state;
    uint32_t pixels[24 * 16] = {0};
    const ost_sheet sheet = {pixels + 8 * 16, 16, 8, 8, NULL};
    ost_lettering *l = letters();
    for (int y = -20; y < 20; y += 3)
        for (int x = -20; x < 20; x += 3) {
            ost_lettering_draw(l, &sheet, x, y, "A0.m?", INK);
            ost_sheet_box(&sheet, x, y, 100, 1, INK, 128);
            ost_scale_bar(l, &sheet, x, y, true, 60, 0.5, 1, INK);
        }
    for (int y = 0; y < 24; y++)
        for (int x = 0; x < 16; x++)
            if (y < 8 || y >= 16 || x >= 8)
                assert_int_equal(pixels[16 * y + x], 0);
    ost_lettering_free(l);
}

/* Tests the letters at the edges. In the radiological axial slice, R is at the left and A at the top. */
static void test_edges(void **state)
{
    (void)state;
    const double right[3] = {1, 0, 0}, up[3] = {0, -1, 0}, none[3] = {0, 0, 0};
    static const char *const expected[4] = {"R", "L", "A", "P"};
    for (int edge = 0; edge < 4; edge++) {
        char l[4];
        ost_edge_letters(right, up, edge, l);
        assert_string_equal(l, expected[edge]);
        ost_edge_letters(none, none, edge, l);
        assert_string_equal(l, "");
    }
}

/*
 * The scale is 2 pixels per millimetre (48 pixels for 24 mm). The axial slice has 48 x 40 pixels, the
 * coronal slice 48 x 32, and the sagittal slice 40 x 32. There are 8 pixels between slices.
 */
static void test_slices(void **state)
{
    (void)state;
    ost_error err = {0};
    ost_volume uncut = ball_of_slices(false), cut = ball_of_slices(true);
    ost_picture p;
    ost_slices_options o = {.at = {-1, -1, -1}, .pixels = 48};
    assert_ok(ost_picture_slices(&uncut, NULL, &o, &p, &err));
    assert_int_equal(p.width, 48 + 8 + 48 + 8 + 40);
    assert_int_equal(p.height, 40);
    /* The window is 400 +- 900 HU, so 1000 HU is (1000 + 500) / 1800 of white, and 0 HU is 500 / 1800. */
    assert_in_range(pixel(&p, 30, 14)[0], 211, 214);
    assert_in_range(pixel(&p, 2, 12)[0], 69, 72);
    ost_picture_free(&p);

    o.at[0] = 24, o.at[1] = 20, o.at[2] = 8;
    assert_ok(ost_picture_slices(&cut, &uncut, &o, &p, &err));
    /* one pixel in front of the cut at y = 8 mm, and one pixel behind it */
    const uint8_t *gone = pixel(&p, 20, 10), *left = pixel(&p, 20, 26);
    assert_true(gone[0] > gone[2] + 60);
    assert_int_equal(left[0], left[2]);
    ost_picture_free(&p);

    o.at[2] = 16;
    assert_int_equal(ost_picture_slices(&cut, &uncut, &o, &p, &err), OST_ERR_RANGE);
    assert_non_null(strstr(err.text, "16 along z"));
    ost_volume_free(&uncut);
    ost_volume_free(&cut);
}

/* Returns the region of a voxel. A box of the voxels 10 <= i < 30, 10 <= j < 30, 4 <= k < 12 has two regions: one
   with i < 20, and one with i >= 20. */
static uint32_t region_of_box(const void *user, size_t v)
{
    (void)user;
    const int i = (int)(v % 48), j = (int)(v / 48 % 40), k = (int)(v / 48 / 40);
    return i < 10 || i >= 30 || j < 10 || j >= 30 || k < 4 || k >= 12 ? OST_NO_REGION : i < 20 ? 0x0000fe : 0x00fe00;
}

static void black(const void *user, size_t v, double rgb[3])
{
    (void)user;
    (void)v;
    memset(rgb, 0, 3 * sizeof *rgb);
}

/*
 * At 240 pixels for 24 mm, a voxel is 5 pixels wide along x and y and 10 along z. In the axial panel, each
 * half of the box is 50 x 100 pixels, and its outline of 2 pixels has 2 x 2 x (50 + 100) - 16 = 584 pixels.
 * In the coronal panel, a half is 50 x 80 pixels, and its outline has 504 pixels. The sagittal panel shows
 * only the red half, which is 100 x 80 pixels with an outline of 704 pixels.
 */
static void test_outlines(void **state)
{
    (void)state;
    ost_error err = {0};
    ost_volume v = ball_of_slices(false);
    ost_picture p;
    const ost_slices_paint paint = {.colour = black, .region = region_of_box, .unoriented = true};
    assert_ok(ost_slices_draw(&v.geometry, (const int32_t[]){15, 20, 8}, 240, &paint, &p, &err));
    int red = 0, green = 0;
    for (int y = 0; y < p.height; y++)
        for (int x = 0; x < p.width; x++) {
            red += pixel(&p, x, y)[0] == 0xfe && pixel(&p, x, y)[1] == 0;
            green += pixel(&p, x, y)[1] == 0xfe && pixel(&p, x, y)[0] == 0;
        }
    assert_int_equal(red, 584 + 504 + 704);
    assert_int_equal(green, 584 + 504);
    ost_picture_free(&p);
    ost_volume_free(&v);
}

/*
 * Tests panels of 480 x 400, 480 x 320 and 400 x 320 pixels. Letters must be in the middle of the edges. If
 * the directions are unknown, there must be no letters.
 */
static void test_letters_of_slices(void **state)
{
    (void)state;
    ost_error err = {0};
    ost_volume v = ball_of_slices(false);
    for (int known = 0; known < 2; known++) {
        const ost_slices_options o = {.at = {-1, -1, -1}, .pixels = 480, .unoriented = !known};
        ost_picture p;
        int edges = 0, title = 0;
        assert_ok(ost_picture_slices(&v, NULL, &o, &p, &err));
        for (int y = 180; y < 220; y++)
            for (int x = 0; x < 40; x++)
                edges += pixel(&p, x, y)[0] > 0xa0 && pixel(&p, x, y)[2] > pixel(&p, x, y)[0];
        for (int y = 370; y < 400; y++)
            for (int x = 380; x < 480; x++)
                title += pixel(&p, x, y)[0] > 0xa0;
        assert_true(known ? edges > 10 : edges == 0);
        assert_true(title > 40);
        ost_picture_free(&p);
    }
    ost_volume_free(&v);
}

static void test_slices_of_volumes_that_do_not_match(void **state)
{
    (void)state;
    ost_error err = {0};
    ost_volume a = ball_of_slices(false), b = ball_of_slices(false);
    ost_picture p;
    b.geometry.spacing.x *= 2;
    assert_int_equal(ost_picture_slices(&a, &b, NULL, &p, &err), OST_ERR_USAGE);
    assert_int_equal(ost_picture_view(&a, &b, NULL, &p, &err), OST_ERR_USAGE);
    ost_volume_free(&a);
    ost_volume_free(&b);
}

/* Colours are interpolated between the centres of voxels, along rows and from row to row. */
static void test_colours_between_voxels(void **state)
{
    (void)state;
    ost_error err = {0};
    const ost_geometry g = {{3, 3, 3}, {OST_PM_PER_MM, OST_PM_PER_MM, OST_PM_PER_MM}, {0, 0, 0}};
    for (int along = 0; along < 2; along++) {
        ost_volume v;
        ost_picture p;
        assert_ok(ost_volume_init(&v, &g, &err));
        /* black, grey and white in a window of 400 +- 900 */
        for (int e = 0; e < 27; e++)
            v.voxels[e] = (int16_t)(-500 + 900 * (along ? e / 3 % 3 : e % 3));
        const ost_slices_options o = {.at = {1, 1, 1}, .pixels = 60};
        assert_ok(ost_picture_slices(&v, NULL, &o, &p, &err));
        /*
         * a voxel is 20 pixels wide: the pixel at 20 is between the first two voxels, and the pixel at 10 is on the
         * first voxel
         */
        assert_in_range(pixel(&p, along ? 40 : 20, along ? 20 : 40)[0], 64, 70);
        assert_in_range(pixel(&p, along ? 40 : 45, along ? 45 : 40)[0], 222, 230);
        assert_in_range(pixel(&p, along ? 40 : 9, along ? 9 : 40)[0], 0, 1);
        ost_picture_free(&p);
        ost_volume_free(&v);
    }
}

#ifdef HAVE_PNG
static void test_png(void **state)
{
    (void)state;
    ost_error err = {0};
    ost_picture p;
    uint8_t *bytes = NULL;
    size_t size = 0;
    assert_ok(ost_picture_init(&p, 300, 7, &err));
    assert_ok(ost_picture_encode_png(&p, &bytes, &size, &err));
    /* The expected bytes follow RFC 2083: the signature, then the chunk IHDR of 13 bytes with the width, the height,
       8 bits and colour type 2. */
    const uint8_t head[] = {0x89, 'P', 'N', 'G', 13, 10, 26, 10, 0, 0, 0, 13, 'I',
                            'H',  'D', 'R', 0,   0,  1,  44, 0,  0, 0, 7, 8,  2};
    assert_true(size > sizeof head);
    assert_memory_equal(bytes, head, sizeof head);

    char path[] = "/tmp/ost-picture-XXXXXX";
    int fd = mkstemp(path);
    assert_true(fd >= 0);
    close(fd);
    assert_ok(ost_picture_write_png(path, &p, &err));
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    uint8_t *read = malloc(size + 1);
    assert_non_null(read);
    assert_int_equal(fread(read, 1, size + 1, file), size);
    assert_memory_equal(read, bytes, size);
    fclose(file);
    unlink(path);
    assert_int_equal(ost_picture_write_png("/dev/null/x.png", &p, &err), OST_ERR_IO);
    free(read);
    free(bytes);
    ost_picture_free(&p);
    assert_int_equal(ost_picture_encode_png(&p, &bytes, &size, &err), OST_ERR_USAGE);
}
#else
static void test_png(void **state)
{
    (void)state;
    ost_error err = {0};
    ost_picture p;
    uint8_t *bytes;
    size_t size;
    assert_ok(ost_picture_init(&p, 3, 3, &err));
    assert_int_equal(ost_picture_encode_png(&p, &bytes, &size, &err), OST_ERR_UNAVAILABLE);
    assert_non_null(strstr(err.text, "libpng"));
    assert_int_equal(ost_picture_write_png("x.png", &p, &err), OST_ERR_UNAVAILABLE);
    ost_picture_free(&p);
}
#endif

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_sizes),
        cmocka_unit_test(test_letters),
        cmocka_unit_test(test_scale_bar),
        cmocka_unit_test(test_clipping),
        cmocka_unit_test(test_slices),
        cmocka_unit_test(test_letters_of_slices),
        cmocka_unit_test(test_colours_between_voxels),
        cmocka_unit_test(test_outlines),
        cmocka_unit_test(test_slices_of_volumes_that_do_not_match),
        cmocka_unit_test(test_edges),
        cmocka_unit_test(test_png),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
