/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The marks over a picture: a scale bar, the patient's directions at its edges
 * as on a radiograph, and a legend of its colours.
 *
 *   .-------- S --------.
 *   |                   |      the bar is exact at the point that the camera is
 *   P                   A      directed at; nearer parts are larger
 *   | [legend]   |---|  |
 *   '-------- I --------'
 */
#ifndef OST_RENDER_MARKS_H
#define OST_RENDER_MARKS_H

#include "render/legend.h"

/* The marks are designed for a picture 720 pixels high, in units of a pixel. */
enum { OST_MARKS_MARGIN = 12 };
#define OST_MARKS_LETTER 9.5 /* height of capitals in units */
/* Returns the size of a unit in pixels for a picture of the given height. */
double ost_marks_unit(int height);

/* Returns the greatest 1, 2 or 5 times a power of ten that is at most `most`, but at least 0.001. */
double ost_round_down(double most);

/*
 * Writes the letters of a direction in the patient: the axis with the greatest component first, then
 * others that are large enough.  LPS+ frame; "S" and "I" for superior and inferior; "" for a zero vector.
 */
void ost_orientation_letters(const double direction[3], char letters[4]);
/* Does so for the edges of a picture: 0 left, 1 right, 2 upper, 3 lower. right, up: the
   picture's axes in the patient. */
void ost_edge_letters(const double right[3], const double up[3], int edge, char letters[4]);

/*
 * Draws a bar with its length above it, its foot at y.  The length is the greatest 1, 2 or 5 times a
 * power of ten of millimetres that is at most `longest` pixels long.  x: the bar's right end, or its
 * left end if from_left is true.
 */
void ost_scale_bar(const ost_lettering *letters, const ost_sheet *sheet, int x, int y, bool from_left, int longest,
                   double mm_per_pixel, double unit, uint32_t colour);

typedef struct ost_marks {
    double right[3], up[3]; /* the picture's axes in the patient, unit vectors; zero if they are not known */
    double mm_per_pixel;    /* 0: no scale bar */
    ost_legend legend;
} ost_marks;

/* Draws all marks that fit. letters: OST_MARKS_LETTER units high. */
void ost_marks_draw(const ost_marks *marks, const ost_lettering *letters, const ost_sheet *sheet, double unit);

#endif
