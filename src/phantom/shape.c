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
    double u, v, du, dv, inverse; /* start and direction of the piece; inverse of its squared length */
    /*
     * Coordinate v of the piece's end, bit-identical to v of the next piece. Therefore a ray through the common
     * point of two pieces crosses exactly one of the two pieces.
     */
    double end_v;
    int tag;
} piece;

/*
 * Computes the squared distance to the nearest piece of each tag. Returns true if (u, v) lies inside the outline,
 * which is determined by the crossings of a ray along u.
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
    for (size_t at = 0; status == OST_OK && at < cells; at++) {
        double best[OST_OUTLINE_TAGS], least = 1e30;
        double u = outline->u0 + step * (double)(at % (size_t)outline->nu),
               v = outline->v0 + step * (double)(at / (size_t)outline->nu);
        bool inside = measure(pieces, count * PIECES, u, v, best);
        for (int t = 0; t < OST_OUTLINE_TAGS; t++) {
            least = ost_min(least, best[t]);
            if (used[t])
                outline->to_tag[t][at] = sqrt(best[t]);
        }
        outline->inside[at] = inside ? sqrt(least) : -sqrt(least);
    }
    free(pieces);
    return status;
}

void ost_outline_free(ost_outline *outline)
{
    free(outline->inside);
    for (int t = 0; t < OST_OUTLINE_TAGS; t++)
        free(outline->to_tag[t]);
    memset(outline, 0, sizeof *outline);
}

/*
 * Returns the value of a table at the point (u, v), after clamping the point to the table. Sets *beyond to the
 * distance by which the point was clamped.
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

void ost_bar_init(ost_bar *bar, const ost_bar_node *nodes, int count, int parts)
{
    assert((count - 1) * parts < OST_BAR_NODES);
    memset(bar, 0, sizeof *bar);
    bar->lo = (ost_v3){1e30, 1e30, 1e30};
    bar->hi = (ost_v3){-1e30, -1e30, -1e30};
    for (int i = 0; i < count; i++) {
        const ost_bar_node *a = &nodes[i > 0 ? i - 1 : 0], *b = &nodes[i], *c = &nodes[i + 1 < count ? i + 1 : i],
                             *d = &nodes[i + 2 < count ? i + 2 : count - 1];
        for (int k = 0; k < (i + 1 < count ? parts : 1); k++) {
            double t = (double)k / parts;
            ost_bar_node *n = &bar->node[bar->count++];
            n->at.x = spline(a->at.x, b->at.x, c->at.x, d->at.x, t);
            n->at.y = spline(a->at.y, b->at.y, c->at.y, d->at.y, t);
            n->at.z = spline(a->at.z, b->at.z, c->at.z, d->at.z, t);
            n->wide = b->wide + t * (c->wide - b->wide);
            n->thick = b->thick + t * (c->thick - b->thick);
            n->side = ost_v3_mad(b->side, ost_v3_sub(c->side, b->side), t);
            double r = ost_max(n->wide, n->thick);
            bar->lo = (ost_v3){ost_min(bar->lo.x, n->at.x - r), ost_min(bar->lo.y, n->at.y - r),
                               ost_min(bar->lo.z, n->at.z - r)};
            bar->hi = (ost_v3){ost_max(bar->hi.x, n->at.x + r), ost_max(bar->hi.y, n->at.y + r),
                               ost_max(bar->hi.z, n->at.z + r)};
        }
    }
    for (int i = 0; i + 1 < bar->count; i++) {
        const ost_bar_node *a = &bar->node[i], *b = &bar->node[i + 1];
        ost_v3 half = ost_v3_mad((ost_v3){0, 0, 0}, ost_v3_sub(b->at, a->at), 0.5);
        bar->middle[i] = ost_v3_mad(a->at, half, 1);
        bar->reach[i] = ost_v3_length(half) + ost_max(ost_max(a->wide, a->thick), ost_max(b->wide, b->thick));
    }
}

/*
 * Returns the first-order distance (k - 1) / |grad k| to an ellipsoid around the nearest point of the path. The
 * ellipsoid has the radii (wide, thick, thick). k is the distance from its centre, relative to its radii.
 */
static double piece_distance(const ost_bar_node *a, const ost_bar_node *b, ost_v3 p)
{
    ost_v3 along = ost_v3_sub(b->at, a->at), from = ost_v3_sub(p, a->at);
    double t = ost_clamp(ost_v3_dot(from, along) / ost_v3_dot(along, along), 0, 1);
    ost_v3 off = ost_v3_mad(from, along, -t);
    ost_v3 side = ost_v3_mad(a->side, ost_v3_sub(b->side, a->side), t);
    side = ost_v3_unit(ost_v3_mad(side, along, -ost_v3_dot(side, along) / ost_v3_dot(along, along)));
    double wide = a->wide + t * (b->wide - a->wide), thick = a->thick + t * (b->thick - a->thick);
    double s = ost_v3_dot(off, side), rest2 = ost_max(ost_v3_dot(off, off) - s * s, 0);
    double k2 = s * s / (wide * wide) + rest2 / (thick * thick);
    double g2 = s * s / (wide * wide * wide * wide) + rest2 / (thick * thick * thick * thick);
    if (g2 < 1e-12)
        return -ost_min(wide, thick);
    double k = sqrt(k2);
    return k * (k - 1) / sqrt(g2);
}

double ost_bar_distance(const ost_bar *bar, ost_v3 p, double far)
{
    double dx = ost_max(ost_max(bar->lo.x - p.x, p.x - bar->hi.x), 0);
    double dy = ost_max(ost_max(bar->lo.y - p.y, p.y - bar->hi.y), 0);
    double dz = ost_max(ost_max(bar->lo.z - p.z, p.z - bar->hi.z), 0);
    double box2 = dx * dx + dy * dy + dz * dz;
    if (box2 > far * far)
        return sqrt(box2);
    double best = 1e30;
    for (int i = 0; i + 1 < bar->count; i++) {
        /* The factor 1.5 is needed, because piece_distance returns too great a distance next to a flat bar. */
        ost_v3 d = ost_v3_sub(p, bar->middle[i]);
        double reach_limit = ost_max(best, 0) * 1.5 + bar->reach[i];
        if (ost_v3_dot(d, d) < reach_limit * reach_limit)
            best = ost_min(best, piece_distance(&bar->node[i], &bar->node[i + 1], p));
    }
    return best;
}
