/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Compares OpenGL's picture with the processor's. The same voxels must be in the same pixels, except for a
 * few pixels for which a driver rounds differently. In a frame of 1280 x 720 pixels, 30 of the 921,600
 * pixels may differ. In smaller frames the allowed number is proportional, with a minimum of 5. The number
 * of differing pixels is printed. The test is skipped if OpenGL without a display is not available.
 *
 * OST_TEST_LONG=1 tests frames of 1280 x 720, and repeats all tests limited to OpenGL 3.3.
 * Covers: REQ-RENDER, REQ-GL-SAME, REQ-GL-HIDDEN, REQ-SMOOTH-TOOL
 */
#include <math.h>
#include <stdlib.h>

#include "gl_scene.h"
#include "render/gl/gl.h"

#include <osteon/phantom.h>

enum { SMALL_W = 480, SMALL_H = 270, LARGE_W = 1280, LARGE_H = 720 };

static ost_gl *gl;
static int version; /* maximum OpenGL version, times ten; 0 means no limit */
static char reason[OST_ERROR_TEXT];

static void check(const char *name, const ost_gl_variant *variant, const ost_frame_thing *things, int count,
                  ost_style style)
{
    ost_error err = {0};
    const int width = things[0].eye.width, height = things[0].eye.height;
    ost_frame ours, theirs;
    assert_ok(ost_frame_init(&ours, width, height, style, OST_ISA_SCALAR, 0, &err));
    assert_ok(ost_frame_init(&theirs, width, height, style, OST_ISA_SCALAR, 0, &err));
    assert_ok(ost_frame_draw_things(&ours, things, count, &err));
    assert_ok(ost_gl_draw(gl, variant, things, count, style, &err));
    assert_ok(ost_gl_read(gl, &theirs, variant->target != OST_GL_FORWARD, &err));
    const difference d = compare(&ours, &theirs);
    size_t covered = 0;
    for (size_t i = 0; i < (size_t)ours.planes.stride * (size_t)height; i++)
        covered += ours.planes.face[i] != OST_NO_FACE;
    const double share = 30.0 * width * height / (1280 * 720);
    const int most = share > 5 ? (int)share : 5;
    printf("# %-36s %dx%d, %7zu pixels covered: %d pixels differ (face %d, depth %d; %d are allowed)%s\n", name, width,
           height, covered, d.colour, d.face, d.depth, most, ost_gl_counts_get(gl).bricks ? ", bricks" : "");
    assert_in_range(d.colour, 0, most);
    if (variant->target != OST_GL_FORWARD)
        assert_in_range(d.depth, 0, most);
    ost_frame_free(&ours);
    ost_frame_free(&theirs);
}

static void skip_without_gl(void)
{
    if (!gl) {
        printf("# skipped: %s\n", reason);
        skip();
    }
}

typedef struct place {
    const char *name;
    /* direction, distance and offset of a camera; distances are multiples of the body's side */
    double x, y, z, distance, aside;
} place;

static const place places[] = {
    {"whole", 0.2, -1, 0.3, 2.1, 0},
    {"oblique", 1, -0.7, 0.6, 2.3, 0},
    {"far", -0.3, 1, -0.2, 6, 0},
    {"bowl", 0.25, -1, 0.0, 0.75, 0.12},
    {"at the frame's edge", 0, -1, 0.1, 1.2, 0.45},
    {"close up", 0.3, -1, 0.2, 0.5, 0.1},
    {"from within", 0.1, -0.3, 1, 0.08, 0},
};

static void check_views(int width, int height, int side)
{
    test_rng rng = rng_seeded("views");
    ost_error err = {0};
    ost_volume v = body(&rng, side, OST_PM_PER_MM / 2);
    ost_volume t = body(&rng, 40, OST_PM_PER_MM / 3);
    ost_surface bone = surface_of(&v), tool = surface_of(&t);
    const double q[4] = {0.8, 0.3, -0.4, 0.33};
    ost_gl_variant ours = ost_gl_ours, points = ost_gl_ours, bricks = ost_gl_ours;
    points.choose = bricks.choose = false;
    bricks.bricks = true;
    for (size_t i = 0; i < sizeof places / sizeof *places; i++) {
        const place *p = &places[i];
        const ost_camera c = look(&v.geometry, p->x, p->y, p->z, p->distance * side, p->aside * side, width, height);
        const double mm = 0.5 * side,
                     at[3] = {-3 + mm * (0.55 + 0.2 * p->x), mm * (0.45 + 0.5 * p->y), 7 + mm * (0.5 + 0.3 * p->z)};
        ost_pose pose;
        char name[80];
        assert_ok(ost_pose_from_doubles(at, q, &pose, &err));
        const ost_frame_thing things[2] = {
            {.surface = &bone, .eye = ost_eye_make(&c, &v.geometry), .paint = OST_PAINT_BONE},
            {.surface = &tool, .eye = ost_eye_make_from(&c, &t.geometry, &pose), .paint = OST_PAINT_STEEL}};
        check(p->name, &points, things, 1, OST_STYLE_SMOOTH);
        snprintf(name, sizeof name, "%s, with a tool", p->name);
        check(name, &ours, things, 2, i % 2 ? OST_STYLE_SMOOTH : OST_STYLE_FACES);
        if (p->distance > 1) {
            snprintf(name, sizeof name, "%s, as bricks", p->name);
            check(name, &bricks, things, 1, OST_STYLE_SMOOTH);
        }
    }
    ost_surface_free(&bone);
    ost_surface_free(&tool);
    ost_volume_free(&v);
    ost_volume_free(&t);
}

static void test_views(void **state)
{
    (void)state;
    skip_without_gl();
    if (getenv("OST_TEST_LONG"))
        check_views(LARGE_W, LARGE_H, 256);
    else
        check_views(SMALL_W, SMALL_H, 96);
}

/* Counts the pixels that differ in coverage, in depth, or by more than two levels of a colour. */
static int differ(const ost_frame *a, const ost_frame *b)
{
    int count = 0;
    for (int y = 0; y < a->height; y++)
        for (int x = 0; x < a->width; x++) {
            const size_t at = (size_t)y * (size_t)a->planes.stride + (size_t)x;
            const bool there = a->planes.face[at] != OST_NO_FACE, also = b->planes.face[at] != OST_NO_FACE;
            bool same = there == also;
            same &= !there || fabsf(a->planes.depth[at] - b->planes.depth[at]) <= 1e-3f * a->planes.depth[at];
            for (int shift = 0; shift < 24; shift += 8)
                same &= abs((int)(a->planes.colour[at] >> shift & 255) -
                            (int)(b->planes.colour[at] >> shift & 255)) <= 2;
            count += !same;
        }
    return count;
}

/* Compares OpenGL's picture of a bone and of a tool's smooth mesh with the processor's picture, from every camera. When
   the same objects are drawn again, nothing may be uploaded. */
static void test_smooth_tool(void **state)
{
    (void)state;
    skip_without_gl();
    enum { SIDE = 96 };
    test_rng rng = rng_seeded("smooth tool");
    ost_error err = {0};
    ost_volume v = body(&rng, SIDE, OST_PM_PER_MM / 2), t = body(&rng, 8, OST_PM_PER_MM / 3);
    ost_surface bone = surface_of(&v), tool = surface_of(&t);
    const ost_pm half = t.geometry.spacing.x / 2;
    const ost_tool_geometry g = {t.geometry.dims, 2 * half, {t.geometry.origin.x - half, t.geometry.origin.y - half,
                                                             t.geometry.origin.z - half}};
    const double q[4] = {0.8, 0.3, -0.4, 0.33};
    ost_mesh mesh;
    ost_smooth_mesh smooth;
    assert_ok(ost_tool_make(OST_TOOL_REAMER, NULL, &mesh, &err));
    assert_ok(ost_smooth_mesh_make(&mesh, 1, &g, &smooth, &err));
    for (size_t i = 0; i < sizeof places / sizeof *places; i++) {
        const place *p = &places[i];
        const ost_camera c = look(&v.geometry, p->x, p->y, p->z, p->distance * SIDE, p->aside * SIDE, SMALL_W, SMALL_H);
        const double mm = 0.5 * SIDE,
                     at[3] = {-3 + mm * (0.55 + 0.2 * p->x), mm * (0.45 + 0.3 * p->y), 7 + mm * (0.5 + 0.3 * p->z)};
        ost_pose pose;
        ost_frame ours, theirs;
        assert_ok(ost_pose_from_doubles(at, q, &pose, &err));
        const ost_frame_thing things[2] = {
            {.surface = &bone, .eye = ost_eye_make(&c, &v.geometry), .paint = OST_PAINT_BONE},
            {.surface = &tool,
             .eye = ost_eye_make_from(&c, &t.geometry, &pose),
             .paint = OST_PAINT_STEEL,
             .mesh = &smooth}};
        assert_ok(ost_frame_init(&ours, SMALL_W, SMALL_H, OST_STYLE_SMOOTH, OST_ISA_SCALAR, 2, &err));
        assert_ok(ost_frame_init(&theirs, SMALL_W, SMALL_H, OST_STYLE_SMOOTH, OST_ISA_SCALAR, 1, &err));
        assert_ok(ost_frame_draw_things(&ours, things, 1, &err));
        assert_ok(ost_frame_draw_things(&theirs, things, 2, &err));
        const int shown = differ(&ours, &theirs);
        assert_ok(ost_frame_draw_things(&ours, things, 2, &err));
        assert_ok(ost_gl_draw(gl, &ost_gl_ours, things, 2, OST_STYLE_SMOOTH, &err));
        assert_ok(ost_gl_read(gl, &theirs, true, &err));
        const int different = differ(&ours, &theirs);
        printf("# %-36s the tool covers %d pixels, %d differ\n", p->name, shown, different);
        assert_true(shown > (p->distance < 0.1 ? -1 : 100));
        assert_in_range(different, 0, 30);
        assert_ok(ost_gl_draw(gl, &ost_gl_ours, things, 2, OST_STYLE_SMOOTH, &err));
        assert_int_equal(ost_gl_counts_get(gl).uploaded, 0);
        ost_frame_free(&ours);
        ost_frame_free(&theirs);
    }
    ost_smooth_mesh_free(&smooth);
    ost_mesh_free(&mesh);
    ost_surface_free(&bone);
    ost_surface_free(&tool);
    ost_volume_free(&v);
    ost_volume_free(&t);
}

/* After a change of a surface, only the changed blocks may be uploaded, and the picture must show the change. */
static void test_changes(void **state)
{
    (void)state;
    skip_without_gl();
    ost_error err = {0};
    test_rng rng = rng_seeded("changes");
    ost_volume v = body(&rng, 70, OST_PM_PER_MM);
    ost_surface s = surface_of(&v);
    const ost_camera c = look(&v.geometry, 0.3, -1, 0.3, 140, 0, 160, 90);
    const ost_frame_thing thing = {.surface = &s, .eye = ost_eye_make(&c, &v.geometry), .paint = OST_PAINT_BONE};
    ost_gl_variant bricks = ost_gl_ours, points = ost_gl_ours;
    points.choose = bricks.choose = false;
    bricks.bricks = true;
    check("before", &points, &thing, 1, OST_STYLE_SMOOTH);
    check("before, as bricks", &bricks, &thing, 1, OST_STYLE_SMOOTH);
    check("again", &points, &thing, 1, OST_STYLE_SMOOTH);
    assert_int_equal(ost_gl_counts_get(gl).uploaded, 0);
    for (int round = 0; round < 4; round++) {
        uint64_t was[27] = {0}, renewed = 0;
        bool differs = false; /* remains false if the body has no voxel in the changed region */
        assert_true(s.used <= 27);
        for (int32_t i = 0; i < s.used; i++)
            was[i] = s.slot[i]->version;
        for (int i = 0; i < 9 * 9 * 9; i++) {
            const int x = 12 * round + 10 + i % 9, y = 14 + i / 9 % 9, z = 30 + i / 81;
            int16_t *voxel = &v.voxels[x + 70 * (y + 70 * z)];
            const int16_t becomes = round == 2 ? 700 : 0;
            differs |= (*voxel >= 120) != (becomes >= 120);
            *voxel = becomes;
        }
        assert_ok(ost_surface_set_volume(&s, &v, 120, &err));
        assert_ok(ost_surface_update(&s, &err));
        for (int32_t i = 0; i < s.used; i++)
            renewed += s.slot[i]->version != was[i] ? s.slot[i]->count : 0;
        check("after a change", &points, &thing, 1, OST_STYLE_SMOOTH);
        assert_int_equal(ost_gl_counts_get(gl).uploaded, 8 * renewed);
        assert_true((renewed > 0) == differs);
        check("after a change, as bricks", &bricks, &thing, 1, OST_STYLE_SMOOTH);
    }
    /* Draws another surface that is stored at the same address. */
    ost_surface_free(&s);
    ost_volume_free(&v);
    v = body(&rng, 50, OST_PM_PER_MM);
    s = surface_of(&v);
    const ost_camera d = look(&v.geometry, 0.3, -1, 0.3, 100, 0, 160, 90);
    const ost_frame_thing other = {.surface = &s, .eye = ost_eye_make(&d, &v.geometry), .paint = OST_PAINT_BONE};
    check("another", &points, &other, 1, OST_STYLE_SMOOTH);
    ost_surface_free(&s);
    ost_volume_free(&v);
}

/*
 * Tests the drawing methods that exist only for comparisons. Each of them must draw the same voxels. Some of them do
 * not clip points at the edge of the frame, so the camera is far enough from the body for all points to lie in the
 * frame.
 */
static void test_variants(void **state)
{
    (void)state;
    skip_without_gl();
    test_rng rng = rng_seeded("variants");
    ost_volume v = body(&rng, 70, OST_PM_PER_MM);
    ost_surface s = surface_of(&v);
    const ost_camera c = look(&v.geometry, 0.3, -1, 0.3, 170, 0, 320, 180);
    const ost_frame_thing thing = {.surface = &s, .eye = ost_eye_make(&c, &v.geometry), .paint = OST_PAINT_BONE};
    const struct {
        const char *name;
        ost_gl_variant variant;
    } list[] = {
        {"thesis", ost_gl_thesis},
        {"surface voxels, G-buffer as in the thesis", {.true_depth = true, .target = OST_GL_WIDE}},
        {"the same in 8 bits", {.frustum = true, .facing = true, .true_depth = true, .target = OST_GL_SMALL}},
        {"compact, slabs", {.frustum = true, .facing = true, .order = true, .true_depth = true}},
        {"tight, slabs", {.frustum = true, .facing = true, .order = true, .tight = true}},
        {"forward",
         {.frustum = true, .facing = true, .order = true, .tight = true, .lines = true, .target = OST_GL_FORWARD}},
        {"bricks, forward", {.frustum = true, .order = true, .tight = true, .bricks = true, .target = OST_GL_FORWARD}},
    };
    for (size_t i = 0; i < sizeof list / sizeof *list; i++)
        check(list[i].name, &list[i].variant, &thing, 1, OST_STYLE_FACES);
    ost_surface_free(&s);
    ost_volume_free(&v);
}

/* Builds a body behind a wall. If `open`, the wall has a window. */
static void build(ost_volume *v, const ost_volume *shape, bool open)
{
    const int n = v->geometry.dims.x;
    for (int k = 0; k < n; k++)
        for (int j = 0; j < n; j++)
            for (int i = 0; i < n; i++) {
                const size_t at = (size_t)i + (size_t)n * (size_t)(j + n * k);
                const bool window = open && i > n / 3 && i < n / 2 && k > n / 3 && k < n / 2;
                v->voxels[at] = j < 12 ? window ? 0 : 700 : j < 40 ? 0 : shape->voxels[at];
            }
}

/*
 * Draws the objects twice, once skipping hidden cells (occlusion) and once drawing them. The two pictures must be
 * bit-identical. Returns the number of cells that were skipped.
 */
static int compare_without_occlusion(const char *name, const ost_gl_variant *variant, const ost_frame_thing *things,
                                     int count)
{
    ost_error err = {0};
    ost_gl_variant without = *variant;
    without.occlusion = false;
    const int width = things[0].eye.width, height = things[0].eye.height;
    ost_frame a, b;
    assert_ok(ost_frame_init(&a, width, height, OST_STYLE_SMOOTH, OST_ISA_SCALAR, 1, &err));
    assert_ok(ost_frame_init(&b, width, height, OST_STYLE_SMOOTH, OST_ISA_SCALAR, 1, &err));
    assert_ok(ost_gl_draw(gl, &without, things, count, OST_STYLE_SMOOTH, &err));
    assert_int_equal(ost_gl_counts_get(gl).hidden, 0);
    const uint64_t points = ost_gl_counts_get(gl).points;
    assert_ok(ost_gl_read(gl, &a, true, &err));
    assert_ok(ost_gl_draw(gl, variant, things, count, OST_STYLE_SMOOTH, &err));
    const ost_gl_counts did = ost_gl_counts_get(gl);
    assert_ok(ost_gl_read(gl, &b, true, &err));
    assert_true(did.hidden ? did.points < points : did.points == points);
    const difference d = compare(&a, &b);
    if (d.colour || d.face || d.depth)
        printf("# %s: %d pixels differ (face %d, depth %d), %d cells hidden\n", name, d.colour, d.face, d.depth,
               (int)did.hidden);
    assert_int_equal(d.colour + d.face + d.depth, 0);
    ost_frame_free(&a);
    ost_frame_free(&b);
    return (int)did.hidden;
}

/*
 * If hidden cells are skipped, no pixel of any frame may change. In some frames the camera moves around the
 * body, so that other cells come to the front. In other frames a window is cut into a wall that hid cells.
 */
static void test_occlusion(void **state)
{
    (void)state;
    skip_without_gl();
    enum { N = 128, CELLS = 16 * 16 * 16, STEPS = 12, REST = 10, W = 283, H = 163 };
    test_rng rng = rng_seeded("occlusion");
    ost_error err = {0};
    ost_volume shape = body(&rng, N, OST_PM_PER_MM), v, t = body(&rng, 40, OST_PM_PER_MM / 3);
    ost_surface tool = surface_of(&t);
    assert_ok(ost_volume_init(&v, &shape.geometry, &err));
    ost_gl_variant list[3] = {ost_gl_ours, ost_gl_ours, ost_gl_ours};
    static const char *const names[] = {"points", "points, tiles by OpenGL", "bricks"};
    assert_true(ost_gl_ours.occlusion);
    for (int i = 0; i < 3; i++) {
        list[i].choose = false;
        list[i].tiles = i == 1;
        list[i].bricks = i == 2;
        int hidden = 0;
        build(&v, &shape, false);
        ost_surface s = surface_of(&v);
        for (int step = 0; step < STEPS; step++) {
            const double turn = 6.2831853 * step / STEPS, away = step < STEPS / 2 ? 1.4 : 0.8;
            const ost_camera c = look(&v.geometry, sin(turn), -cos(turn), 0.2, away * N, 0, W, H);
            const double q[4] = {0.8, 0.3, -0.4, 0.33}, at[3] = {60, 40, 60};
            ost_pose pose;
            assert_ok(ost_pose_from_doubles(at, q, &pose, &err));
            const ost_frame_thing things[2] = {
                {.surface = &s, .eye = ost_eye_make(&c, &v.geometry), .paint = OST_PAINT_BONE},
                {.surface = &tool, .eye = ost_eye_make_from(&c, &t.geometry, &pose), .paint = OST_PAINT_STEEL}};
            hidden += compare_without_occlusion(names[i], &list[i], things, 1 + step % 2);
        }
        /*
         * The camera stays in front of the wall. Most cells behind the wall are skipped until the
         * window opens, and are then drawn at once.
         */
        const ost_camera c = look(&v.geometry, 0.05, -1, 0.0, 0.9 * N, 0, W, H);
        const ost_frame_thing thing = {.surface = &s, .eye = ost_eye_make(&c, &v.geometry), .paint = OST_PAINT_BONE};
        int before = 0, after = 0;
        for (int k = 0; k < REST; k++)
            before = compare_without_occlusion(names[i], &list[i], &thing, 1);
        build(&v, &shape, true);
        assert_ok(ost_surface_set_volume(&s, &v, 120, &err));
        assert_ok(ost_surface_update(&s, &err));
        after = compare_without_occlusion(names[i], &list[i], &thing, 1);
        printf("# %-36s cells hidden: %d while the camera moves, %d before and %d after the window is opened\n",
               names[i], hidden, before, after);
        assert_in_range(hidden, 2000, STEPS * CELLS);
        assert_in_range(before, 1000, CELLS);
        assert_in_range(after, 1, before - 1);
        ost_surface_free(&s);
    }
    ost_surface_free(&tool);
    ost_volume_free(&shape);
    ost_volume_free(&v);
    ost_volume_free(&t);
}

static int begin(void **state)
{
    (void)state;
    ost_error err = {0};
    const ost_gl_options options = {.debug = true, .version = version};
    if (getenv("OST_UNDER_VALGRIND"))
        snprintf(reason, sizeof reason, "valgrind cannot check the code of an OpenGL driver");
    else if (ost_gl_open(&options, &gl, &err) != OST_OK)
        memcpy(reason, err.text, sizeof reason);
    if (gl) {
        const ost_gl_info info = ost_gl_info_get(gl);
        printf("# OpenGL %s, %s; %s; points of up to %g pixels\n", info.version, info.driver, info.way,
               (double)info.largest);
    }
    return 0;
}

static int end(void **state)
{
    (void)state;
    ost_gl_close(gl);
    gl = NULL;
    return 0;
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_views), cmocka_unit_test(test_changes),
                                       cmocka_unit_test(test_variants), cmocka_unit_test(test_occlusion),
                                       cmocka_unit_test(test_smooth_tool)};
    int failed = cmocka_run_group_tests(tests, begin, end);
    version = 33;
    if (getenv("OST_TEST_LONG") && !failed && !*reason)
        failed = cmocka_run_group_tests_name("OpenGL 3.3", tests, begin, end);
    return failed ? failed : *reason ? 77 : 0;
}
