/* SPDX-License-Identifier: Apache-2.0 */
#include "reproduction/plot.h"

#include <math.h>
#include <string.h>

enum { WIDTH = 720, TOP = 40, LEFT = 74, RIGHT = 18, PLOT_HEIGHT = 300, LEGEND_LINE = 19, BELOW = 54, NAME_LINE = 15 };

/* Colours of Okabe and Ito, sorted so that neighbours also differ in lightness. */
static const char *const colours[] = {"#0072B2", "#E69F00", "#009E73", "#CC79A7", "#56B4E9", "#D55E00", "#000000"};
static const char *const dashes[] = {"", "7 3", "2 3", "9 3 2 3"};
enum { COLOURS = sizeof colours / sizeof colours[0], DASHES = sizeof dashes / sizeof dashes[0], MARKERS = 5 };

void plot_text(FILE *to, const char *text)
{
    for (; *text; text++)
        switch (*text) {
        case '&': fputs("&amp;", to); break;
        case '<': fputs("&lt;", to); break;
        case '>': fputs("&gt;", to); break;
        case '"': fputs("&quot;", to); break;
        case '\'': fputs("&#39;", to); break;
        default: fputc((unsigned char)*text < ' ' || *text == 127 ? '?' : *text, to);
        }
}

/* ------------------------------------------------------------------- axis */

/* Rounds a positive number up to 1, 2 or 5 times a power of ten. */
static double round_step(double least)
{
    const double power = pow(10, floor(log10(least)));
    const double share = least / power;
    return power * (share <= 1 + 1e-9 ? 1 : share <= 2 + 1e-9 ? 2 : share <= 5 + 1e-9 ? 5 : 10);
}

static plot_axis linear_axis(double least, double most, bool zero)
{
    if (zero && least > 0)
        least = 0;
    if (!(most > least))
        most = least + (least != 0 ? fabs(least) : 1);
    const double step = round_step((most - least) / 6);
    plot_axis axis = {.least = floor(least / step + 1e-9) * step, .most = ceil(most / step - 1e-9) * step};
    for (double i = 0; axis.least + i * step <= axis.most + 1e-6 * step && axis.count < PLOT_TICKS; i++)
        axis.tick[axis.count++] = axis.least + i * step;
    return axis;
}

/* Rounds a value up or down to a tick of a logarithmic axis. Ticks are powers of ten and, on a fine axis, also 2 and 5
   times powers of ten. */
static double log_tick(double value, bool fine, bool up)
{
    static const double mantissa[] = {1, 2, 5, 10};
    const double decade = pow(10, floor(log10(value) + 1e-9));
    double below = decade;
    for (int i = 0; i < 4; i++) {
        const double tick = decade * mantissa[i];
        if ((!fine && (i == 1 || i == 2)) || tick < value * (1 - 1e-9)) {
            below = fine && tick < value ? tick : below;
            continue;
        }
        return up || tick <= value * (1 + 1e-9) ? tick : below;
    }
    return up ? 10 * decade : below;
}

static plot_axis log_axis(double least, double most)
{
    if (!(most > least))
        most = least * 10;
    static const double mantissa[] = {1, 2, 5};
    const bool fine = log10(most / least) < 2;
    plot_axis axis = {.log = true, .least = log_tick(least, fine, false), .most = log_tick(most, fine, true)};
    for (double decade = log_tick(axis.least, false, false); decade <= axis.most * 1.001; decade *= 10)
        for (int i = 0; i < (fine ? 3 : 1) && axis.count < PLOT_TICKS; i++) {
            const double tick = decade * mantissa[i];
            if (tick > axis.least * 0.999 && tick < axis.most * 1.001)
                axis.tick[axis.count++] = tick;
        }
    return axis;
}

plot_axis plot_axis_make(double least, double most, bool log, bool zero)
{
    return log ? log_axis(least, most) : linear_axis(least, most, zero);
}

double plot_axis_at(const plot_axis *axis, double value)
{
    if (axis->log)
        return log(value / axis->least) / log(axis->most / axis->least);
    return (value - axis->least) / (axis->most - axis->least);
}

static bool shows(bool log, double value)
{
    return isfinite(value) && (!log || value > 0);
}

/* Computes the range of the values of one coordinate. Returns false if there are no values. */
static bool range_of(const plot *p, bool of_x, double *least, double *most)
{
    bool any = false;
    for (int s = 0; s < p->count; s++)
        for (size_t i = 0; i < p->series[s].count; i++) {
            const double x = p->series[s].x[i], y = p->series[s].y[i], value = of_x ? x : y;
            if (!shows(p->log_x, x) || !shows(p->log_y, y))
                continue;
            *least = any && *least < value ? *least : value;
            *most = any && *most > value ? *most : value;
            any = true;
        }
    return any;
}

/*
 * Returns the horizontal axis. If the plot has 2 to FEW different values of x, and they are far enough apart, these
 * values are the ticks, and the axis extends a little beyond them.
 */
static plot_axis x_axis(const plot *p, double least, double most)
{
    enum { FEW = 9 };
    /* fractions of the axis' length: the extension at each end, and the least distance between two ticks */
    static const double BEYOND = 0.04, APART = 0.055;
    plot_axis axis = {.log = p->log_x};
    const plot_axis round = plot_axis_make(least, most, p->log_x, false);
    for (int s = 0; s < p->count; s++)
        for (size_t i = 0; i < p->series[s].count; i++) {
            const double value = p->series[s].x[i];
            int at = 0;
            if (!shows(p->log_x, value))
                continue;
            while (at < axis.count && axis.tick[at] < value)
                at++;
            if (at < axis.count && axis.tick[at] == value)
                continue;
            if (axis.count == FEW)
                return round;
            memmove(&axis.tick[at + 1], &axis.tick[at], (size_t)(axis.count - at) * sizeof axis.tick[0]);
            axis.tick[at] = value;
            axis.count++;
        }
    if (axis.count < 2)
        return round;
    axis.least = p->log_x ? least * pow(most / least, -BEYOND) : least - BEYOND * (most - least);
    axis.most = p->log_x ? most * pow(most / least, BEYOND) : most + BEYOND * (most - least);
    for (int i = 1; i < axis.count; i++)
        if (plot_axis_at(&axis, axis.tick[i]) - plot_axis_at(&axis, axis.tick[i - 1]) < APART)
            return round;
    return axis;
}

/* ----------------------------------------------------------------- drawing */

typedef struct canvas {
    FILE *to;
    const plot *p;
    plot_axis x, y;
    double height; /* height of the drawing */
    int below;     /* additional height for category names with more than one line */
} canvas;

static double across(double share)
{
    return LEFT + share * (WIDTH - LEFT - RIGHT);
}

static double down(double share)
{
    return TOP + (1 - share) * PLOT_HEIGHT;
}

/*
 * Returns the number that determines the colour, dashes and marker of a series. The series of the thesis and those of
 * this run are counted separately, because the thesis' series are black.
 */
static int style_of(const plot *p, int series)
{
    int style = 0;
    for (int s = 0; s < series; s++)
        style += p->series[s].thesis == p->series[series].thesis;
    return style;
}

static const char *colour_of(const plot *p, int series)
{
    return p->series[series].thesis ? "#000000" : colours[style_of(p, series) % COLOURS];
}

/* Returns the fill of a bar. The thesis' bars are white or grey. */
static const char *fill_of(const plot *p, int series)
{
    static const char *const greys[] = {"#ffffff", "#d0d0d0"};
    return p->series[series].thesis ? greys[style_of(p, series) % 2] : colour_of(p, series);
}

static const char *dashes_of(const plot *p, int series)
{
    const int style = style_of(p, series);
    return p->series[series].thesis ? "3 3" : dashes[(style + style / COLOURS) % DASHES];
}

static void marker(const canvas *c, int series, double x, double y)
{
    const char *colour = colour_of(c->p, series);
    const char *fill = c->p->series[series].thesis ? "#ffffff" : colour;
    switch (style_of(c->p, series) % MARKERS) {
    case 0: fprintf(c->to, "<circle cx=\"%.1f\" cy=\"%.1f\" r=\"3.6\"", x, y); break;
    case 1: fprintf(c->to, "<rect x=\"%.1f\" y=\"%.1f\" width=\"6.6\" height=\"6.6\"", x - 3.3, y - 3.3); break;
    case 2: fprintf(c->to, "<path d=\"M%.1f %.1fl4.2 7h-8.4z\"", x, y - 4.4); break;
    case 3: fprintf(c->to, "<path d=\"M%.1f %.1fl4.4 4.4-4.4 4.4-4.4-4.4z\"", x, y - 4.4); break;
    default: fprintf(c->to, "<path d=\"M%.1f %.1fl4.2-7h-8.4z\"", x, y + 4.4);
    }
    fprintf(c->to, " fill=\"%s\" stroke=\"%s\" stroke-width=\"1.2\"/>\n", fill, colour);
}

static void frame(const canvas *c)
{
    for (int i = 0; i < c->y.count; i++) {
        const double y = down(plot_axis_at(&c->y, c->y.tick[i]));
        fprintf(c->to,
                "<path d=\"M%d %.1fH%d\" stroke=\"#d9d9d9\"/><text x=\"%d\" y=\"%.1f\" text-anchor=\"end\">%.6g"
                "</text>\n",
                LEFT, y, WIDTH - RIGHT, LEFT - 7, y + 4.5, c->y.tick[i]);
    }
    for (int i = 0; i < c->x.count && !c->p->bars; i++) {
        const double x = across(plot_axis_at(&c->x, c->x.tick[i]));
        fprintf(c->to,
                "<path d=\"M%.1f %dV%d\" stroke=\"#ececec\"/><path d=\"M%.1f %dv5\" stroke=\"#222\"/>"
                "<text x=\"%.1f\" y=\"%d\" text-anchor=\"middle\">%.6g</text>\n",
                x, TOP, TOP + PLOT_HEIGHT, x, TOP + PLOT_HEIGHT, x, TOP + PLOT_HEIGHT + 18, c->x.tick[i]);
    }
    fprintf(c->to, "<path d=\"M%d %dV%dH%d\" fill=\"none\" stroke=\"#222\"/>\n", LEFT, TOP, TOP + PLOT_HEIGHT,
            WIDTH - RIGHT);
    fprintf(c->to, "<text x=\"%d\" y=\"%d\" text-anchor=\"middle\">", (WIDTH + LEFT - RIGHT) / 2,
            TOP + PLOT_HEIGHT + 38 + c->below);
    plot_text(c->to, c->p->x_label);
    fprintf(c->to, "</text><text transform=\"translate(16 %d) rotate(-90)\" text-anchor=\"middle\">",
            TOP + PLOT_HEIGHT / 2);
    plot_text(c->to, c->p->y_label);
    fputs("</text>\n", c->to);
}

static void lines(const canvas *c)
{
    for (int s = 0; s < c->p->count; s++) {
        const plot_series *series = &c->p->series[s];
        const char *dash = dashes_of(c->p, s);
        bool pen = false;
        fputs("<path d=\"", c->to);
        for (size_t i = 0; i < series->count; i++) {
            if (!shows(c->p->log_x, series->x[i]) || !shows(c->p->log_y, series->y[i]))
                continue;
            fprintf(c->to, "%s%.1f %.1f", pen ? "L" : "M", across(plot_axis_at(&c->x, series->x[i])),
                    down(plot_axis_at(&c->y, series->y[i])));
            pen = true;
        }
        fprintf(c->to, "%s\" fill=\"none\" stroke=\"%s\" stroke-width=\"1.8\"", pen ? "" : "M0 0", colour_of(c->p, s));
        fprintf(c->to, *dash ? " stroke-dasharray=\"%s\"/>\n" : "%s/>\n", dash);
        /* If a series has more than 40 values, some markers are omitted, because they would touch each other. */
        const size_t step = series->count > 40 ? series->count / 20 : 1;
        for (size_t i = 0; i < series->count; i += step)
            if (shows(c->p->log_x, series->x[i]) && shows(c->p->log_y, series->y[i]))
                marker(c, s, across(plot_axis_at(&c->x, series->x[i])), down(plot_axis_at(&c->y, series->y[i])));
    }
}

/* Writes the value of a bar above it, with two or three digits. */
static void bar_value(const canvas *c, double x, double y, double width, double value)
{
    char text[32];
    if (fabs(value) >= 100)
        snprintf(text, sizeof text, "%.0f", value);
    else
        snprintf(text, sizeof text, "%.*g", width < 30 ? 2 : 3, value);
    fprintf(c->to, "<text x=\"%.1f\" y=\"%.1f\" font-size=\"%d\" text-anchor=\"middle\">%s</text>\n", x, y,
            width < 30 ? 9 : 10, text);
}

/* Returns the number of characters of a category's name that fit under its bars. */
static size_t category_width(const plot *p)
{
    const size_t count = p->categories ? p->categories : 1, fits = (WIDTH - LEFT - RIGHT) / count * 10 / 68;
    return fits > 4 ? fits : 4;
}

/* Returns the length of the next line of a name. A line contains as many words as fit, but at least one. */
static size_t line_length(const char *name, size_t fits)
{
    size_t length = strcspn(name, " ");
    while (name[length] == ' ') {
        const size_t next = length + 1 + strcspn(name + length + 1, " ");
        if (next > fits)
            break;
        length = next;
    }
    return length;
}

/* Returns the number of lines of the category name that has the most lines. */
static int category_lines(const plot *p)
{
    int most = 1;
    for (size_t i = 0; i < p->categories && p->bars; i++) {
        int lines = 0;
        for (const char *at = p->category[i]; *at; lines++) {
            at += line_length(at, category_width(p));
            at += *at == ' ';
        }
        most = lines > most ? lines : most;
    }
    return most;
}

static void category_name(const canvas *c, double x, const char *name)
{
    double y = TOP + PLOT_HEIGHT + 18;
    for (const char *at = name; *at; y += NAME_LINE) {
        char line[PLOT_LABEL];
        const size_t length = line_length(at, category_width(c->p));
        snprintf(line, sizeof line, "%.*s", (int)(length < sizeof line ? length : sizeof line - 1), at);
        fprintf(c->to, "<text x=\"%.1f\" y=\"%.0f\" text-anchor=\"middle\">", x, y);
        plot_text(c->to, line);
        fputs("</text>\n", c->to);
        at += length;
        at += *at == ' ';
    }
}

static void bars(const canvas *c)
{
    const double group = (double)(WIDTH - LEFT - RIGHT) / (double)(c->p->categories ? c->p->categories : 1);
    const double width = 0.8 * group / (c->p->count ? c->p->count : 1);
    for (int s = 0; s < c->p->count; s++) {
        const plot_series *series = &c->p->series[s];
        for (size_t i = 0; i < series->count; i++) {
            if (!shows(c->p->log_y, series->y[i]))
                continue;
            const double x = LEFT + group * series->x[i] + 0.1 * group + s * width;
            const double y = down(plot_axis_at(&c->y, series->y[i]));
            fprintf(c->to, "<rect x=\"%.1f\" y=\"%.1f\" width=\"%.1f\" height=\"%.1f\" fill=\"%s\" stroke=\"%s\"%s/>\n",
                    x, y, width - 1, fmax(TOP + PLOT_HEIGHT - y, 0), fill_of(c->p, s),
                    series->thesis ? "#000000" : "none", series->thesis ? " stroke-dasharray=\"3 2\"" : "");
            if (width >= 20)
                bar_value(c, x + width / 2, y - 3, width, series->y[i]);
        }
    }
    for (size_t i = 0; i < c->p->categories; i++)
        category_name(c, LEFT + group * ((double)i + 0.5), c->p->category[i]);
}

static void legend(const canvas *c)
{
    for (int s = 0; s < c->p->count; s++) {
        const double y = TOP + PLOT_HEIGHT + BELOW + c->below + LEGEND_LINE * s;
        const char *dash = dashes_of(c->p, s);
        if (c->p->bars) {
            fprintf(c->to, "<rect x=\"%d\" y=\"%.1f\" width=\"30\" height=\"11\" fill=\"%s\" stroke=\"%s\"%s/>", LEFT,
                    y - 6, fill_of(c->p, s), c->p->series[s].thesis ? "#000000" : "none",
                    c->p->series[s].thesis ? " stroke-dasharray=\"3 2\"" : "");
        } else {
            fprintf(c->to, "<path d=\"M%d %.1fh30\" stroke=\"%s\" stroke-width=\"1.8\"", LEFT, y, colour_of(c->p, s));
            fprintf(c->to, *dash ? " stroke-dasharray=\"%s\"/>" : "%s/>", dash);
            marker(c, s, LEFT + 15, y);
        }
        fprintf(c->to, "<text x=\"%d\" y=\"%.1f\">", LEFT + 38, y + 4.5);
        plot_text(c->to, c->p->series[s].label);
        fputs("</text>\n", c->to);
    }
}

void plot_write(FILE *to, const plot *p)
{
    const bool named = p->count > 1; /* if there is only one series, the title names it */
    const int below = NAME_LINE * (category_lines(p) - 1);
    canvas c = {.to = to,
                .p = p,
                .below = below,
                .height = TOP + PLOT_HEIGHT + BELOW + below + (named ? LEGEND_LINE * p->count : -8)};
    double x0 = 0, x1 = 0, y0 = 0, y1 = 0;
    const bool any = range_of(p, true, &x0, &x1) && range_of(p, false, &y0, &y1);
    fprintf(to,
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"%d\" height=\"%.0f\" viewBox=\"0 0 %d %.0f\" "
            "role=\"img\" font-family=\"Arial, Liberation Sans, DejaVu Sans, sans-serif\" font-size=\"13\" "
            "fill=\"#222222\"><title>",
            WIDTH, c.height, WIDTH, c.height);
    plot_text(to, p->title);
    fprintf(to,
            "</title>\n<rect width=\"%d\" height=\"%.0f\" fill=\"#ffffff\"/>\n<text x=\"%d\" y=\"22\" "
            "font-size=\"15\" font-weight=\"bold\">",
            WIDTH, c.height, LEFT);
    plot_text(to, p->title);
    fputs("</text>\n", to);
    if (any) {
        c.x = x_axis(p, x0, x1);
        c.y = plot_axis_make(y0, y1, p->log_y, true);
        frame(&c);
        if (p->bars)
            bars(&c);
        else
            lines(&c);
        if (named)
            legend(&c);
    } else {
        fprintf(to, "<text x=\"%d\" y=\"%d\">No value was measured.</text>\n", LEFT, TOP + PLOT_HEIGHT / 2);
    }
    fputs("</svg>\n", to);
}
