/* SPDX-License-Identifier: Apache-2.0 */
#include "config.h"

#include "render/points/antialias.h"

#include <stdlib.h>
#include <string.h>

#include "core/conditions.h"

enum { RUN = OST_ANTIALIAS_RUN, WORD = OST_CELL_WIDTH };
_Static_assert(OST_CELL_WIDTH == 16, "a word has one bit for each pixel in a row of a cell");

/*
 * Returns the weight, in 256ths, with which the neighbour across a side is mixed into a pixel. The run continues for
 * `before` sides in one direction and `after` sides in the other. The weight depends only on the nearer end of the run.
 * Let x be the distance from this end. The slanted line (antialias.h) falls from a height of half a pixel at x = 0 to
 * zero in the middle of the run. The weight of a pixel that is k sides away from the end is the area under the line
 * from x = k to x = k + 1. If the middle of the run lies within the pixel, two lines end there, and each of them
 * contributes a triangle.
 */
static uint8_t share_of(int before, int after)
{
    const int k = before < after ? before : after, length = before + after + 1;
    return (uint8_t)(before == after ? (64 + length) / (2 * length)
                                     : (2 * 128 * (length - 2 * k - 1) + length) / (2 * length));
}

void ost_antialias_find_scalar(const uint32_t *row, const uint32_t *next, int cells, uint16_t *below, uint16_t *right)
{
    for (int c = 0; c < cells; c++, row += WORD, next += WORD) {
        uint8_t here[4 * WORD], under[4 * WORD], beyond[4 * WORD], differs[2][4 * WORD];
        memcpy(here, row, sizeof here);
        memcpy(under, next, sizeof under);
        memcpy(beyond, row + 1, sizeof beyond);
        for (int i = 0; i < 4 * WORD; i++) {
            const int down = here[i] - under[i], across = here[i] - beyond[i];
            differs[0][i] = down >= OST_ANTIALIAS_LEAST || -down >= OST_ANTIALIAS_LEAST;
            differs[1][i] = across >= OST_ANTIALIAS_LEAST || -across >= OST_ANTIALIAS_LEAST;
        }
        uint32_t bits[2] = {0, 0};
        for (int i = 0; i < WORD; i++)
            for (int d = 0; d < 2; d++) {
                uint32_t pixel;
                memcpy(&pixel, differs[d] + 4 * i, sizeof pixel);
                bits[d] |= (uint32_t)((pixel & 0xffffff) != 0) << i;
            }
        below[c] = (uint16_t)bits[0];
        right[c] = (uint16_t)bits[1];
    }
}

static ost_antialias_find *find_for(ost_isa isa)
{
#if HAVE_AVX2_BUILD
    if (ost_isa_includes(isa, OST_ISA_AVX2))
        return ost_antialias_find_avx2;
#endif
    (void)isa;
    return ost_antialias_find_scalar;
}

bool ost_antialias_init(ost_antialias *a, int width, int height, ost_isa isa)
{
    *a = (ost_antialias){.words = (width + WORD - 1) / WORD + 2, .width = width, .height = height};
    const size_t count = (size_t)a->words * ((size_t)height + 2);
    a->below = calloc(count, sizeof *a->below);
    a->right = calloc(count, sizeof *a->right);
    a->find = find_for(isa);
    for (int i = 0; i <= RUN; i++)
        for (int j = 0; j <= RUN; j++)
            a->share[i][j] = share_of(i, j);
    return a->below && a->right;
}

void ost_antialias_free(ost_antialias *a)
{
    free(a->below);
    free(a->right);
    *a = (ost_antialias){.words = 0};
}

/* Returns the index of the word with the sides of row y of a cell. Row -1 and cell -1 are valid. */
static size_t word_of(const ost_antialias *a, int cell, int y)
{
    return (size_t)(y + 1) * (size_t)a->words + (size_t)(cell + 1);
}

static int bit_of(const ost_antialias *a, const uint16_t *sides, int x, int y)
{
    return sides[word_of(a, x >> 4, y)] >> (x & 15) & 1;
}

void ost_antialias_edges(const ost_antialias *a, const uint32_t *colour, int stride, const ost_cells *cells, int row)
{
    const int y0 = row * OST_CELL_HEIGHT, y1 = y0 + OST_CELL_HEIGHT < a->height ? y0 + OST_CELL_HEIGHT : a->height;
    const int last = a->words - 3, /* the last cell */
        in_last = a->width - WORD * last;
    for (int from, to = 0; ost_cells_run(cells, row, &from, &to);)
        for (int y = y0; y < y1; y++) {
            const uint32_t *here = colour + (size_t)y * (size_t)stride + WORD * from;
            const size_t at = word_of(a, from, y);
            a->find(here, y + 1 < a->height ? here + stride : here, to - from, a->below + at, a->right + at);
            if (to > last) { /* the picture may end within the last cell, and the last pixel has no right neighbour */
                a->below[word_of(a, last, y)] &= (uint16_t)((1u << in_last) - 1);
                a->right[word_of(a, last, y)] &= (uint16_t)((1u << (in_last - 1)) - 1);
            }
        }
}

void ost_antialias_none(const ost_antialias *a, const ost_cells *cells, int row)
{
    const int y0 = row * OST_CELL_HEIGHT, y1 = y0 + OST_CELL_HEIGHT < a->height ? y0 + OST_CELL_HEIGHT : a->height;
    for (int from, to = 0; ost_cells_run(cells, row, &from, &to);)
        for (int y = y0; y < y1; y++) {
            memset(a->below + word_of(a, from, y), 0, (size_t)(to - from) * sizeof *a->below);
            memset(a->right + word_of(a, from, y), 0, (size_t)(to - from) * sizeof *a->right);
        }
}

/*
 * The run to which a side belongs. A side separates two rows or two columns. The bend at an end of the run is 1 if the
 * edge continues into the first of the two rows or columns, and -1 if the edge continues into the second. The bend is 0
 * if the edge continues into neither or both, or if the end of the run is too far away to be searched.
 */
typedef struct edge {
    int before, after; /* number of further sides of the run in each direction, at most RUN */
    int bend_before, bend_after;
} edge;

/* Returns the weight for mixing the two pixels of an edge: the second into the first if `of_second` is true, otherwise
   the first into the second. */
static uint32_t share(const ost_antialias *a, edge e, bool of_second)
{
    const int sign = of_second ? 1 : -1;
    const uint32_t one = a->share[e.before][e.after];
    return (e.before <= e.after && e.bend_before == sign ? one : 0) +
           (e.after <= e.before && e.bend_after == sign ? one : 0);
}

/* Returns the edge between the pixels (x, y) and (x, y + 1). */
static edge edge_below(const ost_antialias *a, int x, int y)
{
    const uint16_t *w = &a->below[word_of(a, x >> 4, y)];
    /* Bit 16 is the side itself, and bits 0 and 32 are the farthest sides that are searched. */
    const uint64_t around = ((uint64_t)w[-1] | (uint64_t)w[0] << 16 | (uint64_t)w[1] << 32) >> (x & 15);
    const uint32_t ahead = ~(uint32_t)(around >> 17) & 0xffff, behind = ~(uint32_t)around & 0xffff;
    edge e = {.before = behind ? __builtin_clz(behind) - 16 : RUN + 1, .after = ahead ? __builtin_ctz(ahead) : RUN + 1};
    if (e.before <= RUN)
        e.bend_before = bit_of(a, a->right, x - e.before - 1, y) - bit_of(a, a->right, x - e.before - 1, y + 1);
    if (e.after <= RUN)
        e.bend_after = bit_of(a, a->right, x + e.after, y) - bit_of(a, a->right, x + e.after, y + 1);
    e.before = e.before < RUN ? e.before : RUN;
    e.after = e.after < RUN ? e.after : RUN;
    return e;
}

/* Returns the edge between the pixels (x, y) and (x + 1, y). */
static edge edge_right(const ost_antialias *a, int x, int y)
{
    const uint16_t *w = &a->right[word_of(a, x >> 4, y)];
    const int bit = x & 15;
    edge e = {.before = 0};
    while (e.before <= RUN && w[-(e.before + 1) * a->words] >> bit & 1)
        e.before++;
    while (e.after <= RUN && w[(e.after + 1) * a->words] >> bit & 1)
        e.after++;
    if (e.before <= RUN)
        e.bend_before = bit_of(a, a->below, x, y - e.before - 1) - bit_of(a, a->below, x + 1, y - e.before - 1);
    if (e.after <= RUN)
        e.bend_after = bit_of(a, a->below, x, y + e.after) - bit_of(a, a->below, x + 1, y + e.after);
    e.before = e.before < RUN ? e.before : RUN;
    e.after = e.after < RUN ? e.after : RUN;
    return e;
}

/* Mixes two other pixels into a pixel, with weights in 256ths. */
static uint32_t mixed(uint32_t colour, uint32_t first, uint32_t share_1, uint32_t second, uint32_t share_2)
{
    const uint32_t rest = 256 - share_1 - share_2;
    const uint32_t odd = (colour & 0xff00ff) * rest + (first & 0xff00ff) * share_1 + (second & 0xff00ff) * share_2,
                   green = (colour & 0xff00) * rest + (first & 0xff00) * share_1 + (second & 0xff00) * share_2;
    return ((odd + 0x800080) >> 8 & 0xff00ff) | ((green + 0x8000) >> 8 & 0xff00);
}

/* Returns the smoothed colour of a pixel that differs from a neighbour. Only one pair of neighbours is mixed in, either
   the vertical or the horizontal pair: the pair with the greatest of the four weights. */
static uint32_t smoothed(const ost_antialias *a, const uint32_t *at, int stride, int x, int y)
{
    uint32_t above = 0, under = 0, left = 0, right = 0;
    if (bit_of(a, a->below, x, y - 1))
        above = share(a, edge_below(a, x, y - 1), false);
    if (bit_of(a, a->below, x, y))
        under = share(a, edge_below(a, x, y), true);
    if (bit_of(a, a->right, x - 1, y))
        left = share(a, edge_right(a, x - 1, y), false);
    if (bit_of(a, a->right, x, y))
        right = share(a, edge_right(a, x, y), true);
    if ((above | under | left | right) == 0)
        return *at;
    const uint32_t down = above > under ? above : under, across = left > right ? left : right;
    return down >= across ? mixed(*at, above ? at[-stride] : 0, above, under ? at[stride] : 0, under)
                          : mixed(*at, left ? at[-1] : 0, left, right ? at[1] : 0, right);
}

/* Returns true if a pixel of row y in the cells c to c + 3 has an edge. At the end of a row, also reads words of the
 * next row, which is harmless. */
static bool any_of_four(const uint16_t *below, const uint16_t *right, int words)
{
    uint64_t under, above, across;
    memcpy(&under, below, sizeof under);
    memcpy(&above, below - words, sizeof above);
    memcpy(&across, right, sizeof across);
    return (under | above | across | right[-1] >> 15) != 0;
}

/* Smooths row y of the cells from <= c < end. */
static void smooth_row(const ost_antialias *a, const uint32_t *colour, uint32_t *to, int stride, int from, int end,
                       int y)
{
    const uint16_t *below = &a->below[word_of(a, 0, y)], *right = &a->right[word_of(a, 0, y)];
    const uint32_t *row = colour + (size_t)y * (size_t)stride;
    to += (size_t)y * (size_t)stride;
    memcpy(to + WORD * from, row + WORD * from, (size_t)(end - from) * WORD * sizeof *to);
    for (int c = from; c < end; c++) {
        if (!any_of_four(below + c, right + c, a->words)) {
            c += 3;
            continue;
        }
        uint32_t left = (uint16_t)(below[c] | below[c - a->words] | right[c] | right[c] << 1 | right[c - 1] >> 15);
        for (; left; left &= left - 1) {
            const int x = WORD * c + __builtin_ctz(left);
            to[x] = smoothed(a, row + x, stride, x, y);
        }
    }
}

void ost_antialias_smooth(const ost_antialias *a, const uint32_t *colour, uint32_t *to, int stride,
                          const ost_cells *cells, int row)
{
    const int y0 = row * OST_CELL_HEIGHT, y1 = y0 + OST_CELL_HEIGHT < a->height ? y0 + OST_CELL_HEIGHT : a->height;
    for (int from, end = 0; ost_cells_run(cells, row, &from, &end);)
        for (int y = y0; y < y1; y++)
            smooth_row(a, colour, to, stride, from, end, y);
}
