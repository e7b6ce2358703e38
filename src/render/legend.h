/* SPDX-License-Identifier: Apache-2.0 */
/* What the colours of a frame mean, written over it. */
#ifndef OST_RENDER_LEGEND_H
#define OST_RENDER_LEGEND_H

#include "render/lettering.h"
#include "render/points/palette.h"

typedef struct ost_legend {
    ost_colouring colouring;
    double scale_mm;   /* of OST_COLOUR_DEPTH: what its last colour stands for */
    bool plate;        /* of OST_COLOUR_CLASS: the subchondral plate is told apart */
    bool window;       /* a clip plane shows the CT's greys */
} ost_legend;

/* 0 x 0 for plain bone without a plane. */
void ost_legend_size(const ost_legend *legend, double unit, int *width, int *height);
/* Its lower left corner at x, y; unit: pixels of one at 96 to the inch. Nothing for plain bone without a plane. */
void ost_legend_draw(const ost_legend *legend, const ost_lettering *lettering, const ost_sheet *sheet, int x, int y, double unit);

#endif
