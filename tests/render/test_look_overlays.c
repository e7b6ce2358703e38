/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests what is drawn over the bone's surface: the ghost of a tool, lines, the chunks that a tool's box meets, and
 * every overlay of the viewer.
 *
 * Covers: REQ-LOOK
 */
#include "look_bone.h"

#include <math.h>

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

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(ghosts_and_lines_are_blended),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
