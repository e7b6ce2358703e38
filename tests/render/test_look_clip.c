/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests clip planes. The points and shades of a clipped bone are compared with its voxels. The pixels at the plane are
 * compared with the densities of the CT.
 *
 * Covers: REQ-LOOK
 */
#include "look_bone.h"

#include <math.h>

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

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(clip_plane_shows_ct_densities),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
