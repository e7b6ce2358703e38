/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests pictures of points drawn through a camera. A picture is compared with the intersections of each pixel's ray
 * with every voxel. The pictures of all instruction sets and numbers of threads are compared with those of the scalar
 * functions.
 *
 * Covers: REQ-RENDER, REQ-RENDER-POINTS
 */
#include "points_volume.h"

typedef struct scene {
    ost_volume volume;
    ost_surface surface;
} scene;

static void make_scene(scene *s, test_rng *rng, int x, int y, int z)
{
    ost_error err = {0};
    s->volume = pitted_ball(rng, x, y, z);
    assert_ok(ost_surface_init(&s->surface, &s->volume.geometry, &err));
    assert_ok(ost_surface_set_volume(&s->surface, &s->volume, 120, &err));
    assert_ok(ost_surface_update(&s->surface, &err));
}

static void free_scene(scene *s)
{
    ost_surface_free(&s->surface);
    ost_volume_free(&s->volume);
}

static ost_camera camera_at(const ost_volume *v, test_rng *rng, double distance, int width, int height,
                            int32_t focal_milli)
{
    ost_error err = {0};
    ost_camera c = {.focal_milli = focal_milli, .width = width, .height = height};
    const ost_dims d = v->geometry.dims;
    const double centre[3] = {0.5 * d.x - 3, 0.5 * d.y, 0.5 * d.z + 7};
    double from[3], up[3];
    for (int a = 0; a < 3; a++) {
        from[a] = centre[a] + distance * ((double)rng_range(rng, 0, 2000) / 1000.0 - 1);
        up[a] = (double)rng_range(rng, 0, 2000) / 1000.0 - 1;
    }
    from[0] += distance;
    assert_ok(ost_camera_look_at(from, centre, up, &c, &err));
    assert_ok(ost_camera_check(&c, &err));
    return c;
}

/*
 * Returns true if the complete cube around voxel v lies beyond the near plane by more than `by` voxels,
 * so that the voxel is drawn.
 */
static bool beyond_near(const ost_eye *e, const int v[3], double by)
{
    double z = -(double)e->near;
    for (int a = 0; a < 3; a++)
        z += (v[a] - (double)e->at[a]) * (double)e->forward[a] - 0.5 * fabs((double)e->forward[a]);
    return z > by;
}

/*
 * Returns true if the ray of a pixel, computed in doubles, intersects the cube around voxel v, enlarged by
 * `grow`.
 */
static bool meets(const ost_eye *e, double x, double y, const int v[3], double grow)
{
    double in = -1e300, out = 1e300;
    for (int a = 0; a < 3; a++) {
        const double d = (double)e->focal * (double)e->forward[a] +
                         (x + 0.5 - (double)e->half_w) * (double)e->right[a] -
                         (y + 0.5 - (double)e->half_h) * (double)e->up[a];
        const double o = v[a] - (double)e->at[a], t0 = (o - 0.5 - grow) / d, t1 = (o + 0.5 + grow) / d;
        in = fmax(in, fmin(t0, t1));
        out = fmin(out, fmax(t0, t1));
    }
    return in <= out;
}

/* Returns true if the ray enters the cube well inside a face. Near an edge, either of the two faces would be
   correct. */
static bool clear_of_edges(const ost_eye *e, double x, double y, const int v[3])
{
    double best = -1e300, second = -1e300, square = 0;
    for (int a = 0; a < 3; a++) {
        const double d = (double)e->focal * (double)e->forward[a] +
                         (x + 0.5 - (double)e->half_w) * (double)e->right[a] -
                         (y + 0.5 - (double)e->half_h) * (double)e->up[a];
        const double in = (v[a] - (double)e->at[a]) / d - 0.5 / fabs(d);
        second = in > best ? best : fmax(second, in);
        best = fmax(best, in);
        square += d * d;
    }
    return (best - second) * sqrt(square) > 1e-2;
}

enum { NO_VOXEL = 0x7fffffff };

/* Returns the number of the voxel that pixel number `at` shows, or NO_VOXEL if the pixel shows no face. */
static uint32_t id_at(const ost_frame *f, size_t at)
{
    const ost_visible *v = &f->layer[0].visible;
    return f->planes.face[at] == OST_NO_FACE ? NO_VOXEL
                                             : (uint32_t)v->seen[ost_visible_index(v, (uint32_t)f->planes.key[at])];
}

/*
 * Compares each pixel with the nearest voxel on the pixel's ray. If slightly smaller and slightly larger
 * cubes give different voxels, the result depends on rounding, and the pixel is not compared. There are few
 * such pixels.
 */
static void assert_picture(const scene *s, const ost_frame *f, const ost_eye *e, int *checked, int *doubtful)
{
    for (int y = 0; y < f->height; y++)
        for (int x = 0; x < f->width; x++) {
            double best[2] = {1e300, 1e300};
            int who[2][3] = {{-1, -1, -1}, {-1, -1, -1}};
            for (int32_t b = 0; b < s->surface.used; b++)
                for (uint32_t p = 0; p < s->surface.slot[b]->count; p++) {
                    const uint32_t w = s->surface.slot[b]->points[p];
                    const int32_t *at = s->surface.slot[b]->at;
                    const int v[3] = {32 * at[0] + (int)(w & 31), 32 * at[1] + (int)(w >> 5 & 31),
                                      32 * at[2] + (int)(w >> 10 & 31)};
                    double square = 0;
                    for (int a = 0; a < 3; a++)
                        square += (v[a] - (double)e->at[a]) * (v[a] - (double)e->at[a]);
                    for (int grown = 0; grown < 2; grown++)
                        if (square < best[grown] && beyond_near(e, v, grown ? -1e-3 : 1e-3) &&
                            meets(e, x, y, v, grown ? 2e-3 : -2e-3)) {
                            best[grown] = square;
                            memcpy(who[grown], v, sizeof v);
                        }
                }
            if (memcmp(who[0], who[1], sizeof who[0]) != 0) {
                ++*doubtful;
                continue;
            }
            const size_t at = (size_t)y * (size_t)f->planes.stride + (size_t)x;
            const uint32_t id = id_at(f, at);
            if (who[0][0] < 0) {
                assert_int_equal(id, NO_VOXEL);
                assert_int_equal(f->planes.face[at], OST_NO_FACE);
                continue;
            }
            ++*checked;
            assert_int_not_equal(id, NO_VOXEL);
            const int32_t *block = s->surface.slot[id >> OST_LOCAL_BITS]->at;
            assert_int_equal(32 * block[0] + (int)(id & 31), who[0][0]);
            assert_int_equal(32 * block[1] + (int)(id >> 5 & 31), who[0][1]);
            assert_int_equal(32 * block[2] + (int)(id >> 10 & 31), who[0][2]);
            /* The face must border on air, and the depth of the pixel must be a depth on this face. */
            const int face = f->planes.face[at];
            assert_in_range(face, 0, 5);
            if (clear_of_edges(e, x, y, who[0]))
                assert_true(faces(&s->volume, who[0][0], who[0][1], who[0][2]) >> face & 1);
            const double along = (double)f->planes.depth[at] / (double)e->focal;
            const double d = (double)e->focal * (double)e->forward[face / 2] +
                             (x + 0.5 - (double)e->half_w) * (double)e->right[face / 2] -
                             (y + 0.5 - (double)e->half_h) * (double)e->up[face / 2];
            assert_float_equal((float)((double)e->at[face / 2] + along * d),
                               (float)(who[0][face / 2] + (face % 2 ? 0.5 : -0.5)), 2e-3f);
        }
}

static void test_against_rays(void **state)
{
    (void)state;
    ost_error err = {0};
    test_rng rng = rng_seeded("rays");
    scene s;
    int checked = 0, doubtful = 0;
    make_scene(&s, &rng, 37, 34, 40);
    for (int round = 0; round < 5; round++) {
        static const double distance[5] = {60, 30, 22, 300, 16};
        ost_camera c;
        ost_eye e;
        /* The camera is outside the body. Inside the body, the near plane would expose faces that do not border on
           air. */
        do {
            c = camera_at(&s.volume, &rng, distance[round], 33 + 7 * round, 29, round == 3 ? 300000 : 30000);
            e = ost_eye_make(&c, &s.volume.geometry);
        } while (hypotf(e.at[0] - 18, hypotf(e.at[1] - 17, e.at[2] - 20)) < 22);
        ost_frame f;
        assert_ok(ost_frame_init(&f, c.width, c.height, OST_STYLE_SMOOTH, OST_ISA_SCALAR, 1, &err));
        assert_ok(ost_frame_store_keys(&f, &err));
        assert_ok(ost_frame_draw(&f, &s.surface, &e, &err));
        assert_picture(&s, &f, &e, &checked, &doubtful);
        ost_frame_free(&f);
    }
    assert_true(checked > 300);
    assert_true(doubtful * 10 < checked);
    free_scene(&s);
}

static void assert_same(const ost_frame *a, const ost_frame *b)
{
    for (int y = 0; y < a->height; y++) {
        const size_t at = (size_t)y * (size_t)a->planes.stride, n = (size_t)a->width;
        assert_memory_equal(a->planes.colour + at, b->planes.colour + at, n * sizeof *a->planes.colour);
        assert_memory_equal(a->planes.face + at, b->planes.face + at, n);
        for (size_t x = 0; x < n; x++)
            if (a->planes.face[at + x] != OST_NO_FACE) {
                if (a->planes.key && b->planes.key)
                    assert_memory_equal(a->planes.key + at + x, b->planes.key + at + x, sizeof(uint64_t));
                assert_memory_equal(a->planes.depth + at + x, b->planes.depth + at + x, sizeof(float));
            }
    }
}

/* The camera is far from the body, near it, at its edge, or inside it. With every instruction set and number of
   threads, the picture must equal that of the scalar functions. */
static void test_sets_and_threads(void **state)
{
    (void)state;
    ost_error err = {0};
    test_rng rng = rng_seeded("sets");
    scene s;
    make_scene(&s, &rng, 90, 75, 101);
    for (int round = 0; round < 24; round++) {
        const double distance = round % 4 == 0 ? 400 : round % 4 == 1 ? 120 : round % 4 == 2 ? 40 : 8;
        const ost_camera c = camera_at(&s.volume, &rng, distance, 17 + (int)rng_range(&rng, 0, 299),
                                       11 + (int)rng_range(&rng, 0, 199), 20000 + (int)rng_range(&rng, 0, 399999));
        const ost_eye e = ost_eye_make(&c, &s.volume.geometry);
        const ost_style style = round % 5 ? OST_STYLE_SMOOTH : OST_STYLE_FACES;
        ost_frame scalar;
        assert_ok(ost_frame_init(&scalar, c.width, c.height, style, OST_ISA_SCALAR, 1, &err));
        assert_ok(ost_frame_store_keys(&scalar, &err));
        assert_ok(ost_frame_draw(&scalar, &s.surface, &e, &err));
        for (int isa = 0; isa < OST_ISA_COUNT; isa++) {
            if (!ost_isa_available((ost_isa)isa))
                continue;
            ost_frame f;
            assert_ok(ost_frame_init(&f, c.width, c.height, style, (ost_isa)isa, 1 + round % 3, &err));
            for (int again = 0; again < 2; again++) {
                assert_ok(ost_frame_draw(&f, &s.surface, &e, &err));
                if (again == 0) {
                    assert_same(&scalar, &f);
                    assert_ok(ost_frame_store_keys(&f, &err));
                }
            }
            assert_same(&scalar, &f);
            ost_frame_free(&f);
        }
        ost_frame_free(&scalar);
    }
    free_scene(&s);
}

static void test_camera(void **state)
{
    (void)state;
    ost_error err = {0};
    ost_camera c = {.focal_milli = 1000000, .width = 100, .height = 100};
    const double origin[3] = {0, 0, 0}, up[3] = {0, 0, 1};
    assert_ok(ost_camera_look_at((double[3]){0, -10, 0}, origin, up, &c, &err));
    const ost_geometry g = {{4, 4, 4}, {OST_PM_PER_MM / 2, OST_PM_PER_MM / 2, OST_PM_PER_MM / 2}, {0, 0, 0}};
    const ost_eye e = ost_eye_make(&c, &g);
    const float at[3] = {0, -20, 0}, right[3] = {1, 0, 0}, above[3] = {0, 0, 1}, forward[3] = {0, 1, 0};
    for (int a = 0; a < 3; a++) {
        assert_float_equal(e.at[a], at[a], 0);
        assert_float_equal(e.right[a], right[a], 1e-6f);
        assert_float_equal(e.up[a], above[a], 1e-6f);
        assert_float_equal(e.forward[a], forward[a], 1e-6f);
    }
    assert_int_equal(ost_camera_look_at(origin, origin, up, &c, &err), OST_ERR_RANGE);
    assert_int_equal(ost_camera_look_at((double[3]){0, 0, 5}, origin, up, &c, &err), OST_ERR_RANGE);
    c.focal_milli = 999;
    assert_int_equal(ost_camera_check(&c, &err), OST_ERR_RANGE);
    c.focal_milli = 1000;
    c.width = OST_FRAME_MAX + 1;
    assert_int_equal(ost_camera_check(&c, &err), OST_ERR_RANGE);
}

static void test_picture(void **state)
{
    (void)state;
    ost_error err = {0};
    test_rng rng = rng_seeded("picture");
    ost_volume v = pitted_ball(&rng, 40, 40, 40);
    ost_camera c = {.focal_milli = 100000, .width = 64, .height = 48};
    ost_picture smooth, faces;
    ost_points_options options = {.style = OST_STYLE_FACES, .threads = 2};
    assert_ok(ost_camera_look_at((double[3]){17, -60, 27}, (double[3]){17, 20, 27}, (double[3]){0, 0, 1}, &c, &err));
    assert_ok(ost_picture_points(&v, &c, NULL, &smooth, &err));
    assert_ok(ost_picture_points(&v, &c, &options, &faces, &err));
    /* The ball is in the middle, and the corners are background; the light comes from the upper left. */
    const size_t middle = 3 * (24 * 64 + 32), corner = 0, lit = 3 * (16 * 64 + 24), dark = 3 * (34 * 64 + 42);
    assert_memory_equal(smooth.rgb + corner, ((uint8_t[3]){0x16, 0x18, 0x1c}), 3);
    assert_true(smooth.rgb[middle] > 90 && faces.rgb[middle] > 90);
    assert_true(smooth.rgb[lit] > smooth.rgb[dark]);
    assert_memory_not_equal(smooth.rgb, faces.rgb, (size_t)3 * 64 * 48);
    ost_picture_free(&smooth);
    ost_picture_free(&faces);
    /* If no voxel reaches the threshold, there must be only background. */
    options.threshold = 2000;
    assert_ok(ost_picture_points(&v, &c, &options, &faces, &err));
    for (size_t i = 0; i < (size_t)64 * 48; i++)
        assert_memory_equal(faces.rgb + 3 * i, ((uint8_t[3]){0x16, 0x18, 0x1c}), 3);
    ost_picture_free(&faces);
    options.isa = "mmx";
    assert_int_equal(ost_picture_points(&v, &c, &options, &faces, &err), OST_ERR_USAGE);
    assert_null(faces.rgb);
    c.pose.t.x = 4000 * OST_PM_PER_MM;
    v.geometry.spacing = (ost_pm3){OST_PM_PER_MM / 20, OST_PM_PER_MM / 20, OST_PM_PER_MM / 20};
    assert_int_equal(ost_picture_points(&v, &c, NULL, &faces, &err), OST_ERR_RANGE);
    assert_non_null(strstr(err.text, "voxels away"));
    ost_volume_free(&v);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_camera),
        cmocka_unit_test(test_picture),
        cmocka_unit_test(test_against_rays),
        cmocka_unit_test(test_sets_and_threads),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
