/* SPDX-License-Identifier: Apache-2.0 */
#include "app/sim_hud.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "app/say.h"

enum { WHITE = 0xf4f1ee, PALE = 0xb9b2aa, GREEN = 0x8fce7a, AMBER = 0x4fb4f2, RED = 0x5a5af0, PANEL = 0x0e0c0a, BACK = 0x1c1816, BAR = 0x4a423a };
enum { SHADE = 150, LINE = 220 };

struct sim_hud {
    ost_lettering *plain, *large;
    double unit; /* pixels of one at 96 to the inch */
};

ost_status sim_hud_create(double scale, sim_hud **out, ost_error *err)
{
    *out = NULL;
    sim_hud *h = calloc(1, sizeof *h);
    if (!h)
        return ost_fail(err, OST_ERR_MEMORY, "no memory for what is written over a frame");
    h->unit = scale;
    ost_status status = ost_lettering_create(9.5 * scale, &h->plain, err);
    if (status == OST_OK)
        status = ost_lettering_create(13 * scale, &h->large, err);
    if (status != OST_OK) {
        sim_hud_free(h);
        return status;
    }
    *out = h;
    return OST_OK;
}

void sim_hud_free(sim_hud *hud)
{
    if (!hud)
        return;
    ost_lettering_free(hud->plain);
    ost_lettering_free(hud->large);
    free(hud);
}

static int px(const sim_hud *h, double units)
{
    return (int)(units * h->unit + 0.5);
}

/* A name at the left, its value at the right end of a column. */
static void row(const sim_hud *h, const ost_sheet *s, int x, int y, int width, const char *name, const char *value, uint32_t colour)
{
    ost_lettering_draw(h->plain, s, x, y, name, PALE);
    ost_lettering_draw(h->plain, s, x + width - ost_lettering_width(h->plain, value), y, value, colour);
}

static void draw_hand(const sim_hud *h, const ost_sheet *s, const sim_hud_facts *f)
{
    enum { WIDTH = 236, STEP = 21 };
    const int x = px(h, 26), width = px(h, WIDTH);
    int lines = 2 + (f->force_given ? 1 : 0) + (f->planned ? 3 : 0);
    char text[SAY_TEXT];
    ost_sheet_box(s, px(h, 12), px(h, 12), width + px(h, 28), px(h, 46 + STEP * lines + (f->force_given ? 10 : 0)), PANEL, SHADE);
    int y = px(h, 38);
    ost_lettering_draw(h->large, s, x, y, f->tool, WHITE);
    if (f->tools > 1) {
        snprintf(text, sizeof text, "%d of %d", f->number, f->tools);
        ost_lettering_draw(h->plain, s, x + width - ost_lettering_width(h->plain, text), y, text, PALE);
    }
    y += px(h, 26);
    row(h, s, x, y, width, "tool", f->fault ? f->fault : f->touching ? "in the bone" : "free", f->fault ? RED : f->touching ? AMBER : GREEN);
    y += px(h, STEP);
    if (f->force_given) {
        const double most = 10, share = fmin(1, f->force_n / most);
        snprintf(text, sizeof text, "%.1f N", f->force_n);
        row(h, s, x, y, width, "force on the hand", text, share < 0.8 ? WHITE : RED);
        y += px(h, 7);
        ost_sheet_box(s, x, y, width, px(h, 4), BAR, 256);
        ost_sheet_box(s, x, y, (int)(width * share), px(h, 4), share < 0.5 ? GREEN : share < 0.8 ? AMBER : RED, 256);
        y += px(h, STEP + 3);
    }
    snprintf(text, sizeof text, "%.1f mm3", f->removed_mm3);
    row(h, s, x, y, width, "removed", text, WHITE);
    if (!f->planned)
        return;
    y += px(h, STEP);
    snprintf(text, sizeof text, "%+.1f mm", f->depth_mm);
    row(h, s, x, y, width, "depth below the face", text, WHITE);
    const double angle[2] = {f->back_deg, f->up_deg};
    const char *const name[2] = {"retroversion to the plan", "upward tilt to the plan"};
    for (int i = 0; i < 2; i++) {
        y += px(h, STEP);
        snprintf(text, sizeof text, "%+.1f\xc2\xb0", fabs(angle[i]) < 0.05 ? 0 : angle[i]);
        row(h, s, x, y, width, name[i], text, fabs(angle[i]) < 3 ? GREEN : fabs(angle[i]) < 8 ? AMBER : RED);
    }
}

static void draw_rates(const sim_hud *h, const ost_sheet *s, const sim_hud_facts *f)
{
    enum { WIDTH = 178, STEP = 19 };
    const int width = px(h, WIDTH), x = s->width - width - px(h, 26);
    char text[SAY_TEXT], count[SAY_TEXT];
    ost_sheet_box(s, x - px(h, 14), px(h, 12), width + px(h, 28), px(h, 20 + STEP * 5), PANEL, SHADE);
    int y = px(h, 34);
    snprintf(text, sizeof text, "%.0f a second", f->ticks_s);
    row(h, s, x, y, width, "ticks", text, f->ticks_s > 990 ? WHITE : AMBER);
    y += px(h, STEP);
    snprintf(text, sizeof text, "%.0f us", f->takes_us);
    row(h, s, x, y, width, "one takes", text, WHITE);
    y += px(h, STEP);
    row(h, s, x, y, width, "skipped", say_count(count, (int64_t)f->missed), f->missed ? AMBER : WHITE);
    y += px(h, STEP);
    snprintf(text, sizeof text, "%.0f a second", f->frames_s);
    row(h, s, x, y, width, "frames", text, WHITE);
    y += px(h, STEP);
    row(h, s, x, y, width, "recording", f->recording ? "yes" : "no", f->recording ? GREEN : PALE);
}

static const char *const help[][2] = {
    {"left drag", "move the tool in the picture's plane"},
    {"wheel, W S", "push the tool along its axis, pull it back"},
    {"shift, left drag", "turn the tool;  Q E about its axis"},
    {"space", "hold: the tool spins"},
    {"Tab, 1 to 9", "the next tool; a tool by its number"},
    {"Home", "the tool back to where it began"},
    {"right drag", "look from elsewhere; arrow keys too"},
    {"middle drag", "move the picture"},
    {"ctrl wheel, + -", "nearer, farther"},
    {"F2 F3 F4", "operator, en face, lateral"},
    {"F5 F6 F7", "anterior, posterior, superior"},
    {"F8 F9", "along the tool, the whole bone"},
    {"F10", "smooth, or the thesis' flat faces"},
    {"F11 F12", "full screen, screenshot"},
    {"F1, Ctrl Q", "this help, the end"},
};

static void draw_help(const sim_hud *h, const ost_sheet *s)
{
    enum { STEP = 23, WIDTH = 520, KEYS = 165 };
    const int rows = (int)(sizeof help / sizeof *help), width = px(h, WIDTH), height = px(h, STEP * rows + 66);
    const int x = (s->width - width) / 2, y = (s->height - height) / 2;
    ost_sheet_box(s, x, y, width, height, PANEL, LINE);
    ost_lettering_draw(h->large, s, x + px(h, 26), y + px(h, 36), "Mouse and keys", WHITE);
    for (int i = 0; i < rows; i++) {
        ost_lettering_draw(h->plain, s, x + px(h, 26), y + px(h, 68 + STEP * i), help[i][0], AMBER);
        ost_lettering_draw(h->plain, s, x + px(h, 26 + KEYS), y + px(h, 68 + STEP * i), help[i][1], WHITE);
    }
}

/* The greatest 1, 2 or 5 times a power of ten of millimetres that fits. */
static void draw_scale(const sim_hud *h, const ost_sheet *s, double mm_per_pixel)
{
    const double room = px(h, 150) * mm_per_pixel;
    double length = 0;
    char text[SAY_TEXT];
    for (double decade = 0.01; decade < 1e4; decade *= 10)
        for (int step = 1; step <= 5; step += step == 1 ? 1 : 3)
            length = step * decade <= room ? step * decade : length;
    if (!(length > 0))
        return;
    const int width = (int)(length / mm_per_pixel), x = s->width - width - px(h, 26), y = s->height - px(h, 24);
    ost_sheet_box(s, x, y, width, px(h, 2), PALE, 256);
    ost_sheet_box(s, x, y - px(h, 5), px(h, 2), px(h, 7), PALE, 256);
    ost_sheet_box(s, x + width - px(h, 2), y - px(h, 5), px(h, 2), px(h, 7), PALE, 256);
    snprintf(text, sizeof text, "%g mm", length);
    ost_lettering_draw(h->plain, s, x + (width - ost_lettering_width(h->plain, text)) / 2, y - px(h, 10), text, PALE);
}

void sim_hud_draw(const sim_hud *hud, const ost_sheet *sheet, const sim_hud_facts *facts)
{
    draw_hand(hud, sheet, facts);
    draw_rates(hud, sheet, facts);
    draw_scale(hud, sheet, facts->mm_per_pixel);
    const char *foot = facts->message ? facts->message : facts->help ? "" : "F1: mouse and keys";
    if (*foot) {
        const int width = ost_lettering_width(hud->plain, foot);
        ost_sheet_box(sheet, px(hud, 12), sheet->height - px(hud, 42), width + px(hud, 26), px(hud, 30), PANEL, SHADE);
        ost_lettering_draw(hud->plain, sheet, px(hud, 25), sheet->height - px(hud, 22), foot, facts->message ? WHITE : PALE);
    }
    if (facts->help)
        draw_help(hud, sheet);
}

void sim_hud_say(const sim_hud *hud, const ost_sheet *sheet, const char *sentence)
{
    ost_sheet_box(sheet, 0, 0, sheet->width, sheet->height, BACK, 256);
    ost_lettering_draw(hud->large, sheet, (sheet->width - ost_lettering_width(hud->large, sentence)) / 2, sheet->height / 2, sentence, PALE);
}
