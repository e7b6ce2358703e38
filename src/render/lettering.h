/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Draws letters over a frame, at any size. Strokes have a uniform width and round ends. For each size, every letter is
 * rasterized once, to a bitmap of pixel coverage. ASCII, the degree sign and the superscript 3 are supported; all other
 * characters are left blank.
 */
#ifndef OST_RENDER_LETTERING_H
#define OST_RENDER_LETTERING_H

#include <stdbool.h>
#include <stdint.h>

#include <osteon/status.h>

#include "render/points/cells.h"

typedef struct ost_lettering ost_lettering;

/*
 * Pixels on which letters are drawn. A pixel is 0xAABBGGRR, where AA is the opacity; the first row is the top row.
 * Letters on pixels that are 0 form a transparent layer, with colours premultiplied by opacity: a pixel p of this layer
 * over a pixel of colour c yields the colour p + c (255 - AA) / 255. Letters can also be drawn directly on the pixels
 * of a picture, where AA has no meaning.
 */
typedef struct ost_sheet {
    uint32_t *pixels;
    int stride, width, height;
    const ost_cells *written; /* if not NULL, the cells that contain drawn pixels are added to this set */
} ost_sheet;

/* Creates letters of one size. `height` is the height of a capital letter in pixels, from 5 to 200. */
ost_status ost_lettering_create(double height, ost_lettering **out, ost_error *err);
void ost_lettering_free(ost_lettering *lettering); /* accepts NULL */

int ost_lettering_width(const ost_lettering *lettering, const char *text);
/* Draws a line of text, clipped to the sheet. The text begins at x, and its baseline is at y. */
void ost_lettering_draw(const ost_lettering *lettering, const ost_sheet *sheet, int x, int y, const char *text,
                        uint32_t colour);

/* Blends a box of one colour over the sheet. `alpha` is the opacity, 0 to 256 (opaque). */
void ost_sheet_box(const ost_sheet *sheet, int x, int y, int width, int height, uint32_t colour, unsigned alpha);

#endif
