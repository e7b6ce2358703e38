/* SPDX-License-Identifier: Apache-2.0 */
#include "render/points/camera.h"

#include <math.h>

#include "core/quaternion.h"
#include "core/vector.h"

/* Distance of the near plane in voxels; smaller than any detail of the bone. */
static const float NEAR = 0.25f;

ost_status ost_camera_check(const ost_camera *camera, ost_error *err)
{
    ost_status status = ost_pose_check(&camera->pose, err);
    if (status != OST_OK)
        return status;
    if (camera->width < 1 || camera->width > OST_FRAME_MAX || camera->height < 1 || camera->height > OST_FRAME_MAX)
        return ost_fail(err, OST_ERR_RANGE, "a frame of %d x %d pixels; expected 1 to %d a side", camera->width,
                        camera->height, OST_FRAME_MAX);
    if (camera->focal_milli < 1000 || camera->focal_milli > INT32_C(100000000))
        return ost_fail(err, OST_ERR_RANGE,
                        "a focal length of %d thousandths of a pixel; expected 1000 to 100,000,000",
                        (int)camera->focal_milli);
    return OST_OK;
}

/* Returns an eye at the position `at`, in picometres in the grid's frame. The matrix `r` rotates the camera's frame
   to the grid's frame. */
static ost_eye make_eye(const ost_camera *camera, const ost_geometry *grid, const double at[3], const double r[3][3])
{
    const double s = (double)grid->spacing.x;
    ost_eye eye = {
        .at = {(float)((at[0] - (double)grid->origin.x) / s), (float)((at[1] - (double)grid->origin.y) / s),
               (float)((at[2] - (double)grid->origin.z) / s)},
        .focal = (float)((double)camera->focal_milli / 1000.0),
        .half_w = 0.5f * (float)camera->width,
        .half_h = 0.5f * (float)camera->height,
        .near = NEAR,
        .width = camera->width,
        .height = camera->height,
    };
    for (int a = 0; a < 3; a++) {
        eye.right[a] = (float)r[a][0];
        eye.up[a] = (float)r[a][1];
        eye.forward[a] = (float)-r[a][2];
    }
    return eye;
}

/* Positions in picometres are below 2^43, so they and their differences are exact in doubles. */
ost_eye ost_eye_make(const ost_camera *camera, const ost_geometry *bone)
{
    double r[3][3];
    ost_pose_matrix(&camera->pose, r);
    const double at[3] = {(double)camera->pose.t.x, (double)camera->pose.t.y, (double)camera->pose.t.z};
    return make_eye(camera, bone, at, r);
}

ost_eye ost_eye_make_from(const ost_camera *camera, const ost_geometry *grid, const ost_pose *pose)
{
    double c[3][3], p[3][3], r[3][3];
    ost_pose_matrix(&camera->pose, c);
    ost_pose_matrix(pose, p);
    const double d[3] = {(double)(camera->pose.t.x - pose->t.x), (double)(camera->pose.t.y - pose->t.y),
                         (double)(camera->pose.t.z - pose->t.z)};
    double at[3];
    for (int a = 0; a < 3; a++) {
        at[a] = (p[0][a] * d[0] + p[1][a] * d[1]) + p[2][a] * d[2];
        for (int b = 0; b < 3; b++)
            r[a][b] = (p[0][a] * c[0][b] + p[1][a] * c[1][b]) + p[2][a] * c[2][b];
    }
    return make_eye(camera, grid, at, r);
}

/* ------------------------------------------------------------------- aim */

static bool is_direction(double length)
{
    return length > 1e-12 && isfinite(length);
}

ost_status ost_camera_look_at(const double from_mm[3], const double at_mm[3], const double up[3], ost_camera *camera,
                              ost_error *err)
{
    double back[3], right[3], above[3], q[4];
    for (int a = 0; a < 3; a++)
        back[a] = from_mm[a] - at_mm[a];
    ost_vector_cross(up, back, right);
    if (!is_direction(ost_vector_unit(back, 2)) || !is_direction(ost_vector_unit(right, 0)))
        return ost_fail(err, OST_ERR_RANGE,
                        "a camera needs two different points, and an up that does not point along its view");
    ost_vector_cross(back, right, above);
    const double columns[3][3] = {
        {right[0], right[1], right[2]}, {above[0], above[1], above[2]}, {back[0], back[1], back[2]}};
    ost_quaternion_of_columns(columns, q);
    return ost_pose_from_doubles(from_mm, q, &camera->pose, err);
}
