/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Reads the position, axis and side of a glenoid from the header facts of a grid: OST_META_GLENOID_AT,
 * OST_META_GLENOID_AXIS, OST_META_SIDE.
 */
#include <osteon/sim.h>

#include <math.h>
#include <string.h>

static ost_status missing(const char *key, ost_error *err)
{
    return ost_fail(err, OST_ERR_USAGE, "the glenoid is not set: the bone's header has no '%s'", key);
}

/* Parses three numbers, separated by blanks or commas. Returns false if `text` contains anything else. */
static bool three_numbers(const char *text, ost_decimal out[3])
{
    const char *p = text, *end = text + strlen(text);
    for (int a = 0; a < 3; a++) {
        p += strspn(p, " ,");
        p = ost_decimal_read(p, end, &out[a]);
        if (!p)
            return false;
    }
    return !p[strspn(p, " ")];
}

/*
 * Converts a component of a direction and rounds it to nine decimal places. Further digits have no effect on a
 * pose, whose unit is 2^-30.
 */
static bool direction(const ost_decimal *value, double *out)
{
    int64_t nano;
    if (!ost_decimal_scale(value, 1000000000, &nano, NULL))
        return false;
    *out = (double)nano / 1e9;
    return true;
}

static ost_status point(const char *key, const char *text, ost_pm3 *out, ost_error *err)
{
    ost_decimal p[3];
    if (!three_numbers(text, p))
        return ost_fail(err, OST_ERR_INPUT, "%s: '%s'; expected three numbers X,Y,Z in millimetres", key, text);
    if (!ost_decimal_to_pm(&p[0], &out->x, NULL) || !ost_decimal_to_pm(&p[1], &out->y, NULL) ||
        !ost_decimal_to_pm(&p[2], &out->z, NULL))
        return ost_fail(err, OST_ERR_RANGE, "%s: '%s'; expected numbers from -8000 to 8000 mm", key, text);
    return OST_OK;
}

ost_status ost_point_from_meta(const ost_meta *meta, const char *key, ost_pm3 *out, bool *there, ost_error *err)
{
    const char *text = ost_meta_get(meta, key);
    *there = text != NULL;
    return text ? point(key, text, out, err) : OST_OK;
}

ost_status ost_axis_from_meta(const ost_meta *meta, double axis[3], bool *there, ost_error *err)
{
    const char *text = ost_meta_get(meta, OST_META_GLENOID_AXIS);
    ost_decimal d[3];
    *there = text != NULL;
    if (!text)
        return OST_OK;
    if (!three_numbers(text, d))
        return ost_fail(err, OST_ERR_INPUT, "%s: '%s'; expected three numbers X,Y,Z", OST_META_GLENOID_AXIS, text);
    if (!direction(&d[0], &axis[0]) || !direction(&d[1], &axis[1]) || !direction(&d[2], &axis[2]) ||
        (axis[0] == 0 && axis[1] == 0 && axis[2] == 0))
        return ost_fail(err, OST_ERR_INPUT, "%s: '%s' is not a direction", OST_META_GLENOID_AXIS, text);
    return OST_OK;
}

ost_status ost_side_from_meta(const ost_meta *meta, ost_side *out, ost_error *err)
{
    const char *text = ost_meta_get(meta, OST_META_SIDE);
    *out = !text                        ? OST_SIDE_UNKNOWN
           : strcmp(text, "left") == 0  ? OST_SIDE_LEFT
           : strcmp(text, "right") == 0 ? OST_SIDE_RIGHT
                                        : OST_SIDE_UNKNOWN;
    if (text && *out == OST_SIDE_UNKNOWN)
        return ost_fail(err, OST_ERR_INPUT, "%s: '%s'; expected left or right", OST_META_SIDE, text);
    return OST_OK;
}

ost_side ost_side_of_axis(const double axis[3])
{
    static const double least = 0.258819045; /* sine of 15 degrees */
    const double length = sqrt(axis[0] * axis[0] + axis[1] * axis[1] + axis[2] * axis[2]);
    if (!(fabs(axis[0]) > least * length))
        return OST_SIDE_UNKNOWN;
    return axis[0] < 0 ? OST_SIDE_LEFT : OST_SIDE_RIGHT;
}

ost_status ost_glenoid_side(const double axis[3], ost_side stated, bool *left, ost_error *err)
{
    const ost_side found = ost_side_of_axis(axis);
    if (stated == OST_SIDE_UNKNOWN && found == OST_SIDE_UNKNOWN)
        return ost_fail(
            err, OST_ERR_USAGE,
            "the side is not set, and the axis (%.4g, %.4g, %.4g) does not determine it: pass --side left or "
            "--side right",
            axis[0], axis[1], axis[2]);
    if (stated != OST_SIDE_UNKNOWN && found != OST_SIDE_UNKNOWN && stated != found)
        return ost_fail(
            err, OST_ERR_INPUT,
            "the side is %s, but the axis (%.4g, %.4g, %.4g) points into a %s glenoid; correct the side or the axis",
            stated == OST_SIDE_LEFT ? "left" : "right", axis[0], axis[1], axis[2],
            found == OST_SIDE_LEFT ? "left" : "right");
    *left = (stated == OST_SIDE_UNKNOWN ? found : stated) == OST_SIDE_LEFT;
    return OST_OK;
}

ost_status ost_glenoid_from_meta(const ost_meta *meta, ost_glenoid *out, ost_error *err)
{
    ost_glenoid glenoid;
    ost_side side = OST_SIDE_UNKNOWN;
    bool has_at, has_axis;
    ost_status status = ost_point_from_meta(meta, OST_META_GLENOID_AT, &glenoid.at, &has_at, err);
    if (status == OST_OK && !has_at)
        return missing(OST_META_GLENOID_AT, err);
    if (status == OST_OK)
        status = ost_axis_from_meta(meta, glenoid.axis, &has_axis, err);
    if (status == OST_OK && !has_axis)
        return missing(OST_META_GLENOID_AXIS, err);
    if (status == OST_OK)
        status = ost_side_from_meta(meta, &side, err);
    if (status == OST_OK)
        status = ost_glenoid_side(glenoid.axis, side, &glenoid.left, err);
    if (status == OST_OK)
        *out = glenoid;
    return status;
}
