/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Draws marks over a picture: a scale bar, the anatomical directions at the picture's edges as on a radiograph, and a
 * legend of the colours.
 *
 *   .-------- S --------.
 *   |                   |      the bar is exact at the point at which the
 *   P                   A      camera is directed; nearer parts are larger
 *   | [legend]   |---|  |
 *   '-------- I --------'
 */
#ifndef OST_RENDER_MARKS_H
#define OST_RENDER_MARKS_H

#include "render/legend.h"

/* The marks are designed in units; a unit is one pixel in a picture 720 pixels high. */
enum { OST_MARKS_MARGIN = 12 };
#define OST_MARKS_LETTER 9.5 /* height of capitals in units */
/* Returns the size of a unit in pixels for a picture of the given height. */
double ost_marks_unit(int height);

/* Rounds down to 1, 2 or 5 times a power of ten. The result is at least 0.001. */
double ost_round_down(double most);

/*
 * Writes the letters of an anatomical direction. The first letter names the axis with the greatest component. Letters
 * of other axes follow if their components are large enough. The frame is LPS+; "S" and "I" mean superior and inferior.
 * Writes "" for a zero vector.
 */
void ost_orientation_letters(const double direction[3], char letters[4]);
/* Writes the letters of the anatomical direction toward an edge of the picture: 0 left, 1 right, 2 upper, 3 lower.
   `right` and `up` are the picture's axes in the patient's frame. */
void ost_edge_letters(const double right[3], const double up[3], int edge, char letters[4]);

/*
 * Draws a scale bar with its lower edge at y, and writes its length in millimetres above it. The length is 1, 2 or 5
 * times a power of ten, and as large as possible for a bar of at most `longest` pixels. x is the left end of the bar if
 * from_left is true, otherwise the right end.
 */
void ost_scale_bar(const ost_lettering *letters, const ost_sheet *sheet, int x, int y, bool from_left, int longest,
                   double mm_per_pixel, double unit, uint32_t colour);

typedef struct ost_marks {
    /* unit vectors of the picture's axes in the patient's frame; zero vectors if the axes are unknown */
    double right[3], up[3];
    double mm_per_pixel;    /* size of a pixel in mm; 0 for no scale bar */
    ost_legend legend;
} ost_marks;

/* Draws all marks for which there is space. The letters must be OST_MARKS_LETTER units high. */
void ost_marks_draw(const ost_marks *marks, const ost_lettering *letters, const ost_sheet *sheet, double unit);

#endif
