/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Finds spheres on a surface.
 *
 *   point, normal --a vote every millimetre of radius along the normal--> votes per cell of 2 mm
 *   maxima of the votes --radius with the most points--> sphere --least squares, repeated--> sphere
 *
 * The normals point out of the bone. The centre of a concave sphere lies in the direction of its points' normals, and
 * the centre of a convex sphere lies in the opposite direction. The inner surface of a cortical shell has the opposite
 * normals, so its points do not vote for the centre of the outer surface.
 */
#include "core/conditions.h"

#include "anatomy/spheres.h"

#include <stdlib.h>

#include "core/fit.h"
#include "core/vector.h"

enum {
    VOTE_CELLS_MAX = 1 << 24,
    MAXIMA = 32,   /* number of vote maxima that are refined */
    ROUNDS = 8,    /* number of fits per sphere */
    FACE_BINS = 8, /* bins per cube edge; directions from the sphere's centre are counted in 8 x 8 bins on each face
                    * of a cube */
    BINS = 6 * FACE_BINS * FACE_BINS
};
#define STEP_MM 1.5         /* cell width of the field */
#define VOTE_MM 2.0         /* cell width of the vote grid */
#define APART_MM 10.0       /* minimum distance between the centres of two spheres */
#define COARSE_MM 3.0       /* maximum distance of a point from the sphere: COARSE_MM in the first fit, decreasing to
                             * FINE_MM in the last */
#define FINE_MM 1.2
/* minimum cosine of the angle between a point's normal and the normal of the sphere at this point */
#define ALIGNED 0.85
#define COVERAGE_MIN 0.15
#define AREA_MIN_MM2 200.0

typedef struct search {
    const anatomy_surface *surface;
    const ost_sphere_options *options;
    double sign;            /* direction from a point to the centre: 1 along the point's normal, -1 against it */
    double least, most;     /* limits of the radius in mm */
    double lo[3], cell;     /* corner of the vote grid, and cell width */
    int32_t n[3];
    uint32_t *votes, *copy; /* owned */
} search;

typedef struct fitted {
    double centre[3], radius;
    double area, residual, coverage, facing[3];
} fitted;

/* ------------------------------------------------------------------- votes */

static ost_status votes_init(search *s, ost_error *err)
{
    double hi[3];
    for (int a = 0; a < 3; a++) {
        s->lo[a] = hi[a] = s->surface->points[0].at[a];
        for (size_t i = 1; i < s->surface->count; i++) {
            const double v = s->surface->points[i].at[a];
            s->lo[a] = v < s->lo[a] ? v : s->lo[a];
            hi[a] = v > hi[a] ? v : hi[a];
        }
        /* The centre of a convex sphere lies inside the bone's bounding box. The centre of a concave sphere may lie
         * outside the box, but at most by the largest radius. */
        s->lo[a] -= s->options->concave ? s->most : VOTE_MM;
        hi[a] += s->options->concave ? s->most : VOTE_MM;
    }
    int64_t cells;
    for (s->cell = VOTE_MM;; s->cell *= 1.25) {
        cells = 1;
        for (int a = 0; a < 3; a++) {
            s->n[a] = (int32_t)anatomy_floor((hi[a] - s->lo[a]) / s->cell) + 1;
            cells *= s->n[a];
        }
        if (cells <= VOTE_CELLS_MAX)
            break;
    }
    s->votes = calloc((size_t)cells, sizeof *s->votes);
    s->copy = malloc((size_t)cells * sizeof *s->copy);
    if (!s->votes || !s->copy)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for %lld cells of votes", (long long)cells);
    return OST_OK;
}

static bool cell_of(const search *s, const double at[3], size_t *cell)
{
    size_t index = 0;
    for (int a = 2; a >= 0; a--) {
        const double v = (at[a] - s->lo[a]) / s->cell;
        if (!(v >= 0 && v < s->n[a]))
            return false;
        index = index * (size_t)s->n[a] + (size_t)v;
    }
    *cell = index;
    return true;
}

static void vote(search *s)
{
    for (size_t i = 0; i < s->surface->count; i++) {
        const anatomy_point *p = &s->surface->points[i];
        for (double r = s->least; r <= s->most; r += 1) {
            double at[3];
            size_t cell;
            for (int a = 0; a < 3; a++)
                at[a] = p->at[a] + s->sign * r * p->normal[a];
            if (cell_of(s, at, &cell))
                s->votes[cell]++;
        }
    }
}

/* Replaces each cell with the sum of its neighbourhood, weighted by 1, 2, 1 along each axis. */
static void smooth(search *s)
{
    const size_t stride[3] = {1, (size_t)s->n[0], (size_t)s->n[0] * (size_t)s->n[1]};
    const size_t cells = stride[2] * (size_t)s->n[2];
    for (int a = 0; a < 3; a++) {
        for (size_t i = 0; i < cells; i++) {
            const size_t k = i / stride[a] % (size_t)s->n[a];
            s->copy[i] = 2 * s->votes[i] + (k ? s->votes[i - stride[a]] : 0) +
                         (k + 1 < (size_t)s->n[a] ? s->votes[i + stride[a]] : 0);
        }
        uint32_t *const swap = s->votes;
        s->votes = s->copy;
        s->copy = swap;
    }
}

/* Finds the cell with the most votes, and sets all cells near it to 0. Returns false if all cells are 0. */
static bool next_maximum(search *s, double centre[3])
{
    uint32_t most = 0;
    int32_t c[3], at[3] = {0, 0, 0};
    size_t i = 0;
    for (c[2] = 0; c[2] < s->n[2]; c[2]++)
        for (c[1] = 0; c[1] < s->n[1]; c[1]++)
            for (c[0] = 0; c[0] < s->n[0]; c[0]++, i++)
                if (s->votes[i] > most) {
                    most = s->votes[i];
                    for (int a = 0; a < 3; a++)
                        at[a] = c[a];
                }
    if (!most)
        return false;
    const int32_t near = (int32_t)(0.5 * APART_MM / s->cell) + 1;
    int32_t lo[3], hi[3];
    for (int a = 0; a < 3; a++) {
        centre[a] = s->lo[a] + (at[a] + 0.5) * s->cell;
        lo[a] = at[a] > near ? at[a] - near : 0;
        hi[a] = at[a] + near < s->n[a] ? at[a] + near + 1 : s->n[a];
    }
    for (c[2] = lo[2]; c[2] < hi[2]; c[2]++)
        for (c[1] = lo[1]; c[1] < hi[1]; c[1]++)
            for (c[0] = lo[0]; c[0] < hi[0]; c[0]++)
                s->votes[(size_t)c[0] + (size_t)s->n[0] * ((size_t)c[1] + (size_t)s->n[1] * (size_t)c[2])] = 0;
    return true;
}

/* --------------------------------------------------------------------- fit */

/*
 * Computes the distance from the centre to a point, and the unit vector in this direction. Returns false if the point's
 * normal is not aligned with this vector.
 */
static bool seen_from(const search *s, const double centre[3], const anatomy_point *p, double along[3], double *far)
{
    for (int a = 0; a < 3; a++)
        along[a] = p->at[a] - centre[a];
    *far = ost_vector_unit(along, 0);
    return -s->sign * ost_vector_dot(along, p->normal) >= ALIGNED;
}

/*
 * Tries all permitted radii in steps of 0.5 mm. Returns the radius in mm for which the points within COARSE_MM / 2 of
 * the sphere cover the largest part of the sphere.
 */
static double best_radius(const search *s, const double centre[3])
{
    enum { STEPS = 256, WINDOW = (int)(2 * COARSE_MM) };
    double area[STEPS] = {0}, best = 0, radius = s->least;
    for (size_t i = 0; i < s->surface->count; i++) {
        double along[3], far;
        if (seen_from(s, centre, &s->surface->points[i], along, &far) && far * 2 < STEPS)
            area[(int)(far * 2)] += s->surface->points[i].area / (far * far + 1);
    }
    for (int k = 0; k + WINDOW <= STEPS; k++) {
        const double middle = (k + 0.5 * WINDOW) * 0.5;
        double sum = 0;
        for (int i = k; i < k + WINDOW; i++)
            sum += area[i];
        if (middle < s->least || middle > s->most || sum <= best)
            continue;
        best = sum;
        radius = middle;
    }
    return radius;
}

/* Returns the index of the bin that contains a direction (FACE_BINS). */
static int bin_of(const double v[3])
{
    int axis = 0;
    for (int a = 1; a < 3; a++)
        axis = fabs(v[a]) > fabs(v[axis]) ? a : axis;
    int at[2];
    for (int k = 0; k < 2; k++) {
        const double t = (v[(axis + 1 + k) % 3] / fabs(v[axis]) + 1) * 0.5 * FACE_BINS;
        at[k] = t >= FACE_BINS ? FACE_BINS - 1 : (int)t;
    }
    return ((2 * axis + (v[axis] < 0)) * FACE_BINS + at[1]) * FACE_BINS + at[0];
}

/*
 * Computes a sphere's area, residual, coverage and direction (`facing`) from the points within `within` mm of the
 * sphere. Stores these points in `inliers` and returns their number.
 */
static size_t measure(const search *s, fitted *f, double within, double (*inliers)[3])
{
    double squares = 0, sum[3] = {0};
    bool seen[BINS] = {false};
    size_t count = 0;
    f->area = 0;
    for (size_t i = 0; i < s->surface->count; i++) {
        const anatomy_point *p = &s->surface->points[i];
        double along[3], far;
        if (!seen_from(s, f->centre, p, along, &far) || fabs(far - f->radius) > within)
            continue;
        for (int a = 0; a < 3; a++) {
            inliers[count][a] = p->at[a];
            sum[a] += along[a] * p->area;
        }
        count++;
        f->area += p->area;
        squares += (far - f->radius) * (far - f->radius) * p->area;
        seen[bin_of(along)] = true;
    }
    int bins = 0;
    for (int i = 0; i < BINS; i++)
        bins += seen[i];
    f->residual = f->area > 0 ? sqrt(squares / f->area) : 0;
    f->coverage = (double)bins / BINS;
    for (int a = 0; a < 3; a++)
        f->facing[a] = sum[a];
    (void)ost_vector_unit(f->facing, 0);
    return count;
}

/*
 * Refines a sphere by repeated fits. Returns false in these cases: a fit fails or has too few points; the radius leaves
 * its range; the centre is too far from the position in the option `near`; the area or the coverage is too small.
 */
static bool refine(const search *s, fitted *f, double (*inliers)[3])
{
    f->radius = best_radius(s, f->centre);
    for (int round = 0; round < ROUNDS; round++) {
        const double within = COARSE_MM + (FINE_MM - COARSE_MM) * round / (ROUNDS - 1);
        const size_t count = measure(s, f, within, inliers);
        if (count < 20 || !ost_fit_sphere((const double(*)[3])inliers, count, f->centre, &f->radius) ||
            f->radius < s->least || f->radius > s->most)
            return false;
    }
    (void)measure(s, f, FINE_MM, inliers);
    if (s->options->has_near) {
        const double near[3] = {ost_pm_to_mm(s->options->near.x), ost_pm_to_mm(s->options->near.y),
                                ost_pm_to_mm(s->options->near.z)};
        if (ost_vector_distance(near, f->centre) > ost_pm_to_mm(s->options->reach))
            return false;
    }
    return s->options->concave ? f->area >= AREA_MIN_MM2 : f->coverage >= COVERAGE_MIN;
}

/*
 * Inserts a sphere into the sorted list, and removes worse spheres near it. If a better sphere is near it, the
 * list is not changed.
 */
static void insert(const search *s, const fitted *f, fitted *list, int *count)
{
    const double score = s->options->concave ? f->area : f->coverage;
    int kept = 0, at = 0;
    for (int i = 0; i < *count; i++) {
        const bool better = (s->options->concave ? list[i].area : list[i].coverage) >= score;
        if (ost_vector_distance(list[i].centre, f->centre) < APART_MM) {
            if (better)
                return;
            continue;
        }
        at += better;
        list[kept++] = list[i];
    }
    for (int i = kept; i > at; i--)
        list[i] = list[i - 1];
    list[at] = *f;
    *count = kept + 1;
}

ost_status ost_anatomy_spheres(const anatomy_surface *surface, const ost_sphere_options *options, ost_sphere *out,
                               int most, int *count, ost_error *err)
{
    search s = {.surface = surface, .options = options, .sign = options->concave ? 1 : -1,
                .least = ost_pm_to_mm(options->radius_min), .most = ost_pm_to_mm(options->radius_max)};
    fitted list[MAXIMA + 1];
    int found = 0;
    *count = 0;
    if (!surface->count)
        return OST_OK;
    double(*inliers)[3] = malloc(surface->count * sizeof *inliers);
    ost_status status = inliers ? votes_init(&s, err)
                                : ost_fail(err, OST_ERR_MEMORY, "out of memory for %zu points", surface->count);
    if (status == OST_OK) {
        vote(&s);
        smooth(&s);
        fitted f = {.area = 0};
        for (int i = 0; i < MAXIMA && next_maximum(&s, f.centre); i++)
            if (refine(&s, &f, inliers))
                insert(&s, &f, list, &found);
    }
    for (int i = 0; i < found && i < most; i++) {
        const fitted *f = &list[i];
        out[(*count)++] = (ost_sphere){
            .centre = {anatomy_round(f->centre[0]), anatomy_round(f->centre[1]), anatomy_round(f->centre[2])},
            .radius = anatomy_round(f->radius), .coverage = f->coverage, .area_mm2 = f->area,
            .residual_mm = f->residual, .facing = {f->facing[0], f->facing[1], f->facing[2]}};
    }
    free(inliers);
    free(s.votes);
    free(s.copy);
    return status;
}

/* ----------------------------------------------------------------- public */

ost_status ost_anatomy_sphere_options(ost_sphere_options *o, ost_error *err)
{
    const ost_pm mm = OST_PM_PER_MM;
    if (!o->radius_min && !o->radius_max) {
        o->radius_min = (o->concave ? 20 : 17) * mm;
        o->radius_max = (o->concave ? 45 : 32) * mm;
    }
    if (o->radius_min < 5 * mm || o->radius_max > 100 * mm || o->radius_min > o->radius_max)
        return ost_fail(err, OST_ERR_RANGE, "radii from %.9g to %.9g mm; expected a range within 5 to 100 mm",
                        ost_pm_to_mm(o->radius_min), ost_pm_to_mm(o->radius_max));
    if (o->has_near && o->reach <= 0)
        return ost_fail(err, OST_ERR_RANGE, "a reach of %.9g mm; expected more than 0", ost_pm_to_mm(o->reach));
    return OST_OK;
}

ost_status ost_anatomy_bone_check(const ost_anatomy_bone *bone, ost_error *err)
{
    if (!bone || !bone->volume || !bone->volume->voxels)
        return ost_fail(err, OST_ERR_USAGE, "a volume with voxels is needed");
    if (bone->low < 1 || bone->high > INT16_MAX || bone->low > bone->high)
        return ost_fail(err, OST_ERR_RANGE, "bone from %d to %d; expected a range within 1 to %d", (int)bone->low,
                        (int)bone->high, INT16_MAX);
    return ost_geometry_check(&bone->volume->geometry, "the volume", err);
}

ost_status ost_spheres_find(const ost_anatomy_bone *bone, const ost_sphere_options *options, ost_sphere *out,
                            int most, int *count, ost_error *err)
{
    ost_sphere_options o = options ? *options : (ost_sphere_options){.concave = false};
    anatomy_field field = {.share = NULL};
    anatomy_surface surface = {.points = NULL};
    ost_status status = ost_anatomy_bone_check(bone, err);
    *count = 0;
    if (status == OST_OK && (most < 1 || most > OST_SPHERES_MAX))
        status = ost_fail(err, OST_ERR_RANGE, "%d spheres; expected 1 to %d", most, OST_SPHERES_MAX);
    if (status == OST_OK)
        status = ost_anatomy_sphere_options(&o, err);
    if (status == OST_OK)
        status = ost_anatomy_field_make(bone, NULL, STEP_MM, &field, err);
    if (status == OST_OK)
        status = ost_anatomy_field_fill(&field, err);
    if (status == OST_OK)
        status = ost_anatomy_field_smooth(&field, err);
    if (status == OST_OK)
        status = ost_anatomy_surface_make(&field, &surface, err);
    if (status == OST_OK)
        status = ost_anatomy_spheres(&surface, &o, out, most, count, err);
    if (status == OST_OK && !*count)
        status = ost_fail(err, OST_ERR_INPUT, "no %s surface with a radius from %.9g to %.9g mm was found",
                          o.concave ? "concave" : "spherical", ost_pm_to_mm(o.radius_min),
                          ost_pm_to_mm(o.radius_max));
    ost_anatomy_surface_free(&surface);
    ost_anatomy_field_free(&field);
    return status;
}
