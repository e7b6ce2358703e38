/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests all features of a picture together, such as colours, clip planes and ghosts: every instruction set and number
 * of threads must give the same picture, and OpenGL must draw it too.
 *
 * Covers: REQ-LOOK
 */
#include "look_bone.h"

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
    /* At most MOST pixels may differ: a share of 30 in 921,600 pixels, and one more pixel for each object drawn. With
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
        cmocka_unit_test(all_sets_give_same_picture),
        cmocka_unit_test(opengl_gives_same_picture),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
