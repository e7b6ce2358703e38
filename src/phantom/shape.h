/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Shapes that are defined by their signed distance in millimetres, which is negative inside and positive outside.
 *
 *   outline   a smooth closed curve through given points, with a table of its
 *             signed distance; plates are cut out along it
 *   sweep     an elliptical bar along a curve, with two varying radii
 *   blend     two shapes joined smoothly over a width
 *
 * Only additions, multiplications, divisions and square roots are used: IEEE 754
 * defines every bit of their results, so the shape is the same on every machine.
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
static inline ost_v3 ost_v3_mad(ost_v3 a, ost_v3 b, double s)
{
    return (ost_v3){a.x + b.x * s, a.y + b.y * s, a.z + b.z * s};
}
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

/*
 * Returns the distance to the union of two shapes, given the distances a and b to the shapes. The union is rounded
 * where a and b differ by less than `width`. The result is never greater than a or b.
 */
static inline double ost_blend(double a, double b, double width)
{
    double h = ost_max(width - (a > b ? a - b : b - a), 0);
    return ost_min(a, b) - h * h / (4 * width);
}

/* Returns the distance to the intersection of two shapes. The edge of the intersection is rounded. */
static inline double ost_blend_both(double a, double b, double width)
{
    return -ost_blend(-a, -b, width);
}

/* ---------------------------------------------------------------- outline */

typedef struct ost_outline_point {
    double u, v;
    int tag; /* tag of the curve from this point to the next point */
} ost_outline_point;

enum { OST_OUTLINE_TAGS = 4 };

typedef struct ost_outline {
    double u0, v0, step;
    int nu, nv;
    double *inside;                  /* owned; table of the signed distance, positive inside */
    /* Owned; for each tag, a table of the distance to the nearest part of the curve with this tag. NULL for an
     * unused tag. */
    double *to_tag[OST_OUTLINE_TAGS];
} ost_outline;

/*
 * Computes the curve through the points, and a table of signed distances. The table extends beyond the curve by
 * `margin` on every side.
 */
ost_status ost_outline_init(ost_outline *outline, const ost_outline_point *points, int count, double step,
                            double margin, ost_error *err);
void ost_outline_free(ost_outline *outline);
/*
 * The two functions below interpolate a table bilinearly. Outside the table, they use the nearest value at the table's
 * border. ost_outline_inside then subtracts the distance to the border; ost_outline_to_tag adds it.
 */
double ost_outline_inside(const ost_outline *outline, double u, double v);
double ost_outline_to_tag(const ost_outline *outline, int tag, double u, double v);

/* ------------------------------------------------------------------ sweep */

typedef struct ost_bar_node {
    ost_v3 at;
    double wide, thick; /* radii of the cross section: wide along `side`, thick perpendicular to it */
    ost_v3 side;        /* direction in the cross section; it need not be a unit vector or perpendicular to the path */
} ost_bar_node;

/* A straight segment of a bar. `step` and the members ..._step are the differences between its end and its start. */
typedef struct ost_bar_segment {
    ost_v3 from, step;
    ost_v3 side, side_step;
    double wide, wide_step, thick, thick_step; /* radii */
    double length2; /* squared length */
    ost_v3 middle;
    double reach;   /* maximum distance of the segment's surface from `middle` */
    double least_radius, greatest_radius;
    double flatness; /* at most 1; defined with the bounds of segment_distance in shape.c */
} ost_bar_segment;

enum { OST_BAR_SEGMENTS = 48 };
typedef struct ost_bar {
    int count;
    ost_bar_segment segment[OST_BAR_SEGMENTS];
    ost_v3 lo, hi; /* box that contains the bar */
} ost_bar;

/*
 * The segments of a bar that can be nearest to a point of a ball. `least` is a lower bound on all distances in the
 * ball.
 */
typedef struct ost_bar_part {
    const ost_bar *bar;
    double least;
    int count;
    uint8_t segment[OST_BAR_SEGMENTS];
} ost_bar_part;

/*
 * Makes a smooth bar through the nodes, with `parts` straight segments between two neighbouring
 * nodes.  (count - 1) * parts must be at most OST_BAR_SEGMENTS.
 */
void ost_bar_init(ost_bar *bar, const ost_bar_node *nodes, int count, int parts);
/*
 * Returns the distance from p to the bar. If the distance from p to the box around the bar exceeds the limit `far`,
 * returns the distance to the box, which is smaller than the distance to the bar.
 */
double ost_bar_distance(const ost_bar *bar, ost_v3 p, double far);
/*
 * Sets *part to those segments of the bar that can be nearest to a point of the ball around `centre`. The bar must
 * exist as long as *part is used.
 */
void ost_bar_near(const ost_bar *bar, ost_v3 centre, double radius, ost_bar_part *part);
/*
 * For a point p of the part's ball, returns a result that is bit-identical to
 * ost_blend(a, ost_bar_distance(part->bar, p, far), width), but takes less time.
 */
double ost_bar_blend(const ost_bar_part *part, double a, ost_v3 p, double far, double width);

#endif
