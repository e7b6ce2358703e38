/* SPDX-License-Identifier: Apache-2.0 */
#include "render/legend.h"

#include <stdio.h>

enum { WHITE = 0xf4f1ee, PALE = 0xb9b2aa, PANEL = 0x0e0c0a, SHADE = 200, FULL = 256 };
enum { WIDTH = 236, STEP = 21, EDGE = 14, BAR = 12 };

typedef struct page {
    const ost_lettering *letters;
    const ost_sheet *sheet;
    int x, y;
    double unit;
} page;

static int px(const page *p, double units)
{
    return (int)(units * p->unit + 0.5);
}

static void bar(page *p, const char *title, uint32_t (*colour)(int step), bool backwards, const char *const mark[3])
{
    const int width = px(p, WIDTH), thick = px(p, BAR);
    ost_lettering_draw(p->letters, p->sheet, p->x, p->y, title, WHITE);
    p->y += px(p, 10);
    for (int i = 0; i < width; i++) {
        const int step = i * OST_SCALE / width;
        ost_sheet_box(p->sheet, p->x + i, p->y, 1, thick, colour(backwards ? OST_SCALE - 1 - step : step), FULL);
    }
    p->y += thick + px(p, 16);
    for (int i = 0; i < 3; i++) {
        const int w = ost_lettering_width(p->letters, mark[i]);
        ost_lettering_draw(p->letters, p->sheet, p->x + (width - w) * i / 2, p->y, mark[i], PALE);
    }
    p->y += px(p, STEP + 4);
}

static void tissues(page *p, bool plate)
{
    static const ost_tissue order[] = {OST_TISSUE_CARTILAGE, OST_TISSUE_PLATE, OST_TISSUE_CANCELLOUS,
                                       OST_TISSUE_CORTICAL};
    for (int i = 0; i < OST_TISSUES; i++) {
        if (order[i] == OST_TISSUE_PLATE && !plate)
            continue;
        ost_sheet_box(p->sheet, p->x, p->y - px(p, 10), px(p, 16), px(p, 12), ost_tissue_colours[order[i]], FULL);
        ost_lettering_draw(p->letters, p->sheet, p->x + px(p, 26), p->y, ost_tissue_names[order[i]], WHITE);
        p->y += px(p, STEP);
    }
}

enum { BAR_HEIGHT = 10 + BAR + 16 + STEP + 4 };

void ost_legend_size(const ost_legend *legend, double unit, int *width, int *height)
{
    const page p = {NULL, NULL, 0, 0, unit};
    const bool by_class = legend->colouring == OST_COLOUR_CLASS;
    const int bars = (legend->colouring == OST_COLOUR_DEPTH) + (legend->colouring == OST_COLOUR_DENSITY) +
                     (legend->window && !by_class);
    const int lines = by_class ? OST_TISSUES - !legend->plate : 0;
    *width = bars + lines ? px(&p, WIDTH + 2 * EDGE) : 0;
    *height = bars + lines ? px(&p, BAR_HEIGHT * bars + STEP * lines + EDGE) : 0;
}

void ost_legend_draw(const ost_legend *legend, const ost_lettering *lettering, const ost_sheet *sheet, int x, int y,
                     double unit)
{
    page p = {lettering, sheet, x + (int)(EDGE * unit), y, unit};
    const bool by_class = legend->colouring == OST_COLOUR_CLASS;
    int wide, high;
    ost_legend_size(legend, unit, &wide, &high);
    char last[32], half[32], black[32], white[32], middle[32];
    if (!wide)
        return;
    ost_sheet_box(sheet, x, y - high, wide, high, PANEL, SHADE);
    p.y = y - high + px(&p, EDGE + 11);
    snprintf(last, sizeof last, "%g mm", legend->scale_mm);
    snprintf(half, sizeof half, "%g", legend->scale_mm / 2);
    snprintf(black, sizeof black, "%d", OST_WINDOW_BLACK);
    snprintf(white, sizeof white, "%d HU", OST_WINDOW_WHITE);
    snprintf(middle, sizeof middle, "%d", (OST_WINDOW_WHITE + OST_WINDOW_BLACK) / 2);
    if (legend->colouring == OST_COLOUR_DEPTH)
        bar(&p, "depth below the old surface", ost_scale_colour, false, (const char *const[3]){"0", half, last});
    if (legend->colouring == OST_COLOUR_DENSITY)
        bar(&p, "density", ost_scale_colour, true, (const char *const[3]){black, middle, white});
    if (legend->window && !by_class)
        bar(&p, "density in the plane", ost_window_grey, false, (const char *const[3]){black, middle, white});
    if (by_class)
        tissues(&p, legend->plate);
}
