/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Drawing on a picture: rectangles, blended pixels, small text, scale bars.
 * All functions clip to the picture, and none can fail.
 */
#ifndef OST_RENDER_CANVAS_H
#define OST_RENDER_CANVAS_H

#include <osteon/picture.h>

typedef struct ost_rgb {
    uint8_t r, g, b;
} ost_rgb;

void ost_canvas_blend(ost_picture *picture, int x, int y, ost_rgb colour, double alpha);
void ost_canvas_rect(ost_picture *picture, int x, int y, int width, int height, ost_rgb colour, double alpha);

/* Glyphs are 5 x 7 dots (font.c) of `scale` pixels; characters that the font lacks are blank. x, y: top left corner. */
enum { OST_GLYPH_WIDTH = 5, OST_GLYPH_HEIGHT = 7, OST_GLYPH_ADVANCE = 6 };
int ost_canvas_text_width(const char *text, int scale);
void ost_canvas_text(ost_picture *picture, int x, int y, int scale, ost_rgb colour, const char *text);
/* Returns the rows of one glyph, top first, bit 4 the leftmost dot; NULL if the font lacks it. */
const uint8_t *ost_font_glyph(char c);

/*
 * Draws a bar with its length above it, its left end at x and its foot at y.
 * The length is the greatest 1, 2 or 5 times a power of ten of millimetres
 * that is at most `max_pixels` long.
 */
void ost_canvas_scale_bar(ost_picture *picture, int x, int y, int max_pixels, double mm_per_pixel, int scale, ost_rgb colour);

/*
 * Writes the letters of a direction of the picture in the patient, as on a
 * radiograph: the axis with the greatest component first, then others that are
 * large enough.  LPS+ frame; "S" and "I" for superior and inferior.
 */
void ost_orientation_letters(const double direction[3], char letters[4]);

#endif
