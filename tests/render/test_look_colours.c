/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests the colours of cut surfaces by density, depth and tissue. The depth is compared with a separate, simple
 * implementation in this file, which visits all voxels. Further tests check the colours themselves and their legend.
 *
 * Covers: REQ-LOOK
 */
#include "look_bone.h"

#include <math.h>

#include "render/legend.h"

static void check_density(void *user, const int v[3], uint32_t point, uint32_t shade, const ost_surface_block *block)
{
    check *c = user;
    (void)point;
    (void)block;
    const double share = (at(c->before, v[0], v[1], v[2]) + 100) / 1400.0;
    const int step = (int)floor((share > 1 ? 1 : share) * 126 + 0.5);
    assert_int_equal(paint_of(shade), borders_on_removed_voxel(c, v) ? 1 + 126 - step : 0);
    c->painted += borders_on_removed_voxel(c, v);
}

/*
 * Returns the squared distance to the nearest voxel that is neither bone nor pore. In this test pores are
 * single voxels, and the bone is far from the border.
 */
static int distance(const ost_volume *v, const int from[3])
{
    int best = 1024;
    for (int k = 0; k < NZ; k++)
        for (int j = 0; j < NY; j++)
            for (int i = 0; i < NX; i++) {
                const int square = (i - from[0]) * (i - from[0]) + (j - from[1]) * (j - from[1]) +
                                   (k - from[2]) * (k - from[2]);
                const double a = (i - 34) / 32.0, b = (j - 20) / 17.0, c = (k - 19) / 16.0;
                if (square < best && at(v, i, j, k) < 120 && a * a * a * a + b * b * b * b + c * c * c * c >= 1)
                    best = square;
            }
    return best;
}

static void check_depth(void *user, const int v[3], uint32_t point, uint32_t shade, const ost_surface_block *block)
{
    check *c = user;
    if (!borders_on_removed_voxel(c, v)) {
        assert_int_equal(paint_of(shade), 0);
        return;
    }
    if (++c->painted % 5 != 0)
        return;
    const int exact = distance(c->before, v), got = block->depth[point & 0x7fff];
    assert_int_equal(got, exact);
    /*
     * The distance is measured to a voxel's centre, so half a voxel is subtracted to get the distance to
     * its edge. Voxels are half a millimetre wide, and the scale ends at 10 mm.
     */
    assert_int_equal(paint_of(shade), 1 + (int)floor((sqrt(got) - 0.5) * 0.5 / 10 * 126 + 0.5));
}

static void density_and_depth_colours_equal_ct(void **state)
{
    (void)state;
    ost_error err = {0};
    test_rng rng = rng_seeded("colours");
    ost_volume before, after;
    ost_viewer v;
    make_bone(&rng, &before, &after);
    set_bone(&v, &before, &before);
    check c = {&before, &after, NULL, 0, 0};
    assert_ok(ost_surface_set_volume(&v.bone, &after, 120, &err));
    ost_viewer_set_colouring(&v, OST_COLOUR_DENSITY);
    assert_ok(ost_surface_update(&v.bone, &err));
    for_points(&v.bone, check_density, &c);
    assert_true(c.painted > 400);
    /* A bone that was cut before the viewer started must have the same shades. */
    ost_viewer late;
    set_bone(&late, &before, &after);
    ost_viewer_set_colouring(&late, OST_COLOUR_DENSITY);
    assert_ok(ost_surface_update(&late.bone, &err));
    assert_same_shades(&v.bone, &late.bone);
    ost_viewer_free(&late);
    c.painted = 0;
    ost_viewer_set_colouring(&v, OST_COLOUR_DEPTH);
    assert_ok(ost_surface_update(&v.bone, &err));
    for_points(&v.bone, check_depth, &c);
    assert_true(c.painted > 400);
    ost_viewer_free(&v);
    ost_volume_free(&before);
    ost_volume_free(&after);
}

/* Sets the density of all voxels v with from[a] <= v[a] < to[a] on each axis a. */
static void fill_box(ost_volume *v, const int from[3], const int to[3], int16_t density)
{
    for (int k = from[2]; k < to[2]; k++)
        for (int j = from[1]; j < to[1]; j++)
            for (int i = from[0]; i < to[0]; i++)
                v->voxels[index_of(i, j, k)] = density;
}

/*
 * A tunnel into a solid bone must count as outside of the bone, even if the tunnel has bends. A closed cavity must not.
 * The tunnel is six voxels wide, enters at x = 0, and has a segment in each of the six directions.
 */
static void tunnel_is_outside_of_bone(void **state)
{
    (void)state;
    enum { WIDTH = 6, CORNERS = 8 };
    static const int corner[CORNERS][3] = {{0, 6, 6},    {48, 6, 6},  {48, 26, 6}, {12, 26, 6},
                                           {12, 26, 26}, {12, 8, 26}, {40, 8, 26}, {40, 8, 18}};
    ost_error err = {0};
    ost_volume bone, outside;
    ost_viewer v;
    const ost_geometry g = grid();
    assert_ok(ost_volume_init(&bone, &g, &err));
    assert_ok(ost_volume_init(&outside, &g, &err));
    fill_box(&bone, (const int[3]){0, 0, 0}, (const int[3]){NX, NY, NZ}, 500);
    for (int s = 0; s + 1 < CORNERS; s++) {
        int from[3], to[3];
        for (int a = 0; a < 3; a++) {
            const int p = corner[s][a], q = corner[s + 1][a];
            from[a] = p < q ? p : q;
            to[a] = (p < q ? q : p) + WIDTH;
        }
        fill_box(&bone, from, to, 0);
        fill_box(&outside, from, to, 1);
    }
    fill_box(&bone, (const int[3]){22, 16, 16}, (const int[3]){30, 22, 22}, 0); /* makes the closed cavity */
    set_bone(&v, &bone, &bone);
    int checked = 0;
    for (int32_t n = 0; n < v.bone.used; n++) {
        ost_surface_block *b = v.bone.slot[n];
        assert_ok(ost_uncut_depth(&v.bone, b, &err));
        for (int p = n % 37; p < OST_BLOCK * OST_BLOCK_ROWS; p += 37) {
            const int at_p[3] = {OST_BLOCK * b->at[0] + p % OST_BLOCK, OST_BLOCK * b->at[1] + p / OST_BLOCK % OST_BLOCK,
                                 OST_BLOCK * b->at[2] + p / OST_BLOCK_ROWS};
            if (at(&bone, at_p[0], at_p[1], at_p[2]) == 0)
                continue;
            int best = OST_DEPTH_FAR;
            for (int k = 0; k < NZ; k++)
                for (int j = 0; j < NY; j++)
                    for (int i = 0; i < NX; i++)
                        if (outside.voxels[index_of(i, j, k)]) {
                            const int x = i - at_p[0], y = j - at_p[1], z = k - at_p[2],
                                      square = x * x + y * y + z * z;
                            best = square < best ? square : best;
                        }
            assert_int_equal(b->depth[p], best);
            checked++;
        }
        free(b->depth);
        b->depth = NULL;
    }
    assert_true(checked > 1000);
    ost_viewer_free(&v);
    ost_volume_free(&bone);
    ost_volume_free(&outside);
}

/*
 * In the bone of this test, 2 mm of cartilage, 2 mm of hard bone and then cancellous bone lie below
 * a face. There is also hard bone far from the face.
 */
static void tissues_follow_density_and_depth(void **state)
{
    (void)state;
    ost_error err = {0};
    const ost_geometry g = grid();
    const ost_density_classes classes = ost_density_classes_default();
    ost_volume v;
    ost_uncut reference;
    assert_ok(ost_volume_init(&v, &g, &err));
    for (int k = 4; k < 34; k++)
        for (int j = 4; j < 37; j++)
            for (int i = 10; i < 60; i++)
                v.voxels[index_of(i, j, k)] = i < 14 ? 130 : i == 14 ? 400 : i < 18 ? 1100 : i < 55 ? 300 : 1000;
    const ost_pm3 at_pm = {g.origin.x + 10 * (MM / 2), g.origin.y + 20 * (MM / 2), g.origin.z + 19 * (MM / 2)};
    assert_ok(ost_uncut_init(&reference, &v, 120, &classes, &at_pm, (double[3]){2, 0, 0}, &err));
    static const struct {
        int i;
        ost_tissue tissue;
    } wanted[] = {{11, OST_TISSUE_CARTILAGE},  {13, OST_TISSUE_CARTILAGE}, {14, OST_TISSUE_PLATE},
                  {15, OST_TISSUE_PLATE},      {17, OST_TISSUE_PLATE},     {18, OST_TISSUE_CANCELLOUS},
                  {40, OST_TISSUE_CANCELLOUS}, {57, OST_TISSUE_CORTICAL}};
    for (size_t w = 0; w < sizeof wanted / sizeof *wanted; w++) {
        const int32_t p[3] = {wanted[w].i, 20, 19};
        assert_int_equal(ost_uncut_paint(&reference, OST_COLOUR_CLASS, p, 0), OST_PAINT_LIT + wanted[w].tissue);
        assert_int_equal(ost_uncut_cap(&reference, OST_COLOUR_CLASS, p), OST_PAINT_FLAT + wanted[w].tissue);
    }
    ost_uncut_free(&reference);
}

static double luminance(uint32_t colour)
{
    double out = 0;
    static const double weight[3] = {0.2126, 0.7152, 0.0722};
    for (int c = 0; c < 3; c++) {
        const double v = (colour >> (8 * c) & 255) / 255.0;
        out += weight[c] * (v <= 0.04045 ? v / 12.92 : pow((v + 0.055) / 1.055, 2.4));
    }
    return out;
}

/*
 * Each colour of the scale must be darker than the previous colour. Tissues must differ in lightness or in
 * hue.
 */
static void colours_are_distinguishable(void **state)
{
    (void)state;
    for (int i = 1; i < OST_SCALE; i++)
        assert_true(luminance(ost_scale_colour(i)) < luminance(ost_scale_colour(i - 1)));
    assert_true(luminance(ost_scale_colour(0)) > 0.7 && luminance(ost_scale_colour(OST_SCALE - 1)) < 0.03);
    for (int a = 0; a < OST_TISSUES; a++)
        for (int b = 0; b < a; b++) {
            const double x = luminance(ost_tissue_colours[a]) + 0.05, y = luminance(ost_tissue_colours[b]) + 0.05;
            const int red = abs((int)(ost_tissue_colours[a] & 255) - (int)(ost_tissue_colours[b] & 255));
            const int blue = abs((int)(ost_tissue_colours[a] >> 16) - (int)(ost_tissue_colours[b] >> 16));
            assert_true((x > y ? x / y : y / x) > 1.2 || red + blue > 120);
        }
    /* A legend must be drawn in its corner and nowhere else. */
    static uint32_t pixels[300 * 200];
    const ost_sheet sheet = {.pixels = pixels, .stride = 300, .width = 300, .height = 200};
    ost_error err = {0};
    ost_lettering *letters;
    assert_ok(ost_lettering_create(9.5, &letters, &err));
    ost_legend_draw(&(ost_legend){OST_COLOUR_BONE, 10, true, false}, letters, &sheet, 0, 200, 1);
    for (int i = 0; i < 300 * 200; i++)
        assert_int_equal(pixels[i], 0);
    ost_legend_draw(&(ost_legend){OST_COLOUR_DEPTH, 10, true, false}, letters, &sheet, 0, 200, 1);
    int drawn = 0;
    for (int i = 0; i < 300 * 200; i++)
        drawn += pixels[i] != 0;
    assert_true(drawn > 10000);
    assert_int_equal(pixels[0], 0);
    assert_int_equal(pixels[300 * 199 + 299], 0);
    ost_lettering_free(letters);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(density_and_depth_colours_equal_ct),
        cmocka_unit_test(tunnel_is_outside_of_bone),
        cmocka_unit_test(tissues_follow_density_and_depth),
        cmocka_unit_test(colours_are_distinguishable),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
