/* SPDX-License-Identifier: Apache-2.0 */
#include "render/points/camera.h"

#include <math.h>

#include "core/rotation.h"

/* Of a voxel: nothing of the bone is as small as that. */
static const float NEAR = 0.25f;

ost_status ost_camera_check(const ost_camera *camera, ost_error *err)
{
    ost_status status = ost_pose_check(&camera->pose, err);
    if (status != OST_OK)
        return status;
    if (camera->width < 1 || camera->width > OST_FRAME_MAX || camera->height < 1 || camera->height > OST_FRAME_MAX)
        return ost_fail(err, OST_ERR_RANGE, "a frame of %d x %d pixels; 1 to %d a side are supported", camera->width, camera->height,
                        OST_FRAME_MAX);
    if (camera->focal_milli < 1000 || camera->focal_milli > INT32_C(100000000))
        return ost_fail(err, OST_ERR_RANGE, "a focal length of %d thousandths of a pixel; 1000 to 100,000,000 are supported",
                        (int)camera->focal_milli);
    return OST_OK;
}

/* Component a of a column of the rotation, whose entries are exact. */
static float direction(const ost_rotation *r, int a, int column)
{
    return (float)((double)r->m[a][column] / (double)r->n);
}

ost_eye ost_eye_make(const ost_camera *camera, const ost_geometry *bone)
{
    const ost_rotation r = ost_rotation_of(&camera->pose);
    const double s = (double)bone->spacing.x;
    ost_eye eye = {
        .at = {(float)((double)(camera->pose.t.x - bone->origin.x) / s), (float)((double)(camera->pose.t.y - bone->origin.y) / s),
               (float)((double)(camera->pose.t.z - bone->origin.z) / s)},
        .focal = (float)((double)camera->focal_milli / 1000.0),
        .half_w = 0.5f * (float)camera->width,
        .half_h = 0.5f * (float)camera->height,
        .near = NEAR,
        .width = camera->width,
        .height = camera->height,
    };
    for (int a = 0; a < 3; a++) {
        eye.right[a] = direction(&r, a, 0);
        eye.up[a] = direction(&r, a, 1);
        eye.forward[a] = -direction(&r, a, 2);
    }
    return eye;
}

/* ------------------------------------------------------------------- aim */

static void cross(const double a[3], const double b[3], double out[3])
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

static bool unit(double v[3])
{
    const double length = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    if (!(length > 1e-12) || !isfinite(length))
        return false;
    for (int a = 0; a < 3; a++)
        v[a] /= length;
    return true;
}

ost_status ost_camera_look(const double from_mm[3], const double at_mm[3], const double up[3], ost_camera *camera, ost_error *err)
{
    double back[3], right[3], above[3], q[4];
    for (int a = 0; a < 3; a++)
        back[a] = from_mm[a] - at_mm[a];
    cross(up, back, right);
    if (!unit(back) || !unit(right))
        return ost_fail(err, OST_ERR_RANGE, "a camera needs two different points, and an up that does not point along its view");
    cross(back, right, above);
    const double columns[3][3] = {{right[0], right[1], right[2]}, {above[0], above[1], above[2]}, {back[0], back[1], back[2]}};
    ost_quaternion_of_columns(columns, q);
    return ost_pose_from_doubles(from_mm, q, &camera->pose, err);
}
