/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Defines the parts of the scapula and joins them (scapula.h).
 *
 * Three of the parts are plates.  A plate is a curved sheet that is given as a height
 * over a plane and cut out along an outline.  Its thickness depends on the position.
 *
 *   body      over (x, z): y = body_sheet, thick along the lateral border
 *   spine     over (x, y): z = spine_sheet, thin, with a crest swept along it
 *   acromion  over (x, y): z = acromion_sheet
 *
 * The coracoid and the spine's crest are swept bars.  The glenoid is pear-shaped,
 * narrows inward to the neck, and is hollowed by a sphere.
 *
 * All lengths are in millimetres of the mean shape.
 */
#include <string.h>

#include "phantom/noise.h"
#include "phantom/scapula.h"

enum { EDGE_THIN = 0, EDGE_LATERAL = 1, EDGE_MEDIAL = 2 };

/*
 * The outline of the body. It runs from the superior angle down the medial border, around the inferior angle, up
 * the lateral border to the glenoid, and along the superior border with the notch.
 */
static const ost_outline_point BODY[] = {
    {26, 37, EDGE_MEDIAL},   {14, 30, EDGE_MEDIAL},    {5, 16, EDGE_MEDIAL},     {0, 2, EDGE_MEDIAL},
    {-3, -16, EDGE_MEDIAL},  {-5, -40, EDGE_MEDIAL},   {-5, -64, EDGE_MEDIAL},   {-3, -86, EDGE_MEDIAL},
    {2, -103, EDGE_MEDIAL},  {9, -111.5, EDGE_MEDIAL}, {17, -113, EDGE_LATERAL}, {24, -107.5, EDGE_LATERAL},
    {30, -97, EDGE_LATERAL}, {38, -82, EDGE_LATERAL},  {51, -63, EDGE_LATERAL},  {66, -44, EDGE_LATERAL},
    {79, -29, EDGE_LATERAL}, {90, -18, EDGE_LATERAL},  {94, -4, EDGE_THIN},      {92, 10, EDGE_THIN},
    {84, 18, EDGE_THIN},     {75, 19, EDGE_THIN},      {71.5, 14, EDGE_THIN},    {68, 10.5, EDGE_THIN},
    {64, 12.5, EDGE_THIN},   {60, 18, EDGE_THIN},      {51, 23.5, EDGE_THIN},    {41, 30, EDGE_THIN},
    {33, 36, EDGE_MEDIAL},
};

/*
 * The outline of the spine, seen from above. It runs along the root, out along the neck, around the spinoglenoid
 * notch, and back along the crest.
 */
static const ost_outline_point SPINE[] = {
    {4, -1.5, 0}, {20, -6.5, 0}, {45, -10, 0}, {66, -8, 0},  {78, -5, 0},  {79, -9, 0},    {77, -16, 0}, {79, -24, 0},
    {86, -31, 0}, {90, -38, 0},  {80, -42, 0}, {66, -36, 0}, {50, -27, 0}, {34, -17.5, 0}, {18, -10, 0}, {8, -4.5, 0},
};

/*
 * The outline of the acromion, seen from above. It runs from the end of the spine over the posterior angle, the
 * lateral edge, the tip and the facet for the clavicle to the medial edge.
 */
static const ost_outline_point ACROMION[] = {
    {72, -39, 0},    {82, -44, 0},   {93, -46.5, 0}, {103, -43, 0}, {111, -35, 0},  {117, -24, 0},
    {119.5, -12, 0}, {118.5, -2, 0}, {114, 4.5, 0},  {108.5, 4, 0}, {105.5, -3, 0}, {102, -11, 0},
    {97, -19, 0},    {90.5, -25, 0}, {83, -29.5, 0}, {75, -33, 0},
};

/*
 * The outline of the glenoid's rim, seen en face. The coordinates are (forward, up). The notch at the front is the
 * place where the growth centres fused.
 */
static const ost_outline_point PEAR[] = {
    {-1, -17.3, 0}, {5.5, -16.2, 0}, {10.2, -12.2, 0}, {12.4, -6.5, 0},   {11.7, -1, 0},    {9.2, 3.8, 0},
    {7.8, 7.9, 0},  {7.5, 11.5, 0},  {5.7, 15.2, 0},   {1.8, 17.3, 0},    {-3.1, 16.6, 0},  {-7.1, 13.3, 0},
    {-9.5, 8.2, 0}, {-11.3, 2.2, 0}, {-12.6, -4.2, 0}, {-11.8, -10.1, 0}, {-7.9, -15.2, 0},
};

/* The crest, which is the free edge of the spine. The vector `side` lies in the flat plane of the crest. */
static const ost_bar_node CREST[] = {
    {{7, -2.6, 0}, 4, 1.1, {0.2, -0.1, 1}},    {{12, -5.2, 0.2}, 4.4, 1.6, {0.2, -0.4, 1}},
    {{21, -10, 1.2}, 4.2, 2.2, {0, -0.4, 1}},  {{33, -17.5, 2.6}, 5, 2.6, {0, -0.3, 1}},
    {{48, -26, 5}, 4.2, 2.6, {0, -0.3, 1}},    {{62, -33.5, 8.6}, 4, 2.9, {0, -0.4, 1}},
    {{75, -39, 12.4}, 4.2, 3.4, {0, -0.9, 1}}, {{86, -42.5, 15.6}, 4.4, 3.8, {0, -1, 0.4}},
};

/*
 * The pillar along the lateral border, from top to bottom. The pillar supports the glenoid and ends at the inferior
 * angle.
 */
static const ost_bar_node PILLAR[] = {
    {{86, -2.4, -12}, 7.5, 4.6, {0, 0, 1}},   {{75, -3.4, -25}, 5.2, 3.4, {1, 0, -1}},
    {{61, -2.6, -43}, 4.6, 2.9, {1, 0, -1}},  {{46, -0.4, -61}, 4.4, 2.6, {1, 0, -1}},
    {{32, 1.8, -81}, 4.2, 2.3, {1, 0, -0.6}}, {{22, 3.4, -100}, 4.4, 2.2, {1, 0, -0.4}},
    {{14, 4, -107}, 5, 2, {1, 0, 0.2}},
};

/*
 * The coracoid, which begins at the neck above the glenoid, runs up and forward, and is then bent
 * outward like a beak.  The vector `side` is level.
 */
static const ost_bar_node CORACOID[] = {
    {{83, 1, 12}, 9, 6.6, {1, 0, -0.1}},           {{82.5, 6, 20}, 8, 5.8, {1, 0, 0}},
    {{83.5, 12.5, 26}, 7, 4.8, {1, -0.3, 0}},      {{88.5, 20, 28}, 6.3, 4.5, {0.8, -0.6, 0}},
    {{96, 26, 26.2}, 6, 4.3, {0.5, -0.8, 0}},      {{104, 30, 22}, 5.6, 4.2, {0.4, -0.9, 0}},
    {{109.5, 32, 18.5}, 4.6, 3.8, {0.4, -0.9, 0}},
};

/* The start of the spine at the neck: a rounded buttress. */
static const ost_bar_node ROOT[] = {
    {{58, -7, 4}, 4, 2.6, {1, 0, 0}}, {{72, -7.5, 5}, 5.5, 3.6, {0, 0, 1}}, {{84, -4, 3}, 9, 6, {0, 0, 1}},
};

/*
 * CARTILAGE is the thickness of the cartilage at the centre. In a CT, the blur removes some of this thickness on
 * both sides.
 */
#define GREATEST_SIZE 1.142 /* maximum size that fits into the box of Table 3.1; the scapula of a tall man */
#define CARTILAGE 2.4
#define DISH_RADIUS 31.0
#define PAD_RADIUS 29.0
#define FAR 14.0 /* distance in mm beyond which a part has no effect on a blended shape */
#define FARTHER 100.0

static double square(double v)
{
    return v * v;
}

/* Returns a smooth bump: 1 at v = centre, falling to 0 at v = centre - half and at v = centre + half. */
static double bump(double v, double centre, double half)
{
    double t = 1 - square((v - centre) / half);
    return t > 0 ? t * t : 0;
}

/*
 * Returns the height y of the body's sheet.  The sheet is hollow toward the ribs and deepest below
 * the spine, and its upper part leans forward.
 */
static double body_sheet(const ost_scapula *s, double x, double z)
{
    double ripple = 1.1 * (ost_value_noise(s->seed + 15, (x - 0.5 * z) / 13, (z + 0.3 * x) / 24, 0) - 0.5);
    double hollow = -8.5 * bump(x, 44, 62) * bump(z, -22, 105);
    double lean = z > -4 ? 0.0068 * square(z + 4) : 0;
    double foot = z < -60 ? 0.0016 * square(z + 60) : 0;
    double neck = -1.5 * ost_smooth(60, 90, x);
    return hollow + lean + foot + neck + ripple;
}

/*
 * Returns half of the body's thickness.  The body is a thin, translucent sheet with a thicker rim,
 * and with ridges for the muscle toward the ribs.
 */
static double body_half(const ost_scapula *s, double x, double z)
{
    double lateral = ost_outline_to_tag(&s->body, EDGE_LATERAL, x, z),
           medial = ost_outline_to_tag(&s->body, EDGE_MEDIAL, x, z);
    double half = 1.15 + 2.2 / (1 + square(lateral / 7) * (1 + square(lateral / 7))) +
                  1.15 / (1 + square(medial / 4) * (1 + square(medial / 4)));
    half += 2.6 * ost_smooth(64, 90, x) * bump(z, -4, 30);          /* the body is thicker toward the neck */
    half += 1.1 * bump(x, 14, 26) * bump(z, -108, 26);              /* the body is thicker at the inferior angle */
    half += 0.8 * bump(x, 26, 14) * bump(z, 36, 14);                /* the body is thicker at the superior angle */
    return half;
}

static double spine_sheet(double x, double y)
{
    double rise = 0.0034 * ost_clamp(x, 0, 100), behind = -y - 6.5 * ost_smooth(0, 40, x);
    return 0.075 * x - 0.5 + rise * behind;
}

static double acromion_sheet(double x, double y)
{
    return 18.8 + 0.29 * (x - 93) + 0.11 * (y + 46) - 0.0042 * square(x - 104) - 0.0034 * square(y + 16);
}

/*
 * Returns the distance to a plate with a round edge. `off` is the distance from the sheet in the middle of the plate,
 * `inside` is the distance inside the plate's outline, and `half` is half of the thickness.
 */
static double plate(double off, double inside, double half)
{
    off = off < 0 ? -off : off;
    if (inside >= half)
        return off - half;
    return sqrt(square(half - inside) + square(off)) - half;
}

/*
 * Returns the distance to the vault of the glenoid. Toward the neck, the pear-shaped cross section
 * shrinks, more in width than in height, and its middle moves to the sheet of the body.
 */
static double vault(const ost_scapula *s, double depth, double ahead, double above)
{
    if (depth > 56 || depth < -30)
        return ost_max(depth - 34, -12 - depth);
    double deep = ost_clamp(depth, 0, 34);
    double wide = 1 - 0.72 * ost_smooth(0, 30, deep), high = 1 - 0.36 * ost_smooth(1, 30, deep);
    double u = (ahead + 1.2 * ost_smooth(2, 22, deep)) / wide, v = (above - 1.5 * ost_smooth(2, 22, deep)) / high;
    double side = -ost_outline_inside(&s->pear, u, v) * (wide + 0.25 * (high - wide));
    return ost_blend_both(side, ost_max(depth - 34, -12 - depth), 9);
}

void ost_scapula_near(const ost_scapula *s, ost_v3 centre, double radius, ost_scapula_part *part)
{
    part->scapula = s;
    ost_bar_near(&s->crest, centre, radius, &part->crest);
    ost_bar_near(&s->pillar, centre, radius, &part->pillar);
    ost_bar_near(&s->coracoid, centre, radius, &part->coracoid);
    ost_bar_near(&s->root, centre, radius, &part->root);
}

void ost_scapula_at(const ost_scapula_part *part, ost_v3 p, ost_scapula_sample *out)
{
    const ost_scapula *s = part->scapula;
    ost_v3 from = ost_v3_sub(p, s->face);
    double depth = -ost_v3_dot(from, s->out), ahead = ost_v3_dot(from, s->ahead), above = ost_v3_dot(from, s->above);

    /*
     * Heights above the sheets are used in place of distances. Above a sloped sheet, the height is greater than the
     * distance. Where this has an effect, the height is at most a tenth greater.
     */
    double body = 1e30, half = 0;
    double inside = ost_outline_inside(&s->body, p.x, p.z);
    if (inside > -FAR) {
        half = body_half(s, p.x, p.z);
        body = plate(0.95 * (p.y - body_sheet(s, p.x, p.z)), inside, half);
    } else {
        body = -inside - 4;
    }
    double spine = -ost_outline_inside(&s->spine, p.x, p.y) - 3;
    if (spine < FAR) {
        double thin = 1.5 + 0.9 * bump(p.y, -6, 12);
        spine = plate(0.95 * (p.z - spine_sheet(p.x, p.y)), -spine - 3, thin);
    }
    double acromion = -ost_outline_inside(&s->acromion, p.x, p.y) - 5;
    if (acromion < FAR)
        acromion = plate(0.92 * (p.z - acromion_sheet(p.x, p.y)), -acromion - 5, 3.3 + 0.5 * bump(p.x, 98, 20));

    double blade = ost_bar_blend(&part->pillar, body, p, FAR, 11);
    blade = ost_blend(blade, spine, 5);
    blade = ost_bar_blend(&part->root, blade, p, FAR, 7);
    blade = ost_blend(blade, vault(s, depth, ahead, above), 12);

    /*
     * The dish is cut out before the processes are added, because its sphere is as large as the humeral head and would
     * cut into the processes.
     */
    double dish = ost_v3_length(ost_v3_sub(p, s->dish)) - DISH_RADIUS;
    double shape[2] = {ost_blend_both(blade, -dish, 1.6), blade};
    const bool same = shape[0] == shape[1];
    for (int i = 0; i < (same ? 1 : 2); i++) {
        shape[i] = ost_bar_blend(&part->crest, shape[i], p, FAR, 2.5);
        shape[i] = ost_blend(shape[i], acromion, 5);
        shape[i] = ost_bar_blend(&part->coracoid, shape[i], p, FAR, 6);
    }
    if (same)
        shape[1] = shape[0];
    bool near = depth > -14 && depth < 20 && above < 21 && above > -24 && ahead * ahead < 22 * 22;
    out->bone = shape[0] * s->size;
    out->wall = shape[1] * s->size;
    out->dish = (near ? dish : FARTHER) * s->size;
    out->cartilage = FARTHER;
    if (near) {
        double pad = ost_v3_length(ost_v3_sub(p, s->pad)) - PAD_RADIUS,
               rim = -ost_outline_inside(&s->pear, ahead, above);
        out->cartilage = ost_blend_both(ost_max(-pad, dish), rim + 0.6, 1.2) * s->size;
    }
    out->depth = depth * s->size;
    out->ahead = ahead * s->size;
}

/* Returns a pseudo-random number in [-1, 1]. */
static double vary(uint64_t seed, int what)
{
    return 2 * ost_unit(ost_hash3(seed, what, 0, 0), 0) - 1;
}

static ost_status outline(ost_outline *o, const ost_outline_point *points, int count, double step, double margin,
                          double jitter, uint64_t seed, ost_error *err)
{
    ost_outline_point moved[48];
    for (int i = 0; i < count; i++) {
        moved[i] = points[i];
        moved[i].u += jitter * vary(seed, 100 + 2 * i);
        moved[i].v += jitter * vary(seed, 101 + 2 * i);
    }
    return ost_outline_init(o, moved, count, step, margin, err);
}

#define COUNT(array) ((int)(sizeof(array) / sizeof *(array)))

ost_status ost_scapula_init(ost_scapula *s, uint64_t seed, ost_error *err)
{
    memset(s, 0, sizeof *s);
    s->seed = seed;
    s->size = GREATEST_SIZE * (0.982 + 0.010 * vary(seed, 1));
    /*
     * Tangents of the angles by which the face is tilted backward and upward. The mean angles are 2 and 5 degrees; each
     * varies by up to 2 degrees.
     */
    double back = 0.035 + 0.035 * vary(seed, 2), up = 0.087 + 0.035 * vary(seed, 3);
    s->face = (ost_v3){99, 0, 0};
    s->out = ost_v3_unit((ost_v3){1, -back, up});
    s->above = ost_v3_unit(ost_v3_mad((ost_v3){0, 0, 1}, s->out, -s->out.z));
    s->ahead = ost_v3_cross(s->above, s->out);
    s->dish = ost_v3_mad(s->face, s->out, DISH_RADIUS - CARTILAGE);
    s->pad = ost_v3_mad(s->face, s->out, PAD_RADIUS + 0.15);

    ost_status status = outline(&s->body, BODY, COUNT(BODY), 0.5, FAR + 2, 0.5, seed + 11, err);
    if (status == OST_OK)
        status = outline(&s->spine, SPINE, COUNT(SPINE), 0.5, FAR + 2, 0.3, seed + 12, err);
    if (status == OST_OK)
        status = outline(&s->acromion, ACROMION, COUNT(ACROMION), 0.5, FAR + 2, 0.5, seed + 13, err);
    if (status == OST_OK)
        status = outline(&s->pear, PEAR, COUNT(PEAR), 0.25, 9, 0.15, seed + 14, err);
    if (status != OST_OK) {
        ost_scapula_free(s);
        return status;
    }
    s->trigonum = (ost_v3){0, body_sheet(s, 0, 0), 0};
    s->inferior = (ost_v3){12, body_sheet(s, 12, -112.5), -112.5};
    ost_bar_init(&s->crest, CREST, COUNT(CREST), 3);
    ost_bar_init(&s->pillar, PILLAR, COUNT(PILLAR), 3);
    ost_bar_init(&s->coracoid, CORACOID, COUNT(CORACOID), 4);
    ost_bar_init(&s->root, ROOT, COUNT(ROOT), 3);
    return OST_OK;
}

void ost_scapula_free(ost_scapula *s)
{
    ost_outline_free(&s->body);
    ost_outline_free(&s->spine);
    ost_outline_free(&s->acromion);
    ost_outline_free(&s->pear);
}
