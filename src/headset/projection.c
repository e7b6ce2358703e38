/* SPDX-License-Identifier: Apache-2.0 */
#include "headset/projection.h"

#include <math.h>

static const double ANGLE_MAX = 1.4835298641951802; /* 85 degrees */

static bool is_usable(double angle)
{
    return fabs(angle) <= ANGLE_MAX; /* false for NaN */
}

bool ost_headset_project(const ost_headset_fov *fov, int width, int height, ost_headset_projection *out)
{
    if (!is_usable(fov->left) || !is_usable(fov->right) || !is_usable(fov->up) || !is_usable(fov->down) ||
        !(fov->right > fov->left) || !(fov->up > fov->down))
        return false;
    const double left = tan(fov->left), right = tan(fov->right), up = tan(fov->up), down = tan(fov->down);
    /* The focal length is rounded down, so that the picture covers the requested angles. */
    const double milli = floor(1000 * fmin(width / (right - left), height / (up - down)));
    if (!(milli >= 1000 && milli <= 1e8))
        return false;
    const double focal = milli / 1000;
    const double x = (width - focal * (right - left)) / 2 - focal * left,
                 y = (height - focal * (up - down)) / 2 + focal * up;
    *out = (ost_headset_projection){
        .focal_milli = (int32_t)milli,
        .middle = {x, y},
        .fov = {atan(-x / focal), atan((width - x) / focal), atan(y / focal), atan((y - height) / focal)}};
    return true;
}
