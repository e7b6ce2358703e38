/* SPDX-License-Identifier: Apache-2.0 */
#include "app/sim/hud.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "app/common/print.h"
#include "render/marks.h"

enum {
    WHITE = 0xf4f1ee,
    PALE = 0xb9b2aa,
    GREEN = 0x8fce7a,
    AMBER = 0x4fb4f2,
    RED = 0x5a5af0,
    PANEL = 0x0e0c0a,
    BACK = 0x1c1816,
    BAR = 0x4a423a
};
enum { SHADE = 150, LINE = 220 };
enum { ROWS = 9, ROW_TEXT = 64, FOOT_LINES = 4, FOOT_TEXT = 200 };
/*
 * PLAIN and LARGE are the heights of capital letters in units. At 96 dpi, a unit has at least LEAST and at most MOST
 * pixels.
 */
static const double PLAIN = 9.5, LARGE = 13, LEAST = 0.75, MOST = 4;

struct sim_hud {
    ost_lettering *plain, *large;
    double unit; /* one unit of the HUD's layout, in pixels */
};

/* ----------------------------------------------------------------- size */

/*
 * Computes the size of a unit in pixels. The HUD is designed for frames that are 1000 pixels wide and 720 pixels
 * high. On larger frames the HUD grows less than the frame, because large frames are usually viewed from a greater
 * distance. The size is a multiple of 1/16, so that the lettering need not be rebuilt after a small change of the
 * frame's size.
 */
static double unit_for(int width, int height, double scale)
{
    const double dense = fmax(1, scale), available = fmin(height / 720.0, width / 1000.0) / dense;
    const double grown = available > 1 ? 1 + 0.7 * (available - 1) : available;
    return dense * floor(16 * fmax(LEAST, fmin(MOST, grown)) + 0.5) / 16;
}

ost_status sim_hud_create(int width, int height, double scale, sim_hud **out, ost_error *err)
{
    *out = NULL;
    sim_hud *h = calloc(1, sizeof *h);
    if (!h)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for the HUD");
    h->unit = unit_for(width, height, scale);
    ost_status status = ost_lettering_create(PLAIN * h->unit, &h->plain, err);
    if (status == OST_OK)
        status = ost_lettering_create(LARGE * h->unit, &h->large, err);
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

bool sim_hud_suits(const sim_hud *hud, int width, int height, double scale)
{
    return hud && hud->unit == unit_for(width, height, scale);
}

static int px(const sim_hud *h, double units)
{
    return (int)(units * h->unit + 0.5);
}

/* ---------------------------------------------------------------- panels */

/* A table whose rows consist of a name and a value. */
typedef struct table {
    int rows;
    struct {
        const char *name;
        char value[ROW_TEXT];
        uint32_t colour;
        double share; /* length of the bar below the row, from 0 to 1; negative if the row has no bar */
    } row[ROWS];
} table;

static void add(table *t, const char *name, uint32_t colour, const char *value)
{
    t->row[t->rows].name = name;
    t->row[t->rows].colour = colour;
    t->row[t->rows].share = -1;
    snprintf(t->row[t->rows++].value, ROW_TEXT, "%s", value);
}

static void add_angle(table *t, const char *name, double degrees, const char *more, const char *less)
{
    char text[ROW_TEXT];
    const double size = fabs(degrees);
    snprintf(text, sizeof text, "%.1f\xc2\xb0%s%s", size, size < 0.05 ? "" : " ",
             size < 0.05   ? ""
             : degrees > 0 ? more
                           : less);
    add(t, name, size < 3 ? GREEN : size < 8 ? AMBER : RED, text);
}

/* Returns 0 for a value that would be printed as zero, so that no minus sign is printed. */
static double plain(double value)
{
    return fabs(value) < 0.05 ? 0 : value;
}

/* Adds a row that contains a force, the maximum of the force's scale, and a bar with a mark at each quarter. */
static void add_force(table *t, const char *name, double n, double full)
{
    const double share = full > 0 ? fmax(0, fmin(1, n / full)) : 0;
    char text[ROW_TEXT];
    snprintf(text, sizeof text, "%.1f of %.*f N", plain(n), full < 10 ? 1 : 0, full);
    add(t, name, share < 0.8 ? WHITE : RED, text);
    t->row[t->rows - 1].share = share;
}

uint32_t sim_hud_depth_colour(double reached_mm, double planned_mm)
{
    return planned_mm <= 0 || reached_mm < planned_mm + 0.05 ? WHITE : reached_mm <= planned_mm + 1 ? AMBER : RED;
}

static table device_table(const sim_hud_facts *f)
{
    table t = {0};
    char text[ROW_TEXT];
    add(&t, "tool",
        f->fault      ? RED
        : f->touching ? AMBER
                      : GREEN,
        f->fault      ? f->fault
        : f->touching ? "in the bone"
                      : "free");
    if (f->force_given) {
        add_force(&t, "contact force", f->contact_n, f->contact_full_n);
        add_force(&t, "hand force", f->force_n, f->force_full_n);
    }
    snprintf(text, sizeof text, "%.1f mm\xc2\xb3", plain(f->removed_mm3));
    add(&t, "removed", WHITE, text);
    if (!f->planned)
        return t;
    const double reached = plain(f->reached_mm);
    if (f->planned_mm > 0)
        snprintf(text, sizeof text, "%.1f of %.1f mm", reached, f->planned_mm);
    else
        snprintf(text, sizeof text, "%.1f mm", reached);
    add(&t, "depth reached", sim_hud_depth_colour(reached, f->planned_mm), text);
    add_angle(&t, "version error", f->back_deg, "retro", "ante");
    add_angle(&t, "inclination error", f->up_deg, "superior", "inferior");
    return t;
}

static table rates_table(const sim_hud_facts *f)
{
    table t = {0};
    char text[ROW_TEXT], count[FORMAT_TEXT];
    if (f->rates && f->timings) {
        snprintf(text, sizeof text, "%.0f a second", f->ticks_s);
        add(&t, "ticks", f->ticks_s > 990 ? WHITE : AMBER, text);
        snprintf(text, sizeof text, "%.0f us", f->takes_us);
        add(&t, "one takes", WHITE, text);
    }
    if (f->timings)
        add(&t, "deadlines missed", f->missed ? AMBER : WHITE, format_count(count, (int64_t)f->missed));
    if (f->rates && f->timings) {
        snprintf(text, sizeof text, "%.0f a second, %.1f ms", f->frames_s, f->frame_ms);
        add(&t, "frames", WHITE, text);
    }
    snprintf(text, sizeof text, "%d:%02d%s", (int)(f->seconds / 60), (int)f->seconds % 60,
             f->recording ? ", recorded" : "");
    add(&t, "operation", f->recording ? GREEN : PALE, text);
    if (f->filming) {
        snprintf(text, sizeof text, "%s left out", format_count(count, (int64_t)f->dropped));
        add(&t, "video", f->dropped ? AMBER : GREEN, text);
    }
    return t;
}

static double bar_units(const table *t)
{
    double units = 0;
    for (int i = 0; i < t->rows; i++)
        units += t->row[i].share >= 0 ? 10 : 0;
    return units;
}

enum { STEP = 21, MARGIN = 12, INSIDE = 14, GAP = 18 };

/* Returns the rectangle of a table. The table is as wide as its widest row. */
static sim_hud_box table_box(const sim_hud *h, const table *t, int least, bool title)
{
    int width = px(h, least);
    for (int i = 0; i < t->rows; i++) {
        const int w = ost_lettering_width(h->plain, t->row[i].name) + px(h, GAP) +
                      ost_lettering_width(h->plain, t->row[i].value);
        width = w > width ? w : width;
    }
    return (sim_hud_box){0, 0, width + px(h, 2 * INSIDE), px(h, (title ? 26 : 0) + STEP * t->rows + 12 + bar_units(t))};
}

static void draw_table(const sim_hud *h, const ost_sheet *s, const sim_hud_box *box, const table *t, int y)
{
    const int x = box->x + px(h, INSIDE), width = box->width - 2 * px(h, INSIDE);
    for (int i = 0; i < t->rows; i++, y += px(h, STEP)) {
        ost_lettering_draw(h->plain, s, x, y, t->row[i].name, PALE);
        ost_lettering_draw(h->plain, s, x + width - ost_lettering_width(h->plain, t->row[i].value), y, t->row[i].value,
                           t->row[i].colour);
        const double share = t->row[i].share;
        if (share < 0)
            continue;
        y += px(h, 7);
        ost_sheet_box(s, x, y, width, px(h, 4), BAR, 256);
        ost_sheet_box(s, x, y, (int)(width * share), px(h, 4), share < 0.5 ? GREEN : share < 0.8 ? AMBER : RED, 256);
        for (int quarter = 1; quarter < 4; quarter++)
            ost_sheet_box(s, x + width * quarter / 4, y, px(h, 1), px(h, 4), PALE, 256);
        y += px(h, 3);
    }
}

/* ------------------------------------------------------------------ help */

static const char *const help[][2] = {
    {"left drag", "move the tool in the picture's plane"},
    {"wheel, W S", "push the tool along its axis, pull it back"},
    {"shift, left drag", "turn the tool;  Q E about its axis"},
    {"space", "hold: the motor is on, and the tool cuts"},
    {"Tab, shift Tab", "the next tool, the one before"},
    {"Home", "the tool back to where it began"},
    {"right drag, arrows", "look from elsewhere"},
    {"middle drag, shift arrows", "move the picture"},
    {"ctrl wheel, + -", "nearer, farther"},
    {"1 2 3", "operator, en face, lateral"},
    {"4 5 6", "anterior, posterior, superior"},
    {"7 8 0", "along the tool, the whole bone, as it began"},
    {"C, G", "colours of the cut; the planned implant"},
    {"X, page up, down", "clip plane through the bone; move it"},
    {"O, K", "boxes, chunks, axis; where bone goes"},
    {"L", "how punctual loop and frames are"},
    {"F10", "smooth, or the thesis' flat faces"},
    {"F11", "full screen"},
    {"F12", "a picture into this folder, PNG"},
    {"F1, Ctrl Q", "this help, the end"},
};
enum { HELP_ROWS = sizeof help / sizeof *help, HELP_STEP = 21, HELP_KEYS = 200, HELP_WIDTH = 530, HELP_HEAD = 36 };

static void draw_help(const sim_hud *h, const ost_sheet *s, const sim_hud_box *box)
{
    ost_sheet_box(s, box->x, box->y, box->width, box->height, PANEL, LINE);
    ost_lettering_draw(h->large, s, box->x + px(h, 24), box->y + px(h, HELP_HEAD - 8), "Mouse and keys", WHITE);
    for (int i = 0; i < HELP_ROWS; i++) {
        const int y = box->y + px(h, HELP_HEAD + 18 + HELP_STEP * i);
        ost_lettering_draw(h->plain, s, box->x + px(h, 24), y, help[i][0], AMBER);
        ost_lettering_draw(h->plain, s, box->x + px(h, 24 + HELP_KEYS), y, help[i][1], WHITE);
    }
}

/* ------------------------------------------------------------------ foot */

typedef struct foot {
    int lines;
    char line[FOOT_LINES][FOOT_TEXT];
} foot;

/* Breaks a sentence into lines of the given width in pixels. Text that does not fit is omitted. */
static foot foot_of(const sim_hud *h, const char *text, int width)
{
    foot f = {0};
    while (*text && f.lines < FOOT_LINES) {
        char *line = f.line[f.lines];
        size_t used = 0, blank = 0;
        while (text[used] && used < FOOT_TEXT - 1) {
            line[used] = text[used];
            line[used + 1] = '\0';
            if (ost_lettering_width(h->plain, line) > width)
                break;
            if (text[used] == ' ')
                blank = used;
            used++;
        }
        if (used == 0)
            return (foot){0}; /* there is no space for even one letter */
        const bool broken = text[used] && text[used] != ' ' && blank;
        const size_t end = broken ? blank : used;
        line[end] = '\0';
        text += end;
        text += *text == ' ';
        f.lines++;
    }
    return f;
}

static const char *foot_text(const sim_hud_facts *f)
{
    return f->message ? f->message : f->help || f->plain ? "" : "F1: mouse and keys";
}

/* --------------------------------------------------------------------- layout */

static bool apart(const sim_hud_box *a, const sim_hud_box *b)
{
    return !a->width || !b->width || a->x >= b->x + b->width || b->x >= a->x + a->width || a->y >= b->y + b->height ||
           b->y >= a->y + a->height;
}

/*
 * If `box` lies within the frame and overlaps none of the boxes in `before`, returns `box`. If not, returns an empty
 * box.
 */
static sim_hud_box placed(sim_hud_box box, int width, int height, const sim_hud_box *const *before, int count)
{
    bool available = box.width > 0 && box.height > 0 && box.x >= 0 && box.y >= 0 && box.x + box.width <= width &&
                     box.y + box.height <= height;
    for (int i = 0; i < count && available; i++)
        available = apart(&box, before[i]);
    return available ? box : (sim_hud_box){0};
}

sim_hud_layout sim_hud_arrange(const sim_hud *h, int width, int height, const sim_hud_facts *f)
{
    sim_hud_layout l = {0};
    const sim_hud_box *all[] = {&l.help,  &l.device,  &l.scale,   &l.foot,   &l.legend,
                                &l.rates, &l.edge[0], &l.edge[1], &l.edge[2]};
    const table device = device_table(f), rates = rates_table(f);
    const int margin = px(h, MARGIN);
    if (f->help) {
        const int w = px(h, HELP_WIDTH), t = px(h, HELP_HEAD + HELP_STEP * HELP_ROWS + 14);
        l.help = placed((sim_hud_box){(width - w) / 2, (height - t) / 2, w, t}, width, height, all, 0);
    }
    sim_hud_box box = table_box(h, &device, 208, true);
    box.x = box.y = margin;
    l.device = placed(box, width, height, all, 1);
    box = (sim_hud_box){width - margin - px(h, 158), height - margin - px(h, 34), px(h, 158), px(h, 34)};
    l.scale = placed(box, width, height, all, 2);
    const foot lines = foot_of(h, foot_text(f), (l.scale.width ? l.scale.x : width) - 3 * margin - px(h, 2 * INSIDE));
    if (lines.lines) {
        int widest = 0;
        for (int i = 0; i < lines.lines; i++) {
            const int w = ost_lettering_width(h->plain, lines.line[i]);
            widest = w > widest ? w : widest;
        }
        const int t = px(h, 10 + 20 * lines.lines);
        l.foot = placed((sim_hud_box){margin, height - margin - t, widest + px(h, 2 * INSIDE), t}, width, height, all,
                        3);
    }
    ost_legend_size(&f->legend, h->unit, &box.width, &box.height);
    box.x = margin;
    box.y = (l.foot.width ? l.foot.y - margin / 2 : height - margin) - box.height;
    l.legend = placed(box, width, height, all, 4);
    if (!l.legend.width) {
        box.x = width - margin - box.width;
        box.y = (l.scale.width ? l.scale.y - margin / 2 : height - margin) - box.height;
        l.legend = placed(box, width, height, all, 4);
    }
    box = table_box(h, &rates, 178, false);
    box.x = width - margin - box.width;
    box.y = margin;
    l.rates = placed(box, width, height, all, 5);
    if (!l.rates.width && l.device.width) { /* the frame is tall and narrow */
        box.x = margin;
        box.y = l.device.y + l.device.height + margin / 2;
        l.rates = placed(box, width, height, all, 5);
    }
    for (int e = 0; e < 4; e++) {
        char letters[4];
        ost_edge_letters(f->right, f->up, e, letters);
        if (!letters[0])
            continue;
        const int w = ost_lettering_width(h->plain, letters) + px(h, 8), t = px(h, PLAIN + 10);
        box = (sim_hud_box){e == 0   ? margin
                            : e == 1 ? width - margin - w
                                     : (width - w) / 2,
                            e == 2   ? margin
                            : e == 3 ? height - margin - t
                                     : (height - t) / 2,
                            w, t};
        l.edge[e] = placed(box, width, height, all, 6 + e);
    }
    return l;
}

void sim_hud_draw(const sim_hud *hud, const ost_sheet *sheet, const sim_hud_facts *facts)
{
    const sim_hud_layout l = sim_hud_arrange(hud, sheet->width, sheet->height, facts);
    if (l.device.width) {
        const table t = device_table(facts);
        char text[FORMAT_TEXT];
        ost_sheet_box(sheet, l.device.x, l.device.y, l.device.width, l.device.height, PANEL, SHADE);
        ost_lettering_draw(hud->large, sheet, l.device.x + px(hud, INSIDE), l.device.y + px(hud, 26), facts->tool,
                           WHITE);
        if (facts->tools > 1) {
            snprintf(text, sizeof text, "%d of %d", facts->number, facts->tools);
            ost_lettering_draw(hud->plain, sheet,
                               l.device.x + l.device.width - px(hud, INSIDE) - ost_lettering_width(hud->plain, text),
                               l.device.y + px(hud, 26), text, PALE);
        }
        draw_table(hud, sheet, &l.device, &t, l.device.y + px(hud, 26 + STEP + 3));
    }
    if (l.rates.width) {
        const table t = rates_table(facts);
        ost_sheet_box(sheet, l.rates.x, l.rates.y, l.rates.width, l.rates.height, PANEL, SHADE);
        draw_table(hud, sheet, &l.rates, &t, l.rates.y + px(hud, STEP + 1));
    }
    if (l.legend.width)
        ost_legend_draw(&facts->legend, hud->plain, sheet, l.legend.x, l.legend.y + l.legend.height, hud->unit);
    if (l.scale.width)
        ost_scale_bar(hud->plain, sheet, l.scale.x + l.scale.width - px(hud, 4),
                      l.scale.y + l.scale.height - px(hud, 4), false, px(hud, 150), facts->mm_per_pixel, hud->unit,
                      PALE);
    for (int e = 0; e < 4; e++)
        if (l.edge[e].width) {
            char letters[4];
            ost_edge_letters(facts->right, facts->up, e, letters);
            ost_sheet_box(sheet, l.edge[e].x, l.edge[e].y, l.edge[e].width, l.edge[e].height, PANEL, SHADE);
            ost_lettering_draw(hud->plain, sheet, l.edge[e].x + px(hud, 5), l.edge[e].y + l.edge[e].height - px(hud, 5),
                               letters, PALE);
        }
    if (l.foot.width) {
        const foot lines = foot_of(hud, foot_text(facts), l.foot.width - px(hud, 2 * INSIDE));
        ost_sheet_box(sheet, l.foot.x, l.foot.y, l.foot.width, l.foot.height, PANEL, SHADE);
        for (int i = 0; i < lines.lines; i++)
            ost_lettering_draw(hud->plain, sheet, l.foot.x + px(hud, INSIDE), l.foot.y + px(hud, 20 * (i + 1)),
                               lines.line[i], facts->message ? WHITE : PALE);
    }
    if (l.help.width)
        draw_help(hud, sheet, &l.help);
}

void sim_hud_draw_message(const sim_hud *hud, const ost_sheet *sheet, const char *sentence)
{
    ost_sheet_box(sheet, 0, 0, sheet->width, sheet->height, BACK, 256);
    const foot lines = foot_of(hud, sentence, sheet->width - 2 * px(hud, MARGIN));
    for (int i = 0; i < lines.lines; i++)
        ost_lettering_draw(hud->plain, sheet, (sheet->width - ost_lettering_width(hud->plain, lines.line[i])) / 2,
                           sheet->height / 2 + px(hud, 20 * i), lines.line[i], PALE);
}
