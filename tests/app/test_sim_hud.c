/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What is written over a frame, at any size and density: within the frame,
 * nothing over something else, no text out of its panel, no letter too small
 * to be read; at the sizes that people have, everything.
 * Covers: REQ-WINDOW
 */
#include <stdlib.h>

#include "app/sim_hud.h"
#include "harness.h"

static sim_hud_facts facts(bool much)
{
    sim_hud_facts f = {.tool = "reamer", .device = "mouse", .number = 1, .tools = 3, .running = true, .mm_per_pixel = 0.1, .right = {1, 0, 0}, .up = {0, 0, 1}};
    if (!much)
        return f;
    f.legend = (ost_legend){.colouring = OST_COLOUR_CLASS, .plate = true, .window = true};
    f.force_given = f.planned = f.rates = f.recording = f.filming = true;
    f.force_n = 123.4;
    f.removed_mm3 = 123456.7;
    f.depth_mm = -123.4;
    f.planned_mm = 12.5;
    f.back_deg = -178.8;
    f.up_deg = 178.8;
    f.fault = "the pose turned too far, or is none";
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
    const sim_hud_box *all[] = {&l->hand, &l->rates, &l->foot, &l->scale, &l->legend, &l->help, &l->edge[0], &l->edge[1], &l->edge[2], &l->edge[3]};
    return i < 10 ? all[i] : NULL;
}

static bool within(const sim_hud_box *b, int x, int y)
{
    return x >= b->x && x < b->x + b->width && y >= b->y && y < b->y + b->height;
}

static sim_hud *hud;

static void look(int width, int height, double scale, const sim_hud_facts *f, bool draw)
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
        assert_true(a->x >= 0 && a->y >= 0 && a->width > 0 && a->height > 0 && a->x + a->width <= width && a->y + a->height <= height);
        for (int j = 0; j < i; j++) {
            const sim_hud_box *b = box_of(&l, j);
            assert_true(!b->width || a->x >= b->x + b->width || b->x >= a->x + a->width || a->y >= b->y + b->height || b->y >= a->y + a->height);
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
                    in = box_of(&l, i)->width && within(box_of(&l, i), x, y);
                if (!in)
                    fail_msg("%d x %d at %g: something is written at %d, %d, out of every panel", width, height, scale, x, y);
            }
        sim_hud_say(hud, &sheet, "builtin:scapula: a moment");
        free(pixels);
    }
}

static void nothing_overlaps_anywhere(void **state)
{
    static const int sides[] = {1, 2, 7, 40, 100, 160, 240, 333, 480, 640, 900, 1280, 2160, 8192};
    static const double scales[] = {0.5, 1, 1.25, 2, 8};
    (void)state;
    for (size_t s = 0; s < sizeof scales / sizeof *scales; s++)
        for (size_t y = 0; y < sizeof sides / sizeof *sides; y++)
            for (size_t x = 0; x < sizeof sides / sizeof *sides; x++) {
                sim_hud_facts f = facts((x + y) % 2);
                f.help = (x + s) % 3 == 0;
                look(sides[x], sides[y], scales[s], &f, s == 1 && sides[x] * sides[y] < 100000);
            }
}

static void all_of_it_at_usual_sizes(void **state)
{
    static const struct {
        int width, height;
        double scale;
    } usual[] = {{640, 360, 1}, {1280, 720, 1}, {1920, 1080, 1}, {1280, 720, 1.5}, {900, 1000, 1}};
    (void)state;
    for (size_t i = 0; i < sizeof usual / sizeof *usual; i++) {
        sim_hud_facts f = facts(true);
        f.fault = NULL;
        f.depth_mm = f.frame_ms = 1.2;
        f.takes_us = 56;
        look(usual[i].width, usual[i].height, usual[i].scale, &f, true);
        sim_hud_layout l = sim_hud_arrange(hud, usual[i].width, usual[i].height, &f);
        for (int b = 0; box_of(&l, b); b++)
            if (box_of(&l, b) != &l.help && !box_of(&l, b)->width && b < 5)
                fail_msg("%d x %d at %g: panel %d has no room", usual[i].width, usual[i].height, usual[i].scale, b);
        f.help = true;
        l = sim_hud_arrange(hud, usual[i].width, usual[i].height, &f);
        assert_true(l.help.width > 0);
    }
}

/* Larger frames have larger letters, denser ones too; a pixel more or less does not have others. */
static void letters_grow(void **state)
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

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(nothing_overlaps_anywhere),
        cmocka_unit_test(all_of_it_at_usual_sizes),
        cmocka_unit_test(letters_grow),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
