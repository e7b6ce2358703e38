/* SPDX-License-Identifier: Apache-2.0 */
#include "render/points/palette.h"

const char *const ost_tissue_names[OST_TISSUES] = {"cartilage", "cancellous", "cortical", "subchondral plate"};
const uint32_t ost_tissue_colours[OST_TISSUES] = {0xe8bd6a, 0x2f4fc4, 0xb6b9c6, 0x4fc4ee};

const uint32_t ost_label_colours[OST_LABELS] = {0x005ed5, 0xe9b456, 0x42e4f0, 0xa779cc, 0x739e00, 0xd08a3c, 0xb8b0a8};

uint32_t ost_label_colour(int label)
{
    return ost_label_colours[label < OST_LABELS ? label : OST_LABELS - 1];
}

/* Colours of the scale as red, green, blue, from light to dark. */
static const uint8_t stops[][3] = {{246, 226, 74}, {143, 207, 90}, {53, 165, 138},
                                   {43, 111, 142}, {59, 58, 125},  {45, 15, 74}};
enum { STOPS = sizeof stops / sizeof *stops, LAST = OST_SCALE - 1 };

uint32_t ost_scale_colour(int step)
{
    const int at = step * (STOPS - 1), from = at / LAST < STOPS - 1 ? at / LAST : STOPS - 2, part = at - from * LAST;
    uint32_t colour = 0;
    for (int c = 0; c < 3; c++)
        colour |= (uint32_t)((stops[from][c] * (LAST - part) + stops[from + 1][c] * part + LAST / 2) / LAST) << (8 * c);
    return colour;
}

uint32_t ost_window_grey(int step)
{
    return (uint32_t)((step * 255 + LAST / 2) / LAST) * 0x010101u;
}

int ost_window_step(int density)
{
    const int step = ((density - OST_WINDOW_BLACK) * LAST + (OST_WINDOW_WHITE - OST_WINDOW_BLACK) / 2) /
                     (OST_WINDOW_WHITE - OST_WINDOW_BLACK);
    return step < 0 ? 0 : step > LAST ? LAST : step;
}

void ost_palette_make(ost_colouring colouring, uint32_t palette[OST_PAINTS])
{
    palette[0] = 0;
    for (int i = 0; i < OST_SCALE; i++) {
        palette[OST_PAINT_LIT + i] = ost_scale_colour(i);
        palette[OST_PAINT_FLAT + i] = ost_window_grey(i);
    }
    palette[OST_PAINTS - 1] = palette[OST_PAINTS - 2];
    for (int t = 0; t < OST_TISSUES && colouring == OST_COLOUR_CLASS; t++)
        palette[OST_PAINT_LIT + t] = palette[OST_PAINT_FLAT + t] = ost_tissue_colours[t];
    for (int l = 0; l < OST_LABELS && colouring == OST_COLOUR_LABEL; l++)
        palette[OST_PAINT_LIT + l] = palette[OST_PAINT_FLAT + l] = ost_label_colours[l];
}
