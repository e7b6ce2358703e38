/* SPDX-License-Identifier: Apache-2.0 */
#include "app/picture/chart.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "render/points/frame.h"

enum { BACK = 0x201a16, INK = 0xf0e8e0, PALE = 0xb9b2aa, AMBER = 0x50c8ff, FULL = 256 }; /* 0xBBGGRR */
/*
 * Lengths in pixels. CAPITAL and TITLE are the heights of capitals, LINE is the distance between baselines, and
 * SQUARE is the side of a coloured square.
 */
enum { CAPITAL = 11, TITLE = 15, LINE = 22, KEY_WIDTH = 128, SQUARE = 14, TITLE_BASELINE = 38 };

chart_row *chart_add(chart_table *table, const char *key, const char *format, ...)
{
    /* If the table is full, the new row replaces the last row, and the omitted rows are counted. */
    if (table->count == CHART_ROWS_MAX) {
        table->omitted++;
        table->count--;
    }
    chart_row *row = &table->row[table->count++];
    va_list args;
    *row = (chart_row){.colour = CHART_NO_COLOUR};
    snprintf(row->key, sizeof row->key, "%s", key);
    va_start(args, format);
    vsnprintf(row->text, sizeof row->text, format, args);
    va_end(args);
    return row;
}

ost_status chart_begin(chart *p, int width, int height, ost_error *err)
{
    *p = (chart){.sheet = {.stride = width, .width = width, .height = height}};
    ost_status status = ost_lettering_create(CAPITAL, &p->text, err);
    if (status == OST_OK)
        status = ost_lettering_create(TITLE, &p->title, err);
    if (status != OST_OK)
        return status;
    p->sheet.pixels = malloc((size_t)width * (size_t)height * sizeof *p->sheet.pixels);
    if (!p->sheet.pixels)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for a picture of %d x %d pixels", width, height);
    ost_sheet_box(&p->sheet, 0, 0, width, height, BACK, FULL);
    return OST_OK;
}

void chart_free(chart *p)
{
    ost_lettering_free(p->text);
    ost_lettering_free(p->title);
    free(p->sheet.pixels);
    *p = (chart){.text = NULL};
}

void chart_put(chart *p, const ost_picture *picture, int x, int y)
{
    for (int j = 0; j < picture->height && y + j < p->sheet.height; j++)
        for (int i = 0; i < picture->width && x + i < p->sheet.width; i++) {
            const uint8_t *rgb = picture->rgb + 3 * ((size_t)j * (size_t)picture->width + (size_t)i);
            p->sheet.pixels[(size_t)(y + j) * (size_t)p->sheet.stride + (size_t)(x + i)] =
                rgb[0] | (uint32_t)rgb[1] << 8 | (uint32_t)rgb[2] << 16;
        }
}

void chart_title(chart *p, const char *text)
{
    ost_lettering_draw(p->title, &p->sheet, CHART_MARGIN, TITLE_BASELINE, text, INK);
}

void chart_text(chart *p, int x, int y, const char *text)
{
    ost_lettering_draw(p->text, &p->sheet, x, y, text, PALE);
}

/*
 * Returns the number of bytes of the text that fit into the width. The line contains as many words as possible. If the
 * first word is too long, the word is divided after at least one character.
 */
static size_t line_length(const ost_lettering *letters, const char *text, int width)
{
    char line[CHART_TEXT];
    size_t fits = 0, words = 0;
    for (size_t n = 1; n <= strlen(text); n++) {
        memcpy(line, text, n);
        line[n] = '\0';
        if (ost_lettering_width(letters, line) > width)
            return words ? words : fits ? fits : 1;
        fits = n;
        if (text[n] == ' ' || !text[n])
            words = n;
    }
    return fits;
}

/* Draws a string in several lines and returns the number of lines. If `draw` is false, the lines are only counted. */
static int wrapped(const chart *p, const char *text, int x, int y, int width, uint32_t colour, bool draw)
{
    int lines = 0;
    while (*text) {
        char line[CHART_TEXT];
        const size_t n = line_length(p->text, text, width);
        memcpy(line, text, n);
        line[n] = '\0';
        if (draw)
            ost_lettering_draw(p->text, &p->sheet, x, y + LINE * lines, line, colour);
        lines++;
        text += n;
        text += strspn(text, " ");
    }
    return lines;
}

void chart_put_table(chart *p, const chart_table *table, int x, int y, int width, int height)
{
    const int last = y + height;
    int at = y + CAPITAL;
    for (int i = 0; i < table->count; i++) {
        const chart_row *row = &table->row[i];
        const int lines = wrapped(p, row->text, 0, 0, width - KEY_WIDTH, 0, false);
        const bool is_last = i + 1 == table->count && !table->omitted;
        if (at + LINE * (lines - 1) > last || (!is_last && at + LINE * lines > last)) {
            char text[CHART_TEXT];
            snprintf(text, sizeof text, "... and %d more lines in the output of the command",
                     table->count - i + table->omitted);
            ost_lettering_draw(p->text, &p->sheet, x, at, text, PALE);
            return;
        }
        if (row->colour != CHART_NO_COLOUR)
            ost_sheet_box(&p->sheet, x + KEY_WIDTH - SQUARE - 8, at - (CAPITAL + SQUARE) / 2, SQUARE, SQUARE,
                          row->colour, FULL);
        ost_lettering_draw(p->text, &p->sheet, x, at, row->key, row->warning ? AMBER : PALE);
        at += LINE * wrapped(p, row->text, x + KEY_WIDTH, at, width - KEY_WIDTH, row->warning ? AMBER : INK, true);
    }
}

ost_status chart_end(const chart *p, ost_picture *out, ost_error *err)
{
    ost_status status = ost_picture_init(out, p->sheet.width, p->sheet.height, err);
    if (status == OST_OK)
        ost_colours_copy(p->sheet.pixels, p->sheet.stride, out);
    return status;
}
