/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A chart, which is a picture that contains other pictures and a table of text.
 *
 *   chart_begin --> chart_put, chart_text, chart_table --> chart_end --> picture
 */
#ifndef OST_APP_PICTURE_CHART_H
#define OST_APP_PICTURE_CHART_H

#include <osteon/picture.h>

#include "render/lettering.h"

enum { CHART_ROWS_MAX = 48, CHART_KEY = 24, CHART_TEXT = 480, CHART_MARGIN = 20 };
enum { CHART_NO_COLOUR = 0x7fffffff };

/* A row of a table. It consists of a key or a coloured square, and the text to the right. */
typedef struct chart_row {
    char key[CHART_KEY];
    char text[CHART_TEXT];
    uint32_t colour; /* 0xBBGGRR, or CHART_NO_COLOUR */
    bool warning;    /* true to draw the text in the colour of warnings */
} chart_row;

typedef struct chart_table {
    int count;
    int omitted; /* number of rows that did not fit into the table */
    chart_row row[CHART_ROWS_MAX];
} chart_table;

/* Appends a row to a table and returns it. Text beyond CHART_TEXT - 1 bytes is cut off. */
chart_row *chart_add(chart_table *table, const char *key, const char *format, ...) OST_PRINTF(3, 4);

typedef struct chart {
    ost_sheet sheet; /* owned */
    ost_lettering *text, *title;
} chart;

/* Creates an empty chart. Free it with chart_free, even after an error. */
ost_status chart_begin(chart *c, int width, int height, ost_error *err);
void chart_free(chart *c);
/* Copies a picture to the chart. (x, y) is the upper left corner. Pixels beyond the chart are omitted. */
void chart_put(chart *c, const ost_picture *picture, int x, int y);
void chart_title(chart *c, const char *text);
/* Draws a line of text. x is the left end, and y is the baseline. */
void chart_text(chart *c, int x, int y, const char *text);
/* Draws a table into a box. Long strings are wrapped. If rows do not fit, the last line states their number. */
void chart_put_table(chart *c, const chart_table *table, int x, int y, int width, int height);
/* Copies the chart to a picture. The caller owns *out. */
ost_status chart_end(const chart *c, ost_picture *out, ost_error *err);

#endif
