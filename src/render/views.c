/* SPDX-License-Identifier: Apache-2.0 */
#include "render/views.h"

#include <math.h>
#include <string.h>

#include "core/vector.h"

/* maximum elevation in radians; beyond it, the picture would turn upside down */
static const double STEEPEST = 1.55;
static const double NEAREST = 4, FARTHEST = 3000; /* mm */

ost_view_subject ost_view_subject_make(const ost_geometry *g, const ost_pm3 *at, const double *axis, bool left)
{
    const double origin[3] = {1e-9 * (double)g->origin.x, 1e-9 * (double)g->origin.y, 1e-9 * (double)g->origin.z};
    const double side[3] = {1e-9 * (double)(g->dims.x * g->spacing.x), 1e-9 * (double)(g->dims.y * g->spacing.y),
                            1e-9 * (double)(g->dims.z * g->spacing.z)};
    ost_view_subject s = {.size = fmax(side[0], fmax(side[1], side[2])), .has_face = axis != NULL, .left = left};
    for (int a = 0; a < 3; a++)
        s.middle[a] = origin[a] + 0.5 * side[a];
    if (axis) {
        memcpy(s.inward, axis, sizeof s.inward);
        ost_vector_unit(s.inward, 2);
        s.face[0] = 1e-9 * (double)at->x;
        s.face[1] = 1e-9 * (double)at->y;
        s.face[2] = 1e-9 * (double)at->z;
    }
    return s;
}

void ost_active_box(const ost_volume *volume, int32_t threshold, int32_t lo[3], int32_t hi[3])
{
    const ost_dims d = volume->geometry.dims;
    const int16_t *row = volume->voxels;
    const int32_t middle[3] = {d.x / 2, d.y / 2, d.z / 2};
    lo[0] = d.x, lo[1] = d.y, lo[2] = d.z;
    hi[0] = hi[1] = hi[2] = 0;
    for (int32_t k = 0; k < d.z; k++)
        for (int32_t j = 0; j < d.y; j++, row += d.x) {
            int32_t first = 0, last = d.x - 1;
            while (first < d.x && row[first] < threshold)
                first++;
            if (first == d.x)
                continue;
            while (row[last] < threshold)
                last--;
            const int32_t from[3] = {first, j, k}, to[3] = {last + 1, j + 1, k + 1};
            for (int a = 0; a < 3; a++) {
                lo[a] = from[a] < lo[a] ? from[a] : lo[a];
                hi[a] = to[a] > hi[a] ? to[a] : hi[a];
            }
        }
    for (int a = 0; a < 3 && hi[2] == 0; a++)
        lo[a] = hi[a] = middle[a];
}

void ost_view_subject_fit(ost_view_subject *s, const ost_volume *volume, int32_t threshold)
{
    const ost_geometry *g = &volume->geometry;
    const double origin[3] = {ost_pm_to_mm(g->origin.x), ost_pm_to_mm(g->origin.y), ost_pm_to_mm(g->origin.z)};
    const double step[3] = {ost_pm_to_mm(g->spacing.x), ost_pm_to_mm(g->spacing.y), ost_pm_to_mm(g->spacing.z)};
    int32_t lo[3], hi[3];
    double longest = 0;
    ost_active_box(volume, threshold, lo, hi);
    for (int a = 0; a < 3; a++) {
        s->middle[a] = origin[a] + 0.5 * step[a] * (lo[a] + hi[a] - 1);
        longest = fmax(longest, step[a] * (hi[a] - lo[a]));
    }
    s->size = longest > 0 ? longest : s->size;
}

/*
 * Returns an orbit around the point at[]. The vector back[] points from there to the camera. In LPS, x points to the
 * patient's left, y to the back, and z up.
 */
static ost_orbit from(const double at[3], const double back[3], double distance)
{
    double b[3] = {back[0], back[1], back[2]};
    ost_vector_unit(b, 2);
    ost_orbit o = {.azimuth = atan2(b[0], -b[1]), .elevation = asin(fmax(-1, fmin(1, b[2]))), .distance = distance};
    o.elevation = fmax(-STEEPEST, fmin(STEEPEST, o.elevation));
    memcpy(o.at, at, sizeof o.at);
    return o;
}

ost_orbit ost_view_orbit(ost_view_name view, const ost_view_subject *s, const ost_pose *tool)
{
    const double *at = s->has_face ? s->face : s->middle;
    const double near = s->has_face ? fmin(100, 0.9 * s->size) : 1.5 * s->size;
    const double side = s->left ? 1 : -1;
    double back[3] = {side, 0, 0};
    if (s->has_face)
        for (int a = 0; a < 3; a++)
            back[a] = -s->inward[a];
    if (view == OST_VIEW_TOOL && tool) {
        double t[3], q[4];
        ost_pose_to_doubles(tool, t, q);
        const double w = q[0], x = q[1], y = q[2], z = q[3];
        /* The tool works in the direction of its -z axis. */
        return from(t, (double[3]){2 * (x * z + w * y), 2 * (y * z - w * x), w * w - x * x - y * y + z * z},
                    1.4 * near);
    }
    switch (view) {
    case OST_VIEW_EN_FACE: break;
    case OST_VIEW_LATERAL: return from(at, (double[3]){side, 0, 0}, near);
    case OST_VIEW_MEDIAL: return from(s->middle, (double[3]){-side, 0, 0}, 1.5 * s->size);
    case OST_VIEW_ANTERIOR: return from(at, (double[3]){0, -1, 0}, near);
    case OST_VIEW_POSTERIOR: return from(at, (double[3]){0, 1, 0}, near);
    case OST_VIEW_SUPERIOR: return from(at, (double[3]){0, 0, 1}, near);
    case OST_VIEW_INFERIOR: return from(s->middle, (double[3]){0, 0, -1}, 1.5 * s->size);
    case OST_VIEW_OVERVIEW: return from(s->middle, (double[3]){back[0], back[1] - 0.7, back[2] + 0.25}, 1.5 * s->size);
    case OST_VIEW_TOOL:
    case OST_VIEW_OPERATOR:
    case OST_VIEW_COUNT: {
        ost_orbit o = from(at, back, near);
        o.azimuth -= side * 0.75;
        o.elevation += 0.38;
        return o;
    }
    }
    return from(at, back, near);
}

void ost_orbit_frame(const ost_orbit *o, double right[3], double up[3], double back[3])
{
    const double ca = cos(o->azimuth), sa = sin(o->azimuth), ce = cos(o->elevation), se = sin(o->elevation);
    const double b[3] = {sa * ce, -ca * ce, se}, r[3] = {ca, sa, 0}, u[3] = {-sa * se, ca * se, ce};
    memcpy(back, b, sizeof b);
    memcpy(right, r, sizeof r);
    memcpy(up, u, sizeof u);
}

void ost_orbit_turn(ost_orbit *o, double dx, double dy, int height)
{
    /* rotation, in radians, for a drag over the full height of the picture */
    const double a_picture = 2.5;
    o->azimuth -= a_picture * dx / height;
    o->elevation = fmax(-STEEPEST, fmin(STEEPEST, o->elevation + a_picture * dy / height));
}

void ost_orbit_shift(ost_orbit *o, double dx, double dy, int height)
{
    double right[3], up[3], back[3];
    const double mm = o->distance / (OST_VIEW_FOCAL * height);
    ost_orbit_frame(o, right, up, back);
    for (int a = 0; a < 3; a++)
        o->at[a] += mm * (dy * up[a] - dx * right[a]);
}

void ost_orbit_near(ost_orbit *o, double steps)
{
    o->distance = fmax(NEAREST, fmin(FARTHEST, o->distance * exp2(-steps / 8)));
}

ost_status ost_orbit_camera(const ost_orbit *o, int width, int height, ost_camera *out, ost_error *err)
{
    double right[3], up[3], back[3], eye[3];
    *out = (ost_camera){.focal_milli = (int32_t)(OST_VIEW_FOCAL * 1000 * height), .width = width, .height = height};
    ost_orbit_frame(o, right, up, back);
    for (int a = 0; a < 3; a++)
        eye[a] = o->at[a] + o->distance * back[a];
    return ost_camera_look_at(eye, o->at, up, out, err);
}
