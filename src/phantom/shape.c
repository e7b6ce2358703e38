/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Computes outlines and swept bars (shape.h).
 */
#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "phantom/shape.h"

/*
 * Returns the value at t of a Catmull-Rom spline. The spline is b at t = 0 and c at t = 1, with the tangents (c -
 * a) / 2 and (d - b) / 2.
 */
static double spline(double a, double b, double c, double d, double t)
{
    double c1 = 0.5 * (c - a), c2 = a - 2.5 * b + 2 * c - 0.5 * d, c3 = 0.5 * (d - a) + 1.5 * (b - c);
    return b + t * (c1 + t * (c2 + t * c3));
}

/* ---------------------------------------------------------------- outline */

enum { PIECES = 6 }; /* number of straight pieces between two points of an outline */

typedef struct piece {
    double u, v, du, dv, inverse; /* start (u, v) and direction (du, dv) of the piece; inverse: 1 / squared length */
    /*
     * Coordinate v of the piece's end. It is bit-identical to the start v of the next piece, so that a ray through the
     * common point of two pieces crosses exactly one of them.
     */
    double end_v;
    int tag;
} piece;

/*
 * Stores in best[t] the squared distance from (u, v) to the nearest piece with tag t. Returns true if (u, v) lies
 * inside the outline, according to the number of crossings of a ray along u.
 */
static bool measure(const piece *pieces, int count, double u, double v, double best[OST_OUTLINE_TAGS])
{
    bool inside = false;
    for (int t = 0; t < OST_OUTLINE_TAGS; t++)
        best[t] = 1e30;
    for (int i = 0; i < count; i++) {
        const piece *p = &pieces[i];
        double t = ost_clamp(((u - p->u) * p->du + (v - p->v) * p->dv) * p->inverse, 0, 1);
        double eu = u - p->u - t * p->du, ev = v - p->v - t * p->dv, e = eu * eu + ev * ev;
        if (e < best[p->tag])
            best[p->tag] = e;
        if ((p->v > v) != (p->end_v > v) && u < p->u + p->du * (v - p->v) / p->dv)
            inside = !inside;
    }
    return inside;
}

ost_status ost_outline_init(ost_outline *outline, const ost_outline_point *points, int count, double step,
                            double margin, ost_error *err)
{
    memset(outline, 0, sizeof *outline);
    piece *pieces = malloc((size_t)count * PIECES * sizeof *pieces);
    if (!pieces)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for an outline of %d points", count);
    double lo_u = 1e30, lo_v = 1e30, hi_u = -1e30, hi_v = -1e30;
    bool used[OST_OUTLINE_TAGS] = {false};
    for (int i = 0; i < count; i++) {
        const ost_outline_point *a = &points[(i + count - 1) % count], *b = &points[i], *c = &points[(i + 1) % count],
                                *d = &points[(i + 2) % count];
        used[b->tag] = true;
        for (int k = 0; k < PIECES; k++) {
            double t = (double)k / PIECES;
            piece *p = &pieces[i * PIECES + k];
            p->u = spline(a->u, b->u, c->u, d->u, t);
            p->v = spline(a->v, b->v, c->v, d->v, t);
            p->tag = b->tag;
            lo_u = ost_min(lo_u, p->u), hi_u = ost_max(hi_u, p->u);
            lo_v = ost_min(lo_v, p->v), hi_v = ost_max(hi_v, p->v);
        }
    }
    for (int i = 0; i < count * PIECES; i++) {
        piece *p = &pieces[i];
        const piece *next = &pieces[(i + 1) % (count * PIECES)];
        p->end_v = next->v;
        p->du = next->u - p->u;
        p->dv = next->v - p->v;
        p->inverse = 1 / (p->du * p->du + p->dv * p->dv);
    }
    outline->u0 = lo_u - margin;
    outline->v0 = lo_v - margin;
    outline->step = step;
    outline->nu = (int)((hi_u - lo_u + 2 * margin) / step) + 2;
    outline->nv = (int)((hi_v - lo_v + 2 * margin) / step) + 2;
    size_t cells = (size_t)outline->nu * (size_t)outline->nv;
    ost_status status = OST_OK;
    outline->inside = malloc(cells * sizeof *outline->inside);
    for (int t = 0; t < OST_OUTLINE_TAGS; t++)
        outline->to_tag[t] = used[t] ? malloc(cells * sizeof *outline->to_tag[t]) : NULL;
    for (int t = 0; t < OST_OUTLINE_TAGS; t++)
        if (!outline->inside || (used[t] && !outline->to_tag[t])) {
            status = ost_fail(err, OST_ERR_MEMORY, "out of memory for an outline's table of %zu places", cells);
            ost_outline_free(outline);
            break;
        }
    if (status != OST_OK) {
        free(pieces);
        return status;
    }
#pragma omp parallel for
    for (int64_t at = 0; at < (int64_t)cells; at++) {
        double best[OST_OUTLINE_TAGS], least = 1e30;
        double u = outline->u0 + step * (double)(at % outline->nu), v = outline->v0 + step * (double)(at / outline->nu);
        bool inside = measure(pieces, count * PIECES, u, v, best);
        for (int t = 0; t < OST_OUTLINE_TAGS; t++) {
            least = ost_min(least, best[t]);
            if (used[t])
                outline->to_tag[t][at] = sqrt(best[t]);
        }
        outline->inside[at] = inside ? sqrt(least) : -sqrt(least);
    }
    free(pieces);
    return OST_OK;
}

void ost_outline_free(ost_outline *outline)
{
    free(outline->inside);
    for (int t = 0; t < OST_OUTLINE_TAGS; t++)
        free(outline->to_tag[t]);
    memset(outline, 0, sizeof *outline);
}

/*
 * Returns the value of a table at the point (u, v). A point outside the table is first moved to the nearest point of
 * the table's border, and *beyond is set to the distance moved.
 */
static double lookup(const ost_outline *o, const double *table, double u, double v, double *beyond)
{
    double a = (u - o->u0) / o->step, b = (v - o->v0) / o->step;
    double ca = ost_clamp(a, 0, o->nu - 1), cb = ost_clamp(b, 0, o->nv - 1);
    *beyond = (ca == a && cb == b) ? 0 : o->step * sqrt((a - ca) * (a - ca) + (b - cb) * (b - cb));
    int i = (int)ca, j = (int)cb;
    i = i > o->nu - 2 ? o->nu - 2 : i;
    j = j > o->nv - 2 ? o->nv - 2 : j;
    const double *t = table + (size_t)j * (size_t)o->nu + (size_t)i;
    double fa = ca - i, fb = cb - j;
    double low = t[0] + fa * (t[1] - t[0]), high = t[o->nu] + fa * (t[o->nu + 1] - t[o->nu]);
    return low + fb * (high - low);
}

double ost_outline_inside(const ost_outline *outline, double u, double v)
{
    double beyond, value = lookup(outline, outline->inside, u, v, &beyond);
    return value - beyond;
}

double ost_outline_to_tag(const ost_outline *outline, int tag, double u, double v)
{
    double beyond, value = lookup(outline, outline->to_tag[tag], u, v, &beyond);
    return value + beyond;
}

/* ------------------------------------------------------------------ sweep */

static void segment_init(ost_bar_segment *segment, const ost_bar_node *a, const ost_bar_node *b)
{
    const ost_v3 half = ost_v3_mad((ost_v3){0, 0, 0}, ost_v3_sub(b->at, a->at), 0.5);
    segment->from = a->at;
    segment->step = ost_v3_sub(b->at, a->at);
    segment->side = a->side;
    segment->side_step = ost_v3_sub(b->side, a->side);
    segment->wide = a->wide;
    segment->wide_step = b->wide - a->wide;
    segment->thick = a->thick;
    segment->thick_step = b->thick - a->thick;
    segment->length2 = ost_v3_dot(segment->step, segment->step);
    segment->middle = ost_v3_mad(a->at, half, 1);
    segment->least_radius = ost_min(ost_min(a->wide, a->thick), ost_min(b->wide, b->thick));
    segment->greatest_radius = ost_max(ost_max(a->wide, a->thick), ost_max(b->wide, b->thick));
    segment->reach = ost_v3_length(half) + segment->greatest_radius;
    segment->flatness = ost_min(2 / (a->wide / a->thick + a->thick / a->wide),
                                2 / (b->wide / b->thick + b->thick / b->wide));
}

void ost_bar_init(ost_bar *bar, const ost_bar_node *nodes, int count, int parts)
{
    assert(count > 1 && (count - 1) * parts <= OST_BAR_SEGMENTS);
    memset(bar, 0, sizeof *bar);
    bar->lo = (ost_v3){1e30, 1e30, 1e30};
    bar->hi = (ost_v3){-1e30, -1e30, -1e30};
    ost_bar_node before = nodes[0];
    for (int i = 0; i < count; i++) {
        const ost_bar_node *a = &nodes[i > 0 ? i - 1 : 0], *b = &nodes[i], *c = &nodes[i + 1 < count ? i + 1 : i],
                             *d = &nodes[i + 2 < count ? i + 2 : count - 1];
        for (int k = 0; k < (i + 1 < count ? parts : 1); k++) {
            double t = (double)k / parts;
            ost_bar_node n;
            n.at.x = spline(a->at.x, b->at.x, c->at.x, d->at.x, t);
            n.at.y = spline(a->at.y, b->at.y, c->at.y, d->at.y, t);
            n.at.z = spline(a->at.z, b->at.z, c->at.z, d->at.z, t);
            n.wide = b->wide + t * (c->wide - b->wide);
            n.thick = b->thick + t * (c->thick - b->thick);
            n.side = ost_v3_mad(b->side, ost_v3_sub(c->side, b->side), t);
            double r = ost_max(n.wide, n.thick);
            bar->lo = (ost_v3){ost_min(bar->lo.x, n.at.x - r), ost_min(bar->lo.y, n.at.y - r),
                               ost_min(bar->lo.z, n.at.z - r)};
            bar->hi = (ost_v3){ost_max(bar->hi.x, n.at.x + r), ost_max(bar->hi.y, n.at.y + r),
                               ost_max(bar->hi.z, n.at.z + r)};
            if (i > 0 || k > 0)
                segment_init(&bar->segment[bar->count++], &before, &n);
            before = n;
        }
    }
}

/*
 * Returns the first-order distance (k - 1) / |grad k| from p to an ellipsoid. The ellipsoid has the radii (wide, thick,
 * thick), and its centre is the point of the path nearest to p. k is the distance of p from the centre relative to the
 * radii, so the surface is k = 1.
 */
static double segment_distance(const ost_bar_segment *segment, ost_v3 p)
{
    ost_v3 from = ost_v3_sub(p, segment->from);
    double t = ost_clamp(ost_v3_dot(from, segment->step) / segment->length2, 0, 1);
    ost_v3 off = ost_v3_mad(from, segment->step, -t);
    ost_v3 side = ost_v3_mad(segment->side, segment->side_step, t);
    side = ost_v3_unit(ost_v3_mad(side, segment->step, -ost_v3_dot(side, segment->step) / segment->length2));
    double wide = segment->wide + t * segment->wide_step, thick = segment->thick + t * segment->thick_step;
    double s = ost_v3_dot(off, side), rest2 = ost_max(ost_v3_dot(off, off) - s * s, 0);
    double k2 = s * s / (wide * wide) + rest2 / (thick * thick);
    double g2 = s * s / (wide * wide * wide * wide) + rest2 / (thick * thick * thick * thick);
    if (g2 < 1e-12)
        return -ost_min(wide, thick);
    double k = sqrt(k2);
    return k * (k - 1) / sqrt(g2);
}

/*
 * Returns true if the segment may be nearer to p than the distance `best`; ost_bar_distance skips all other segments.
 * If the result is true for some value of `best`, it is true for all greater values, because every operation is
 * monotonic, including its rounding.
 */
static bool is_in_reach(const ost_bar_segment *segment, ost_v3 p, double best)
{
    /* The factor 1.5 is needed because the distances that segment_distance returns next to a flat bar are too great. */
    const ost_v3 d = ost_v3_sub(p, segment->middle);
    const double reach_limit = ost_max(best, 0) * 1.5 + segment->reach;
    return ost_v3_dot(d, d) < reach_limit * reach_limit;
}

/* Returns the squared distance from p to the box that contains the bar. */
static double box_distance2(const ost_bar *bar, ost_v3 p)
{
    double dx = ost_max(ost_max(bar->lo.x - p.x, p.x - bar->hi.x), 0);
    double dy = ost_max(ost_max(bar->lo.y - p.y, p.y - bar->hi.y), 0);
    double dz = ost_max(ost_max(bar->lo.z - p.z, p.z - bar->hi.z), 0);
    return dx * dx + dy * dy + dz * dz;
}

double ost_bar_distance(const ost_bar *bar, ost_v3 p, double far)
{
    const double box2 = box_distance2(bar, p);
    if (box2 > far * far)
        return sqrt(box2);
    double best = 1e30;
    for (int i = 0; i < bar->count; i++)
        if (is_in_reach(&bar->segment[i], p, best))
            best = ost_min(best, segment_distance(&bar->segment[i], p));
    return best;
}

/*
 * Bounds of segment_distance for a point and a segment:
 *
 *   o                  distance from the point to the segment's path
 *   s, r               components of o: s along `side`, r perpendicular to `side`
 *   w, t               radii at the nearest point of the path: w along `side`, t perpendicular to `side`
 *   least, greatest    smallest and largest radius anywhere on the segment
 *
 *   k^2 = s^2 / w^2 + r^2 / t^2,   g^2 = s^2 / w^4 + r^2 / t^4,   segment_distance = k^2 / g - k / g,
 *
 * k^2 / g is the product of the vectors (s, r) and (s / w^2, r / t^2), divided by the length of the second vector. It
 * is at most o, and at least o * flatness, where flatness = 2 / (w / t + t / w) (Kantorovich's inequality). k^2 / g^2
 * is a weighted mean of w^2 and t^2. Therefore
 *
 *   o * flatness - greatest  <=  segment_distance  <=  o - least.
 *
 * Along a segment, w / t is a monotonic function, so flatness is least at one of the ends. A segment whose lower bound
 * in the ball is above the upper bound of another segment is not the nearest segment to any point of the ball. MARGIN,
 * in mm, exceeds all rounding errors, which are below 1e-9 mm.
 */
#define MARGIN 1e-6

void ost_bar_near(const ost_bar *bar, ost_v3 centre, double radius, ost_bar_part *part)
{
    double lower[OST_BAR_SEGMENTS], upper = 1e30;
    part->bar = bar;
    part->least = 1e30;
    part->count = 0;
    for (int i = 0; i < bar->count; i++) {
        const ost_bar_segment *segment = &bar->segment[i];
        const ost_v3 from = ost_v3_sub(centre, segment->from);
        const double t = ost_clamp(ost_v3_dot(from, segment->step) / segment->length2, 0, 1);
        const double off = ost_v3_length(ost_v3_mad(from, segment->step, -t));
        lower[i] = ost_max(off - radius, 0) * segment->flatness - segment->greatest_radius - MARGIN;
        upper = ost_min(upper, off + radius - segment->least_radius + MARGIN);
        part->least = ost_min(part->least, lower[i]);
    }
    for (int i = 0; i < bar->count; i++)
        if (lower[i] <= upper)
            part->segment[part->count++] = (uint8_t)i;
}

double ost_bar_blend(const ost_bar_part *part, double a, ost_v3 p, double far, double width)
{
    /* The distance to the bar is at least part->least, or greater than the limit `far`. If a + width is below both
       bounds, the bar does not affect the blend, whose result is then a. */
    if (a + width < part->least && a + width < far - MARGIN)
        return a;
    const ost_bar *bar = part->bar;
    const double box2 = box_distance2(bar, p);
    if (box2 > far * far)
        return ost_blend(a, sqrt(box2), width);
    double best = 1e30;
    int nearest = 0;
    for (int i = 0; i < part->count; i++) {
        const double d = segment_distance(&bar->segment[part->segment[i]], p);
        if (d < best) {
            best = d;
            nearest = part->segment[i];
        }
    }
    /*
     * If is_in_reach returns false for the nearest segment, ost_bar_distance skips this segment and returns a greater
     * distance. This function must return the same distance.
     */
    if (!is_in_reach(&bar->segment[nearest], p, best))
        best = ost_bar_distance(bar, p, far);
    return ost_blend(a, best, width);
}
