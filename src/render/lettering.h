/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Draws letters over a frame, at any size. The strokes of the letters have a uniform width and
 * round ends. For each size, every letter is rasterized once to a bitmap of pixel coverage. ASCII,
 * the degree sign and the raised three are supported; all other characters are left blank.
 */
#ifndef OST_RENDER_LETTERING_H
#define OST_RENDER_LETTERING_H

#include <stdbool.h>
#include <stdint.h>

#include <osteon/status.h>

#include "render/points/cells.h"

typedef struct ost_lettering ost_lettering;

/*
 * The pixels on which letters are drawn. A pixel has the form 0xAABBGGRR; the first row is the top row. AA is the
 * opacity. If all pixels were 0 before, a sheet contains what was drawn as a transparent layer, whose colours are
 * multiplied by their opacity: over a picture with the colour c, the layer's pixel p gives p + c (255 - AA) / 255.
 * Sheets of pictures have any opacity.
 */
typedef struct ost_sheet {
    uint32_t *pixels;
    int stride, width, height;
    const ost_cells *written; /* if not NULL, the set of cells to which the cells with drawn pixels are added */
} ost_sheet;

/* Creates letters of one size. The parameter `height` is the height of a capital letter in pixels, from 5 to 200. */
ost_status ost_lettering_create(double height, ost_lettering **out, ost_error *err);
void ost_lettering_free(ost_lettering *lettering); /* accepts NULL */

int ost_lettering_width(const ost_lettering *lettering, const char *text);
/* Draws a line of text and clips it to the sheet. The text begins at x, and its baseline is at y. */
void ost_lettering_draw(const ost_lettering *lettering, const ost_sheet *sheet, int x, int y, const char *text,
                        uint32_t colour);

/* Blends a box of one colour over the sheet. The opacity alpha is at most 256, which means opaque. */
void ost_sheet_box(const ost_sheet *sheet, int x, int y, int width, int height, uint32_t colour, unsigned alpha);

#endif
