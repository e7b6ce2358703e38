/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Checks the site before an operation: counts the bone voxels in front of the glenoid's face, and measures the
 * fraction of bone along the glenoid's axis.
 *
 *        near side        |  bone
 *                 .-------'        r
 *     front ->   :                 ^    A voxel is in front of the face if
 *   - - - - - - -:- - - - + - - - -+--> w  w < -(3 + min(r, 18)^2 / 60) mm.  At r = 17 mm the limit is
 *      axis      :        at            -7.8 mm, and the rim is at most 5 mm in front of the centre.
 *                 '-------.
 *                         |
 *
 * In the drawing, w is the position along the axis in mm, and r is the distance from the axis in mm. The limit on w
 * excludes the rim of the face. Floats are allowed, because the results are only reported and have no effect on voxels.
 */
#include <osteon/sim.h>

#include <math.h>
#include <stdlib.h>

#define FRONT_MM 3.0
#define FRONT_BEND_MM 60.0
#define FRONT_RADIUS_MM 18.0

/*
 * The fraction of bone is measured in two cylinders around the axis, one on each side of the glenoid. Along the axis,
 * their distance from the glenoid is CORE_FROM_MM to CORE_TO_MM.
 */
#define CORE_RADIUS_MM 4.0
#define CORE_FROM_MM 1.0
#define CORE_TO_MM 11.0

enum { SLAB = 8 };

/*
 * Returns true if a voxel is in the zone. w is the voxel's position along the axis in mm, and r2 is the square of the
 * voxel's distance from the axis in mm^2.
 */
typedef bool zone(const double *limits, double w, double r2);

static bool in_front(const double *limits, double w, double r2)
{
    const double bend = r2 < FRONT_RADIUS_MM * FRONT_RADIUS_MM ? r2 : FRONT_RADIUS_MM * FRONT_RADIUS_MM;
    return w < -(FRONT_MM + bend / FRONT_BEND_MM) && w >= -limits[1] && r2 <= limits[0] * limits[0];
}

static bool in_core(const double *limits, double w, double r2)
{
    return w >= limits[0] && w < limits[1] && r2 <= CORE_RADIUS_MM * CORE_RADIUS_MM;
}

static ost_status unit(const ost_glenoid *glenoid, double out[3], ost_error *err)
{
    const double *a = glenoid->axis, length = sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]);
    if (!isfinite(length) || !(length > 0))
        return ost_fail(err, OST_ERR_USAGE, "the glenoid's axis (%g, %g, %g) is not a direction", a[0], a[1], a[2]);
    for (int i = 0; i < 3; i++)
        out[i] = a[i] / length;
    return OST_OK;
}

static int64_t count_slab(const ost_geometry *g, const int16_t *slab, int32_t z0, int32_t slices, const double at[3],
                          const double axis[3], zone *in, const double *limits)
{
    const double step[3] = {ost_pm_to_mm(g->spacing.x), ost_pm_to_mm(g->spacing.y), ost_pm_to_mm(g->spacing.z)};
    const double origin[3] = {ost_pm_to_mm(g->origin.x) - at[0], ost_pm_to_mm(g->origin.y) - at[1],
                              ost_pm_to_mm(g->origin.z) - at[2]};
    int64_t count = 0;
    for (int32_t k = 0; k < slices; k++) {
        for (int32_t j = 0; j < g->dims.y; j++) {
            const int16_t *row = slab + (size_t)g->dims.x * ((size_t)j + (size_t)g->dims.y * (size_t)k);
            const double y = origin[1] + j * step[1], z = origin[2] + (z0 + k) * step[2];
            for (int32_t i = 0; i < g->dims.x; i++) {
                if (!row[i])
                    continue;
                const double x = origin[0] + i * step[0], w = x * axis[0] + y * axis[1] + z * axis[2];
                count += in(limits, w, x * x + y * y + z * z - w * w);
            }
        }
    }
    return count;
}

/* Counts the active voxels in a zone. All parts of the zone must lie within `far` mm of the glenoid. */
static ost_status count_zone(const ost_bone *bone, const ost_glenoid *glenoid, double far, zone *in,
                             const double *limits, int64_t *out, ost_error *err)
{
    ost_bone_info info;
    double axis[3];
    *out = 0;
    ost_status status = unit(glenoid, axis, err);
    if (status == OST_OK)
        status = ost_bone_info_get(bone, &info, err);
    if (status != OST_OK)
        return status;
    const ost_geometry *g = &info.geometry;
    const double at[3] = {ost_pm_to_mm(glenoid->at.x), ost_pm_to_mm(glenoid->at.y), ost_pm_to_mm(glenoid->at.z)};
    const double middle = (at[2] - ost_pm_to_mm(g->origin.z)) / ost_pm_to_mm(g->spacing.z),
                 reach = far / ost_pm_to_mm(g->spacing.z) + 1;
    const int32_t from = (int32_t)fmin(fmax(middle - reach, 0), g->dims.z),
                  to = (int32_t)fmin(fmax(middle + reach + 1, 0), g->dims.z);
    int16_t *slab = malloc((size_t)g->dims.x * (size_t)g->dims.y * SLAB * sizeof *slab);
    if (!slab)
        return ost_fail(err, OST_ERR_MEMORY, "out of memory for %d slices of the bone", SLAB);
    for (int32_t z = from; z < to && status == OST_OK; z += SLAB) {
        const int32_t slices = to - z < SLAB ? to - z : SLAB;
        status = ost_bone_download(bone, z, slices, slab, err);
        if (status == OST_OK)
            *out += count_slab(g, slab, z, slices, at, axis, in, limits);
    }
    free(slab);
    return status;
}

ost_status ost_bone_in_front(const ost_bone *bone, const ost_glenoid *glenoid, double radius_mm, double reach_mm,
                             int64_t *voxels, ost_error *err)
{
    const double limits[2] = {radius_mm > 0 ? radius_mm : INFINITY, reach_mm > 0 ? reach_mm : INFINITY};
    return count_zone(bone, glenoid, sqrt(limits[0] * limits[0] + limits[1] * limits[1]), in_front, limits, voxels,
                      err);
}

ost_status ost_bone_along_axis(const ost_bone *bone, const ost_glenoid *glenoid, double *inward_percent,
                               double *outward_percent, ost_error *err)
{
    static const double inward[2] = {CORE_FROM_MM, CORE_TO_MM}, outward[2] = {-CORE_TO_MM, -CORE_FROM_MM};
    int64_t in = 0, out = 0;
    ost_bone_info info;
    ost_status status = ost_bone_info_get(bone, &info, err);
    if (status == OST_OK)
        status = count_zone(bone, glenoid, CORE_TO_MM + CORE_RADIUS_MM, in_core, inward, &in, err);
    if (status == OST_OK)
        status = count_zone(bone, glenoid, CORE_TO_MM + CORE_RADIUS_MM, in_core, outward, &out, err);
    if (status != OST_OK)
        return status;
    const double s = ost_pm_to_mm(info.geometry.spacing.x);
    const double voxels = 3.14159265358979323846 * CORE_RADIUS_MM * CORE_RADIUS_MM * (CORE_TO_MM - CORE_FROM_MM) /
                          (s * s * s);
    *inward_percent = fmin(100, 100 * (double)in / voxels);
    *outward_percent = fmin(100, 100 * (double)out / voxels);
    return OST_OK;
}

ost_status ost_bone_overlap(const ost_bone *bone, const ost_tool *tool, const ost_pose *pose, int64_t *voxels,
                            ost_error *err)
{
    ost_map map;
    ost_bone_info info;
    ost_removal_report report = {0};
    const ost_density_classes classes = ost_density_classes_default();
    ost_status status = ost_bone_info_get(bone, &info, err);
    if (status == OST_OK)
        status = ost_map_make(pose, &info.geometry, ost_tool_geometry_get(tool), &map, err);
    if (status == OST_OK) {
        const ost_voxel_box all = {.hi = {info.geometry.dims.x, info.geometry.dims.y, info.geometry.dims.z}};
        const ost_removal_event event = {.pose_count = 1, .maps = &map, .boxes = &all, .classes = &classes};
        status = ost_bone_collide(bone, tool, &event, &report, err);
        *voxels = (int64_t)(report.total_voxels + report.touched_voxels);
    }
    ost_removal_report_free(&report);
    return status;
}
