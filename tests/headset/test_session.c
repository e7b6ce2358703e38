/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests a session with a fake OpenXR runtime (runtime.h). The picture of each eye is compared with a part of a larger,
 * symmetric picture. The two must be equal except for a few pixels at edges. The calls must be in the order that OpenXR
 * requires. Every failure of the runtime must cause one error, and every session must be destroyed. The test is skipped
 * if OpenGL cannot be used without a display.
 * Covers: REQ-HEADSET
 */
#include <dlfcn.h>
#include <math.h>
#include <unistd.h>

#include "harness.h"
#include "headset/headset.h"
#include "headset/room.h"
#include "headset/runtime.h"
#include "render/viewer.h"

#define MM OST_PM_PER_MM

static fake_xr_state *fake;
static ost_viewer viewer;
static ost_room room;
static ost_headset_hand hand;
static char manifest[64];
static char reason[OST_ERROR_TEXT];

static const double RIGHT[3] = {0, 1, 0}, UP[3] = {0, 0, 1}, BACK[3] = {1, 0, 0}, AT[3] = {35, 30, 25};

/* Makes a block of bone with grooves. It looks different from each side. */
static void make_bone(void)
{
    ost_error err = {0};
    ost_volume v;
    const ost_geometry g = {{70, 60, 50}, {MM, MM, MM}, {0, 0, 0}};
    assert_ok(ost_volume_init(&v, &g, &err));
    for (size_t k = 0; k < 50; k++)
        for (size_t j = 0; j < 60; j++)
            for (size_t i = 0; i < 70; i++)
                v.voxels[i + 70 * (j + 60 * k)] =
                    i > 8 && i < 60 && j > 10 && j < 50 && k > 4 && k < 44 && (i + j) % 17 > 2 && (j + 2 * k) % 23 > 1
                        ? 700
                        : 0;
    assert_ok(ost_viewer_init(&viewer, &g, OST_STYLE_SMOOTH, NULL, 1, &err));
    assert_ok(ost_surface_set_volume(&viewer.bone, &v, 120, &err));
    assert_ok(ost_viewer_update(&viewer, &err));
    ost_volume_free(&v);
}

static int begin(void **state)
{
    (void)state;
    ost_error err = {0};
    make_bone();
    room = ost_room_make(AT, RIGHT, UP, BACK);
    if (ost_viewer_use_gl(&viewer, &ost_gl_ours, &err) != OST_OK)
        snprintf(reason, sizeof reason, "%s", err.text);
    return 0;
}

static int end(void **state)
{
    (void)state;
    ost_viewer_free(&viewer);
    unlink(manifest);
    return 0;
}

static int reset(void **state)
{
    static const float fov[4] = {-0.5f, 0.8f, 0.6f, -0.4f};
    (void)state;
    memset(fake, 0, sizeof *fake);
    fake->head_tracked = true;
    fake->eye_x[0] = -0.03f;
    fake->eye_x[1] = 0.03f;
    for (int i = 0; i < 4; i++) {
        fake->fov[0][i] = fov[i];
        fake->fov[1][i] = i < 2 ? -fov[1 - i] : fov[i]; /* The right eye is the left eye's mirror image. */
    }
    return 0;
}

static ost_status draw(void *user, const ost_headset_view *view, ost_error *err)
{
    ost_camera camera = {
        .focal_milli = view->projection.focal_milli, .width = view->width, .height = view->height};
    (void)user;
    ost_status status = ost_room_pose(&room, view->at, view->q, &camera.pose, err);
    return status == OST_OK ? ost_viewer_draw_gl(&viewer, &camera, view->projection.middle, err) : status;
}

static void store_hand(void *user, const ost_headset_hand *now)
{
    (void)user;
    hand = *now;
}

static const ost_headset_calls calls = {.draw = draw, .hand = store_hand};

static ost_headset *open_session(void)
{
    ost_error err = {0};
    ost_headset *h;
    if (!viewer.gl) {
        printf("# skipped: %s\n", reason);
        skip();
    }
    assert_ok(ost_headset_open(&h, &err));
    assert_ok(ost_headset_begin(h, viewer.gl, 0, 0, false, &err));
    return h;
}

static void run_frames(ost_headset *h, int frames)
{
    ost_error err = {0};
    bool ended;
    for (int i = 0; i < frames; i++) {
        assert_ok(ost_headset_frame(h, &calls, &ended, &err));
        assert_false(ended);
    }
}

static void close_session(ost_headset *h)
{
    ost_headset_close(h);
    assert_false(fake->wrong_order);
    assert_int_equal(fake->sessions, 0);
    assert_int_equal(fake->instances, 0);
}

/*
 * Compares an eye's picture with a part of a symmetric picture that the processor draws with the same focal length.
 * This part begins at an integer pixel position. Returns the number of pixels that differ. The eye's axis follows from
 * the angles and is only approximately at an integer position, so pixels at edges may differ.
 */
static int differing(int eye, const ost_headset_projection *p)
{
    enum { W = 400, H = 300 };
    ost_error err = {0};
    ost_camera camera = {.focal_milli = p->focal_milli, .width = W, .height = H};
    const double at[3] = {fake->eye_x[eye], 0, 0}, none[4] = {1, 0, 0, 0};
    const int x0 = (int)lrint(W / 2 - p->middle[0]), y0 = (int)lrint(H / 2 - p->middle[1]);
    int count = 0, bone = 0;
    ost_gl *gl = viewer.gl;
    viewer.gl = NULL; /* Without gl, the processor draws. */
    assert_ok(ost_room_pose(&room, at, none, &camera.pose, &err));
    assert_ok(ost_viewer_draw(&viewer, &camera, &err));
    viewer.gl = gl;
    const ost_planes *planes = &viewer.frame.planes;
    for (int y = 0; y < FAKE_HEIGHT; y++)
        for (int x = 0; x < FAKE_WIDTH; x++) {
            const uint32_t ours = fake->picture[eye][(FAKE_HEIGHT - 1 - y) * FAKE_WIDTH + x] & 0xffffff;
            const uint32_t theirs = planes->colour[(size_t)(y0 + y) * (size_t)planes->stride + (size_t)(x0 + x)];
            count += ours != (theirs & 0xffffff);
            bone += (theirs & 0xffffff) != OST_BACKGROUND;
        }
    assert_true(bone > 500);
    printf("# eye %d: %d of %d pixels of bone differ\n", eye, count, bone);
    return count;
}

static void eye_pictures_equal_symmetric_picture(void **state)
{
    (void)state;
    ost_headset *h = open_session();
    /* For these angles, the eye's axis is at a whole pixel and the pixels are square. */
    const double focal = 1000, middle[2][2] = {{60, 70}, {100, 70}};
    for (int i = 0; i < 2; i++) {
        fake->fov[i][0] = (float)-atan(middle[i][0] / focal);
        fake->fov[i][1] = (float)atan((FAKE_WIDTH - middle[i][0]) / focal);
        fake->fov[i][2] = (float)atan(middle[i][1] / focal);
        fake->fov[i][3] = (float)-atan((FAKE_HEIGHT - middle[i][1]) / focal);
    }
    run_frames(h, 5);
    assert_int_equal(fake->layers, 5);
    for (int i = 0; i < 2; i++) {
        const ost_headset_fov fov = {fake->fov[i][0], fake->fov[i][1], fake->fov[i][2], fake->fov[i][3]};
        ost_headset_projection p;
        assert_true(ost_headset_project(&fov, FAKE_WIDTH, FAKE_HEIGHT, &p));
        assert_true(fabs(p.middle[0] - middle[i][0]) < 0.01 && fabs(p.middle[1] - middle[i][1]) < 0.01);
        for (int k = 0; k < 4; k++)
            assert_true(fabsf(fake->shown_fov[i][k] - fake->fov[i][k]) < 1e-4f);
        assert_in_range(differing(i, &p), 0, FAKE_PIXELS / 100);
    }
    close_session(h);
}

static void hand_and_buttons_are_passed_on(void **state)
{
    (void)state;
    ost_headset *h = open_session();
    run_frames(h, 2);
    assert_false(hand.tracked);
    fake->hand_tracked = true;
    fake->hand[1] = 0.25f;
    fake->buttons = 5;
    run_frames(h, 1);
    assert_true(hand.tracked && hand.at[1] == 0.25 && hand.q[0] == 1);
    assert_int_equal(hand.buttons, OST_HEADSET_TRIGGER | OST_HEADSET_SQUEEZE);
    close_session(h);
}

static void missed_periods_are_counted(void **state)
{
    (void)state;
    ost_headset *h = open_session();
    run_frames(h, 3);
    fake->skip = 4;
    run_frames(h, 3);
    const ost_headset_counts counts = ost_headset_counts_get(h);
    assert_int_equal(counts.frames, 6);
    assert_int_equal(counts.drawn, 6);
    assert_int_equal(counts.missed, 4);
    assert_true(fabs(counts.display_hz - 72) < 0.01);
    /*
     * The runtime announces a period of three display periods. The two display periods without a frame must still be
     * counted as missed.
     */
    fake->slow = 3;
    run_frames(h, 5);
    assert_int_equal(ost_headset_counts_get(h).missed, 4 + 5 * 2);
    assert_true(fabs(ost_headset_counts_get(h).display_hz - 72) < 0.01);
    close_session(h);
}

/*
 * If the head is not tracked or an eye is too far away, or if the runtime hides the picture, frames must end without a
 * layer.
 */
static void frames_without_picture_have_no_layer(void **state)
{
    (void)state;
    ost_headset *h = open_session();
    fake->head_tracked = false;
    run_frames(h, 2);
    assert_int_equal(ost_headset_counts_get(h).untracked, 2);
    fake->head_tracked = true;
    fake->hidden = true;
    run_frames(h, 2);
    fake->hidden = false;
    fake->eye_x[1] = 50;
    run_frames(h, 2);
    assert_int_equal(fake->frames, 6);
    assert_int_equal(fake->layers, 0);
    fake->eye_x[1] = 0.03f;
    run_frames(h, 1);
    assert_int_equal(fake->layers, 1);
    close_session(h);
}

static void lost_session_ends(void **state)
{
    (void)state;
    ost_error err = {0};
    bool ended = false;
    int frames = 0;
    ost_headset *h = open_session();
    fake->lose_after = 3;
    while (!ended && frames < 20) {
        assert_ok(ost_headset_frame(h, &calls, &ended, &err));
        frames++;
    }
    assert_true(ended);
    close_session(h);
}

static void each_failure_causes_one_error(void **state)
{
    (void)state;
    static const char *const at_begin[] = {"CreateSession", "CreateSwapchain", "AttachSessionActionSets"},
                                   *const in_frame[] = {"PollEvent", "WaitFrame", "EndFrame", "AcquireSwapchainImage"};
    ost_error err = {0};
    ost_headset *h = open_session();
    close_session(h);
    fake->fail = "CreateInstance";
    assert_int_equal(ost_headset_open(&h, &err), OST_ERR_UNAVAILABLE);
    assert_non_null(strstr(err.text, "start it first"));
    fake->fail = NULL;
    fake->no_headset = true;
    assert_int_equal(ost_headset_open(&h, &err), OST_ERR_UNAVAILABLE);
    assert_non_null(strstr(err.text, "no headset"));
    for (size_t i = 0; i < sizeof at_begin / sizeof *at_begin; i++) {
        reset(NULL);
        fake->fail = at_begin[i];
        assert_ok(ost_headset_open(&h, &err));
        assert_int_equal(ost_headset_begin(h, viewer.gl, 0, 0, false, &err), OST_ERR_UNAVAILABLE);
        close_session(h);
    }
    for (size_t i = 0; i < sizeof in_frame / sizeof *in_frame; i++) {
        bool ended;
        reset(NULL);
        h = open_session();
        run_frames(h, 2);
        fake->fail = in_frame[i];
        assert_int_equal(ost_headset_frame(h, &calls, &ended, &err), OST_ERR_UNAVAILABLE);
        assert_non_null(strstr(err.text, "fake result"));
        fake->fail = NULL;
        ost_headset_close(h);
        assert_int_equal(fake->sessions, 0);
    }
    /* This must be the last test, because the loader caches the extension list of a runtime that it has opened. */
    reset(NULL);
    fake->no_egl = true;
    assert_int_equal(ost_headset_open(&h, &err), OST_ERR_UNAVAILABLE);
    assert_non_null(strstr(err.text, "XR_MNDX_egl_enable"));
}

/* Writes the file that names the runtime, and finds its state. Returns false if the runtime cannot be opened. */
static bool find_runtime(void)
{
    char path[4096], given[2048];
    const char *build = getenv("top_builddir");
    snprintf(given, sizeof given, "%s/.libs/fake_openxr.so", build ? build : ".");
    if (!realpath(given, path))
        return false;
    snprintf(manifest, sizeof manifest, "/tmp/osteon-openxr-%ld.json", (long)getpid());
    FILE *file = fopen(manifest, "w");
    if (!file)
        return false;
    fprintf(file, "{\"file_format_version\": \"1.0.0\", \"runtime\": {\"library_path\": \"%s\"}}\n", path);
    fclose(file);
    setenv("XR_RUNTIME_JSON", manifest, 1);
    void *library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    fake = library ? dlsym(library, "fake_xr") : NULL;
    return fake;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(eye_pictures_equal_symmetric_picture, reset),
        cmocka_unit_test_setup(hand_and_buttons_are_passed_on, reset),
        cmocka_unit_test_setup(missed_periods_are_counted, reset),
        cmocka_unit_test_setup(frames_without_picture_have_no_layer, reset),
        cmocka_unit_test_setup(lost_session_ends, reset),
        cmocka_unit_test_setup(each_failure_causes_one_error, reset),
    };
    if (getenv("OST_UNDER_VALGRIND")) {
        printf("# skipped: valgrind cannot check the code of an OpenGL driver\n");
        return 77;
    }
    if (!find_runtime()) {
        printf("# skipped: .libs/fake_openxr.so, the runtime for tests, cannot be opened\n");
        return 77;
    }
    return cmocka_run_group_tests(tests, begin, end);
}
