/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests the HUD for frames of all sizes and pixel densities: all elements are within the frame, no elements
 * overlap, no text exceeds its panel, and no letter is too small to be read. Frames of common sizes show
 * every element.
 * Covers: REQ-WINDOW
 */
#include <stdlib.h>

#include "app/sim/hud.h"
#include "harness.h"
#include "render/lettering.h"

static sim_hud_facts facts(bool much)
{
    sim_hud_facts f = {.tool = "reamer",
                       .device = "mouse",
                       .number = 1,
                       .tools = 3,
                       .running = true,
                       .mm_per_pixel = 0.1,
                       .right = {1, 0, 0},
                       .up = {0, 0, 1}};
    if (!much)
        return f;
    f.legend = (ost_legend){.colouring = OST_COLOUR_CLASS, .plate = true, .window = true};
    f.force_given = f.planned = f.rates = f.timings = f.recording = f.filming = true;
    f.force_n = 123.4;
    f.contact_n = 1234.5;
    f.force_full_n = 12;
    f.contact_full_n = 150;
    f.removed_mm3 = 123456.7;
    f.reached_mm = 123.4;
    f.planned_mm = 12.5;
    f.back_deg = -178.8;
    f.up_deg = 178.8;
    f.fault = "the pose turned too far, or is invalid";
    f.ticks_s = 1000;
    f.takes_us = 123456;
    f.frames_s = 1000;
    f.frame_ms = 12345.6;
    f.missed = 1234567;
    f.dropped = 1234567;
    f.seconds = 86399;
    f.message = "OpenGL here is software (llvmpipe (LLVM 15.0.6, 256 bits)): the processor draws";
    return f;
}

static const sim_hud_box *box_of(const sim_hud_layout *l, int i)
{
    const sim_hud_box *all[] = {&l->device, &l->rates,   &l->foot,    &l->scale,   &l->legend,
                                &l->help,   &l->edge[0], &l->edge[1], &l->edge[2], &l->edge[3]};
    return i < 10 ? all[i] : NULL;
}

static bool contains(const sim_hud_box *b, int x, int y)
{
    return x >= b->x && x < b->x + b->width && y >= b->y && y < b->y + b->height;
}

static sim_hud *hud;

static void check_layout(int width, int height, double scale, const sim_hud_facts *f, bool draw)
{
    ost_error err = {0};
    if (!sim_hud_suits(hud, width, height, scale)) {
        sim_hud_free(hud);
        assert_ok(sim_hud_create(width, height, scale, &hud, &err));
    }
    assert_true(sim_hud_suits(hud, width, height, scale));
    const sim_hud_layout l = sim_hud_arrange(hud, width, height, f);
    for (int i = 0; box_of(&l, i); i++) {
        const sim_hud_box *a = box_of(&l, i);
        if (!a->width)
            continue;
        assert_true(a->x >= 0 && a->y >= 0 && a->width > 0 && a->height > 0 && a->x + a->width <= width &&
                    a->y + a->height <= height);
        for (int j = 0; j < i; j++) {
            const sim_hud_box *b = box_of(&l, j);
            assert_true(!b->width || a->x >= b->x + b->width || b->x >= a->x + a->width || a->y >= b->y + b->height ||
                        b->y >= a->y + a->height);
        }
    }
    if (draw) {
        const uint32_t blank = 0x808080;
        uint32_t *pixels = malloc((size_t)width * (size_t)height * sizeof *pixels);
        assert_non_null(pixels);
        for (int i = 0; i < width * height; i++)
            pixels[i] = blank;
        const ost_sheet sheet = {.pixels = pixels, .stride = width, .width = width, .height = height};
        sim_hud_draw(hud, &sheet, f);
        for (int y = 0; y < height; y++)
            for (int x = 0; x < width; x++) {
                bool in = pixels[x + width * y] == blank;
                for (int i = 0; box_of(&l, i) && !in; i++)
                    in = box_of(&l, i)->width && contains(box_of(&l, i), x, y);
                if (!in)
                    fail_msg("%d x %d at scale %g: pixel %d, %d is drawn but is outside of all panels", width, height,
                             scale, x, y);
            }
        sim_hud_draw_message(hud, &sheet, "builtin:scapula: a moment");
        free(pixels);
    }
}

static void panels_do_not_overlap(void **state)
{
    static const int sides[] = {1, 2, 7, 40, 100, 160, 240, 333, 480, 640, 900, 1280, 2160, 8192};
    static const double scales[] = {0.5, 1, 1.25, 2, 8};
    (void)state;
    for (size_t s = 0; s < sizeof scales / sizeof *scales; s++)
        for (size_t y = 0; y < sizeof sides / sizeof *sides; y++)
            for (size_t x = 0; x < sizeof sides / sizeof *sides; x++) {
                sim_hud_facts f = facts((x + y) % 2);
                f.help = (x + s) % 3 == 0;
                check_layout(sides[x], sides[y], scales[s], &f, s == 1 && sides[x] * sides[y] < 100000);
            }
}

static void common_sizes_show_all_panels(void **state)
{
    static const struct {
        int width, height;
        double scale;
    } usual[] = {{640, 360, 1}, {1280, 720, 1}, {1920, 1080, 1}, {1280, 720, 1.5}, {900, 1000, 1}};
    (void)state;
    for (size_t i = 0; i < sizeof usual / sizeof *usual; i++) {
        sim_hud_facts f = facts(true);
        f.fault = NULL;
        f.reached_mm = f.frame_ms = 1.2;
        f.takes_us = 56;
        check_layout(usual[i].width, usual[i].height, usual[i].scale, &f, true);
        sim_hud_layout l = sim_hud_arrange(hud, usual[i].width, usual[i].height, &f);
        for (int b = 0; box_of(&l, b); b++)
            if (box_of(&l, b) != &l.help && !box_of(&l, b)->width && b < 5)
                fail_msg("%d x %d at scale %g: panel %d is not shown", usual[i].width, usual[i].height, usual[i].scale,
                         b);
        f.help = true;
        l = sim_hud_arrange(hud, usual[i].width, usual[i].height, &f);
        assert_true(l.help.width > 0);
    }
}

/* Draws the HUD with the values *f on a grey frame. */
static void draw_hud(const sim_hud_facts *f, uint32_t *pixels, int width, int height)
{
    for (int i = 0; i < width * height; i++)
        pixels[i] = 0x808080;
    const ost_sheet sheet = {.pixels = pixels, .stride = width, .width = width, .height = height};
    sim_hud_draw(hud, &sheet, f);
}

static void forces_depth_and_times_are_displayed(void **state)
{
    enum { W = 640, H = 360 };
    static uint32_t a[W * H], b[W * H];
    ost_error err = {0};
    (void)state;
    sim_hud_free(hud);
    assert_ok(sim_hud_create(W, H, 1, &hud, &err));
    sim_hud_facts f = facts(true);
    f.message = f.fault = NULL;
    f.contact_n = 30;
    f.contact_full_n = 37.5;
    f.force_n = 2.4;
    f.force_full_n = 3;
    f.reached_mm = f.planned_mm = 3;
    /* Zero is displayed without a sign. */
    f.reached_mm = f.back_deg = f.up_deg = f.removed_mm3 = f.contact_n = f.force_n = 0;
    draw_hud(&f, a, W, H);
    f.reached_mm = f.removed_mm3 = f.contact_n = f.force_n = -0.04;
    f.back_deg = f.up_deg = -0.04;
    draw_hud(&f, b, W, H);
    assert_memory_equal(a, b, sizeof a);
    /* Contact force, hand force and depth are each displayed. */
    double *const shown[] = {&f.contact_n, &f.force_n, &f.reached_mm};
    for (size_t i = 0; i < sizeof shown / sizeof *shown; i++) {
        *shown[i] = 1.7;
        draw_hud(&f, b, W, H);
        assert_memory_not_equal(a, b, sizeof a);
        *shown[i] = 0;
    }
    /* On request, the HUD also displays the times of the loop and of the frames. */
    const sim_hud_layout with = sim_hud_arrange(hud, W, H, &f);
    f.timings = false;
    const sim_hud_layout without = sim_hud_arrange(hud, W, H, &f);
    assert_true(without.rates.width > 0 && without.rates.height < with.rates.height);
    draw_hud(&f, a, W, H);
    f.missed = 3;
    f.ticks_s = 500;
    f.frame_ms = 99;
    draw_hud(&f, b, W, H);
    assert_memory_equal(a, b, sizeof a);
    /* The colour changes when the depth exceeds the plan. */
    const uint32_t within_plan = sim_hud_depth_colour(3, 3), beyond = sim_hud_depth_colour(3.1, 3),
                   far = sim_hud_depth_colour(4.1, 3);
    assert_true(within_plan == sim_hud_depth_colour(0, 3) && beyond == sim_hud_depth_colour(4, 3) &&
                far == sim_hud_depth_colour(40, 3));
    assert_true(within_plan != beyond && beyond != far && far != within_plan);
    assert_int_equal(sim_hud_depth_colour(40, 0), within_plan);
    sim_hud_free(hud);
    hud = NULL;
}

/* Letters are larger on larger frames and on displays with a higher pixel density. A change in the frame size by one or
   two pixels must not change the letters. */
static void letter_size_follows_frame_size(void **state)
{
    ost_error err = {0};
    (void)state;
    sim_hud_free(hud);
    assert_ok(sim_hud_create(1280, 720, 1, &hud, &err));
    assert_true(sim_hud_suits(hud, 1281, 722, 1));
    assert_false(sim_hud_suits(hud, 1920, 1080, 1));
    assert_false(sim_hud_suits(hud, 640, 360, 1));
    assert_false(sim_hud_suits(hud, 1280, 720, 2));
    assert_false(sim_hud_suits(NULL, 1280, 720, 1));
    sim_hud_free(hud);
    hud = NULL;
}

static uint32_t blend(uint32_t a, uint32_t b, unsigned share)
{
    uint32_t v = 0;
    for (int c = 0; c < 32; c += 8)
        v |= ((a >> c & 255) * (256 - share) + (b >> c & 255) * share) / 256 << c;
    return v;
}

/*
 * The blended colour and opacity of a pixel must depend neither on the number of pixels in one call nor on the
 * alignment of the first pixel. No other pixel may change.
 */
static void pixels_are_blended_independently(void **state)
{
    enum { W = 37, H = 3 };
    uint32_t pixels[W * H];
    unsigned seed = 5;
    (void)state;
    for (int round = 0; round < 3000; round++) {
        uint32_t before[W * H], colour, alpha;
        for (int i = 0; i < W * H; i++)
            before[i] = pixels[i] = seed = seed * 1664525 + 1013904223;
        colour = (seed = seed * 1664525 + 1013904223) >> 8;
        alpha = round % 257;
        const int x = round % 41 - 2, width = round / 41 % 40;
        const ost_sheet sheet = {.pixels = pixels, .stride = W, .width = W, .height = H};
        ost_sheet_box(&sheet, x, 1, width, 1, colour, alpha);
        for (int i = 0; i < W * H; i++) {
            const bool in = i / W == 1 && i % W >= x && i % W < x + width;
            assert_int_equal(pixels[i], in ? blend(before[i], colour | 0xff000000, alpha) : before[i]);
        }
    }
}

/* A letter must have the same pixels at every position. The part of a letter outside the frame is not drawn. */
static void letters_are_equal_at_every_position(void **state)
{
    enum { W = 120, H = 24 };
    static uint32_t first[W * H], pixels[W * H];
    ost_error err = {0};
    ost_lettering *l;
    (void)state;
    assert_ok(ost_lettering_create(9.5, &l, &err));
    for (int shift = -60; shift < 60; shift++) {
        for (int i = 0; i < W * H; i++)
            first[i] = pixels[i] = 0x406080;
        const ost_sheet a = {.pixels = first, .stride = W, .width = W, .height = H},
                        b = {.pixels = pixels, .stride = W, .width = W, .height = H};
        ost_lettering_draw(l, &a, 0, 15, "Wg%8.", 0xf0e0d0);
        ost_lettering_draw(l, &b, shift, 15, "Wg%8.", 0xf0e0d0);
        int drawn = 0;
        for (int y = 0; y < H; y++)
            for (int x = 0; x < W; x++) {
                drawn += first[y * W + x] != 0x406080;
                const int from = x - shift;
                /* The first letter is clipped at the left edge of the frame. */
                if (from >= 2 && from < W)
                    assert_int_equal(pixels[y * W + x], first[y * W + from]);
            }
        assert_true(drawn > 100);
    }
    ost_lettering_free(l);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(panels_do_not_overlap),
        cmocka_unit_test(common_sizes_show_all_panels),
        cmocka_unit_test(forces_depth_and_times_are_displayed),
        cmocka_unit_test(letter_size_follows_frame_size),
        cmocka_unit_test(pixels_are_blended_independently),
        cmocka_unit_test(letters_are_equal_at_every_position),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
