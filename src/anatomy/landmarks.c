/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Finds the landmarks of a scapula.
 *
 *   coarse field, filled --> cells, surface --concave spheres--> candidates for the glenoid
 *   candidate --checks: bone behind it, free space in front of it, rim, blade--> face, trigonum, inferior angle
 *   repeated with another surface level, half of the rim, or a coarser field --> spreads (<osteon/anatomy.h>)
 */
#include "core/conditions.h"

#include <math.h>
#include <string.h>

#include "anatomy/blade.h"
#include "anatomy/face.h"
#include "anatomy/spheres.h"
#include "core/vector.h"

#define STEP_MM 1.5     /* cell width of the coarse field */
#define COARSER_MM 2.0  /* cell width of a second coarse field, which is used only to compute the spreads */
#define FINE_MM 0.7     /* cell width of the fine field around the face */
#define ROUND_MM 36.0   /* half width of the fine field */
#define HEAD_MM 15.0 /* maximum distance between the humeral head's centre and the centre of the glenoid's curvature */
/*
 * numbers of positions, 1 mm apart: VAULT_MM positions behind the face are checked for bone, and FREE_MM positions in
 * front of it for free space
 */
#define VAULT_MM 11
#define FREE_MM 15

/* A coarse field of the complete bone, and its cells that are bone. */
typedef struct coarse {
    anatomy_field field;
    anatomy_cells cells;
    double step;
} coarse;

typedef struct proposal {
    anatomy_face face;
    anatomy_blade blade;
    double height, width;
} proposal;

static ost_status coarse_make(const ost_anatomy_bone *bone, double step, coarse *out, ost_error *err)
{
    *out = (coarse){.step = step};
    ost_status status = ost_anatomy_field_make(bone, NULL, step, &out->field, err);
    if (status == OST_OK)
        status = ost_anatomy_field_fill(&out->field, err);
    if (status == OST_OK)
        status = ost_anatomy_cells_make(&out->field, &out->cells, err);
    if (status == OST_OK && out->cells.count < 100)
        status = ost_fail(err, OST_ERR_INPUT, "there is no bone from %d to %d", (int)bone->low, (int)bone->high);
    if (status == OST_OK)
        status = ost_anatomy_field_smooth(&out->field, err);
    return status;
}

static void coarse_free(coarse *c)
{
    ost_anatomy_cells_free(&c->cells);
    ost_anatomy_field_free(&c->field);
}

/* -------------------------------------------------------------- candidates */

/*
 * Returns the share of bone among `count` positions on a ray. The positions are 1 mm apart and begin 2 mm from
 * `from`.
 */
static double bone_along(const anatomy_field *f, const double from[3], const double way[3], int count)
{
    int bone = 0;
    for (int i = 0; i < count; i++) {
        const double p[3] = {from[0] + (i + 2) * way[0], from[1] + (i + 2) * way[1], from[2] + (i + 2) * way[2]};
        bone += ost_anatomy_field_at(f, p) >= 0.4;
    }
    return (double)bone / count;
}

/*
 * Sets `inward` to the direction from the sphere's centre into the bone, and `at` to the point where the ray in this
 * direction leaves the sphere. Returns false if the sphere cannot be a glenoid.
 */
static bool is_socket(const coarse *c, const ost_sphere *s, double at[3], double inward[3])
{
    const double centre[3] = {ost_pm_to_mm(s->centre.x), ost_pm_to_mm(s->centre.y), ost_pm_to_mm(s->centre.z)};
    double outward[3], middle[3] = {0};
    for (int a = 0; a < 3; a++) {
        inward[a] = s->facing[a];
        outward[a] = -inward[a];
        at[a] = centre[a] + ost_pm_to_mm(s->radius) * inward[a];
    }
    for (size_t i = 0; i < c->cells.count; i++)
        for (int a = 0; a < 3; a++)
            middle[a] += (c->cells.at[i][a] - at[a]) / (double)c->cells.count;
    return bone_along(&c->field, at, inward, VAULT_MM) > 0.8 && bone_along(&c->field, at, outward, FREE_MM) == 0 &&
           ost_vector_dot(middle, inward) > 15;
}

static void superior_of(const proposal *p, double out[3])
{
    double lateral[3], down[3];
    for (int a = 0; a < 3; a++) {
        lateral[a] = p->face.centre[a] - p->blade.trigonum[a];
        down[a] = p->blade.inferior[a] - p->blade.trigonum[a];
    }
    (void)ost_vector_unit(lateral, 0);
    const double along = ost_vector_dot(down, lateral);
    for (int a = 0; a < 3; a++)
        out[a] = along * lateral[a] - down[a];
    (void)ost_vector_unit(out, 2);
}

static ost_status propose(const coarse *c, const anatomy_field *fine, const anatomy_variant *variant,
                          const double at[3], const double inward[3], proposal *out, ost_error *err)
{
    double superior[3], medial[3];
    memset(out, 0, sizeof *out);
    for (int a = 0; a < 3; a++) {
        out->face.centre[a] = at[a];
        out->face.inward[a] = inward[a];
    }
    if (!ost_anatomy_face_find(fine, variant, &out->face))
        return ost_fail(err, OST_ERR_INPUT,
                        "the rim of the glenoid was found in %.0f %% of the directions; expected at least 50 %%: the "
                        "glenoid is not complete, or another bone touches it",
                        100 * out->face.seen_share);
    ost_status status =
        ost_anatomy_blade_find(&c->cells, out->face.centre, out->face.inward, c->step, &out->blade, err);
    if (status != OST_OK)
        return status;
    superior_of(out, superior);
    if (!ost_anatomy_face_align(fine, variant, superior, &out->face, &out->height, &out->width))
        return ost_fail(err, OST_ERR_INPUT, "the middle of the rim does not lie in front of bone");
    for (int a = 0; a < 3; a++)
        medial[a] = out->blade.trigonum[a] - out->face.centre[a];
    (void)ost_vector_unit(medial, 0);
    if (ost_vector_dot(medial, out->face.inward) < 0.7)
        return ost_fail(err, OST_ERR_INPUT, "the face found does not point away from the medial border");
    if (out->height < 20 || out->height > 60 || out->width < 14 || out->width > 50)
        return ost_fail(err, OST_ERR_INPUT,
                        "the rim found is %.0f mm high and %.0f mm wide; expected 20 to 60 mm and 14 to 50 mm: the "
                        "glenoid is not complete, or another bone touches it",
                        out->height, out->width);
    return OST_OK;
}

static ost_status fine_make(const ost_anatomy_bone *bone, const double at[3], anatomy_field *out, ost_error *err)
{
    anatomy_box box;
    for (int a = 0; a < 3; a++) {
        box.lo[a] = at[a] - ROUND_MM;
        box.hi[a] = at[a] + ROUND_MM;
    }
    ost_status status = ost_anatomy_field_make(bone, &box, FINE_MM, out, err);
    return status == OST_OK ? ost_anatomy_field_smooth(out, err) : status;
}

/*
 * Selects the candidate whose rim was found in the most directions. Candidates without a rim or a blade are ignored.
 */
static ost_status choose(const ost_anatomy_bone *bone, const coarse *c, const ost_sphere *spheres, int count,
                         anatomy_field *fine, proposal *best, int *chosen, ost_error *err)
{
    const anatomy_variant nominal = {0.5, 1, 0};
    ost_error reason = {OST_OK, ""};
    *chosen = -1;
    for (int i = 0; i < count; i++) {
        double at[3], inward[3];
        anatomy_field field = {.share = NULL};
        proposal p;
        if (!is_socket(c, &spheres[i], at, inward))
            continue;
        ost_status status = fine_make(bone, at, &field, err);
        if (status == OST_ERR_MEMORY) {
            ost_anatomy_field_free(&field);
            return status;
        }
        if (status == OST_OK)
            status = propose(c, &field, &nominal, at, inward, &p, &reason);
        if (status == OST_OK && (*chosen < 0 || p.face.seen_share > best->face.seen_share)) {
            ost_anatomy_field_free(fine);
            *fine = field;
            *best = p;
            *chosen = i;
        } else {
            ost_anatomy_field_free(&field);
        }
    }
    if (*chosen >= 0)
        return OST_OK;
    return ost_fail(err, OST_ERR_INPUT, "no glenoid was found: %s",
                    reason.text[0] ? reason.text
                                   : "no concave surface has bone behind it and free space in front of it; expected "
                                     "one complete scapula without the humerus");
}

/* ------------------------------------------------------------------ spread */

static double apart(const double a[3], const double b[3])
{
    const double d[3] = {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
    return sqrt(ost_vector_dot(d, d));
}

/*
 * Returns the angle between two unit vectors in degrees, or 90 if the angle is greater than 90. The arctangent is
 * computed by halving the angle, arctan x = 2 arctan(x / (1 + sqrt(1 + x^2))), and then by a series.
 */
static double angle_deg(const double a[3], const double b[3])
{
    double cross[3];
    ost_vector_cross(a, b, cross);
    const double sine = sqrt(ost_vector_dot(cross, cross)), cosine = ost_vector_dot(a, b);
    if (!(cosine > 0))
        return 90;
    double x = sine / cosine, sum = 0;
    for (int i = 0; i < 3; i++)
        x = x / (1 + sqrt(1 + x * x));
    double power = x;
    for (int k = 1; k < 24; k += 2) {
        sum += (k % 4 == 1 ? power : -power) / k;
        power *= x * x;
    }
    return sum * 8 * 57.295779513082321;
}

static void widen(const proposal *a, const proposal *b, ost_scapula_landmarks *out)
{
    const double d[4] = {apart(a->face.centre, b->face.centre), angle_deg(a->face.inward, b->face.inward),
                         apart(a->blade.trigonum, b->blade.trigonum), apart(a->blade.inferior, b->blade.inferior)};
    double *const most[4] = {&out->glenoid_spread_mm, &out->axis_spread_deg, &out->trigonum_spread_mm,
                             &out->inferior_spread_mm};
    for (int i = 0; i < 4; i++)
        *most[i] = d[i] > *most[i] ? d[i] : *most[i];
}

static ost_status spread(const ost_anatomy_bone *bone, const coarse *c, const anatomy_field *fine,
                         const proposal *best, ost_scapula_landmarks *out, ost_error *err)
{
    static const anatomy_variant variants[] = {{0.35, 1, 0}, {0.65, 1, 0}, {0.5, 2, 0}, {0.5, 2, 1}};
    proposal p;
    for (size_t i = 0; i < sizeof variants / sizeof variants[0]; i++) {
        const ost_status status = propose(c, fine, &variants[i], best->face.centre, best->face.inward, &p, err);
        if (status != OST_OK)
            return ost_fail_context(err, "the proposal is not stable");
        widen(best, &p, out);
    }
    coarse coarser;
    const anatomy_variant nominal = {0.5, 1, 0};
    ost_status status = coarse_make(bone, COARSER_MM, &coarser, err);
    if (status == OST_OK)
        status = propose(&coarser, fine, &nominal, best->face.centre, best->face.inward, &p, err);
    if (status == OST_OK)
        widen(best, &p, out);
    coarse_free(&coarser);
    return status == OST_OK ? status : ost_fail_context(err, "the proposal is not stable");
}

/* ----------------------------------------------------------------- public */

static ost_pm3 rounded(const double p[3])
{
    return (ost_pm3){anatomy_round(p[0]), anatomy_round(p[1]), anatomy_round(p[2])};
}

static int list_rim(const anatomy_face *face, ost_pm3 rim[OST_RIM_MAX])
{
    int count = 0;
    for (int k = 0; k < OST_RIM_MAX; k++)
        if (face->seen[k])
            rim[count++] = rounded(face->rim[k]);
    return count;
}

static void store(const proposal *p, const ost_sphere *curvature, ost_scapula_landmarks *out)
{
    out->glenoid = rounded(p->face.centre);
    out->trigonum = rounded(p->blade.trigonum);
    out->inferior = rounded(p->blade.inferior);
    for (int a = 0; a < 3; a++)
        out->axis[a] = (double)anatomy_floor(p->face.inward[a] * 1e6 + 0.5) / 1e6;
    out->left = p->blade.left;
    out->curvature = *curvature;
    out->height = anatomy_round(p->height);
    out->width = anatomy_round(p->width);
    out->rim_count = list_rim(&p->face, out->rim);
    out->rim_share = p->face.seen_share;
    out->rim_residual_mm = p->face.residual;
}

ost_status ost_scapula_landmarks_find(const ost_anatomy_bone *bone, const ost_sphere *head,
                                      ost_scapula_landmarks *out, ost_error *err)
{
    coarse c = {.step = 0};
    anatomy_surface surface = {.points = NULL};
    anatomy_field fine = {.share = NULL};
    ost_sphere spheres[OST_SPHERES_MAX];
    ost_sphere_options o = {.concave = true};
    proposal best;
    int count = 0, chosen = -1;
    *out = (ost_scapula_landmarks){.rim_count = 0};
    if (head) {
        o.has_near = true;
        o.near = head->centre;
        o.reach = (ost_pm)HEAD_MM * OST_PM_PER_MM;
    }
    ost_status status = ost_anatomy_bone_check(bone, err);
    if (status == OST_OK)
        status = ost_anatomy_sphere_options(&o, err);
    if (status == OST_OK)
        status = coarse_make(bone, STEP_MM, &c, err);
    if (status == OST_OK)
        status = ost_anatomy_surface_make(&c.field, &surface, err);
    if (status == OST_OK)
        status = ost_anatomy_spheres(&surface, &o, spheres, OST_SPHERES_MAX, &count, err);
    if (status == OST_OK)
        status = choose(bone, &c, spheres, count, &fine, &best, &chosen, err);
    if (status == OST_OK)
        status = spread(bone, &c, &fine, &best, out, err);
    if (status == OST_OK)
        store(&best, &spheres[chosen], out);
    ost_anatomy_surface_free(&surface);
    ost_anatomy_field_free(&fine);
    coarse_free(&c);
    return status;
}

ost_status ost_glenoid_rim_find(const ost_anatomy_bone *bone, const double centre_mm[3], const double axis[3],
                                ost_pm3 rim[OST_RIM_MAX], int *count, ost_error *err)
{
    const anatomy_variant nominal = {0.5, 1, 0};
    anatomy_field fine = {.share = NULL};
    anatomy_face face = {.centre = {centre_mm[0], centre_mm[1], centre_mm[2]}, .inward = {axis[0], axis[1], axis[2]}};
    *count = 0;
    ost_status status = ost_anatomy_bone_check(bone, err);
    for (int a = 0; a < 3 && status == OST_OK; a++)
        if (!(fabs(centre_mm[a]) <= 8000))
            status = ost_fail(err, OST_ERR_RANGE, "the glenoid at %g mm; expected a position within 8 m", centre_mm[a]);
    const double length = ost_vector_unit(face.inward, 0);
    if (status == OST_OK && !(length > 0 && isfinite(length)))
        status = ost_fail(err, OST_ERR_RANGE, "the axis of the glenoid is not a direction");
    if (status == OST_OK)
        status = fine_make(bone, centre_mm, &fine, err);
    if (status == OST_OK) {
        ost_anatomy_face_rim(&fine, &nominal, &face);
        *count = list_rim(&face, rim);
    }
    ost_anatomy_field_free(&fine);
    return status;
}
