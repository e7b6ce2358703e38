/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests the features of a picture other than shape, such as colours, clip planes and ghosts. Each feature
 * is compared with a separate, simple implementation in this file, which visits all voxels.
 *
 * Covers: REQ-LOOK
 */
#include <math.h>
#include <stdlib.h>

#include "harness.h"
#include "render/legend.h"
#include "render/points/extract.h"
#include "render/points/renew.h"
#include "render/viewer.h"

#define MM OST_PM_PER_MM
enum { NX = 70, NY = 41, NZ = 38, COUNT = NX * NY * NZ };

static ost_geometry grid(void)
{
    return (ost_geometry){{NX, NY, NZ}, {MM / 2, MM / 2, MM / 2}, {5 * MM, -3 * MM, 0}};
}

static size_t index_of(int i, int j, int k)
{
    return (size_t)i + (size_t)NX * ((size_t)j + (size_t)NY * (size_t)k);
}

/*
 * Makes a bone of many densities, with rounded corners and pores. In *after, a cylinder along x has been
 * removed from this bone. The cylinder extends from i = 46 to the end of the bone.
 */
static void make_bone(test_rng *rng, ost_volume *before, ost_volume *after)
{
    ost_error err = {0};
    const ost_geometry g = grid();
    assert_ok(ost_volume_init(before, &g, &err));
    assert_ok(ost_volume_init(after, &g, &err));
    for (int k = 0; k < NZ; k++)
        for (int j = 0; j < NY; j++)
            for (int i = 0; i < NX; i++) {
                const double a = (i - 34) / 32.0, b = (j - 20) / 17.0, c = (k - 19) / 16.0,
                             e = (j - 20.0) * (j - 20.0) + (k - 17.0) * (k - 17.0);
                const double shell = a * a * a * a + b * b * b * b + c * c * c * c;
                /* pores begin at a depth of four voxels */
                const bool bone = shell < 0.3 ? rng_range(rng, 0, 200) != 0 : shell < 1;
                const int16_t v = bone ? (int16_t)rng_range(rng, 120, 1500) : 0;
                before->voxels[index_of(i, j, k)] = v;
                after->voxels[index_of(i, j, k)] = i > 45 && e < 36 ? 0 : v;
            }
}

static int at(const ost_volume *v, int i, int j, int k)
{
    return i >= 0 && j >= 0 && k >= 0 && i < NX && j < NY && k < NZ ? v->voxels[index_of(i, j, k)] : 0;
}

static void set_bone(ost_viewer *v, const ost_volume *before, const ost_volume *now)
{
    ost_error err = {0};
    const ost_geometry g = grid();
    const ost_density_classes classes = ost_density_classes_default();
    ost_volume copy;
    assert_ok(ost_viewer_init(v, &g, OST_STYLE_SMOOTH, NULL, 1, &err));
    assert_ok(ost_volume_init(&copy, &g, &err));
    memcpy(copy.voxels, before->voxels, COUNT * sizeof *copy.voxels);
    assert_ok(ost_viewer_set_uncut(v, &copy, 120, &classes, NULL, NULL, &err));
    assert_ok(ost_surface_set_volume(&v->bone, now, 120, &err));
    assert_ok(ost_surface_update(&v->bone, &err));
}

typedef void each_point(void *user, const int v[3], uint32_t point, uint32_t shade, const ost_surface_block *block);

static void for_points(const ost_surface *s, each_point *visit, void *user)
{
    for (int32_t b = 0; b < s->used; b++)
        for (uint32_t p = 0; p < s->slot[b]->count; p++) {
            const uint32_t w = s->slot[b]->points[p];
            const int v[3] = {32 * s->slot[b]->at[0] + (int)(w & 31), 32 * s->slot[b]->at[1] + (int)(w >> 5 & 31),
                              32 * s->slot[b]->at[2] + (int)(w >> 10 & 31)};
            visit(user, v, w, s->slot[b]->shades[p], s->slot[b]);
        }
}

static void assert_same_shades(const ost_surface *a, const ost_surface *b)
{
    assert_int_equal(a->points, b->points);
    for (int32_t i = 0; i < b->used; i++) {
        const int32_t *at = b->slot[i]->at;
        const ost_surface_block *same = ost_surface_block_at(a, at[0], at[1], at[2]);
        assert_non_null(same);
        assert_int_equal(same->count, b->slot[i]->count);
        if (same->count == 0)
            continue;
        assert_memory_equal(same->points, b->slot[i]->points, same->count * sizeof(uint32_t));
        assert_memory_equal(same->shades, b->slot[i]->shades, same->count * sizeof(uint32_t));
    }
}

typedef struct check {
    const ost_volume *before, *now;
    const ost_clip *clip;
    int seen, painted;
} check;

static uint32_t paint_of(uint32_t shade)
{
    return shade >> OST_PAINT_SHIFT & 255;
}

/* ------------------------------------------------------------------- clip */

static bool is_not_clipped(const ost_clip *c, const int v[3])
{
    return (int64_t)c->n[0] * v[0] + (int64_t)c->n[1] * v[1] + (int64_t)c->n[2] * v[2] <= c->d;
}

/*
 * A voxel next to the clip plane must be grey. The voxel's CT density determines the grey level, which increases
 * in 126 steps from black at -100 HU to white at 1300 HU.
 */
static void check_clip(void *user, const int v[3], uint32_t point, uint32_t shade, const ost_surface_block *block)
{
    check *c = user;
    bool cap = false;
    (void)block;
    assert_true(is_not_clipped(c->clip, v));
    for (int f = 0; f < 6; f++) {
        int n[3] = {v[0], v[1], v[2]};
        n[f / 2] += f % 2 ? 1 : -1;
        const bool there = at(c->now, n[0], n[1], n[2]) >= 120;
        assert_int_equal(point >> (OST_FACES_SHIFT + f) & 1, !there || !is_not_clipped(c->clip, n));
        cap |= there && !is_not_clipped(c->clip, n);
    }
    const double share = (at(c->now, v[0], v[1], v[2]) + 100) / 1400.0;
    const int step = (int)floor((share > 1 ? 1 : share) * 126 + 0.5);
    assert_int_equal(paint_of(shade), cap ? 128 + step : 0);
    c->seen++;
    c->painted += cap;
}

static void clip_plane_shows_ct_densities(void **state)
{
    (void)state;
    ost_error err = {0};
    test_rng rng = rng_seeded("clip");
    ost_volume before, after;
    ost_viewer v;
    make_bone(&rng, &before, &after);
    set_bone(&v, &after, &after);
    for (int round = 0; round < 12; round++) {
        ost_clip clip;
        double normal[3], middle[3] = {5 + NX / 4.0, -3 + NY / 4.0, NZ / 4.0};
        for (int a = 0; a < 3; a++) {
            normal[a] = round < 6 ? (round / 2 == a) * (round % 2 ? 1 : -1) : (double)rng_range(&rng, -100, 100);
            middle[a] += (double)rng_range(&rng, -40, 40) * 0.1;
        }
        assert_ok(ost_clip_make(&v.bone.geometry, middle, normal, &clip, &err));
        /*
         * The plane must contain the requested point; the allowed error is 2^-14 voxel, which is one unit of the
         * plane's `d`. The length of the normal must be correct to 0.01 %.
         */
        double away = 0, length = 0;
        for (int a = 0; a < 3; a++) {
            away += clip.n[a] * (middle[a] * 2 - (a == 0 ? 10 : a == 1 ? -6 : 0));
            length += (double)clip.n[a] * clip.n[a];
        }
        assert_true(fabs(away - (double)clip.d) <= 1 && fabs(sqrt(length) / 16384 - 1) < 1e-4);
        ost_viewer_set_clip(&v, &clip);
        assert_ok(ost_surface_update(&v.bone, &err));
        check c = {&after, &after, &clip, 0, 0};
        for_points(&v.bone, check_clip, &c);
        assert_true(c.seen > 500 && c.painted > 50);
    }
    /*
     * In the picture, the voxels at the clip plane must have exactly the greys of their densities, because they are
     * not lit. The camera looks along x at a plane perpendicular to x.
     */
    const ost_clip across = {{-OST_CLIP_UNIT, 0, 0}, -(INT64_C(40) << 14)};
    ost_camera camera = {.focal_milli = 100000, .width = 64, .height = 64};
    assert_ok(ost_camera_look_at((double[3]){-10, -3 + 10, 9}, (double[3]){40, -3 + 10, 9}, (double[3]){0, 0, 1},
                                 &camera, &err));
    ost_viewer_set_clip(&v, &across);
    assert_ok(ost_viewer_update(&v, &err));
    assert_ok(ost_viewer_draw(&v, &camera, &err));
    assert_ok(ost_frame_store_keys(&v.frame, &err));
    assert_ok(ost_viewer_draw(&v, &camera, &err));
    const ost_planes *p = &v.frame.planes;
    int pixels = 0;
    for (int y = 0; y < 64; y++)
        for (int x = 0; x < 64; x++) {
            const size_t i = (size_t)y * (size_t)p->stride + (size_t)x;
            if (p->face[i] != OST_FACE_X0)
                continue;
            const uint32_t id = (uint32_t)v.frame.layer[0]
                                    .visible.seen[ost_visible_index(&v.frame.layer[0].visible, (uint32_t)p->key[i])];
            const int32_t *b = v.bone.slot[id >> OST_LOCAL_BITS]->at;
            const int j = 32 * b[1] + (int)(id >> 5 & 31), k = 32 * b[2] + (int)(id >> 10 & 31);
            if (32 * b[0] + (int)(id & 31) != 40 || at(&after, 39, j, k) < 120)
                continue;
            const double share = (at(&after, 40, j, k) + 100) / 1400.0;
            const int grey = (int)(p->colour[i] & 255);
            assert_int_equal(p->colour[i], grey * 0x010101);
            assert_true(fabs(grey - 255 * (share > 1 ? 1 : share)) <= 1.6);
            pixels++;
        }
    assert_true(pixels > 300);
    /* After the clip plane is removed, all shades must be those of a bone that never had a clip plane. */
    ost_viewer fresh;
    set_bone(&fresh, &after, &after);
    ost_viewer_set_clip(&v, NULL);
    assert_ok(ost_surface_update(&v.bone, &err));
    assert_same_shades(&v.bone, &fresh.bone);
    ost_viewer_free(&fresh);
    ost_viewer_free(&v);
    ost_volume_free(&before);
    ost_volume_free(&after);
}

/* ----------------------------------------------------------------- colours */

static bool borders_on_removed_voxel(const check *c, const int v[3])
{
    for (int f = 0; f < 6; f++) {
        int n[3] = {v[0], v[1], v[2]};
        n[f / 2] += f % 2 ? 1 : -1;
        if (at(c->now, n[0], n[1], n[2]) < 120 && at(c->before, n[0], n[1], n[2]) >= 120)
            return true;
    }
    return false;
}

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

/* Sets the density of the voxels from[] <= v < to[]. */
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

/* ----------------------------------------------------------------- contact */

static void count_contact(void *user, const int v[3], uint32_t point, uint32_t shade, const ost_surface_block *block)
{
    check *c = user;
    (void)point;
    (void)block;
    const bool hot = shade & OST_SHADE_CONTACT;
    if (c->before)
        assert_int_equal(hot, borders_on_removed_voxel(c, v));
    c->painted += hot;
}

static void new_surface_is_highlighted(void **state)
{
    (void)state;
    ost_error err = {0};
    test_rng rng = rng_seeded("contact");
    ost_volume before, after;
    ost_viewer v;
    make_bone(&rng, &before, &after);
    set_bone(&v, &before, &before);
    ost_viewer_set_contact(&v, true);
    assert_ok(ost_surface_set_volume(&v.bone, &after, 120, &err));
    for (int aged = 0; aged < 3; aged++) {
        assert_ok(ost_surface_update(&v.bone, &err));
        check c = {aged < 2 ? &before : NULL, &after, NULL, 0, 0};
        for_points(&v.bone, count_contact, &c);
        assert_true(aged < 2 ? c.painted > 400 : c.painted == 0);
        ost_surface_age(&v.bone);
        /* While voxels remain highlighted, the lists of their blocks must not be made again. */
        for (int32_t b = 0; b < v.bone.used && aged == 0; b++)
            assert_false(v.bone.slot[b]->dirty);
    }
    ost_viewer_free(&v);
    ost_volume_free(&before);
    ost_volume_free(&after);
}

/* ----------------------------------------------------------- recomputation */

/* Removes a ball of bone, or restores the complete bone. */
static void remove_or_restore_ball(test_rng *rng, const ost_volume *before, ost_volume *now)
{
    const int c[3] = {(int)rng_range(rng, -2, NX), (int)rng_range(rng, -2, NY), (int)rng_range(rng, -2, NZ)},
              r = (int)rng_range(rng, 0, 6);
    const bool back = rng_range(rng, 0, 7) == 0;
    for (int k = c[2] - r; k <= c[2] + r; k++)
        for (int j = c[1] - r; j <= c[1] + r; j++)
            for (int i = c[0] - r; i <= c[0] + r; i++) {
                const int a[3] = {i - c[0], j - c[1], k - c[2]};
                if (i >= 0 && j >= 0 && k >= 0 && i < NX && j < NY && k < NZ &&
                    a[0] * a[0] + a[1] * a[1] + a[2] * a[2] <= r * r)
                    now->voxels[index_of(i, j, k)] = back ? before->voxels[index_of(i, j, k)] : 0;
            }
}

/* With every instruction set, an updated block must equal a block computed from scratch. */
static void updated_blocks_equal_new_blocks(void **state)
{
    (void)state;
    enum { ROUNDS = 40, SLOTS = 64 };
    ost_error err = {0};
    test_rng rng = rng_seeded("updates");
    ost_volume before, now;
    make_bone(&rng, &before, &now);
    for (int isa = 0; isa < OST_ISA_COUNT; isa++) {
        if (!ost_isa_available((ost_isa)isa))
            continue;
        for (int known = 0; known < 2; known++) {
            ost_viewer v[2];
            int looked_at = 0, made = 0, kept = 0;
            memcpy(now.voxels, before.voxels, COUNT * sizeof *now.voxels);
            for (int i = 0; i < 2; i++) {
                set_bone(&v[i], &before, &before);
                if (!known)
                    assert_ok(ost_surface_set_uncut(&v[i].bone, NULL, &err));
                assert_ok(ost_surface_use(&v[i].bone, i ? OST_ISA_SCALAR : (ost_isa)isa, &err));
                ost_viewer_set_contact(&v[i], true);
            }
            for (int round = 0; round < ROUNDS; round++) {
                const int32_t n = (int32_t)rng_range(&rng, -9000, 9000);
                const ost_clip plane = {{n, 8192, 4096},
                                        n * (NX / 2) + 8192 * (NY / 2 + rng_range(&rng, -6, 12)) + 4096 * (NZ / 2)};
                const int what = (int)rng_range(&rng, 0, 11), colour = (int)rng_range(&rng, 0, OST_COLOUR_COUNT - 1);
                uint64_t version[SLOTS] = {0};
                for (int more = (int)rng_range(&rng, 1, 3); more > 0 && what > 1; more--)
                    remove_or_restore_ball(&rng, &before, &now);
                for (int32_t b = 0; b < v[0].bone.used; b++)
                    version[b] = v[0].bone.slot[b]->version;
                for (int i = 0; i < 2; i++) {
                    ost_surface *s = &v[i].bone;
                    if (what == 0)
                        ost_viewer_set_colouring(&v[i], (ost_colouring)colour);
                    else if (what == 1)
                        ost_viewer_set_clip(&v[i], colour ? &plane : NULL);
                    else if (what < 5)
                        ost_surface_age(s);
                    assert_ok(ost_surface_set_volume(s, &now, 120, &err));
                    for (int32_t b = 0; b < s->used; b++)
                        if (i)
                            s->slot[b]->dirty = s->slot[b]->remade = s->slot[b]->unlisted = s->slot[b]
                                                                                                ->unmeasured = true;
                        else
                            looked_at += s->slot[b]->dirty;
                    assert_ok(ost_surface_update(s, &err));
                }
                assert_same_shades(&v[0].bone, &v[1].bone);
                /* `renewed` must contain exactly the blocks whose lists changed. */
                int named = 0;
                for (int32_t b = 0; b < v[0].bone.used; b++)
                    named += v[0].bone.slot[b]->version != version[b];
                assert_int_equal(named, v[0].bone.renewals);
                for (int32_t b = 0; b < v[0].bone.renewals; b++)
                    assert_true(v[0].bone.slot[v[0].bone.renewed[b]]->version != version[v[0].bone.renewed[b]]);
                made += named;
                kept += v[0].bone.used - named;
            }
            assert_true(made > ROUNDS / 2 && kept > ROUNDS / 2 && looked_at >= made);
            /* The result must not depend on how the bone was changed before. */
            ost_viewer fresh;
            set_bone(&fresh, &before, &now);
            if (!known)
                assert_ok(ost_surface_set_uncut(&fresh.bone, NULL, &err));
            ost_viewer_set_colouring(&fresh, (ost_colouring)v[0].bone.colouring);
            ost_viewer_set_clip(&v[0], NULL);
            ost_viewer_set_contact(&v[0], false);
            assert_ok(ost_surface_update(&v[0].bone, &err));
            assert_ok(ost_surface_update(&fresh.bone, &err));
            assert_same_shades(&v[0].bone, &fresh.bone);
            ost_viewer_free(&fresh);
            ost_viewer_free(&v[0]);
            ost_viewer_free(&v[1]);
        }
    }
    ost_volume_free(&before);
    ost_volume_free(&now);
}

/* ---------------------------------------------------------- ghost and lines */

static ost_tool_volume rod(void)
{
    ost_error err = {0};
    ost_tool_volume t;
    const ost_tool_geometry g = {{8, 8, 60}, MM / 2, {-2 * MM, -2 * MM, 0}};
    assert_ok(ost_tool_volume_init(&t, &g, &err));
    memset(t.voxels, OST_TOOL_CUTTING, 8 * 8 * 60);
    return t;
}

static void ghosts_and_lines_are_blended(void **state)
{
    (void)state;
    enum { W = 160, H = 120 };
    ost_error err = {0};
    test_rng rng = rng_seeded("ghost");
    ost_volume before, after;
    ost_viewer v;
    ost_tool_volume t = rod();
    ost_camera camera = {.focal_milli = 180000, .width = W, .height = H};
    make_bone(&rng, &before, &after);
    set_bone(&v, &before, &after);
    assert_ok(ost_camera_look_at((double[3]){22, -50, 9}, (double[3]){22, 7, 9}, (double[3]){0, 0, 1}, &camera, &err));
    assert_ok(ost_viewer_draw(&v, &camera, &err));
    const size_t count = (size_t)v.frame.planes.stride * H;
    uint32_t *plain = malloc(count * sizeof *plain);
    uint8_t *face = malloc(count);
    assert_non_null(plain);
    assert_non_null(face);
    memcpy(plain, v.frame.planes.colour, count * sizeof *plain);
    memcpy(face, v.frame.planes.face, count);
    /*
     * The ghost must be faint behind the bone and stronger in front of it. The ghost is 4 mm wide, and
     * the focal length is 180 pixels.
     */
    double change[2] = {0, 0};
    for (int near = 0; near < 2; near++) {
        const ost_pose pose = {.t = {22 * MM, near ? -10 * MM : 20 * MM, -5 * MM}, .qw = OST_Q30_ONE};
        assert_ok(ost_viewer_set_ghost(&v, &t, &pose, &err));
        assert_ok(ost_viewer_draw(&v, &camera, &err));
        int inside = 0;
        for (int y = 0; y < H; y++)
            for (int x = 0; x < W; x++) {
                const size_t i = (size_t)y * (size_t)v.frame.planes.stride + (size_t)x;
                assert_int_equal(v.frame.planes.face[i], face[i]);
                if (fabs(x - 80.0) > 20)
                    assert_int_equal(v.frame.planes.colour[i], plain[i]);
                else if (fabs(x - 80.0) < 4 && face[i] != OST_NO_FACE) {
                    change[near] += fabs((double)(v.frame.planes.colour[i] & 255) - (double)(plain[i] & 255));
                    inside++;
                }
            }
        assert_true(inside > 100);
        change[near] /= inside;
    }
    assert_true(change[0] > 8 && change[1] > 1.4 * change[0]);
    v.show_ghost = false;
    assert_ok(ost_viewer_draw(&v, &camera, &err));
    assert_memory_equal(v.frame.planes.colour, plain, count * sizeof *plain);
    int columns = 0, hidden = 0;
    /*
     * A line is drawn across the picture. In every column, the colours that the line adds must sum to the line's
     * full colour, whatever the position of the line. Behind the bone, the sum must be a fifth of this colour.
     */
    for (int near = 0; near < 2; near++) {
        const ost_eye eye = ost_eye_make(&camera, &v.bone.geometry);
        const float y = near ? -20 : 45, from[3] = {-60, y, 18}, to[3] = {140, y, 18};
        memcpy(v.frame.planes.colour, plain, count * sizeof *plain);
        ost_overlay_line(&v.frame, &eye, from, to, 0xffffff, 256, 1);
        for (int x = 0; x < W; x++) {
            double change_here = 0;
            int behind = 0, bright = 0;
            for (int row = 0; row < H; row++) {
                const size_t i = (size_t)row * (size_t)v.frame.planes.stride + (size_t)x;
                const double was = plain[i] & 255, more = (double)(v.frame.planes.colour[i] & 255) - was;
                assert_true(more == 0 || abs(row - 60) <= 1);
                change_here += was < 255 ? more / (255 - was) : 0;
                behind += abs(row - 60) <= 1 && face[i] != OST_NO_FACE;
                bright += abs(row - 60) <= 1 && was > 235;
            }
            if ((behind > 0 && behind < 3) || bright)
                continue;
            columns++;
            hidden += behind == 3 && !near;
            assert_true(fabs(change_here - (behind && !near ? 0.2 : 1)) < 0.06);
        }
    }
    assert_true(columns > W && hidden > 30);
    /* Tests which chunks a tool's box meets. The corners of the box are exact multiples of half a millimetre. */
    const ost_overlay_scene scene = {.bone = &v.bone,
                                     .tool = &v.ghost,
                                     .tool_grid = t.geometry,
                                     .pose = {.t = {13 * MM, 7 * MM, -40 * MM}, .qw = OST_Q30_ONE},
                                     .chunk = 16};
    int32_t lo[3], hi[3];
    ost_overlay_hit_range(&scene, lo, hi);
    for (int a = 0; a < 3; a++)
        assert_int_equal(hi[a] - lo[a], 0);
    ost_overlay_scene meets = scene;
    meets.pose.t.z = 0; /* in bone voxels, the tool's box extends over x 12 to 20, y 16 to 24, z 0 to 38 */
    ost_overlay_hit_range(&meets, lo, hi);
    assert_int_equal(lo[0], 0);
    assert_int_equal(hi[0], 2);
    assert_int_equal(lo[1], 1);
    assert_int_equal(hi[1], 2);
    assert_int_equal(lo[2], 0);
    assert_int_equal(hi[2], 3);
    /* Every overlay must draw something. */
    v.has_state = true;
    v.state = (ost_live_state){.ticks = 1, .pose = meets.pose};
    assert_ok(ost_viewer_add_tool(&v, &t, &err));
    v.scene.planned = true;
    v.scene.inward[1] = 1;
    v.scene.face_mm[0] = 22;
    v.scene.face_mm[1] = -2;
    v.scene.face_mm[2] = 9;
    v.scene.depth_mm = 3;
    assert_ok(ost_viewer_draw(&v, &camera, &err));
    memcpy(plain, v.frame.planes.colour, count * sizeof *plain);
    for (int o = 0; o < OST_OVERLAY_COUNT; o++) {
        v.overlays = 1u << o;
        assert_ok(ost_viewer_draw(&v, &camera, &err));
        assert_memory_not_equal(v.frame.planes.colour, plain, count * sizeof *plain);
    }
    free(plain);
    free(face);
    ost_tool_volume_free(&t);
    ost_viewer_free(&v);
    ost_volume_free(&before);
    ost_volume_free(&after);
}

/* Tests all features of a picture together. Every instruction set and number of threads must give the same picture. */
static void all_sets_give_same_picture(void **state)
{
    (void)state;
    enum { W = 150, H = 110 };
    static const char *const sets[] = {"scalar", "avx2", "avx512"};
    ost_error err = {0};
    test_rng rng = rng_seeded("sets");
    ost_volume before, after;
    ost_viewer v[3];
    bool have[3];
    ost_tool_volume t = rod();
    make_bone(&rng, &before, &after);
    for (int i = 0; i < 3; i++) {
        ost_isa isa;
        have[i] = ost_isa_choose(sets[i], &isa, NULL) == OST_OK;
        if (!have[i])
            continue;
        set_bone(&v[i], &before, &after);
        v[i].isa = isa;
        v[i].threads = 1 + i;
        const ost_pose pose = {.t = {20 * MM, 2 * MM, 0}, .qw = OST_Q30_ONE};
        assert_ok(ost_viewer_set_ghost(&v[i], &t, &pose, &err));
        v[i].overlays = 1u << OST_OVERLAY_CHUNKS;
    }
    for (int round = 0; round < 8; round++) {
        ost_camera camera = {.focal_milli = 150000, .width = W, .height = H};
        ost_clip clip;
        const double to[3] = {22, 7, 9}, from[3] = {(double)rng_range(&rng, -30, 70), (double)rng_range(&rng, -60, -20),
                                                    (double)rng_range(&rng, -30, 50)};
        const double normal[3] = {from[0] - to[0] + (double)rng_range(&rng, -20, 20), from[1] - to[1], from[2] - to[2]};
        assert_ok(ost_camera_look_at(from, to, (double[3]){0, 0, 1}, &camera, &err));
        assert_ok(ost_clip_make(&v[0].bone.geometry, to, normal, &clip, &err));
        for (int i = 0; i < 3; i++) {
            if (!have[i])
                continue;
            ost_viewer_set_colouring(&v[i], (ost_colouring)(round % OST_COLOUR_COUNT));
            ost_viewer_set_clip(&v[i], round % 3 ? &clip : NULL);
            assert_ok(ost_viewer_update(&v[i], &err));
            assert_ok(ost_viewer_draw(&v[i], &camera, &err));
            for (int y = 0; y < H; y++)
                assert_memory_equal(v[i].frame.planes.colour + (size_t)y * (size_t)v[i].frame.planes.stride,
                                    v[0].frame.planes.colour + (size_t)y * (size_t)v[0].frame.planes.stride,
                                    W * sizeof(uint32_t));
        }
    }
    for (int i = 0; i < 3; i++)
        if (have[i])
            ost_viewer_free(&v[i]);
    ost_tool_volume_free(&t);
    ost_volume_free(&before);
    ost_volume_free(&after);
}

/* Returns the number of pixels whose colours differ. */
static int differing(const uint32_t *a, const uint32_t *b, int width, int height, int stride)
{
    int count = 0;
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++)
            count += ((a[y * stride + x] ^ b[y * stride + x]) & 0xffffff) != 0;
    return count;
}

/* OpenGL must draw the same colours, planes and ghosts. Returns false if OpenGL is not available. */
static bool compare_opengl(bool antialiased)
{
    /* MOST is the number of pixels that may differ: 30 of 921,600 pixels, and one for each object drawn. With
       antialiasing, each of these pixels may also change other pixels at distances up to OST_ANTIALIAS_REACH. */
    enum { W = 160, H = 120, MOST = 2, SPREAD = 4 * OST_ANTIALIAS_REACH };
    ost_error err = {0};
    test_rng rng = rng_seeded("gl");
    ost_volume before, after;
    ost_viewer v[2];
    ost_tool_volume t = rod();
    make_bone(&rng, &before, &after);
    for (int i = 0; i < 2; i++) {
        const ost_pose pose = {.t = {20 * MM, 2 * MM, 0}, .qw = OST_Q30_ONE};
        set_bone(&v[i], &before, &before);
        v[i].antialiased = antialiased;
        ost_viewer_set_contact(&v[i], true);
        assert_ok(ost_surface_set_volume(&v[i].bone, &after, 120, &err));
        assert_ok(ost_viewer_set_ghost(&v[i], &t, &pose, &err));
    }
    /* OpenGL is not tested under valgrind, which cannot check the code of a driver. */
    const bool have = !getenv("OST_UNDER_VALGRIND") && ost_viewer_use_gl(&v[1], &ost_gl_ours, &err) == OST_OK;
    for (int round = 0; have && round < 6; round++) {
        ost_camera camera = {.focal_milli = 150000, .width = W, .height = H};
        ost_clip clip;
        const double to[3] = {22, 7, 9}, from[3] = {round % 2 ? 60 : 10, -30, 20},
                     normal[3] = {from[0] - to[0], from[1] - to[1], 3};
        assert_ok(ost_camera_look_at(from, to, (double[3]){0, 0, 1}, &camera, &err));
        assert_ok(ost_clip_make(&v[0].bone.geometry, to, normal, &clip, &err));
        for (int i = 0; i < 2; i++) {
            if (round == 3)
                ost_viewer_set_contact(&v[i], false);
            ost_viewer_set_colouring(&v[i], (ost_colouring)(round % OST_COLOUR_COUNT));
            ost_viewer_set_clip(&v[i], round > 1 ? &clip : NULL);
            assert_ok(ost_viewer_update(&v[i], &err));
            assert_ok(ost_viewer_draw(&v[i], &camera, &err));
        }
        assert_string_equal(v[1].lost, "");
        const ost_frame *a = &v[0].frame, *b = &v[1].frame;
        const int spread = antialiased ? differing(a->drawn.colour, b->drawn.colour, W, H, a->planes.stride) : 0;
        assert_in_range(spread, 0, MOST);
        assert_in_range(differing(a->planes.colour, b->planes.colour, W, H, a->planes.stride), 0,
                        MOST + SPREAD * spread);
        if (antialiased)
            assert_true(differing(b->planes.colour, b->drawn.colour, W, H, b->planes.stride) > 100);
    }
    for (int i = 0; i < 2; i++)
        ost_viewer_free(&v[i]);
    ost_tool_volume_free(&t);
    ost_volume_free(&before);
    ost_volume_free(&after);
    return have;
}

static void opengl_gives_same_picture(void **state)
{
    (void)state;
    if (!compare_opengl(false) || !compare_opengl(true))
        skip();
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(clip_plane_shows_ct_densities),
        cmocka_unit_test(density_and_depth_colours_equal_ct),
        cmocka_unit_test(tunnel_is_outside_of_bone),
        cmocka_unit_test(tissues_follow_density_and_depth),
        cmocka_unit_test(colours_are_distinguishable),
        cmocka_unit_test(new_surface_is_highlighted),
        cmocka_unit_test(updated_blocks_equal_new_blocks),
        cmocka_unit_test(ghosts_and_lines_are_blended),
        cmocka_unit_test(all_sets_give_same_picture),
        cmocka_unit_test(opengl_gives_same_picture),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
