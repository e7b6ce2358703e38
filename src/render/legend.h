/* SPDX-License-Identifier: Apache-2.0 */
/* Draws a legend of the colours over a frame. */
#ifndef OST_RENDER_LEGEND_H
#define OST_RENDER_LEGEND_H

#include "render/lettering.h"
#include "render/points/palette.h"

typedef struct ost_legend {
    ost_colouring colouring;
    double scale_mm;   /* depth of the last colour, in mm; used only with OST_COLOUR_DEPTH */
    bool plate;        /* true if the subchondral plate has its own colour; used only with OST_COLOUR_CLASS */
    bool window;       /* true if a clip plane shows the inside of the bone in the CT's grey values */
} ost_legend;

/* Computes the size of the legend in pixels; 0 x 0 for plain bone without a clip plane. */
void ost_legend_size(const ost_legend *legend, double unit, int *width, int *height);
/*
 * Draws the legend with its lower left corner at (x, y). `unit` is the number of pixels per 1/96 inch. Draws nothing
 * for plain bone without a clip plane.
 */
void ost_legend_draw(const ost_legend *legend, const ost_lettering *lettering, const ost_sheet *sheet, int x, int y,
                     double unit);

#endif
