/* SPDX-License-Identifier: Apache-2.0 */
#include "render/marks.h"

#include <math.h>
#include <stdio.h>

enum { WHITE = 0xf4f1ee, PALE = 0xb9b2aa, PANEL = 0x0e0c0a, SHADE = 200, FULL = 256 };
/* The limit LONGEST is in units (marks.h); the other sizes are in pixels. */
enum { LEAST_WIDTH = 160, LEAST_HEIGHT = 120, LEGEND_WIDTH = 430, LONGEST = 150 };

double ost_marks_unit(int height)
{
    return fmin(20, fmax(0.75, height / 720.0));
}

double ost_round_down(double most)
{
    double out = 1e-3;
    for (double decade = 1e-3; decade <= most; decade *= 10)
        for (int step = 1; step <= 5; step += step == 1 ? 1 : 3)
            out = step * decade <= most * (1 + 1e-9) ? step * decade : out;
    return out;
}

void ost_orientation_letters(const double direction[3], char letters[4])
{
    static const char names[3][2] = {{'R', 'L'}, {'A', 'P'}, {'I', 'S'}};
    double size[3], square = 0;
    bool used[3] = {false, false, false};
    int n = 0;
    for (int a = 0; a < 3; a++) {
        size[a] = fabs(direction[a]);
        square += size[a] * size[a];
    }
    while (n < 3 && square > 0) {
        int best = -1;
        for (int a = 0; a < 3; a++)
            if (!used[a] && (best < 0 || size[a] > size[best]))
                best = a;
        /* stops if the largest remaining component is below sin(20 degrees) times the vector's length */
        if (n > 0 && size[best] * size[best] < 0.12 * square)
            break;
        used[best] = true;
        letters[n++] = names[best][direction[best] > 0];
    }
    letters[n] = '\0';
}

void ost_edge_letters(const double right[3], const double up[3], int edge, char letters[4])
{
    double direction[3];
    for (int a = 0; a < 3; a++)
        direction[a] = (edge == 0 || edge == 3 ? -1 : 1) * (edge < 2 ? right[a] : up[a]);
    ost_orientation_letters(direction, letters);
}

void ost_scale_bar(const ost_lettering *letters, const ost_sheet *sheet, int x, int y, bool from_left, int longest,
                   double mm_per_pixel, double unit, uint32_t colour)
{
    const double most = longest * mm_per_pixel, length = ost_round_down(most);
    char text[32];
    if (!(length <= most * (1 + 1e-9)))
        return;
    const int width = (int)(length / mm_per_pixel + 0.5), thick = (int)(2 * unit + 0.5), end = (int)(7 * unit + 0.5);
    snprintf(text, sizeof text, "%g mm", length);
    const int left = from_left ? x : x - width, wide = ost_lettering_width(letters, text);
    /* the text is centred above the bar, but is shifted if it would extend beyond the bar's end at x */
    int at = left + (width - wide) / 2;
    at = from_left ? (at < left ? left : at) : at + wide > x ? x - wide : at;
    ost_sheet_box(sheet, left, y - thick, width, thick, colour, FULL);
    ost_sheet_box(sheet, left, y - end, thick, end - thick, colour, FULL);
    ost_sheet_box(sheet, left + width - thick, y - end, thick, end - thick, colour, FULL);
    ost_lettering_draw(letters, sheet, at, y - (int)(12 * unit), text, colour);
}

void ost_marks_draw(const ost_marks *marks, const ost_lettering *letters, const ost_sheet *sheet, double unit)
{
    const int width = sheet->width, height = sheet->height, margin = (int)(OST_MARKS_MARGIN * unit);
    int legend_width = 0, legend_height = 0;
    if (width < LEAST_WIDTH || height < LEAST_HEIGHT)
        return;
    if (width >= LEGEND_WIDTH)
        ost_legend_size(&marks->legend, unit, &legend_width, &legend_height);
    if (legend_width)
        ost_legend_draw(&marks->legend, letters, sheet, margin, height - margin, unit);
    if (marks->mm_per_pixel > 0)
        ost_scale_bar(letters, sheet, width - margin, height - margin, false, (int)fmin(LONGEST * unit, width / 4.0),
                      marks->mm_per_pixel, unit, WHITE);
    for (int edge = 0; edge < 4; edge++) {
        char text[4];
        ost_edge_letters(marks->right, marks->up, edge, text);
        const int w = ost_lettering_width(letters, text) + (int)(8 * unit), h = (int)((OST_MARKS_LETTER + 10) * unit);
        const int x = edge == 0 ? margin : edge == 1 ? width - margin - w : (width - w) / 2;
        const int y = edge == 2 ? margin : edge == 3 ? height - margin - h : (height - h) / 2;
        const bool free = x >= margin + legend_width || y + h <= height - margin - legend_height;
        if (!text[0] || !free)
            continue;
        ost_sheet_box(sheet, x, y, w, h, PANEL, SHADE);
        ost_lettering_draw(letters, sheet, x + (int)(5 * unit), y + h - (int)(5 * unit), text, PALE);
    }
}
