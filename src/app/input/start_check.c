/* SPDX-License-Identifier: Apache-2.0 */
#include "app/input/start_check.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "app/common/result.h"
#include "app/common/print.h"

/*
 * Smallest volume of bone in front of the face that causes a warning. Noise and single osteophytes are smaller; the
 * other bone of a joint has thousands of mm3.
 */
#define FRONT_LEAST_MM3 50.0
#define BONE_LEAST_PERCENT 25.0
#define APPROACH_MM 8.0 /* distance in front of the face at which built-in paths start */

static ost_status problem(const app_state *app, bool strict, ost_error *err, const char *format, ...) OST_PRINTF(4, 5);

static ost_status problem(const app_state *app, bool strict, ost_error *err, const char *format, ...)
{
    char text[OST_ERROR_TEXT];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    if (strict)
        return ost_fail(err, OST_ERR_INPUT, "%s", text);
    warn(app, "%s", text);
    return OST_OK;
}

static double voxel_mm3(const ost_bone *bone)
{
    ost_bone_info info;
    if (ost_bone_info_get(bone, &info, NULL) != OST_OK)
        return 0;
    const double s = ost_pm_to_mm(info.geometry.spacing.x);
    return s * s * s;
}

void start_poses(const ost_path *path, const ost_pose *first[OPTION_LIST_MAX])
{
    for (size_t i = 0; i < path->count; i++) {
        const int32_t tool = path->ticks[i].tool;
        if (tool >= 0 && tool < OPTION_LIST_MAX && !first[tool])
            first[tool] = &path->ticks[i].pose;
    }
}

/* Computes the size of a tool in mm: its radius about its axis, and its length along the axis. */
static void tool_size(const ost_tool *tool, double *radius_mm, double *length_mm)
{
    const ost_tool_geometry *g = ost_tool_geometry_get(tool);
    const ost_pm ends[4] = {g->corner.x, g->corner.x + g->dims.x * g->voxel, g->corner.y,
                            g->corner.y + g->dims.y * g->voxel};
    *radius_mm = 0;
    for (int i = 0; i < 4; i++)
        *radius_mm = fmax(*radius_mm, fabs(ost_pm_to_mm(ends[i])));
    *length_mm = ost_pm_to_mm(g->dims.z * g->voxel);
}

static ost_status check_front(const app_state *app, const start_setup *setup, const ost_glenoid *glenoid,
                              bool axis_good, ost_error *err)
{
    int64_t most = 0;
    int which = 0;
    ost_status status = OST_OK;
    for (int i = 0; i < setup->names->count && status == OST_OK; i++) {
        double radius, length;
        int64_t voxels = 0;
        if (!setup->first[i])
            continue;
        tool_size(setup->tools[i], &radius, &length);
        status = ost_bone_in_front(setup->bone, glenoid, radius, length + APPROACH_MM, &voxels, err);
        which = voxels > most ? i : which;
        most = voxels > most ? voxels : most;
    }
    const double mm3 = (double)most * voxel_mm3(setup->bone);
    put_real(app->result, "front_mm3", mm3);
    /* Without a valid axis, the region in front of the face is not defined. The invalid axis has already been
     * reported. */
    if (status != OST_OK || mm3 < FRONT_LEAST_MM3 || !axis_good)
        return status;
    return problem(
        app, setup->strict, err,
        "%s: %.0f mm3 of bone lie in front of the glenoid's face, in the way of %s: probably a humeral head that "
        "was not resected",
        setup->bone_name, mm3, setup->names->value[which]);
}

static ost_status check_axis(const app_state *app, const start_setup *setup, const ost_glenoid *glenoid, bool *good,
                             ost_error *err)
{
    double inward, outward;
    ost_status status = ost_bone_along_axis(setup->bone, glenoid, &inward, &outward, err);
    if (status != OST_OK)
        return status;
    put_real(app->result, "axis_bone_percent", inward);
    *good = inward >= BONE_LEAST_PERCENT;
    if (*good)
        return OST_OK;
    const double *a = glenoid->axis;
    return problem(app, setup->strict, err,
                   "%s: the axis (%.4g, %.4g, %.4g) does not point into bone: from 1 to 11 mm below the face, %.0f %% "
                   "of it lies in bone, and from 1 to 11 mm in front of the face, %.0f %%; %s",
                   setup->bone_name, a[0], a[1], a[2], inward, outward,
                   outward >= BONE_LEAST_PERCENT ? "the axis is probably reversed" : "check --at and --axis");
}

static ost_status check_overlap(const app_state *app, const start_setup *setup, ost_error *err)
{
    int64_t all = 0;
    ost_status status = OST_OK;
    for (int i = 0; i < setup->names->count && status == OST_OK; i++) {
        int64_t voxels = 0;
        char count[FORMAT_TEXT], at[FORMAT_TEXT];
        if (!setup->first[i])
            continue;
        status = ost_bone_overlap(setup->bone, setup->tools[i], setup->first[i], &voxels, err);
        all += voxels;
        if (status == OST_OK && voxels)
            status = problem(
                app, setup->strict, err,
                "%s overlaps %s bone voxels at its first pose, with its origin at %s; start the path outside the bone",
                setup->names->value[i], format_count(count, voxels), format_point(at, setup->first[i]->t));
    }
    put_integer(app->result, "overlap_voxels", all);
    return status;
}

ost_status start_check(const app_state *app, const start_setup *setup, start_checked *out, ost_error *err)
{
    ost_status status = OST_OK;
    *out = (start_checked){.known = setup->plan != NULL};
    if (setup->plan) {
        out->glenoid = (ost_glenoid){.at = setup->plan->at, .left = setup->plan->left};
        memcpy(out->glenoid.axis, setup->plan->axis, sizeof out->glenoid.axis);
        bool axis_good = false;
        status = check_axis(app, setup, &out->glenoid, &axis_good, err);
        if (status == OST_OK)
            status = check_front(app, setup, &out->glenoid, axis_good, err);
    }
    if (status == OST_OK)
        status = check_overlap(app, setup, err);
    if (status == OST_OK && out->known)
        status = ost_bone_in_front(setup->bone, &out->glenoid, 0, 0, &out->near_side, err);
    return status;
}

ost_status start_check_end(start_checked *checked, const ost_bone *bone, ost_error *err)
{
    int64_t after = 0;
    ost_status status = checked->known ? ost_bone_in_front(bone, &checked->glenoid, 0, 0, &after, err) : OST_OK;
    if (status == OST_OK)
        checked->near_side -= after;
    return status;
}

void start_check_report(const app_state *app, const start_checked *checked, double mm3)
{
    char text[FORMAT_TEXT];
    if (!checked->known)
        return;
    put_integer(app->result, "near_side_voxels", checked->near_side);
    put_real(app->result, "near_side_mm3", (double)checked->near_side * mm3);
    print_line(app, "  on the near side of the glenoid's face: %s voxels, %.1f mm3",
               format_count(text, checked->near_side), (double)checked->near_side * mm3);
}
