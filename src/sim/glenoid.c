/* SPDX-License-Identifier: Apache-2.0 */
/* Where a grid says its glenoid is: OST_META_GLENOID_AT, OST_META_GLENOID_AXIS, OST_META_SIDE. */
#include <osteon/sim.h>

#include <string.h>

static ost_status missing(const char *key, ost_error *err)
{
    return ost_fail(err, OST_ERR_USAGE, "the bone does not say where its glenoid is (no '%s'); give the point, axis and side", key);
}

/* Three decimals, divided by blanks or commas, and nothing else. */
static ost_status three_decimals(const char *key, const char *text, ost_decimal out[3], ost_error *err)
{
    const char *p = text, *end = text + strlen(text);
    for (int a = 0; a < 3; a++) {
        p += strspn(p, " ,");
        p = ost_decimal_read(p, end, &out[a]);
        if (!p)
            return ost_fail(err, OST_ERR_INPUT, "%s: '%s' is not three decimals", key, text);
    }
    if (p[strspn(p, " ")])
        return ost_fail(err, OST_ERR_INPUT, "%s: '%s' has more than three decimals", key, text);
    return OST_OK;
}

/* A direction to nine places: more would not show in a pose of 2^-30. */
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
    ost_status status = three_decimals(key, text, p, err);
    if (status != OST_OK)
        return status;
    if (!ost_decimal_to_pm(&p[0], &out->x, NULL) || !ost_decimal_to_pm(&p[1], &out->y, NULL) || !ost_decimal_to_pm(&p[2], &out->z, NULL))
        return ost_fail(err, OST_ERR_RANGE, "%s: '%s' is beyond 8 m", key, text);
    return OST_OK;
}

ost_status ost_point_from_meta(const ost_meta *meta, const char *key, ost_pm3 *out, bool *there, ost_error *err)
{
    const char *text = ost_meta_get(meta, key);
    *there = text != NULL;
    return text ? point(key, text, out, err) : OST_OK;
}

ost_status ost_glenoid_from_meta(const ost_meta *meta, ost_glenoid *out, ost_error *err)
{
    const char *at = ost_meta_get(meta, OST_META_GLENOID_AT);
    const char *axis = ost_meta_get(meta, OST_META_GLENOID_AXIS);
    const char *side = ost_meta_get(meta, OST_META_SIDE);
    if (!at)
        return missing(OST_META_GLENOID_AT, err);
    if (!axis)
        return missing(OST_META_GLENOID_AXIS, err);
    if (!side)
        return missing(OST_META_SIDE, err);

    ost_decimal d[3];
    ost_glenoid glenoid;
    ost_status status = point(OST_META_GLENOID_AT, at, &glenoid.at, err);
    if (status == OST_OK)
        status = three_decimals(OST_META_GLENOID_AXIS, axis, d, err);
    if (status != OST_OK)
        return status;
    if (!direction(&d[0], &glenoid.axis[0]) || !direction(&d[1], &glenoid.axis[1]) || !direction(&d[2], &glenoid.axis[2]) ||
        (glenoid.axis[0] == 0 && glenoid.axis[1] == 0 && glenoid.axis[2] == 0))
        return ost_fail(err, OST_ERR_INPUT, "%s: '%s' is not a direction", OST_META_GLENOID_AXIS, axis);
    glenoid.left = strcmp(side, "left") == 0;
    if (!glenoid.left && strcmp(side, "right") != 0)
        return ost_fail(err, OST_ERR_INPUT, "%s: '%s' is neither left nor right", OST_META_SIDE, side);
    *out = glenoid;
    return OST_OK;
}
