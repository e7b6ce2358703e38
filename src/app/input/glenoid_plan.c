/* SPDX-License-Identifier: Apache-2.0 */
#include "app/input/glenoid_plan.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { DEPTH_UM = 3000, DEPTH_UM_MAX = 20000, POINT_TEXT = 3 * OST_PM_TEXT };

/* Keys in the header of a session, and the corresponding keys in the header of a grid. */
static const struct {
    const char *session, *grid;
} same[] = {
    {"plan.at_mm", OST_META_GLENOID_AT},
    {"plan.axis", OST_META_GLENOID_AXIS},
    {"plan.side", OST_META_SIDE},
    {"plan.trigonum_mm", OST_META_TRIGONUM},
    {"plan.inferior_angle_mm", OST_META_INFERIOR_ANGLE},
};
enum { SAME = sizeof same / sizeof same[0] };
static const char depth_key[] = "plan.depth_mm";

static const char *point_text(ost_pm3 p, char text[POINT_TEXT])
{
    char x[OST_PM_TEXT], y[OST_PM_TEXT], z[OST_PM_TEXT];
    snprintf(text, POINT_TEXT, "%s,%s,%s", ost_pm_format(p.x, x), ost_pm_format(p.y, y), ost_pm_format(p.z, z));
    return text;
}

/*
 * Normalizes an axis and rounds it to nine decimal places, which is how an axis is stored as text. Programs that read
 * the text therefore compute with the same axis.
 */
static bool unit_axis(const double in[3], double out[3], ost_pm3 *nano)
{
    double size = sqrt(in[0] * in[0] + in[1] * in[1] + in[2] * in[2]);
    int64_t n[3];
    /* An axis that was rounded to nine places when it was stored must not change again. */
    size = fabs(size - 1) < 2e-9 ? 1 : size;
    for (int a = 0; a < 3; a++) {
        const double v = in[a] / size;
        if (!isfinite(v))
            return false;
        n[a] = llrint(v * 1e9);
        out[a] = (double)n[a] / 1e9;
    }
    *nano = (ost_pm3){n[0], n[1], n[2]};
    return true;
}

/* Values in the session's header override those in the grid's header. */
static ost_status overlay(const char *session, const ost_session_header *header, ost_meta *stored, ost_error *err)
{
    for (int i = 0; header && i < SAME; i++) {
        const char *value = ost_session_header_get(header, same[i].session);
        if (value && ost_meta_set(stored, same[i].grid, value, NULL) != OST_OK)
            return ost_fail(err, OST_ERR_INPUT, "%s: its header has '%s: %.80s', which is not valid", session,
                            same[i].session, value);
    }
    return OST_OK;
}

static ost_status find_depth(const app_state *app, const glenoid_plan_options *options, const char *session,
                             const ost_session_header *header, double *out, ost_error *err)
{
    const char *stored = header ? ost_session_header_get(header, depth_key) : NULL;
    int64_t um = DEPTH_UM;
    if (options->depth.text) {
        if (!ost_decimal_scale(&options->depth.value, 1000, &um, NULL) || um < 0 || um > DEPTH_UM_MAX)
            return usage_error(app, err, "--planned %s: must be from 0 to %d", options->depth.text,
                               DEPTH_UM_MAX / 1000);
    } else if (stored) {
        ost_decimal d;
        const char *end = stored + strlen(stored);
        if (ost_decimal_read(stored, end, &d) != end || !ost_decimal_scale(&d, 1000, &um, NULL) || um < 0 ||
            um > DEPTH_UM_MAX)
            return ost_fail(err, OST_ERR_INPUT, "%s: its header has '%s: %.80s', which is not valid", session,
                            depth_key, stored);
    }
    *out = (double)um * 1e-3;
    return OST_OK;
}

static ost_status find_landmarks(const app_state *app, const glenoid_plan_options *options, const ost_meta *stored,
                                 ost_metrics_plan *out, ost_error *err)
{
    bool trigonum = false, inferior = false;
    ost_status status = ost_point_from_meta(stored, OST_META_TRIGONUM, &out->trigonum, &trigonum, err);
    if (status == OST_OK)
        status = ost_point_from_meta(stored, OST_META_INFERIOR_ANGLE, &out->inferior, &inferior, err);
    if (status != OST_OK)
        return status;
    if (options->trigonum_given)
        out->trigonum = options->trigonum;
    if (options->inferior_given)
        out->inferior = options->inferior;
    trigonum |= options->trigonum_given;
    inferior |= options->inferior_given;
    if (trigonum != inferior && (options->trigonum_given || options->inferior_given))
        return usage_error(app, err, "--%s needs --%s as well", trigonum ? "trigonum" : "inferior-angle",
                           trigonum ? "inferior-angle" : "trigonum");
    out->landmarks = trigonum && inferior;
    return OST_OK;
}

ost_status glenoid_plan_find(const app_state *app, const glenoid_plan_options *options, const char *session,
                             const ost_session_header *header, const ost_meta *meta, const char *bone, bool needed,
                             ost_metrics_plan *out, bool *known, ost_error *err)
{
    ost_meta stored = *meta;
    ost_glenoid glenoid;
    ost_pm3 nano;
    *out = (ost_metrics_plan){.depth_mm = 0};
    *known = false;
    needed |= options->depth.text || options->trigonum_given || options->inferior_given;
    ost_status status = overlay(session, header, &stored, err);
    if (status != OST_OK)
        return status;
    const target_options *t = &options->target;
    status = target_find(app, t, &stored, bone, &glenoid, err);
    if (status == OST_ERR_USAGE && !needed) {
        *err = (ost_error){0};
        return OST_OK;
    }
    if (status == OST_OK)
        status = find_depth(app, options, session, header, &out->depth_mm, err);
    if (status == OST_OK)
        status = find_landmarks(app, options, &stored, out, err);
    if (status != OST_OK)
        return status;
    if (!unit_axis(glenoid.axis, out->axis, &nano))
        return usage_error(app, err, "the glenoid's axis (%g, %g, %g) is not a direction", glenoid.axis[0],
                           glenoid.axis[1], glenoid.axis[2]);
    out->at = glenoid.at;
    out->left = glenoid.left;
    *known = true;
    return OST_OK;
}

ost_status glenoid_plan_set(ost_session_header *header, const ost_metrics_plan *plan, ost_error *err)
{
    char text[POINT_TEXT], depth[OST_PM_TEXT];
    double axis[3];
    ost_pm3 nano;
    if (!unit_axis(plan->axis, axis, &nano))
        return ost_fail(err, OST_ERR_USAGE, "a plan's axis is not a direction");
    ost_status status = ost_session_header_set(header, same[0].session, point_text(plan->at, text), err);
    if (status == OST_OK)
        status = ost_session_header_set(header, same[1].session, point_text(nano, text), err);
    if (status == OST_OK)
        status = ost_session_header_set(header, same[2].session, plan->left ? "left" : "right", err);
    if (status == OST_OK)
        status = ost_session_header_set(
            header, depth_key, ost_pm_format(llrint(plan->depth_mm * 1e3) * (OST_PM_PER_MM / 1000), depth), err);
    if (status == OST_OK && plan->landmarks) {
        status = ost_session_header_set(header, same[3].session, point_text(plan->trigonum, text), err);
        if (status == OST_OK)
            status = ost_session_header_set(header, same[4].session, point_text(plan->inferior, text), err);
    }
    return status;
}
