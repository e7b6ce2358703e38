/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests the view of a volume without a display: the silhouette and the removed part of a ball, marks, label maps, and
 * volumes without active voxels. The positions of pixels are computed from the camera.
 */
#include "picture_ball.h"

#include <math.h>

#include <osteon/render.h>

#include "render/marks.h"
#include "render/points/palette.h"
#include "render/view.h"
#include "render/views.h"

/*
 * Returns a ball of 1000 HU with a radius of 8 mm, in the middle of a cube of 24 mm with voxels
 * of 0.5 mm. If `bitten`, the front of the ball (y < -4 mm) is removed. The origin is chosen so
 * that the middle is at (0, 0, 0).
 */
static ost_volume cubes(bool bitten)
{
    ost_error err = {0};
    ost_volume v;
    const ost_pm s = OST_PM_PER_MM / 2, o = -24 * s + s / 2;
    const ost_geometry g = {{48, 48, 48}, {s, s, s}, {o, o, o}};
    assert_ok(ost_volume_init(&v, &g, &err));
    for (int k = 0; k < 48; k++)
        for (int j = 0; j < 48; j++)
            for (int i = 0; i < 48; i++) {
                const double x = 0.5 * i - 11.75, y = 0.5 * j - 11.75, z = 0.5 * k - 11.75;
                v.voxels[i + 48 * (j + 48 * k)] = x * x + y * y + z * z < 64 && !(bitten && y < -4) ? 1000 : 0;
            }
    return v;
}

static bool is_bone(const ost_picture *p, int x, int y)
{
    return pixel(p, x, y)[0] > 0x16 + 24; /* brighter than the background, 0x16181c */
}

/*
 * The silhouette of a ball of radius r in front of a camera at the distance d is a circle. In the plane through the
 * ball's centre, the circle's radius is r * d / sqrt(d^2 - r^2). The extent of 40 mm is the height of that plane, so d
 * = 40 mm x 1.2071 = 48.28 mm and the radius is 8.112 mm, which is 40.6 of 200 pixels. Voxels extend beyond the ball by
 * at most one voxel, which is 2.5 pixels.
 */
static void test_view_silhouette(void **state)
{
    (void)state;
    ost_error err = {0};
    ost_volume ball = cubes(false);
    ost_picture p;
    for (int axis = 0; axis < 6; axis++) {
        ost_view_options o = {.width = 240, .height = 200, .extent_mm = 40, .no_legend = true};
        o.direction[axis / 2] = axis % 2 ? 1 : -1;
        assert_ok(ost_picture_view(&ball, NULL, &o, &p, &err));
        for (int y = 0; y < p.height; y++)
            for (int x = 0; x < p.width; x++) {
                const double r = hypot(x + 0.5 - 120, y + 0.5 - 100);
                if (r < 40.6 - 2.5)
                    assert_true(is_bone(&p, x, y));
                if (r > 40.6 + 2.5)
                    assert_false(is_bone(&p, x, y));
            }
        ost_picture_free(&p);
    }
    ost_volume_free(&ball);
}

/*
 * Tests the view from the front. The bone is in the middle, has a warm colour and is lit from
 * the upper left. A cut front has the colour of its depth; the uncut back does not. If no extent
 * is given, the complete bone is in the picture and fills most of it.
 */
static void test_view(void **state)
{
    (void)state;
    ost_error err = {0};
    ost_volume ball = cubes(false), cut = cubes(true);
    ost_picture p;
    ost_view_options o = {.width = 200, .height = 200, .no_legend = true};
    assert_ok(ost_picture_view(&ball, NULL, &o, &p, &err));
    assert_true(pixel(&p, 100, 100)[0] > pixel(&p, 100, 100)[2] + 10); /* the colour of bone, #e3dac9, is warm */
    assert_true(pixel(&p, 80, 60)[0] > pixel(&p, 120, 150)[0] + 20);
    assert_true(is_bone(&p, 100, 36) && is_bone(&p, 36, 100));
    for (int i = 0; i < 200; i++)
        assert_true(!is_bone(&p, i, 0) && !is_bone(&p, i, 199) && !is_bone(&p, 0, i) && !is_bone(&p, 199, i));
    ost_picture_free(&p);

    /* On the scale of 10 mm, a depth of 3.75 mm below the pole is green. Uncut bone is never green. */
    assert_ok(ost_picture_view(&cut, &ball, &o, &p, &err));
    const uint8_t *bared = pixel(&p, 100, 100);
    assert_true(bared[1] > bared[0] + 20 && bared[1] > bared[2]);
    ost_picture_free(&p);
    o.direction[1] = -1;
    assert_ok(ost_picture_view(&cut, &ball, &o, &p, &err));
    const uint8_t *back = pixel(&p, 100, 100);
    assert_true(back[0] >= back[1] && back[1] > back[2]);
    ost_picture_free(&p);

    o.up[1] = 3;
    assert_int_equal(ost_picture_view(&cut, NULL, &o, &p, &err), OST_ERR_USAGE);
    o = (ost_view_options){.width = OST_FRAME_MAX + 1};
    assert_int_equal(ost_picture_view(&cut, NULL, &o, &p, &err), OST_ERR_RANGE);
    ost_volume flat = ball_of_slices(false);
    assert_int_equal(ost_picture_view(&flat, NULL, NULL, &p, &err), OST_ERR_RANGE);
    ost_volume_free(&flat);
    ost_volume_free(&ball);
    ost_volume_free(&cut);
}

/*
 * Tests the marks in a view. A scale bar at the lower right is exact in the plane through the
 * centre. Letters are at the edges, except for a tool and for a file of unknown orientation. A
 * legend is drawn only if `before` is given.
 */
static void test_view_marks(void **state)
{
    (void)state;
    ost_error err = {0};
    ost_volume ball = cubes(false), cut = cubes(true);
    /* k = 0 shows a bone, 1 a bone of unknown orientation, 2 a tool, and 3 a cut bone with its uncut bone */
    for (int k = 0; k < 4; k++) {
        ost_view_options o = {.width = 600, .height = 600, .extent_mm = 60, .unoriented = k == 1, .tool = k == 2};
        ost_picture p;
        int bar = 0, letter = 0, legend = 0;
        assert_ok(ost_picture_view(k == 3 ? &cut : &ball, k == 3 ? &ball : NULL, &o, &p, &err));
        /* the lowest row of the bar is 10 pixels above the edge; the bar is 2 x 5 / 6 pixels thick */
        for (int x = 300; x < 600; x++)
            bar += pixel(&p, x, 600 - 10 - 1)[0] > 0xe0;
        /* at 60 mm for 600 pixels, the bar of 10 mm has 100 pixels; a bar of 20 mm would exceed 150 x 5 / 6 pixels */
        assert_int_equal(bar, 100);
        for (int y = 280; y < 320; y++)
            for (int x = 0; x < 40; x++)
                letter += pixel(&p, x, y)[0] > 0x50;
        assert_true(k == 1 || k == 2 ? letter == 0 : letter >= 8);
        for (int y = 500; y < 600; y++)
            for (int x = 0; x < 200; x++)
                legend += pixel(&p, x, y)[0] > 0x80;
        assert_true(k == 3 ? legend > 500 : legend == 0);
        ost_picture_free(&p);
    }
    ost_volume_free(&ball);
    ost_volume_free(&cut);
}

/*
 * Tests the bounding box of the ball's active voxels. It extends 8 mm, or 16 voxels of 0.5 mm, from the middle to each
 * side.
 */
static void test_active_box(void **state)
{
    (void)state;
    ost_volume ball = cubes(false);
    int32_t lo[3], hi[3];
    ost_view_subject s = {.size = 1};
    ost_active_box(&ball, 1000, lo, hi);
    ost_view_subject_fit(&s, &ball, 1000);
    for (int a = 0; a < 3; a++) {
        assert_int_equal(lo[a], 24 - 16);
        assert_int_equal(hi[a], 24 + 16);
        assert_true(fabs(s.middle[a]) < 1e-9);
    }
    assert_true(fabs(s.size - 16) < 1e-9);
    ost_active_box(&ball, 1001, lo, hi); /* no voxel reaches this threshold */
    assert_true(lo[0] == 24 && hi[0] == 24);
    ost_volume_free(&ball);
}

/* If no voxel is active, the picture must contain only background, in every direction of view. */
static void test_view_without_active_voxels(void **state)
{
    (void)state;
    ost_error err = {0};
    ost_volume v;
    ost_geometry g = {{1, 1, 1}, {OST_PM_PER_MM, OST_PM_PER_MM, OST_PM_PER_MM}, {0, 0, 0}};
    ost_picture p;
    assert_ok(ost_volume_init(&v, &g, &err));
    ost_view_options o = {.direction = {0, 0, -1}, .width = 16, .height = 16};
    for (int full = 0; full < 2; full++) {
        v.voxels[0] = (int16_t)(500 * full);
        assert_ok(ost_picture_view(&v, NULL, &o, &p, &err));
        assert_int_equal(is_bone(&p, 8, 8), full);
        assert_false(is_bone(&p, 0, 0));
        ost_picture_free(&p);
    }
    ost_volume_free(&v);
}

/* Tests a cube of three layers with the labels 1, 2 and 0 from bottom to top, seen from the front. */
static void test_view_of_labels(void **state)
{
    (void)state;
    ost_error err = {0};
    const ost_geometry g = {{30, 30, 30}, {OST_PM_PER_MM, OST_PM_PER_MM, OST_PM_PER_MM}, {0, 0, 0}};
    static const int layers[3] = {1, 2, 0};
    ost_volume v;
    ost_picture p, again;
    assert_ok(ost_volume_init(&v, &g, &err));
    for (int i = 0; i < 27000; i++)
        v.voxels[i] = (int16_t)(OST_LABEL_DENSITY + layers[i / 9000]);
    ost_view_options o = {.threshold = 1, .width = 90, .height = 90, .no_legend = true, .threads = 1};
    assert_ok(ost_view_draw(&v, true, 0, &o, &p, &err));
    for (int layer = 0; layer < 3; layer++) {
        const uint32_t colour = ost_label_colours[layers[layer]];
        const uint8_t *at = pixel(&p, 45, layer == 0 ? 70 : layer == 1 ? 45 : 20);
        /* Light must change the lightness of a colour, but not the order of its channels. */
        for (int a = 0; a < 3; a++)
            for (int b = 0; b < 3; b++)
                if ((colour >> (8 * a) & 255) > (colour >> (8 * b) & 255) + 40)
                    assert_true(at[a] > at[b]);
    }
    o.threads = 3;
    assert_ok(ost_view_draw(&v, true, 0, &o, &again, &err));
    assert_memory_equal(p.rgb, again.rgb, 3 * 90 * 90);
    ost_picture_free(&p);
    ost_picture_free(&again);
    ost_volume_free(&v);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_view_of_labels),
        cmocka_unit_test(test_view_silhouette),
        cmocka_unit_test(test_view),
        cmocka_unit_test(test_view_marks),
        cmocka_unit_test(test_view_without_active_voxels),
        cmocka_unit_test(test_active_box),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
