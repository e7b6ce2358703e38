/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests frames with a bone and a tool. The nearer object must be visible for any orientation of the tool.
 * All instruction sets and numbers of threads must give bit-identical pictures. Every named camera must
 * look at its object.
 * Covers: REQ-VIEWER
 */
#include <math.h>

#include "harness.h"
#include "render/viewer.h"
#include "render/views.h"

#define MM OST_PM_PER_MM

static ost_volume block_of_bone(void)
{
    ost_error err = {0};
    ost_volume v;
    const ost_geometry g = {{70, 60, 50}, {MM, MM, MM}, {0, 0, 0}};
    assert_ok(ost_volume_init(&v, &g, &err));
    for (size_t k = 0; k < 50; k++)
        for (size_t j = 0; j < 60; j++)
            for (size_t i = 0; i < 70; i++)
                v.voxels[i + 70 * (j + 60 * k)] = i > 8 && i < 60 && j > 10 && j < 50 && k > 4 && k < 44 &&
                                                          (i + j) % 17 > 2
                                                      ? 700
                                                      : 0;
    return v;
}

/* Makes a rod of half-millimetre voxels, 4 x 4 x 20 mm, which extends upward from its origin. */
static ost_tool_volume rod(void)
{
    ost_error err = {0};
    ost_tool_volume t;
    const ost_tool_geometry g = {{8, 8, 40}, MM / 2, {-2 * MM, -2 * MM, 0}};
    assert_ok(ost_tool_volume_init(&t, &g, &err));
    memset(t.voxels, OST_TOOL_CUTTING, 8 * 8 * 40);
    return t;
}

static void make(ost_viewer *v, const char *isa, int threads)
{
    ost_error err = {0};
    ost_volume bone = block_of_bone();
    ost_tool_volume tool = rod();
    assert_ok(ost_viewer_init(v, &bone.geometry, OST_STYLE_SMOOTH, isa, threads, &err));
    assert_ok(ost_surface_set_volume(&v->bone, &bone, 120, &err));
    assert_ok(ost_viewer_add_tool(v, &tool, &err));
    assert_ok(ost_viewer_update(v, &err));
    ost_tool_volume_free(&tool);
    ost_volume_free(&bone);
}

static void put_tool(ost_viewer *v, ost_pose pose)
{
    v->has_state = true;
    v->state = (ost_live_state){.ticks = 1, .pose = pose};
}

static ost_camera camera_from(double x, double y, double z)
{
    ost_error err = {0};
    ost_camera c = {.focal_milli = 250000, .width = 300, .height = 200};
    assert_ok(ost_camera_look_at((double[3]){x, y, z}, (double[3]){35, 30, 25}, (double[3]){0, 0, 1}, &c, &err));
    return c;
}

/* Returns true if the pixel has a cold colour, the colour of steel. Bone has a warm colour. */
static bool is_steel(const ost_frame *f, int x, int y)
{
    const uint32_t c = f->planes.colour[(size_t)y * (size_t)f->planes.stride + (size_t)x];
    return f->planes.face[(size_t)y * (size_t)f->planes.stride + (size_t)x] != OST_NO_FACE &&
           (c >> 16 & 255) > (c & 255);
}

static size_t steel_pixels(const ost_frame *f)
{
    size_t count = 0;
    for (int y = 0; y < f->height; y++)
        for (int x = 0; x < f->width; x++)
            count += is_steel(f, x, y);
    return count;
}

static void nearer_object_is_visible(void **state)
{
    ost_error err = {0};
    ost_viewer v;
    const ost_camera c = camera_from(35, -60, 25);
    (void)state;
    make(&v, NULL, 1);
    assert_ok(ost_viewer_draw(&v, &c, &err));
    assert_int_equal(steel_pixels(&v.frame), 0);
    /*
     * The tool is in front of the middle of the block. At a distance of 58 mm and a focal length of 250
     * pixels, the tool of 4 x 20 mm covers about 17 x 86 pixels.
     */
    put_tool(&v, (ost_pose){.t = {35 * MM, 0, 15 * MM}, .qw = OST_Q30_ONE});
    assert_ok(ost_viewer_draw(&v, &c, &err));
    const size_t before = steel_pixels(&v.frame);
    assert_in_range(before, 1350, 1650);
    /*
     * The depth of the pixel must be that of the tool, in units of bone voxels. The front of the
     * tool is 58 mm away. The tool's own voxels are half as large as the bone's.
     */
    assert_true(is_steel(&v.frame, 150, 100));
    assert_true(fabsf(v.frame.planes.depth[100 * v.frame.planes.stride + 150] - 58) < 0.05f);
    /* A tool behind the block must not be visible. */
    put_tool(&v, (ost_pose){.t = {35 * MM, 70 * MM, 15 * MM}, .qw = OST_Q30_ONE});
    assert_ok(ost_viewer_draw(&v, &c, &err));
    assert_int_equal(steel_pixels(&v.frame), 0);
    put_tool(&v, (ost_pose){.t = {35 * MM, 30 * MM, 15 * MM}, .qw = OST_Q30_ONE});
    assert_ok(ost_viewer_draw(&v, &c, &err));
    assert_in_range(steel_pixels(&v.frame), 0, before / 4); /* a tool in the block is visible only through the slots */
    /* The tool lies on its side: it is rotated by a quarter turn about the line of sight. */
    put_tool(&v, (ost_pose){.t = {25 * MM, 0, 25 * MM}, .qw = 759250125, .qy = 759250125});
    assert_ok(ost_viewer_draw(&v, &c, &err));
    assert_in_range(steel_pixels(&v.frame), 1350, 1650);
    assert_true(is_steel(&v.frame, 180, 100));
    assert_false(is_steel(&v.frame, 150, 130));
    ost_viewer_free(&v);
}

static void all_sets_give_same_picture(void **state)
{
    ost_error err = {0};
    test_rng rng = rng_seeded("viewer");
    static const char *const sets[] = {"avx2", "avx512"};
    ost_viewer plain;
    (void)state;
    make(&plain, "scalar", 1);
    for (size_t i = 0; i < 2; i++) {
        ost_viewer v;
        ost_isa isa;
        if (ost_isa_choose(sets[i], &isa, NULL) != OST_OK)
            continue;
        make(&v, sets[i], 3);
        for (int round = 0; round < 8; round++) {
            const ost_camera c = camera_from((double)rng_range(&rng, -80, 150), (double)rng_range(&rng, -90, 0),
                                             (double)rng_range(&rng, -50, 100));
            int32_t q[4];
            double n = 0;
            for (int a = 0; a < 4; a++) {
                q[a] = (int32_t)rng_range(&rng, -1000, 1000);
                n += (double)q[a] * q[a];
            }
            n = (double)OST_Q30_ONE / sqrt(n);
            const ost_pose pose = {
                .t = {rng_range(&rng, 0, 70) * MM, rng_range(&rng, -10, 20) * MM, rng_range(&rng, 0, 50) * MM},
                .qw = (int32_t)(q[0] * n),
                .qx = (int32_t)(q[1] * n),
                .qy = (int32_t)(q[2] * n),
                .qz = (int32_t)(q[3] * n)};
            put_tool(&plain, pose);
            put_tool(&v, pose);
            assert_ok(ost_viewer_draw(&plain, &c, &err));
            assert_ok(ost_viewer_draw(&v, &c, &err));
            const size_t count = (size_t)plain.frame.planes.stride * 200;
            assert_memory_equal(plain.frame.planes.colour, v.frame.planes.colour, count * sizeof(uint32_t));
            assert_memory_equal(plain.frame.planes.face, v.frame.planes.face, count);
        }
        ost_viewer_free(&v);
    }
    ost_viewer_free(&plain);
}

static void named_views_look_at_their_object(void **state)
{
    ost_error err = {0};
    const ost_geometry g = {{100, 80, 120}, {MM, MM, MM}, {-50 * MM, -40 * MM, -60 * MM}};
    const double axis[3] = {-0.9, 0.3, 0.1};
    const ost_pm3 at = {30 * MM, -10 * MM, 20 * MM};
    const ost_view_subject s = ost_view_subject_make(&g, &at, axis, true);
    (void)state;
    for (int i = 0; i < OST_VIEW_COUNT; i++) {
        double right[3], up[3], back[3], dot = 0, length = 0;
        ost_camera c;
        const ost_orbit o = ost_view_orbit((ost_view_name)i, &s, NULL);
        assert_ok(ost_orbit_camera(&o, 640, 480, &c, &err));
        assert_ok(ost_camera_check(&c, &err));
        ost_orbit_frame(&o, right, up, back);
        for (int a = 0; a < 3; a++) {
            dot += back[a] * -s.inward[a];
            length += right[a] * up[a];
        }
        assert_true(fabs(length) < 1e-12);
        if (i == OST_VIEW_EN_FACE)
            assert_true(dot > 0.9999);
        if (i == OST_VIEW_LATERAL)
            assert_true(back[0] > 0.9999);
        if (i == OST_VIEW_MEDIAL)
            assert_true(back[0] < -0.9999);
        if (i == OST_VIEW_ANTERIOR)
            assert_true(back[1] < -0.9999);
        if (i == OST_VIEW_INFERIOR)
            assert_true(back[2] < -0.999); /* not -1, because the elevation is limited to STEEPEST */
        const bool all = i == OST_VIEW_OVERVIEW || i == OST_VIEW_MEDIAL || i == OST_VIEW_INFERIOR;
        assert_true(fabs(o.at[0] - (all ? 0 : 30)) < 1e-9);
    }
    /* The tool points toward -y. The camera looks along the tool from behind. */
    const ost_pose tool = {.t = {5 * MM, 6 * MM, 7 * MM}, .qw = 759250125, .qx = -759250125};
    double right[3], up[3], back[3];
    ost_orbit o = ost_view_orbit(OST_VIEW_TOOL, &s, &tool);
    ost_orbit_frame(&o, right, up, back);
    assert_true(back[1] > 0.999);
    /* A drag to the right must rotate the object to the right. The mouse wheel must move the camera nearer, up to a
       limit. */
    const double azimuth = o.azimuth, distance = o.distance;
    ost_orbit_turn(&o, 10, 0, 480);
    assert_true(o.azimuth < azimuth);
    ost_orbit_near(&o, 1);
    assert_true(o.distance < distance);
    for (int i = 0; i < 1000; i++)
        ost_orbit_near(&o, 1);
    assert_true(o.distance > 1);
    for (int i = 0; i < 1000; i++)
        ost_orbit_turn(&o, 0, 100, 480);
    ost_camera c;
    assert_ok(ost_orbit_camera(&o, 640, 480, &c, &err));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(nearer_object_is_visible),
        cmocka_unit_test(all_sets_give_same_picture),
        cmocka_unit_test(named_views_look_at_their_object),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
