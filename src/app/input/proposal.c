/* SPDX-License-Identifier: Apache-2.0 */
#include "app/input/proposal.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <osteon/anatomy.h>
#include <osteon/sim.h>

#include "app/common/print.h"
#include "app/common/result.h"
#include "app/input/load.h"

enum { POINTS = 4, AXIS_MM = 20 };

/* Converts landmarks to the form of a landmarks file, which represents the axis by a point AXIS_MM below the face. */
static ost_status to_landmarks(const ost_scapula_landmarks *l, ost_landmarks *out, ost_error *err)
{
    const ost_pm3 g = l->glenoid;
    const ost_pm3 deep = {g.x + (ost_pm)(l->axis[0] * AXIS_MM * 1e9), g.y + (ost_pm)(l->axis[1] * AXIS_MM * 1e9),
                          g.z + (ost_pm)(l->axis[2] * AXIS_MM * 1e9)};
    const ost_landmark items[POINTS] = {{"glenoid", OST_LANDMARK_GLENOID, g},
                                        {"axis", OST_LANDMARK_AXIS_POINT, deep},
                                        {"trigonum", OST_LANDMARK_TRIGONUM, l->trigonum},
                                        {"inferior angle", OST_LANDMARK_INFERIOR_ANGLE, l->inferior}};
    *out = (ost_landmarks){.items = malloc(sizeof items)};
    if (!out->items)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for %d landmarks", POINTS);
    memcpy(out->items, items, sizeof items);
    out->count = POINTS;
    return OST_OK;
}

static void put_proposal(const app_state *app, const ost_scapula_landmarks *l)
{
    json_t *o = json_object();
    put_mm3(o, "glenoid_mm", l->glenoid);
    put(o, "axis", json_pack("[f,f,f]", l->axis[0], l->axis[1], l->axis[2]));
    put_mm3(o, "trigonum_mm", l->trigonum);
    put_mm3(o, "inferior_angle_mm", l->inferior);
    put_text(o, "side", l->left ? "left" : "right");
    put_mm(o, "height_mm", l->height);
    put_mm(o, "width_mm", l->width);
    put_mm(o, "curvature_mm", l->curvature.radius);
    put_real(o, "curvature_residual_mm", l->curvature.residual_mm);
    put_real(o, "rim_share", l->rim_share);
    put_real(o, "rim_residual_mm", l->rim_residual_mm);
    put_real(o, "glenoid_spread_mm", l->glenoid_spread_mm);
    put_real(o, "axis_spread_deg", l->axis_spread_deg);
    put_real(o, "trigonum_spread_mm", l->trigonum_spread_mm);
    put_real(o, "inferior_angle_spread_mm", l->inferior_spread_mm);
    put(app->result, "landmarks_proposed", o);
}

static void print_proposal(const app_state *app, const char *name, const ost_scapula_landmarks *l)
{
    char a[FORMAT_TEXT];
    print_line(app, "%s: landmarks proposed, not measured: check them before they are used", name);
    print_line(app, "  glenoid        %s, stable to %.1f mm; face %.1f x %.1f mm, radius %.0f mm, %s side",
               format_point(a, l->glenoid), l->glenoid_spread_mm, ost_pm_to_mm(l->height), ost_pm_to_mm(l->width),
               ost_pm_to_mm(l->curvature.radius), l->left ? "left" : "right");
    print_line(app, "  axis           (%.3f, %.3f, %.3f) inward, stable to %.1f degrees; rim found in %.0f %% of the "
               "directions",
               l->axis[0], l->axis[1], l->axis[2], l->axis_spread_deg, 100 * l->rim_share);
    print_line(app, "  trigonum       %s, stable to %.1f mm", format_point(a, l->trigonum), l->trigonum_spread_mm);
    print_line(app, "  inferior angle %s, stable to %.1f mm", format_point(a, l->inferior), l->inferior_spread_mm);
}

/* Returns true if a point lies within two voxels of a border of the grid. */
static bool is_at_end(const ost_geometry *g, ost_pm3 p)
{
    const ost_pm at[3] = {p.x - g->origin.x, p.y - g->origin.y, p.z - g->origin.z};
    const ost_pm step[3] = {g->spacing.x, g->spacing.y, g->spacing.z};
    const int32_t n[3] = {g->dims.x, g->dims.y, g->dims.z};
    for (int a = 0; a < 3; a++)
        if (at[a] < 2 * step[a] || at[a] > (n[a] - 3) * step[a])
            return true;
    return false;
}

ost_status proposal_make(const app_state *app, const ost_bone *bone, const char *name, ost_meta *meta,
                         ost_landmarks *out, ost_error *err)
{
    ost_volume volume = {.voxels = NULL};
    ost_bone_info info;
    ost_scapula_landmarks found;
    char text[OST_META_VALUE];
    *out = (ost_landmarks){.count = 0};
    ost_status status = ost_bone_info_get(bone, &info, err);
    if (status == OST_OK)
        status = bone_to_volume(bone, NULL, &volume, err);
    if (status == OST_OK) {
        const ost_anatomy_bone solid = {&volume, info.threshold > 0 ? info.threshold : 1, INT16_MAX};
        status = ost_scapula_landmarks_find(&solid, NULL, &found, err);
        if (status != OST_OK)
            (void)ost_fail_context(err, "--landmarks %s: %s", PROPOSAL_AUTO, name);
    }
    ost_volume_free(&volume);
    if (status == OST_OK)
        status = ost_meta_set(meta, OST_META_SIDE, found.left ? "left" : "right", err);
    if (status == OST_OK) {
        snprintf(text, sizeof text, "stable to: glenoid %.2f mm, axis %.2f deg, trigonum %.2f mm, inferior %.2f mm",
                 found.glenoid_spread_mm, found.axis_spread_deg, found.trigonum_spread_mm, found.inferior_spread_mm);
        status = ost_meta_set(meta, PROPOSAL_FACT, text, err);
    }
    if (status == OST_OK)
        status = to_landmarks(&found, out, err);
    if (status == OST_OK) {
        put_proposal(app, &found);
        print_proposal(app, name, &found);
        if (is_at_end(&info.geometry, found.inferior) || is_at_end(&info.geometry, found.trigonum))
            warn(app, "%s: the inferior angle or the trigonum lies at the end of the CT: the scapula may continue "
                 "beyond it, so version and inclination are uncertain", name);
    }
    return status;
}

ost_status angles_report(const app_state *app, const ost_meta *meta, ost_error *err)
{
    ost_metrics_plan plan = {.landmarks = true};
    ost_side side;
    bool at, axis, trigonum, inferior;
    double version, inclination;
    ost_status status = ost_point_from_meta(meta, OST_META_GLENOID_AT, &plan.at, &at, err);
    if (status == OST_OK)
        status = ost_axis_from_meta(meta, plan.axis, &axis, err);
    if (status == OST_OK)
        status = ost_point_from_meta(meta, OST_META_TRIGONUM, &plan.trigonum, &trigonum, err);
    if (status == OST_OK)
        status = ost_point_from_meta(meta, OST_META_INFERIOR_ANGLE, &plan.inferior, &inferior, err);
    if (status == OST_OK)
        status = ost_side_from_meta(meta, &side, err);
    if (status != OST_OK || !at || !axis || !trigonum || !inferior || side == OST_SIDE_UNKNOWN)
        return status;
    plan.left = side == OST_SIDE_LEFT;
    if (!ost_metrics_angles(&plan, &version, &inclination))
        return OST_OK;
    put_real(app->result, "version_deg", version);
    put_real(app->result, "inclination_deg", inclination);
    print_line(app, "  %.1f degrees of %sversion, %.1f degrees of %s inclination", version < 0 ? -version : version,
               version < 0 ? "ante" : "retro", inclination < 0 ? -inclination : inclination,
               inclination < 0 ? "inferior" : "superior");
    return OST_OK;
}
