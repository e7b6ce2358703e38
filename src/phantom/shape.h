/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Shapes by their distance: negative inside, positive outside, millimetres.
 *
 *   outline   a smooth closed curve through given points, with its signed
 *             distance on a table: plates are cut out along it
 *   sweep     an elliptical bar along a curve, its two radii varying
 *   blend     two shapes grown together over a width
 *
 * Additions, multiplications, divisions and square roots only: IEEE 754
 * defines each to the bit, so every machine sees the same shape.
 */
#ifndef OST_PHANTOM_SHAPE_H
#define OST_PHANTOM_SHAPE_H

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <osteon/status.h>

#include "core/conditions.h"

typedef struct ost_v3 {
    double x, y, z;
} ost_v3;

static inline double ost_min(double a, double b) { return a < b ? a : b; }
static inline double ost_max(double a, double b) { return a > b ? a : b; }
static inline double ost_clamp(double v, double lo, double hi) { return v < lo ? lo : v > hi ? hi : v; }
static inline double ost_smooth(double lo, double hi, double v)
{
    double t = ost_clamp((v - lo) / (hi - lo), 0, 1);
    return t * t * (3 - 2 * t);
}

static inline ost_v3 ost_v3_sub(ost_v3 a, ost_v3 b) { return (ost_v3){a.x - b.x, a.y - b.y, a.z - b.z}; }
static inline ost_v3 ost_v3_mad(ost_v3 a, ost_v3 b, double s) { return (ost_v3){a.x + b.x * s, a.y + b.y * s, a.z + b.z * s}; }
static inline double ost_v3_dot(ost_v3 a, ost_v3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static inline double ost_v3_length(ost_v3 a) { return sqrt(ost_v3_dot(a, a)); }
static inline ost_v3 ost_v3_cross(ost_v3 a, ost_v3 b)
{
    return (ost_v3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
static inline ost_v3 ost_v3_unit(ost_v3 a)
{
    double n = 1 / ost_v3_length(a);
    return (ost_v3){a.x * n, a.y * n, a.z * n};
}

/* Union, rounded where the two are within `width` of each other; never farther than the nearer one. */
static inline double ost_blend(double a, double b, double width)
{
    double h = ost_max(width - (a > b ? a - b : b - a), 0);
    return ost_min(a, b) - h * h / (4 * width);
}

/* Intersection, its edge rounded. */
static inline double ost_blend_both(double a, double b, double width)
{
    return -ost_blend(-a, -b, width);
}

/* ---------------------------------------------------------------- outline */

typedef struct ost_outline_point {
    double u, v;
    int tag; /* of the curve from here to the next point */
} ost_outline_point;

enum { OST_OUTLINE_TAGS = 4 };

typedef struct ost_outline {
    double u0, v0, step;
    int nu, nv;
    double *inside;                  /* owned: positive inside */
    double *to_tag[OST_OUTLINE_TAGS]; /* owned: distance to the nearest stretch with this tag; NULL for tags that none has */
} ost_outline;

/* The curve passes through the points; the table covers it with `margin` on every side. */
ost_status ost_outline_init(ost_outline *outline, const ost_outline_point *points, int count, double step, double margin, ost_error *err);
void ost_outline_free(ost_outline *outline);
/* Bilinear; beyond the table, the value at its border less the distance to it (plus, for a tag). */
double ost_outline_inside(const ost_outline *outline, double u, double v);
double ost_outline_to_tag(const ost_outline *outline, int tag, double u, double v);

/* ------------------------------------------------------------------ sweep */

typedef struct ost_bar_node {
    ost_v3 at;
    double wide, thick; /* radii along `side` and across it */
    ost_v3 side;        /* need not be unit nor square to the path */
} ost_bar_node;

enum { OST_BAR_NODES = 48 };
typedef struct ost_bar {
    int count;
    ost_bar_node node[OST_BAR_NODES];
    ost_v3 middle[OST_BAR_NODES]; /* of the piece from a node to the next */
    double reach[OST_BAR_NODES];  /* of that piece from its middle */
    ost_v3 lo, hi; /* box that holds it */
} ost_bar;

/* Smooth through the given nodes, `parts` straight pieces between two of them. (count - 1) * parts < OST_BAR_NODES. */
void ost_bar_init(ost_bar *bar, const ost_bar_node *nodes, int count, int parts);
/* Beyond `far` of its box only the distance to the box, which is less. */
double ost_bar_distance(const ost_bar *bar, ost_v3 p, double far);

#endif
