/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The inner loop of triangles.c, written with the compiler's vector types: eight pixels at a time in
 * x86/triangles_avx2.c, four elsewhere. The variants are bit-identical, because each float operation is rounded once
 * and the order of the operations is fixed. Lanes outside the span compute values that are not stored.
 */
#ifndef OST_RENDER_TRIANGLE_ROW_H
#define OST_RENDER_TRIANGLE_ROW_H

#include <string.h>

#ifdef __AVX2__
#include <immintrin.h>
#endif

#include "render/points/triangles.h"

#ifdef __AVX2__
enum { OST_ROW_LANES = 8 };
#else
enum { OST_ROW_LANES = 4 };
#endif
_Static_assert((int)OST_LANES % (int)OST_ROW_LANES == 0, "the lanes from a multiple of their number on are in one row");

typedef float ost_row_floats __attribute__((vector_size(4 * OST_ROW_LANES)));
typedef int32_t ost_row_ints __attribute__((vector_size(4 * OST_ROW_LANES))); /* masks have 0 or -1 in each lane */
typedef uint8_t ost_row_bytes __attribute__((vector_size(OST_ROW_LANES)));

static inline ost_row_floats ost_row_choose(ost_row_ints mask, ost_row_floats a, ost_row_floats b)
{
    return (ost_row_floats)(((ost_row_ints)a & mask) | ((ost_row_ints)b & ~mask));
}

static inline ost_row_floats ost_row_positive(ost_row_floats v)
{
    return (ost_row_floats)((ost_row_ints)v & (v > 0));
}

static inline ost_row_ints ost_row_least(ost_row_ints v, int32_t most)
{
    const ost_row_ints low = v < most;
    return (v & low) | (most & ~low);
}

/* Interpolates a value that is linear in the picture from its values at the corners. */
static inline ost_row_floats ost_row_linear(float at_0, float at_1, float at_2, ost_row_floats b, ost_row_floats c)
{
    return (at_0 + b * (at_1 - at_0)) + c * (at_2 - at_0);
}

/*
 * Returns 1 / sqrt(v), with a relative error of about 2^-22, for 1e-30 <= v <= 1e30. The first estimate is within 3.5 %
 * (Lomont 2003), and each step doubles the number of correct bits.
 */
static inline ost_row_floats ost_row_inverse_root(ost_row_floats v)
{
    ost_row_floats r = (ost_row_floats)(0x5f375a86 - ((ost_row_ints)v >> 1));
    for (int i = 0; i < 3; i++)
        r = r * (1.5f - 0.5f * v * (r * r));
    return r;
}

static inline ost_row_floats ost_row_along(const float v[3], const ost_row_floats n[3])
{
    return (n[0] * v[0] + n[1] * v[1]) + n[2] * v[2];
}

static inline ost_row_ints ost_row_channel(uint32_t full, ost_row_ints bright, ost_row_ints gloss)
{
    return ost_row_least((bright * (int32_t)full >> 8) + gloss, 255);
}

/* Computes colours from normals of any length, by the formulas of light.c. */
static inline ost_row_ints ost_row_light(const ost_triangles *t, ost_row_floats n[3])
{
    const ost_lamps *l = &t->lamps;
    const ost_row_floats square = (n[0] * n[0] + n[1] * n[1]) + n[2] * n[2],
                         least = {0};
    const ost_row_floats root = ost_row_inverse_root(ost_row_choose(square > 1e-30f, square, least + 1e-30f));
    for (int a = 0; a < 3; a++)
        n[a] *= root;
    const ost_row_floats sky = 0.5f + 0.5f * ost_row_along(l->up, n);
    const ost_row_floats key = ost_row_positive(ost_row_along(l->key, n)),
                         fill = ost_row_positive(ost_row_along(l->fill, n)),
                         back = ost_row_positive(ost_row_along(l->back, n));
    ost_row_floats mirror = ost_row_positive(ost_row_along(l->half, n));
    for (int i = 0; i < 4; i++)
        mirror *= mirror;
    const ost_row_floats bright = ((OST_LIGHT_AMBIENT + OST_LIGHT_SKY * sky) +
                                   (OST_LIGHT_KEY * key + OST_LIGHT_FILL * fill)) + OST_LIGHT_BACK * back;
    const ost_row_ints scaled = ost_row_least(__builtin_convertvector(256.0f * bright + 0.5f, ost_row_ints),
                                              OST_LIGHT_MOST),
                       gloss = __builtin_convertvector(t->gloss * mirror + 0.5f, ost_row_ints);
    return ost_row_channel(t->colour & 255, scaled, gloss) | ost_row_channel(t->colour >> 8 & 255, scaled, gloss) << 8 |
           ost_row_channel(t->colour >> 16, scaled, gloss) << 16;
}

static inline ost_row_ints ost_row_numbers(int32_t first)
{
    static const int32_t numbers[8] = {0, 1, 2, 3, 4, 5, 6, 7};
    ost_row_ints v;
    memcpy(&v, numbers, sizeof v);
    return v + first;
}

static inline bool ost_row_any(ost_row_ints mask)
{
    uint64_t words[sizeof mask / sizeof(uint64_t)], any = 0;
    memcpy(words, &mask, sizeof mask);
    for (size_t i = 0; i < sizeof words / sizeof *words; i++)
        any |= words[i];
    return any != 0;
}

/* Intrinsics are used here, because compilers convert between byte masks and int masks lane by lane. */
#ifdef __AVX2__
static inline ost_row_ints ost_row_without_face(ost_row_bytes faces)
{
    const ost_row_bytes none = faces == OST_NO_FACE;
    return (ost_row_ints)_mm256_cvtepi8_epi32(_mm_cvtsi64_si128((int64_t)none));
}
static inline ost_row_bytes ost_row_byte_mask(ost_row_ints mask)
{
    const __m256i v = (__m256i)mask;
    const __m128i words = _mm_packs_epi32(_mm256_castsi256_si128(v), _mm256_extracti128_si256(v, 1));
    return (ost_row_bytes)_mm_cvtsi128_si64(_mm_packs_epi16(words, words));
}
#else
static inline ost_row_ints ost_row_without_face(ost_row_bytes faces)
{
    return __builtin_convertvector(faces, ost_row_ints) == OST_NO_FACE;
}
static inline ost_row_bytes ost_row_byte_mask(ost_row_ints mask)
{
    return __builtin_convertvector(mask, ost_row_bytes);
}
#endif

/* A span of a row: the pixels from <= x < to. b and c are the weights of corners 1 and 2 at the first pixel; b_step and
   c_step are the changes of b and c from pixel to pixel. */
typedef struct ost_row_span {
    int from, to;
    float b, b_step, c, c_step;
} ost_row_span;

/* Draws the part of a span that lies in one vector of pixels. The vector begins at column x, which has the index `at`
   in the planes. Returns true if a pixel has changed. */
static inline bool ost_row_some(const ost_triangles *t, const ost_flat_triangle *f, const ost_row_span *s, int x,
                                const ost_planes *planes, size_t at)
{
    ost_row_floats was, n[3];
    ost_row_ints colours;
    ost_row_bytes faces;
    memcpy(&was, planes->depth + at, sizeof was);
    memcpy(&faces, planes->face + at, sizeof faces);
    const ost_row_ints number = ost_row_numbers(x - s->from),
                       inside = (number >= 0) & (number < s->to - s->from);
    /* lanes outside the span use the weights of corner 0 */
    const ost_row_floats along = __builtin_convertvector(number & inside, ost_row_floats);
    const ost_row_floats b = (ost_row_floats)((ost_row_ints)(s->b + along * s->b_step) & inside),
                         c = (ost_row_floats)((ost_row_ints)(s->c + along * s->c_step) & inside);
    const ost_row_floats depth = t->scale / ost_row_linear(f->inverse[0], f->inverse[1], f->inverse[2], b, c);
    const ost_row_ints take = inside & (ost_row_without_face(faces) | (depth < was));
    if (!ost_row_any(take))
        return false;
    for (int a = 0; a < 3; a++)
        n[a] = ost_row_linear(f->normal[0][a], f->normal[1][a], f->normal[2][a], b, c);
    memcpy(&colours, planes->colour + at, sizeof colours);
    colours = (ost_row_light(t, n) & take) | (colours & ~take);
    was = ost_row_choose(take, depth, was);
    faces &= ~ost_row_byte_mask(take); /* face 0 */
    memcpy(planes->colour + at, &colours, sizeof colours);
    memcpy(planes->depth + at, &was, sizeof was);
    memcpy(planes->face + at, &faces, sizeof faces);
    return true;
}

/*
 * The edge function of a side of a triangle: linear in the position, 0 on the side, and positive inside the triangle.
 * The sum of all three edge functions is twice the triangle's area at every pixel. Values are below 2^60.
 */
typedef struct ost_row_side {
    int64_t value;        /* value at the centre of the triangle's first pixel column in the row */
    int64_t across, down; /* across: change from one pixel to the next; down: change from one row to the next */
} ost_row_side;

/* Returns, for row y, the edge function of the side opposite to a corner. `opposite` is the number of the corner. */
static inline ost_row_side ost_row_side_of(const ost_flat_triangle *f, int opposite, int y)
{
    const int a = (opposite + 1) % 3, b = (opposite + 2) % 3;
    const int64_t dx = f->x[b] - f->x[a], dy = f->y[b] - f->y[a];
    const int64_t px = (int64_t)f->pixels.x0 * OST_PIXEL_PARTS + OST_PIXEL_PARTS / 2,
                  py = (int64_t)y * OST_PIXEL_PARTS + OST_PIXEL_PARTS / 2;
    return (ost_row_side){dx * (py - f->y[a]) - dy * (px - f->x[a]), -dy * OST_PIXEL_PARTS, dx * OST_PIXEL_PARTS};
}

/*
 * Returns floor(a / b) for a >= 0 and b > 0. Division of doubles is faster and correct for a < 2^52: if a / b is not an
 * integer, it is at least 1 / b away from every integer, and the rounding error is below (a / b) 2^-53 < 1 / b.
 */
static inline int64_t ost_row_quotient(int64_t a, int64_t b)
{
    return a < INT64_C(1) << 52 ? (int64_t)((double)a / (double)b) : a / b;
}

/* Removes from the half-open range [*from, *to) the pixels at which an edge function is negative. Pixels are counted
   from the triangle's first column. */
static inline void ost_row_narrow(const ost_row_side *s, int *from, int *to)
{
    if (s->value < 0) {
        const int64_t first = s->across > 0 ? ost_row_quotient(s->across - 1 - s->value, s->across) : *to;
        *from = first > *from ? first < *to ? (int)first : *to : *from;
    } else if (s->value + (*to - 1) * s->across < 0) {
        const int64_t end = ost_row_quotient(s->value, -s->across) + 1;
        *to = end < *to ? (int)end : *to;
    }
}

/* Draws the rows of a triangle. */
static inline void ost_row_triangle(const ost_triangles *t, const ost_flat_triangle *f, const ost_planes *planes,
                                    int y0, int y1, const ost_cells *over)
{
    ost_row_side s[3] = {ost_row_side_of(f, 0, y0), ost_row_side_of(f, 1, y0), ost_row_side_of(f, 2, y0)};
    for (int y = y0; y < y1; y++) {
        int from = 0, to = f->pixels.x1 - f->pixels.x0;
        for (int i = 0; i < 3; i++)
            ost_row_narrow(&s[i], &from, &to);
        const ost_row_span span = {.from = f->pixels.x0 + from,
                                   .to = f->pixels.x0 + to,
                                   .b = (float)(s[1].value + from * s[1].across) * f->whole,
                                   .b_step = (float)s[1].across * f->whole,
                                   .c = (float)(s[2].value + from * s[2].across) * f->whole,
                                   .c_step = (float)s[2].across * f->whole};
        for (int x = span.from / OST_ROW_LANES * OST_ROW_LANES; x < span.to && from < to; x += OST_ROW_LANES)
            if (ost_row_some(t, f, &span, x, planes, ost_row(planes, y) + (size_t)x))
                ost_cells_dot(over, x, y);
        for (int i = 0; i < 3; i++)
            s[i].value += s[i].down;
    }
}

#endif
