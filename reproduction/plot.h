/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Draws a plot as SVG: lines with markers, or groups of bars.
 *
 *      title
 *      y |        o                 o---o this run        series differ in colour, marker and dashes, so that
 *        |   o  /                   +- -+ thesis          they can be distinguished in grey and by colour-blind
 *        |  / \/                                          readers (colours of Okabe and Ito)
 *        '--------- x
 *
 * The values of the thesis are black with hollow markers and dashes; the thesis' bars are white or grey with a dashed
 * outline. Sizes are in units of 1/96 inch. Values that a logarithmic axis cannot show (0 and less) are omitted.
 */
#ifndef OST_REPRODUCTION_PLOT_H
#define OST_REPRODUCTION_PLOT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

enum { PLOT_SERIES = 24, PLOT_LABEL = 200, PLOT_TICKS = 64 };

typedef struct plot_series {
    char label[PLOT_LABEL];
    bool thesis;            /* true if the thesis states the values */
    size_t count;
    const double *x, *y;    /* borrowed; in a plot with bars, x is the index of the category */
} plot_series;

typedef struct plot {
    const char *title, *x_label, *y_label;
    bool bars, log_x, log_y;
    const char *const *category; /* names of the groups of bars, borrowed */
    size_t categories;
    int count;
    plot_series series[PLOT_SERIES];
} plot;

/* Writes the plot as a complete SVG document. The document has no XML declaration, so it can also be a part of a page.
   A plot without values contains a sentence that states this. */
void plot_write(FILE *to, const plot *p);

/*
 * Writes a string as XML text. The characters < > & and quotation marks become entities, and control characters
 * become '?'.
 */
void plot_text(FILE *to, const char *text);

/* A linear or logarithmic axis, and the values of its ticks. */
typedef struct plot_axis {
    bool log;
    double least, most; /* ends of the axis, least < most */
    int count;
    double tick[PLOT_TICKS];
} plot_axis;

/*
 * Selects the ends and the ticks of an axis for values in the range [least, most]. A linear axis has ticks at
 * multiples of 1, 2 or 5 times a power of ten. It begins at 0 if the flag `zero` is set and no value is negative. A
 * logarithmic axis has ticks at powers of ten or, if it spans less than two decades, at 1, 2 and 5 times powers of ten.
 */
plot_axis plot_axis_make(double least, double most, bool log, bool zero);
/* Returns the position of a value on the axis: 0 at its beginning and 1 at its end. */
double plot_axis_at(const plot_axis *axis, double value);

#endif
