/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests the window on simulated systems: with old drivers, with drivers that are reset once or
 * repeatedly, with frames of any size and pixel density, and with missing screens.
 * Covers: REQ-WINDOW, REQ-GL-SHOW
 */
#include <stdlib.h>
#include <string.h>

#include "harness.h"
#include "tests/window/fake.h"
#include "window/window.h"

static uint32_t pixels[64];

static ost_window *open_window(void)
{
    ost_error err = {0};
    ost_window *w;
    assert_ok(ost_window_open("a title", 640, 400, &w, &err));
    return w;
}

static void close_window(ost_window *w)
{
    ost_window_close(w);
    assert_int_equal(the_fake.inits, 0);
    assert_int_equal(the_fake.windows, 0);
    assert_int_equal(the_fake.objects, 0);
}

static void assert_refused(const char *words)
{
    ost_error err = {0};
    ost_window *w;
    assert_int_equal(ost_window_open("a title", 640, 400, &w, &err), OST_ERR_UNAVAILABLE);
    assert_null(w);
    if (!strstr(err.text, words))
        fail_msg("the error '%s' does not contain '%s'", err.text, words);
    assert_non_null(strstr(err.text, "--headless"));
    assert_int_equal(the_fake.inits, 0);
    assert_int_equal(the_fake.windows, 0);
}

static int present(ost_window *w, ost_error *err)
{
    return ost_window_present(w, &(ost_window_picture){.pixels = pixels, .stride = 8, .width = 8, .height = 8}, true,
                              err);
}

static void missing_features_are_reported(void **state)
{
    (void)state;
    fake_begin();
    unsetenv("DISPLAY");
    unsetenv("WAYLAND_DISPLAY");
    assert_refused("DISPLAY is not set");
    setenv("DISPLAY", ":0", 1);
    the_fake.no_init = true;
    the_fake.why = "the display cannot be opened";
    assert_refused("cannot be opened");
    /* The driver supports OpenGL 2.1 and reports that it does not support 3.3. */
    fake_begin();
    the_fake.version = 0;
    the_fake.plain_version = 21;
    assert_refused("needs OpenGL 3.3, found 2.1 of a test (a fake)");
    assert_refused("LIBGL_ALWAYS_SOFTWARE=1");
    /* The driver reports a different reason, although it supports only 2.1. */
    the_fake.why = "no visual";
    assert_refused("found 2.1 of a test");
    /* The version is sufficient, so it must not be reported as the reason. */
    the_fake.plain_version = 45;
    assert_refused("no visual");
    the_fake.plain_version = 0;
    assert_refused("no visual");
    the_fake.why = NULL;
    assert_refused("found none (no renderer)");
    fake_begin();
    the_fake.no_compile = true;
    assert_refused("cannot run the window's program");
}

static void newest_context_is_requested(void **state)
{
    (void)state;
    fake_begin();
    ost_window *w = open_window();
    assert_int_equal(10 * the_fake.requested_major + the_fake.requested_minor, 44);
    assert_int_equal(the_fake.requested_robustness, GLFW_LOSE_CONTEXT_ON_RESET);
    assert_string_equal(ost_window_info_get(w).version, "4.5 of a test");
    assert_string_equal(the_fake.title, "a title");
    close_window(w);
    the_fake.version = 33;
    w = open_window();
    assert_int_equal(10 * the_fake.requested_major + the_fake.requested_minor, 33);
    close_window(w);
}

static void reset_makes_new_context(void **state)
{
    ost_error err = {0};
    ost_window_event e;
    (void)state;
    for (int round = 0; round < 3; round++) {
        /* Resets can be detected with OpenGL 4.5 or with either of two extensions. */
        fake_begin();
        the_fake.version = round ? 33 : 45;
        the_fake.khr = round == 1;
        the_fake.arb = round == 2;
        ost_window *w = open_window();
        assert_true(ost_window_info_get(w).robust);
        ost_window_title(w, "another title");
        fake_place(70, 80);
        fake_size(500, 300);
        assert_ok(present(w, &err));
        assert_int_equal(the_fake.frames, 1);
        the_fake.reset = GL_UNKNOWN_CONTEXT_RESET;
        assert_ok(present(w, &err));
        assert_int_equal(the_fake.frames, 1);
        assert_int_equal(the_fake.contexts, 2);
        assert_int_equal(ost_window_info_get(w).resets, 1);
        assert_string_equal(the_fake.title, "another title");
        /* Because the window may have missed key releases during the reset, it must add a release event. */
        assert_true(ost_window_next(w, &e));
        assert_int_equal(e.kind, OST_WINDOW_RELEASE);
        assert_false(ost_window_next(w, &e));
        int width, height;
        double scale;
        ost_window_size(w, &width, &height, &scale);
        assert_int_equal(width, 500);
        assert_int_equal(height, 300);
        assert_true(ost_window_damaged(w));
        assert_ok(present(w, &err));
        assert_int_equal(the_fake.frames, 2);
        /* The driver is reset in the middle of a frame. */
        the_fake.reset_in_upload = true;
        assert_ok(ost_window_present(w, &(ost_window_picture){.pixels = pixels, .stride = 4, .width = 4, .height = 4},
                                     true, &err));
        assert_int_equal(ost_window_info_get(w).resets, 2);
        assert_ok(present(w, &err));
        close_window(w);
    }
    /* The driver never reports a reset. */
    fake_begin();
    the_fake.version = 33;
    the_fake.khr = false;
    ost_window *w = open_window();
    assert_false(ost_window_info_get(w).robust);
    the_fake.reset = GL_GUILTY_CONTEXT_RESET;
    assert_ok(present(w, &err));
    close_window(w);
}

static void repeated_resets_are_an_error(void **state)
{
    ost_error err = {0};
    (void)state;
    fake_begin();
    ost_window *w = open_window();
    the_fake.reset = GL_GUILTY_CONTEXT_RESET;
    the_fake.reset_stays = true;
    for (int i = 0; i < 3; i++)
        assert_ok(present(w, &err));
    assert_int_equal(present(w, &err), OST_ERR_UNAVAILABLE);
    assert_non_null(strstr(err.text, "was reset 4 times within 10 s"));
    close_window(w);
    /* Rare resets must not close the window. */
    fake_begin();
    w = open_window();
    for (int i = 0; i < 20; i++) {
        the_fake.reset = GL_INNOCENT_CONTEXT_RESET;
        the_fake.clock_ns += INT64_C(4000000000);
        assert_ok(present(w, &err));
        assert_ok(present(w, &err));
    }
    assert_int_equal(ost_window_info_get(w).resets, 20);
    /* No new context can be made, so the window can only be closed. */
    the_fake.reset = GL_GUILTY_CONTEXT_RESET;
    the_fake.clock_ns += INT64_C(90000000000);
    the_fake.no_next = true;
    the_fake.why = "the card fell out";
    int width, height;
    double scale;
    ost_window_event e;
    assert_int_equal(present(w, &err), OST_ERR_UNAVAILABLE);
    assert_non_null(strstr(err.text, "reset"));
    assert_non_null(strstr(err.text, "fell out"));
    assert_true(ost_window_closing(w));
    assert_int_equal(ost_window_check(w, &err), OST_ERR_UNAVAILABLE);
    assert_int_equal(present(w, &err), OST_ERR_UNAVAILABLE);
    ost_window_poll(w, 1);
    while (ost_window_next(w, &e))
        ;
    ost_window_size(w, &width, &height, &scale);
    ost_window_title(w, "nothing");
    ost_window_full_screen(w, true);
    assert_false(ost_window_is_full_screen(w));
    close_window(w);
}

static void frames_of_any_size(void **state)
{
    static const struct {
        int frame[2], picture[2], side;
    } sizes[] = {{{1, 1}, {1, 1}, 16384},           {{8192, 8192}, {8192, 8192}, 16384},
                 {{16384, 100}, {8192, 50}, 16384}, {{30000, 1}, {8192, 1}, 16384},
                 {{1, 30000}, {1, 8192}, 16384},    {{6000, 3000}, {4096, 2048}, 4096},
                 {{1300, 1000}, {1024, 787}, 1024}, {{0, 0}, {0, 0}, 16384},
                 {{100, 0}, {0, 0}, 16384}};
    ost_error err = {0};
    (void)state;
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        int width, height;
        double scale;
        fake_begin();
        the_fake.texture_side = sizes[i].side;
        ost_window *w = open_window();
        fake_size(sizes[i].frame[0], sizes[i].frame[1]);
        ost_window_size(w, &width, &height, &scale);
        assert_int_equal(width, sizes[i].picture[0]);
        assert_int_equal(height, sizes[i].picture[1]);
        if (width) {
            /* The pointer's position must be in picture pixels. */
            ost_window_event e;
            fake_move(sizes[i].frame[0], sizes[i].frame[1]);
            assert_true(ost_window_next(w, &e));
            assert_in_range((int)(e.x + 0.5), width - 1, width + 1);
            assert_in_range((int)(e.y + 0.5), height - 1, height + 1);
            assert_ok(ost_window_present(
                w, &(ost_window_picture){.pixels = pixels, .stride = width, .width = width, .height = height}, false,
                &err));
            assert_int_equal(the_fake.viewport[0], sizes[i].frame[0]);
            assert_int_equal(the_fake.viewport[1], sizes[i].frame[1]);
            assert_int_equal(the_fake.swap_interval, 0);
        }
        close_window(w);
    }
    fake_begin();
    ost_window *w = open_window();
    the_fake.no_texture_memory = true;
    assert_int_equal(present(w, &err), OST_ERR_UNAVAILABLE);
    assert_non_null(strstr(err.text, "out of memory for a picture of 8 x 8"));
    close_window(w);
}

/*
 * Tests drawing by another module with the window's context. This is possible only if a graphics card executes OpenGL.
 */
static void drawing_by_another_module(void **state)
{
    ost_error err = {0};
    (void)state;
    fake_begin();
    ost_window *w = open_window();
    assert_true(ost_window_can_be_drawn(w, 640, 400));
    assert_false(ost_window_can_be_drawn(w, 641, 400));
    assert_false(ost_window_can_be_drawn(w, 640, 399));
    assert_ok(ost_window_show_drawn(w, true, &err));
    assert_int_equal(the_fake.frames, 1);
    assert_int_equal(the_fake.uploads, 0);
    assert_int_equal(the_fake.swap_interval, 1);
    fake_damage();
    assert_true(ost_window_damaged(w));
    assert_ok(ost_window_show_drawn(w, false, &err));
    assert_false(ost_window_damaged(w));
    assert_int_equal(the_fake.swap_interval, 0);
    /* After a reset, nothing is shown, and the window reports the reset. */
    the_fake.reset = GL_GUILTY_CONTEXT_RESET;
    assert_ok(ost_window_show_drawn(w, false, &err));
    assert_int_equal(the_fake.frames, 2);
    assert_int_equal(the_fake.contexts, 2);
    assert_int_equal(ost_window_info_get(w).resets, 1);
    assert_ok(ost_window_show_drawn(w, false, &err));
    assert_int_equal(the_fake.frames, 3);
    /* No new context can be made. */
    the_fake.reset = GL_GUILTY_CONTEXT_RESET;
    the_fake.no_next = true;
    assert_int_equal(ost_window_show_drawn(w, false, &err), OST_ERR_UNAVAILABLE);
    assert_false(ost_window_can_be_drawn(w, 640, 400));
    assert_int_equal(ost_window_show_drawn(w, false, &err), OST_ERR_UNAVAILABLE);
    close_window(w);
    fake_begin();
    the_fake.renderer = "llvmpipe (LLVM 15.0.6, 256 bits)";
    w = open_window();
    assert_false(ost_window_can_be_drawn(w, 640, 400));
    close_window(w);
}

static void displays_with_high_pixel_density(void **state)
{
    int width, height;
    double scale;
    ost_window_event e;
    (void)state;
    fake_begin();
    the_fake.scale = 2;
    the_fake.frame_of_window = 2;
    ost_window *w = open_window();
    ost_window_size(w, &width, &height, &scale);
    assert_int_equal(width, 1280);
    assert_int_equal(height, 800);
    assert_true(scale == 2);
    fake_move(320, 100);
    assert_true(ost_window_next(w, &e));
    assert_true(e.x == 640 && e.y == 200);
    ost_error err = {0};
    assert_ok(present(w, &err));
    assert_false(ost_window_damaged(w));
    fake_rescale(1.5f); /* the window is moved to another screen */
    ost_window_size(w, &width, &height, &scale);
    assert_true(scale == 1.5);
    assert_true(ost_window_damaged(w));
    fake_rescale(0); /* some systems report the scale 0 if they cannot determine it */
    ost_window_size(w, &width, &height, &scale);
    assert_true(scale == 1);
    close_window(w);
}

static void invisible_window_has_no_size(void **state)
{
    int width, height;
    double scale;
    ost_error err = {0};
    (void)state;
    fake_begin();
    ost_window *w = open_window();
    fake_minimise(true);
    ost_window_size(w, &width, &height, &scale);
    assert_int_equal(width, 0);
    fake_minimise(false);
    ost_window_size(w, &width, &height, &scale);
    assert_int_equal(width, 640);
    /* The window is hidden without a callback. */
    assert_ok(present(w, &err));
    fake_hide(true);
    ost_window_poll(w, 0);
    ost_window_size(w, &width, &height, &scale);
    assert_int_equal(width, 640);
    ost_window_poll(w, 0.3);
    ost_window_poll(w, 0);
    ost_window_size(w, &width, &height, &scale);
    assert_int_equal(width, 0);
    assert_false(ost_window_damaged(w));
    fake_hide(false);
    ost_window_poll(w, 0.3);
    ost_window_size(w, &width, &height, &scale);
    assert_int_equal(width, 640);
    assert_true(ost_window_damaged(w));
    /* A callback reports that the window is visible again. The size must then be correct without a further poll. */
    fake_hide(true);
    ost_window_poll(w, 0.3);
    fake_damage();
    ost_window_size(w, &width, &height, &scale);
    assert_int_equal(width, 640);
    close_window(w);
}

static void full_screen_and_back(void **state)
{
    int width, height;
    double scale;
    (void)state;
    fake_begin();
    ost_window *w = open_window();
    fake_place(1800, 50); /* most of the window is on the second screen, so this screen must become the full screen */
    ost_window_full_screen(w, true);
    assert_true(ost_window_is_full_screen(w));
    ost_window_size(w, &width, &height, &scale);
    assert_int_equal(width, 1280);
    assert_int_equal(height, 1024);
    ost_window_full_screen(w, true);
    ost_window_full_screen(w, false);
    assert_false(ost_window_is_full_screen(w));
    ost_window_size(w, &width, &height, &scale);
    assert_int_equal(width, 640);
    assert_int_equal(height, 400);
    /* The driver is reset during full screen. */
    ost_error err = {0};
    ost_window_full_screen(w, true);
    the_fake.reset = GL_GUILTY_CONTEXT_RESET;
    assert_ok(present(w, &err));
    assert_true(ost_window_is_full_screen(w));
    ost_window_full_screen(w, false);
    ost_window_size(w, &width, &height, &scale);
    assert_int_equal(width, 640);
    /* After a screen is unplugged, its full-screen window must return to the normal size. */
    ost_window_full_screen(w, true);
    fake_unplug_monitor();
    assert_false(ost_window_is_full_screen(w));
    the_fake.no_monitor = true;
    ost_window_full_screen(w, true);
    assert_false(ost_window_is_full_screen(w));
    close_window(w);
}

static void lost_key_releases_are_reported(void **state)
{
    ost_window_event e;
    (void)state;
    fake_begin();
    ost_window *w = open_window();
    fake_key(GLFW_KEY_W, GLFW_PRESS, 0);
    fake_key(GLFW_KEY_W, GLFW_REPEAT, 0);
    fake_key(GLFW_KEY_KP_3, GLFW_PRESS, 0);
    fake_key(GLFW_KEY_F12, GLFW_RELEASE, 0);
    /* when a modifier key is pressed, GLFW reports only the modifiers that were already pressed; the event must also
       include this key */
    fake_key(GLFW_KEY_LEFT_CONTROL, GLFW_PRESS, 0);
    assert_true(ost_window_next(w, &e) && e.key == 'W' && e.pressed);
    assert_true(ost_window_next(w, &e) && e.key == '3');
    assert_true(ost_window_next(w, &e) && e.key == OST_KEY_F1 + 11 && !e.pressed);
    assert_true(ost_window_next(w, &e) && e.mods == OST_WINDOW_CONTROL);
    fake_move(1, 1);
    fake_move(5, 6);
    fake_wheel(2, 0);
    assert_true(ost_window_next(w, &e) && e.kind == OST_WINDOW_MOVE && e.x == 5);
    assert_true(ost_window_next(w, &e) && e.kind == OST_WINDOW_WHEEL && e.y == 2);
    assert_false(ost_window_next(w, &e));
    /*
     * More events arrive than the queue can hold. The last event, the release of a key, is lost.
     * The loss must be reported.
     */
    int count = 0;
    fake_key(GLFW_KEY_SPACE, GLFW_PRESS, 0);
    for (int i = 0; i < 1000; i++)
        fake_button(i % 2, i % 4 < 2 ? GLFW_PRESS : GLFW_RELEASE, 0);
    fake_key(GLFW_KEY_SPACE, GLFW_RELEASE, 0);
    while (ost_window_next(w, &e))
        count++;
    assert_in_range(count, 100, 1000);
    assert_int_equal(e.kind, OST_WINDOW_RELEASE);
    fake_key(999, GLFW_PRESS, 0);
    assert_true(ost_window_next(w, &e) && e.key == 0);
    assert_false(ost_window_closing(w));
    fake_close();
    ost_error err = {0};
    assert_true(ost_window_closing(w));
    assert_ok(ost_window_check(w, &err));
    close_window(w);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(missing_features_are_reported),
        cmocka_unit_test(newest_context_is_requested),
        cmocka_unit_test(reset_makes_new_context),
        cmocka_unit_test(repeated_resets_are_an_error),
        cmocka_unit_test(frames_of_any_size),
        cmocka_unit_test(drawing_by_another_module),
        cmocka_unit_test(displays_with_high_pixel_density),
        cmocka_unit_test(invisible_window_has_no_size),
        cmocka_unit_test(full_screen_and_back),
        cmocka_unit_test(lost_key_releases_are_reported),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
