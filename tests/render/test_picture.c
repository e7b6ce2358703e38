/* SPDX-License-Identifier: Apache-2.0 */
/* Pictures without a display: the positions of objects in them, and their encoding as PNG. */
#include <unistd.h>

#include "harness.h"

#include "config.h"
#include "render/canvas.h"

/*
 * Returns a ball of 1000 HU, radius 8 mm, in a box of 24 x 20 x 16 mm, voxels of 0.5 x 0.5 x 1
 * mm; bitten: its front (y < 10 mm) is removed.
 */
static ost_volume ball(bool bitten)
{
    ost_error err = {0};
    ost_volume v;
    ost_geometry g = {{48, 40, 16}, {OST_PM_PER_MM / 2, OST_PM_PER_MM / 2, OST_PM_PER_MM}, {0, 0, 0}};
    assert_ok(ost_volume_init(&v, &g, &err));
    for (int k = 0; k < 16; k++)
        for (int j = 0; j < 40; j++)
            for (int i = 0; i < 48; i++) {
                double x = 0.5 * i - 12, y = 0.5 * j - 10, z = k - 8;
                v.voxels[i + 48 * (j + 40 * k)] = x * x + y * y + z * z < 64 && !(bitten && j < 16) ? 1000 : 0;
            }
    return v;
}

static const uint8_t *pixel(const ost_picture *p, int x, int y)
{
    return p->rgb + 3 * ((size_t)y * (size_t)p->width + (size_t)x);
}

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

/*
 * The bar is the greatest 1, 2 or 5 times a power of ten that fits: 60 pixels of 0.5 mm hold 20
 * mm, 40 pixels.
 */
static void test_scale_bar(void **state)
{
    (void)state;
    ost_error err = {0};
    ost_picture p;
    assert_ok(ost_picture_init(&p, 100, 40, &err));
    ost_canvas_scale_bar(&p, 10, 35, 60, 0.5, 1, (ost_rgb){255, 255, 255});
    int lit = 0;
    for (int x = 0; x < 100; x++)
        lit += pixel(&p, x, 34)[0] == 255;
    assert_int_equal(lit, 40);
    assert_int_equal(pixel(&p, 10, 34)[0], 255);
    assert_int_equal(pixel(&p, 49, 34)[0], 255);
    ost_picture_free(&p);
}

/* Drawing across every edge changes nothing outside the picture. */
static void test_clipping(void **state)
{
    (void)state;
    ost_error err = {0};
    ost_picture p;
    assert_ok(ost_picture_init(&p, 8, 8, &err));
    for (int y = -20; y < 20; y += 3)
        for (int x = -20; x < 20; x += 3) {
            ost_canvas_text(&p, x, y, 2, (ost_rgb){9, 9, 9}, "A0.m?");
            ost_canvas_rect(&p, x, y, 100, 1, (ost_rgb){9, 9, 9}, 0.5);
        }
    ost_picture_free(&p);
}

/*
 * The scale is 2 pixels a millimetre (48 for 24 mm): axial 48 x 40, coronal 48 x 32, sagittal 40
 * x 32, 8 pixels between.
 */
static void test_slices(void **state)
{
    (void)state;
    ost_error err = {0};
    ost_volume whole = ball(false), cut = ball(true);
    ost_picture p;
    ost_slices_options o = {.at = {-1, -1, -1}, .pixels = 48};
    assert_ok(ost_picture_slices(&whole, NULL, &o, &p, &err));
    assert_int_equal(p.width, 48 + 8 + 48 + 8 + 40);
    assert_int_equal(p.height, 40);
    /* 1000 HU in a window of 400 +- 900 is (1000 + 500) / 1800 of white; 0 HU is 500 / 1800. */
    assert_in_range(pixel(&p, 30, 14)[0], 211, 214);
    assert_in_range(pixel(&p, 2, 12)[0], 69, 72);
    ost_picture_free(&p);

    o.at[0] = 24, o.at[1] = 20, o.at[2] = 8;
    assert_ok(ost_picture_slices(&cut, &whole, &o, &p, &err));
    const uint8_t *gone = pixel(&p, 20, 10), *left = pixel(&p, 20, 26); /* before and behind the border at 8 mm */
    assert_true(gone[0] > gone[2] + 60);
    assert_int_equal(left[0], left[2]);
    ost_picture_free(&p);

    o.at[2] = 16;
    assert_int_equal(ost_picture_slices(&cut, &whole, &o, &p, &err), OST_ERR_RANGE);
    assert_non_null(strstr(err.text, "16 along z"));
    ost_volume_free(&whole);
    ost_volume_free(&cut);
}

static void test_slices_of_volumes_that_do_not_match(void **state)
{
    (void)state;
    ost_error err = {0};
    ost_volume a = ball(false), b = ball(false);
    ost_picture p;
    b.geometry.spacing.x *= 2;
    assert_int_equal(ost_picture_slices(&a, &b, NULL, &p, &err), OST_ERR_USAGE);
    assert_int_equal(ost_picture_view(&a, &b, NULL, &p, &err), OST_ERR_USAGE);
    ost_volume_free(&a);
    ost_volume_free(&b);
}

/*
 * From the front: bone in the middle, background in the corner, lit from above; a cut front is
 * red, the back is not.
 */
static void test_view(void **state)
{
    (void)state;
    ost_error err = {0};
    ost_volume whole = ball(false), cut = ball(true);
    ost_picture p;
    ost_view_options o = {.width = 60, .height = 60};
    assert_ok(ost_picture_view(&whole, NULL, &o, &p, &err));
    const uint8_t *bone = pixel(&p, 30, 30), *corner = pixel(&p, 57, 3);
    assert_true(bone[0] > bone[2] + 10);   /* #e3dac9 is warm */
    assert_true(corner[2] >= corner[0] && corner[0] > 200);
    assert_true(pixel(&p, 24, 16)[0] > pixel(&p, 36, 48)[0]);
    ost_picture_free(&p);

    assert_ok(ost_picture_view(&cut, &whole, &o, &p, &err));
    const uint8_t *bared = pixel(&p, 30, 30);
    assert_true(bared[0] > bared[1] + 40);
    ost_picture_free(&p);
    o.direction[1] = -1;
    assert_ok(ost_picture_view(&cut, &whole, &o, &p, &err));
    const uint8_t *back = pixel(&p, 30, 30);
    assert_true(back[0] < back[1] + 30);
    ost_picture_free(&p);

    o.up[1] = 3;
    assert_int_equal(ost_picture_view(&cut, NULL, &o, &p, &err), OST_ERR_USAGE);
    ost_volume_free(&whole);
    ost_volume_free(&cut);
}

/* Without an active voxel there is only background, in every direction of view. */
static void test_view_of_nothing(void **state)
{
    (void)state;
    ost_error err = {0};
    ost_volume v;
    ost_geometry g = {{1, 1, 1}, {OST_PM_PER_MM, OST_PM_PER_MM, OST_PM_PER_MM}, {0, 0, 0}};
    ost_picture p;
    assert_ok(ost_volume_init(&v, &g, &err));
    ost_view_options o = {.direction = {0, 0, -1}, .width = 16, .height = 16};
    assert_ok(ost_picture_view(&v, NULL, &o, &p, &err));
    assert_true(pixel(&p, 8, 5)[0] > 200);
    ost_picture_free(&p);
    v.voxels[0] = 500;
    assert_ok(ost_picture_view(&v, NULL, &o, &p, &err));
    ost_picture_free(&p);
    ost_volume_free(&v);
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
    /* RFC 2083: signature, then IHDR of 13 bytes: width, height, 8 bits, colour type 2. */
    const uint8_t head[] = {0x89, 'P', 'N', 'G', 13, 10, 26, 10, 0, 0, 0, 13, 'I', 'H', 'D', 'R', 0, 0, 1, 44, 0, 0, 0, 7, 8, 2};
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
        cmocka_unit_test(test_sizes),  cmocka_unit_test(test_letters),
        cmocka_unit_test(test_scale_bar), cmocka_unit_test(test_clipping),
        cmocka_unit_test(test_slices), cmocka_unit_test(test_slices_of_volumes_that_do_not_match),
        cmocka_unit_test(test_view),   cmocka_unit_test(test_view_of_nothing),
        cmocka_unit_test(test_png),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
