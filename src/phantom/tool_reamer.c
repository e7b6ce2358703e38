/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Makes the head of a glenoid reamer.  It has a domed cutting face toward -z with twelve radial
 * teeth, a rim with three flats so that the head fits past the retractors, and a hub with a socket
 * for the drive shaft toward +z.
 *
 *               ___   ___        z = length
 *              |   |_|   |       hub and its socket
 *          .---'         '---.
 *      .---'                 '---.
 *     |                           |   rim
 *      '-_/\_/\_       _/\_/\_-'      teeth: grooves run outward from a
 *            '--._____.--'            smooth nose
 *                              z = 0
 *
 * The dome is part of a sphere whose radius is 3/4 of the head's diameter (27 mm for a head of
 * 36 mm, about the curvature of a glenoid).  The crests of all teeth lie on the sphere and only the
 * grooves lie deeper, so a turning reamer sweeps the smooth dome.
 *
 * The flats of the rim are at 29/30 of the radius and face 0, 120 and 240 degrees. The crests of the
 * teeth are at all multiples of 30 degrees. Therefore the bounds of the default head are exactly
 * (-18, -18, 0) to (17.4, 18, 20.3) mm. The three grids of the thesis follow from these bounds
 * (docs/spec/arithmetic.md, AR-TOOL).
 *
 * In polar coordinates, the face and the back are heights as functions of the radius.  The back is
 * higher than the face everywhere, so the surface never intersects itself.
 */
#include "phantom/tool_shape.h"

#include "core/conditions.h"

enum {
    TEETH = 12,
    FACE_RINGS = 28, /* number of rings on the face, from the nose to the rim */
    NOSE_RINGS = 6,  /* number of rings without grooves at the centre of the face */
    RAMP_RINGS = 6,  /* number of rings over which the grooves grow to full depth */
    BACK_RINGS = 11,
    BACK_OF_HEAD = 4 /* number of rings of the back that precede the hub */
};

typedef struct reamer {
    ost_pm radius;
    ost_pm sphere; /* radius of the dome */
    ost_pm groove; /* maximum depth of a groove */
    int segments;
} reamer;

/*
 * Returns the depth of the groove at segment k, as a share of the maximum depth. The profile of a tooth consists
 * of a land at 0, a relief slope from 0 to 1, a floor at 1, and a steep cutting face.
 */
static ost_q60 groove_share(const reamer *r, int k)
{
    const int pitch = r->segments / TEETH;
    const int at = k % pitch;
    if (4 * at <= pitch)
        return 0;
    if (4 * at >= 3 * pitch)
        return OST_Q60_ONE;
    return ost_q60_ratio(4 * at - pitch, 2 * pitch);
}

/*
 * Returns the radius of the outline at segment k, as a share of the full radius. The share is less than 1 on the flats
 * and 1 elsewhere.
 */
static ost_q60 flat_share(const reamer *r, int k)
{
    const int third = r->segments / 3;
    const int at = k % third;
    ost_q60 c, s;
    /* The angle to the nearest flat is at most 60 degrees, so c >= 1/2. */
    ost_circle(at < third - at ? at : third - at, r->segments, &c, &s);
    const ost_q60 share = ost_q60_ratio(OST_Q60_ONE - OST_Q60_ONE / 30, c);
    return share < OST_Q60_ONE ? share : OST_Q60_ONE;
}

/*
 * Returns the height of the dome at a given distance from the axis. The square root is rounded down, so the height
 * is never negative.
 */
static ost_pm dome(const reamer *r, ost_pm distance)
{
    return r->sphere - ost_isqrt((unsigned __int128)((__int128)r->sphere * r->sphere - (__int128)distance * distance));
}

/*
 * Returns the radius of the rim at segment k, as a share of the full radius. A groove reduces the radius by up to a
 * 24th, so that the teeth are visible from the side.
 */
static ost_q60 rim_share(const reamer *r, int k)
{
    return ost_q60_times(flat_share(r, k), OST_Q60_ONE - groove_share(r, k) / 24);
}

static void face_ring(const reamer *r, ost_skin *skin, int ring)
{
    ost_pm3 *points = ost_skin_ring(skin);
    ost_pm deepest = 0;
    if (ring > NOSE_RINGS)
        deepest = ring < NOSE_RINGS + RAMP_RINGS ? r->groove * (ring - NOSE_RINGS) / RAMP_RINGS : r->groove;
    for (int k = 0; k < r->segments; k++) {
        ost_q60 c, s;
        ost_circle(k, r->segments, &c, &s);
        ost_pm distance = ost_q60_times(r->radius, rim_share(r, k)) * ring / FACE_RINGS;
        points[k].x = ost_q60_times(distance, c);
        points[k].y = ost_q60_times(distance, s);
        points[k].z = dome(r, distance) + ost_q60_times(deepest, groove_share(r, k));
    }
}

/*
 * Makes a ring of the back. If `outline` is true, the ring has the outline of the rim; otherwise, the ring is a circle.
 */
static void back_ring(const reamer *r, ost_skin *skin, ost_pm radius, ost_pm z, bool outline)
{
    if (!outline) {
        ost_skin_circle(skin, radius, z);
        return;
    }
    ost_pm3 *points = ost_skin_ring(skin);
    for (int k = 0; k < r->segments; k++) {
        ost_q60 c, s;
        ost_circle(k, r->segments, &c, &s);
        ost_pm distance = ost_q60_times(radius, rim_share(r, k));
        points[k] = (ost_pm3){ost_q60_times(distance, c), ost_q60_times(distance, s), z};
    }
}

ost_status ost_tool_make_reamer(const ost_tool_options *options, ost_mesh *out, ost_error *err)
{
    const ost_pm d = options->diameter, top = options->length;
    char a[OST_PM_TEXT], b[OST_PM_TEXT];
    if (options->segments % (2 * TEETH))
        return ost_fail(err, OST_ERR_USAGE, "a reamer has %d teeth and takes a multiple of %d segments, not %d", TEETH,
                        2 * TEETH, options->segments);
    if (20 * (int64_t)top < 9 * d)
        return ost_fail(err, OST_ERR_USAGE, "a reamer of diameter %s mm must be at least %s mm long, for its hub",
                        ost_pm_format(d, a), ost_pm_format(9 * d / 20, b));
    const reamer r = {.radius = d / 2, .sphere = 3 * d / 4, .groove = d / 24, .segments = options->segments};
    const ost_pm rim = dome(&r, r.radius);

    const bool shaft = options->part == OST_TOOL_SHAFT, head = options->part == OST_TOOL_HEAD;
    const ost_pm seam = rim + d * 54 / 360; /* height of the flat back from which the hub rises */
    if (shaft && top - d / 6 <= seam)
        return ost_fail(err, OST_ERR_USAGE, "a reamer of diameter %s mm and length %s mm has no hub", ost_pm_format(d,
                        a), ost_pm_format(top, b));
    const int first = shaft ? BACK_OF_HEAD - 1 : 0, last = head ? BACK_OF_HEAD : BACK_RINGS;

    ost_skin skin;
    ost_status status = ost_skin_init(&skin, out, r.segments, (shaft ? 0 : FACE_RINGS) + last - first, shaft ? seam : 0,
                                      head ? seam : top - d / 6, err);
    if (status != OST_OK)
        return status;
    for (int ring = 1; ring <= FACE_RINGS && !shaft; ring++)
        face_ring(&r, &skin, ring);

    /* Radii and heights are in 360ths of the diameter. For a diameter of 36 mm, a 360th is a tenth of a millimetre. */
    const struct {
        int radius;
        int above_rim; /* height above the rim; if negative, below_top gives the height */
        int below_top; /* distance below the top of the hub */
        bool outline;
    } back[BACK_RINGS] = {
        {180, 32, -1, true},  {174, 38, -1, true},  {120, 46, -1, false}, {74, 54, -1, false},
        {66, 58, -1, false},  {62, 64, -1, false},  {62, -1, 8, false},   {54, -1, 0, false},
        {34, -1, 0, false},   {30, -1, 4, false},   {30, -1, 60, false},
    };
    for (int i = first; i < last; i++) {
        ost_pm z = back[i].above_rim >= 0 ? rim + d * back[i].above_rim / 360 : top - d * back[i].below_top / 360;
        back_ring(&r, &skin, d * back[i].radius / 360, z, back[i].outline);
    }
    return OST_OK;
}
