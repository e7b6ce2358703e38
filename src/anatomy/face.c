/* SPDX-License-Identifier: Apache-2.0 */
#include "core/conditions.h"

#include "anatomy/face.h"

#include <math.h>

#include "core/fit.h"
#include "core/vector.h"

enum { WAYS = OST_RIM_MAX, ROUNDS = 5 };
#define FRONT_MM (-12.0) /* rays start at FRONT_MM and end at BACK_MM, measured inward from the centre along the axis */
#define BACK_MM 20.0
#define RAY_MM 0.5
#define NEAREST_MM 4.0   /* the rim is searched for between NEAREST_MM and FARTHEST_MM from the axis */
#define FARTHEST_MM 30.0
#define STEP_MM 0.25
#define FALL_MM 3.0
#define LEVEL_MM 1.0
#define CLIMB_MM 8.0 /* maximum height above the centre; higher positions are on the coracoid or the acromion */
/* maximum difference between the rim's distance from the axis and the median of this distance over five adjacent
 * directions */
#define OUTLIER_MM 4.0
/* maximum distance of a point from the first plane; points farther away are excluded from the second fit */
#define OFF_PLANE_MM 3.0
#define COS_CHORD 0.93969262078590838 /* cosine of 20 degrees */
#define COS_WAY 0.99619469809174553 /* cosine of 5 degrees, the angle between two neighbouring directions */
#define SIN_WAY 0.08715574274765817

/* Computes two unit vectors perpendicular to the inward direction and to each other. */
static void across(const double inward[3], double u[3], double v[3])
{
    int least = 0;
    for (int a = 1; a < 3; a++)
        least = fabs(inward[a]) < fabs(inward[least]) ? a : least;
    const double axis[3] = {least == 0, least == 1, least == 2};
    ost_vector_cross(inward, axis, u);
    (void)ost_vector_unit(u, 0);
    ost_vector_cross(inward, u, v);
}

/* Returns the position of the first surface along a ray, or BACK_MM if the ray meets no surface. */
static double surface_along(const anatomy_field *f, double level, const double from[3], const double inward[3])
{
    double before = 0;
    for (double w = FRONT_MM; w < BACK_MM; w += RAY_MM) {
        const double p[3] = {from[0] + w * inward[0], from[1] + w * inward[1], from[2] + w * inward[2]};
        const double share = ost_anatomy_field_at(f, p);
        if (share >= level)
            return before < level && w > FRONT_MM ? w - RAY_MM * (share - level) / (share - before) : w;
        before = share;
    }
    return BACK_MM;
}

/*
 * Follows the surface outward in the direction `way`. Returns the distance of the rim from the axis, or 0 if there is
 * no rim. The distance is negative if the surface does not end at the rim but climbs to another part of the bone.
 */
static double trace(const anatomy_field *f, double level, const anatomy_face *face, const double way[3],
                    double rim[3], double crest[3])
{
    const double start = surface_along(f, level, face->centre, face->inward);
    double highest = BACK_MM, last = 0;
    for (double r = NEAREST_MM; r <= FARTHEST_MM; r += STEP_MM) {
        double p[3];
        for (int a = 0; a < 3; a++)
            p[a] = face->centre[a] + r * way[a];
        const double w = surface_along(f, level, p, face->inward);
        const bool end = w >= BACK_MM || w > highest + FALL_MM;
        if (highest < BACK_MM && (end || w < highest - FALL_MM || w < start - CLIMB_MM))
            return end ? last : -last;
        if (end)
            return 0;
        for (int a = 0; a < 3 && w <= highest; a++)
            crest[a] = p[a] + w * face->inward[a];
        highest = w < highest ? w : highest;
        if (w <= highest + LEVEL_MM) {
            last = r;
            for (int a = 0; a < 3; a++)
                rim[a] = p[a] + w * face->inward[a];
        }
    }
    return 0;
}

static double median5(double v[5])
{
    for (int i = 1; i < 5; i++)
        for (int k = i; k > 0 && v[k] < v[k - 1]; k--) {
            const double swap = v[k];
            v[k] = v[k - 1];
            v[k - 1] = swap;
        }
    return v[2];
}

/*
 * Finds the rim. In each direction, the rim is accepted only if its distance from the axis is close to the median over
 * five adjacent directions (OUTLIER_MM). The tolerance is halved if the surface climbs to another part of the bone in
 * this direction, such as the root of the coracoid.
 */
void ost_anatomy_face_rim(const anatomy_field *f, const anatomy_variant *variant, anatomy_face *face)
{
    double u[3], v[3], c = 1, s = 0, r[WAYS];
    int seen = 0, used = 0;
    across(face->inward, u, v);
    for (int k = 0; k < WAYS; k++) {
        double way[3];
        for (int a = 0; a < 3; a++)
            way[a] = c * u[a] + s * v[a];
        r[k] = trace(f, variant->level, face, way, face->rim[k], face->crest[k]);
        const double next = c * COS_WAY - s * SIN_WAY;
        s = s * COS_WAY + c * SIN_WAY;
        c = next;
    }
    for (int k = 0; k < WAYS; k++) {
        double near[5];
        for (int i = 0; i < 5; i++)
            near[i] = fabs(r[(k + i - 2 + WAYS) % WAYS]);
        const double median = median5(near);
        face->seen[k] = false;
        if (k % variant->every != variant->first)
            continue;
        used++;
        face->seen[k] = r[k] != 0 && fabs(fabs(r[k]) - median) <= (r[k] < 0 ? 0.5 : 1) * OUTLIER_MM;
        seen += face->seen[k];
    }
    face->seen_share = (double)seen / used;
}

/* Fits the plane to the crest twice. The second fit excludes points that are far from the first plane. */
static bool fit_plane(anatomy_face *face, double normal[3])
{
    double points[WAYS][3], mean[3] = {0}, along[3];
    for (int a = 0; a < 3; a++)
        along[a] = -face->inward[a];
    for (int round = 0; round < 2; round++) {
        size_t count = 0;
        double squares = 0;
        for (int k = 0; k < WAYS; k++) {
            const double off[3] = {face->crest[k][0] - mean[0], face->crest[k][1] - mean[1],
                                   face->crest[k][2] - mean[2]};
            if (!face->seen[k] || (round && fabs(ost_vector_dot(off, normal)) > OFF_PLANE_MM))
                continue;
            for (int a = 0; a < 3; a++)
                points[count][a] = face->crest[k][a];
            count++;
        }
        if (!ost_fit_plane((const double(*)[3])points, count, along, normal, mean))
            return false;
        for (size_t i = 0; i < count; i++) {
            const double off[3] = {points[i][0] - mean[0], points[i][1] - mean[1], points[i][2] - mean[2]};
            const double d = ost_vector_dot(off, normal);
            squares += d * d;
        }
        face->residual = sqrt(squares / (double)count);
    }
    return true;
}

/* Moves the point `from` along the axis onto the surface. */
static bool onto_surface(const anatomy_field *f, double level, const double from[3], anatomy_face *face)
{
    const double w = surface_along(f, level, from, face->inward);
    for (int a = 0; a < 3; a++)
        face->centre[a] = from[a] + w * face->inward[a];
    return w > FRONT_MM && w < BACK_MM;
}

bool ost_anatomy_face_find(const anatomy_field *f, const anatomy_variant *variant, anatomy_face *face)
{
    for (int round = 0; round < ROUNDS; round++) {
        double normal[3], middle[3] = {0};
        int pairs = 0;
        ost_anatomy_face_rim(f, variant, face);
        if (face->seen_share < 0.5 || !fit_plane(face, normal))
            return false;
        for (int k = 0; k < WAYS / 2; k++)
            if (face->seen[k] && face->seen[k + WAYS / 2]) {
                pairs++;
                for (int a = 0; a < 3; a++)
                    middle[a] += 0.5 * (face->rim[k][a] + face->rim[k + WAYS / 2][a]);
            }
        if (pairs < 6)
            return false;
        for (int a = 0; a < 3; a++) {
            face->inward[a] = -normal[a];
            middle[a] /= pairs;
        }
        if (!onto_surface(f, variant->level, middle, face))
            return false;
    }
    return true;
}

/* Measures the extents of the rim along two directions, and moves the centre to the middle of these extents. */
static bool centre_on_extents(const anatomy_field *f, double level, double way[2][3], anatomy_face *face,
                              double extent[2])
{
    double from[3] = {face->centre[0], face->centre[1], face->centre[2]};
    for (int i = 0; i < 2; i++) {
        double lo = 1e9, hi = -1e9;
        for (int k = 0; k < WAYS; k++) {
            if (!face->seen[k])
                continue;
            const double p[3] = {face->rim[k][0] - face->centre[0], face->rim[k][1] - face->centre[1],
                                 face->rim[k][2] - face->centre[2]};
            const double at = ost_vector_dot(p, way[i]);
            lo = at < lo ? at : lo;
            hi = at > hi ? at : hi;
        }
        extent[i] = hi - lo;
        for (int a = 0; a < 3; a++)
            from[a] += 0.5 * (lo + hi) * way[i][a];
    }
    return onto_surface(f, level, from, face);
}

/* Computes the mean direction of the chords that join opposite crest points and lie within 20 degrees of `way`. */
static bool mean_chord(const anatomy_face *face, const double way[3], double out[3])
{
    for (int a = 0; a < 3; a++)
        out[a] = 0;
    int chords = 0;
    for (int k = 0; k < WAYS / 2; k++) {
        const double *p = face->crest[k], *q = face->crest[k + WAYS / 2];
        double chord[3] = {p[0] - q[0], p[1] - q[1], p[2] - q[2]};
        if (!face->seen[k] || !face->seen[k + WAYS / 2])
            continue;
        (void)ost_vector_unit(chord, 0);
        const double along = ost_vector_dot(chord, way);
        if (fabs(along) < COS_CHORD)
            continue;
        chords++;
        for (int a = 0; a < 3; a++)
            out[a] += along > 0 ? chord[a] : -chord[a];
    }
    return chords && ost_vector_unit(out, 0) > 0;
}

/*
 * Computes the residual: the RMS distance of the crest points from the plane that is perpendicular to the axis
 * and contains their mean.
 */
static void measure_plane(anatomy_face *face)
{
    double sum = 0, squares = 0;
    int count = 0;
    for (int k = 0; k < WAYS; k++) {
        if (!face->seen[k])
            continue;
        const double off[3] = {face->crest[k][0] - face->centre[0], face->crest[k][1] - face->centre[1],
                               face->crest[k][2] - face->centre[2]};
        const double w = ost_vector_dot(off, face->inward);
        count++;
        sum += w;
        squares += w * w;
    }
    const double variance = count ? squares / count - (sum / count) * (sum / count) : 0;
    face->residual = variance > 0 ? sqrt(variance) : 0;
}

bool ost_anatomy_face_align(const anatomy_field *f, const anatomy_variant *variant, const double superior[3],
                            anatomy_face *face, double *height, double *width)
{
    for (int round = 0; round < 3; round++) {
        double way[2][3], chord[2][3], extent[2];
        const double along = ost_vector_dot(superior, face->inward);
        for (int a = 0; a < 3; a++)
            way[0][a] = superior[a] - along * face->inward[a];
        (void)ost_vector_unit(way[0], 2);
        ost_vector_cross(way[0], face->inward, way[1]);
        if (!centre_on_extents(f, variant->level, way, face, extent))
            return false;
        ost_anatomy_face_rim(f, variant, face);
        *height = extent[0];
        *width = extent[1];
        if (face->seen_share < 0.5 || !mean_chord(face, way[0], chord[0]) || !mean_chord(face, way[1], chord[1]))
            return false;
        /* The chords are close to way[0] and way[1], so their cross product points inward, as way[1] x way[0] does. */
        ost_vector_cross(chord[1], chord[0], face->inward);
        (void)ost_vector_unit(face->inward, 0);
        const double from[3] = {face->centre[0], face->centre[1], face->centre[2]};
        if (!onto_surface(f, variant->level, from, face))
            return false;
    }
    measure_plane(face);
    return true;
}
