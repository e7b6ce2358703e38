/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A letter consists of strokes between points of a grid. A point is written as a digit for x and a letter for y: 'd' is
 * the baseline, 'j' is the top of a small letter, and 'm' is the top of a capital.
 *
 *     m  3          "0d3m6d 1g5g"      two strokes of straight lines
 *       / \
 *     g 1---5       ~  a curve from its first point to its last; the points in between are control points
 *     d 0   6       @  a closed curve
 *
 * Curves are quadratic B-splines: parabolas between the midpoints of the control polygon's sides, with the polygon's
 * corners as control points.
 */
#include "render/lettering.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    FIRST = 32,
    LAST = 126,
    DEGREE = 127,
    CUBED,
    GLYPHS = 129 - FIRST,
    POINTS = 16,
    SEGMENTS = 128,
    PIECES = 6,
    CAPITAL = 9
};
/* GAP is the distance between two letters, and WEIGHT is half the width of a stroke, both in units of the grid. */
static const double GAP = 2.7, WEIGHT = 0.62;

typedef struct drawing {
    unsigned char c;
    signed char width;
    const char *strokes;
} drawing;

static const drawing drawings[] = {
    {' ', 2, ""},
    {'!', 1, "0m0g 0d0d"},
    {'"', 2, "0m0k 2m2k"},
    {'\'', 1, "0m0k"},
    {'%', 8, "1d7m @0i0m3m3i @5d5h8h8d"},
    {'&', 6, "~6g5d2d0d0g2i4j4m1m1k1j6d"},
    {'(', 2, "~2n0j0f2b"},
    {')', 2, "~0n2j2f0b"},
    {'*', 4, "0i4i 1k3g 3k1g"},
    {'+', 4, "0g4g 2e2i"},
    {',', 1, "1d0b"},
    {'-', 3, "0g3g"},
    {'.', 0, "0d0d"},
    {'/', 4, "0c4m"},
    {'0', 5, "@0d0m5m5d"},
    {'1', 5, "1k3m3d"},
    {'2', 5, "~0k0m5m5i3g0d 0d5d"},
    {'3', 5, "~0k0m5m5i2i ~2i5i5d0d0f"},
    {'4', 5, "4d4m0f5f"},
    {'5', 5, "5m1m0i ~0i2j5j5d0d0f"},
    {'6', 5, "~4m0j0d5d5i0i0f"},
    {'7', 5, "0m5m2d"},
    {'8', 5, "@0i0m5m5i @0i0d5d5i"},
    {'9', 5, "~1d5g5m0m0h5h5k"},
    {':', 0, "0d0d 0i0i"},
    {';', 1, "1d0b 1i1i"},
    {'<', 4, "4j0g4d"},
    {'=', 4, "0f4f 0i4i"},
    {'>', 4, "0j4g0d"},
    {'?', 4, "~0k0m4m4i2i2g 2d2d"},
    {'A', 6, "0d3m6d 1g5g"},
    {'B', 6, "0d0m ~0m3m5m5i3i0i ~0i4i6i6d4d0d"},
    {'C', 6, "~6k5m3m0m0h0d3d5d6f"},
    {'D', 6, "0d0m ~0m3m6m6h6d3d0d"},
    {'E', 5, "5m0m0d5d 0i4i"},
    {'F', 5, "5m0m0d 0i4i"},
    {'G', 6, "~6k5m3m0m0h0d3d6d6f6h 6h3h"},
    {'H', 6, "0d0m 6d6m 0i6i"},
    {'I', 0, "0d0m"},
    {'J', 4, "~4m4h4f4d2d0d0f"},
    {'K', 6, "0d0m 6m0g 2i6d"},
    {'L', 5, "0m0d5d"},
    {'M', 8, "0d0m4f8m8d"},
    {'N', 6, "0d0m6d6m"},
    {'O', 7, "@0d0m7m7d"},
    {'P', 5, "0d0m ~0m3m5m5h3h0h"},
    {'Q', 7, "@0d0m7m7d 5f7c"},
    {'R', 6, "0d0m ~0m3m5m5h3h0h 3h6d"},
    {'S', 5, "~5k5m2m0m0i5i5d3d0d0f"},
    {'T', 6, "0m6m 3m3d"},
    {'U', 6, "~0m0h0d3d6d6h6m"},
    {'V', 6, "0m3d6m"},
    {'W', 8, "0m2d4k6d8m"},
    {'X', 6, "0d6m 0m6d"},
    {'Y', 6, "0m3h6m 3h3d"},
    {'Z', 6, "0m6m0d6d"},
    {'[', 2, "2n0n0b2b"},
    {'\\', 4, "0m4c"},
    {']', 2, "0n2n2b0b"},
    {'_', 5, "0c5c"},
    {'a', 5, "@0d0j5j5d 5j5d"},
    {'b', 5, "0m0d @0d0j5j5d"},
    {'c', 4, "~4i4j0j0d4d4e"},
    {'d', 5, "5m5d @0d0j5j5d"},
    {'e', 5, "0g5g ~5g5j0j0d5d5e"},
    {'f', 3, "~3m1m1j1d 0j3j"},
    {'g', 5, "@0d0j5j5d ~5j5d5a0a0b"},
    {'h', 5, "0m0d ~0g0j5j5g5d"},
    {'i', 0, "0j0d 0m0m"},
    {'j', 1, "~1j1d1a0a 1m1m"},
    {'k', 4, "0m0d 4j0f 1g4d"},
    {'l', 1, "~0m0f0d1d"},
    {'m', 8, "0d0j ~0g0j4j4g4d ~4g4j8j8g8d"},
    {'n', 5, "0d0j ~0g0j5j5g5d"},
    {'o', 5, "@0d0j5j5d"},
    {'p', 5, "0j0a @0d0j5j5d"},
    {'q', 5, "5j5a @0d0j5j5d"},
    {'r', 3, "0d0j ~0g0j3j"},
    {'s', 4, "~4i4j0j0g4g4d0d0e"},
    {'t', 3, "~1l1g1d3d 0j3j"},
    {'u', 5, "~0j0g0d5d5g 5j5d"},
    {'v', 4, "0j2d4j"},
    {'w', 8, "0j2d4i6d8j"},
    {'x', 4, "0d4j 0j4d"},
    {'y', 4, "4j1a 0j2d"},
    {'z', 4, "0j4j0d4d"},
    {'|', 0, "0n0b"},
    {DEGREE, 2, "@0k0m2m2k"},
    {CUBED, 3, "~0m3m3k1k ~1k3k3h0h"},
};

typedef struct glyph {
    /*
     * position and size of the bitmap in pixels; the position is relative to the start of the letter on the baseline,
     * and y points down
     */
    int x, y, width, height;
    double advance;
    uint8_t *cover; /* owned; coverage of each pixel by the letter, 0 to 255 */
} glyph;

struct ost_lettering {
    glyph glyph[GLYPHS];
};

typedef struct segment {
    double ax, ay, bx, by;
} segment;

typedef struct outline {
    segment segment[SEGMENTS];
    int count;
    double x0, y0, x1, y1;
} outline;

static void add(outline *o, double ax, double ay, double bx, double by)
{
    if (o->count == SEGMENTS)
        return;
    o->segment[o->count++] = (segment){ax, ay, bx, by};
    o->x0 = fmin(o->x0, fmin(ax, bx));
    o->x1 = fmax(o->x1, fmax(ax, bx));
    o->y0 = fmin(o->y0, fmin(ay, by));
    o->y1 = fmax(o->y1, fmax(ay, by));
}

static void parabola(outline *o, const double a[2], const double pull[2], const double b[2])
{
    double x = a[0], y = a[1];
    for (int i = 1; i <= PIECES; i++) {
        const double t = (double)i / PIECES, u = 1 - t;
        const double nx = u * u * a[0] + 2 * u * t * pull[0] + t * t * b[0],
                     ny = u * u * a[1] + 2 * u * t * pull[1] + t * t * b[1];
        add(o, x, y, nx, ny);
        x = nx;
        y = ny;
    }
}

static void middle(const double a[2], const double b[2], double out[2])
{
    out[0] = 0.5 * (a[0] + b[0]);
    out[1] = 0.5 * (a[1] + b[1]);
}

static void stroke(outline *o, char kind, double p[POINTS][2], int n)
{
    double a[2], b[2];
    if (kind == '@') {
        for (int i = 0; i < n; i++) {
            middle(p[i], p[(i + 1) % n], a);
            middle(p[(i + 1) % n], p[(i + 2) % n], b);
            parabola(o, a, p[(i + 1) % n], b);
        }
        return;
    }
    if (kind == '~') {
        memcpy(a, p[0], sizeof a);
        for (int i = 1; i < n - 1; i++) {
            if (i == n - 2)
                memcpy(b, p[n - 1], sizeof b);
            else
                middle(p[i], p[i + 1], b);
            parabola(o, a, p[i], b);
            memcpy(a, b, sizeof a);
        }
        return;
    }
    for (int i = 1; i < n; i++)
        add(o, p[i - 1][0], p[i - 1][1], p[i][0], p[i][1]);
}

/* Converts the strokes to line segments in pixels, with the baseline at y = 0 and y upward. */
static void trace(const drawing *d, double unit, outline *o)
{
    *o = (outline){.x0 = 1e9, .y0 = 1e9, .x1 = -1e9, .y1 = -1e9};
    for (const char *s = d->strokes; *s;) {
        double p[POINTS][2];
        int n = 0;
        const char kind = *s == '~' || *s == '@' ? *s++ : ' ';
        for (; *s && *s != ' ' && n < POINTS; s += 2, n++) {
            p[n][0] = (s[0] - '0') * unit;
            p[n][1] = (s[1] - 'd') * unit;
        }
        stroke(o, kind, p, n);
        s += *s == ' ';
    }
}

static double distance(const segment *s, double x, double y)
{
    const double dx = s->bx - s->ax, dy = s->by - s->ay, length = dx * dx + dy * dy;
    double t = length > 0 ? ((x - s->ax) * dx + (y - s->ay) * dy) / length : 0;
    t = fmax(0, fmin(1, t));
    const double ex = x - s->ax - t * dx, ey = y - s->ay - t * dy;
    return sqrt(ex * ex + ey * ey);
}

static bool draw_glyph(const drawing *d, double unit, glyph *g)
{
    outline o;
    const double r = fmax(WEIGHT * unit, 0.55);
    trace(d, unit, &o);
    g->advance = (d->width + GAP) * unit;
    if (!o.count)
        return true;
    g->x = (int)floor(o.x0 - r - 1);
    g->y = (int)floor(-o.y1 - r - 1);
    g->width = (int)ceil(o.x1 + r + 1) - g->x;
    g->height = (int)ceil(-o.y0 + r + 1) - g->y;
    g->cover = calloc((size_t)g->width, (size_t)g->height);
    if (!g->cover)
        return false;
    /* For speed, only the pixels that a segment can reach are visited. */
    for (int i = 0; i < o.count; i++) {
        const segment *e = &o.segment[i];
        const int x0 = (int)floor(fmin(e->ax, e->bx) - r - 1) - g->x, x1 = (int)ceil(fmax(e->ax, e->bx) + r + 1) - g->x;
        const int y0 = (int)floor(-fmax(e->ay, e->by) - r - 1) - g->y,
                  y1 = (int)ceil(-fmin(e->ay, e->by) + r + 1) - g->y;
        for (int y = y0; y < y1; y++)
            for (int x = x0; x < x1; x++) {
                const double cover = fmax(0, fmin(1, r - distance(e, g->x + x + 0.5, -(g->y + y + 0.5)) + 0.5));
                uint8_t *at = &g->cover[x + g->width * y], mine = (uint8_t)(255 * cover + 0.5);
                *at = mine > *at ? mine : *at;
            }
    }
    return true;
}

ost_status ost_lettering_create(double height, ost_lettering **out, ost_error *err)
{
    *out = NULL;
    if (!(height >= 5 && height <= 200))
        return ost_fail(err, OST_ERR_RANGE, "letters of %.3g pixels; expected 5 to 200", height);
    ost_lettering *l = calloc(1, sizeof *l);
    bool complete = l != NULL;
    for (size_t i = 0; complete && i < sizeof drawings / sizeof *drawings; i++)
        complete = draw_glyph(&drawings[i], height / CAPITAL, &l->glyph[drawings[i].c - FIRST]);
    if (!complete) {
        ost_lettering_free(l);
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for letters");
    }
    *out = l;
    return OST_OK;
}

void ost_lettering_free(ost_lettering *lettering)
{
    for (int i = 0; lettering && i < GLYPHS; i++)
        free(lettering->glyph[i].cover);
    free(lettering);
}

/* Returns the next letter of a UTF-8 text, or NULL at the end of the text. */
static const glyph *next(const ost_lettering *l, const char **text)
{
    const unsigned char c = (unsigned char)**text;
    if (!c)
        return NULL;
    ++*text;
    if (c == 0xc2 && ((unsigned char)**text == 0xb0 || (unsigned char)**text == 0xb3))
        return &l->glyph[(*(*text)++ == '\xb0' ? DEGREE : CUBED) - FIRST];
    return &l->glyph[(c >= FIRST && c <= LAST ? c : ' ') - FIRST];
}

int ost_lettering_width(const ost_lettering *lettering, const char *text)
{
    double width = 0;
    for (const glyph *g; (g = next(lettering, &text)) != NULL;)
        width += g->advance;
    return (int)ceil(width);
}

static const uint32_t OPAQUE = 0xff000000;

static uint32_t mixed(uint32_t a, uint32_t b, unsigned share)
{
    const uint32_t even = (((a & 0xff00ff) * (256 - share) + (b & 0xff00ff) * share) >> 8) & 0xff00ff;
    const uint32_t odd = ((a >> 8 & 0xff00ff) * (256 - share) + (b >> 8 & 0xff00ff) * share) & 0xff00ff00;
    return even | odd;
}

/*
 * Mixes four pixels at once, bit-identically to mixing them one by one. A product of a colour channel and a weight is
 * at most 255 x 256, so it fits into 16 bits.
 */
typedef uint32_t four __attribute__((vector_size(16)));
typedef uint16_t eight __attribute__((vector_size(16)));

static four mixed_four(four a, four b, eight share)
{
    const four low = {0xff00ff, 0xff00ff, 0xff00ff, 0xff00ff};
    const eight complement = 256 - share;
    const eight even = ((eight)(a & low) * complement + (eight)(b & low) * share) >> 8,
                odd = (eight)(a >> 8 & low) * complement + (eight)(b >> 8 & low) * share;
    return (four)even | ((four)odd & ~low);
}

static four load(const void *from)
{
    four v;
    memcpy(&v, from, sizeof v);
    return v;
}

static void mix_row(uint32_t *row, int count, uint32_t colour, unsigned alpha)
{
    const four b = {colour, colour, colour, colour};
    const uint16_t a = (uint16_t)alpha;
    const eight share = {a, a, a, a, a, a, a, a};
    int i = 0;
    for (; i + 4 <= count; i += 4) {
        const four v = mixed_four(load(row + i), b, share);
        memcpy(row + i, &v, sizeof v);
    }
    for (; i < count; i++)
        row[i] = mixed(row[i], colour, alpha);
}

static void cover_row(uint32_t *row, const uint8_t *cover, int count, uint32_t colour)
{
    const four b = {colour, colour, colour, colour};
    int i = 0;
    for (; i + 4 <= count; i += 4) {
        uint32_t any;
        memcpy(&any, cover + i, sizeof any);
        if (!any)
            continue;
        four c = {cover[i], cover[i + 1], cover[i + 2], cover[i + 3]};
        c += c >> 7;
        const four v = mixed_four(load(row + i), b, (eight)(c | c << 16));
        memcpy(row + i, &v, sizeof v);
    }
    for (; i < count; i++)
        if (cover[i])
            row[i] = mixed(row[i], colour, cover[i] + (cover[i] >> 7));
}

void ost_lettering_draw(const ost_lettering *lettering, const ost_sheet *sheet, int x, int y, const char *text,
                        uint32_t colour)
{
    double at = x;
    colour |= OPAQUE;
    for (const glyph *g; (g = next(lettering, &text)) != NULL; at += g->advance) {
        const int left = (int)floor(at + 0.5) + g->x, top = y + g->y;
        if (sheet->written)
            ost_cells_add(sheet->written, left, left + g->width, top, top + g->height);
        const int from = left < 0 ? -left : 0, to = left + g->width > sheet->width ? sheet->width - left : g->width;
        for (int j = top < 0 ? -top : 0; j < g->height && top + j < sheet->height && from < to; j++)
            cover_row(sheet->pixels + (size_t)(top + j) * (size_t)sheet->stride + (size_t)(left + from),
                      g->cover + from + (size_t)g->width * (size_t)j, to - from, colour);
    }
}

void ost_sheet_box(const ost_sheet *sheet, int x, int y, int width, int height, uint32_t colour, unsigned alpha)
{
    if (sheet->written)
        ost_cells_add(sheet->written, x, x + width, y, y + height);
    const int from = x < 0 ? 0 : x, to = x + width > sheet->width ? sheet->width : x + width;
    for (int j = y < 0 ? 0 : y; j < y + height && j < sheet->height && from < to; j++)
        mix_row(sheet->pixels + (size_t)j * (size_t)sheet->stride + (size_t)from, to - from, colour | OPAQUE, alpha);
}
