/* SPDX-License-Identifier: Apache-2.0 */
/* Computes the bone's grid by AR-CUB-1. The steps of the map are computed from this grid. */
#include "validation/dense/steps.h"

/* Returns the number of cubic voxels that cover n rect voxels: the least m with m * c >= n * s, where s and c are the
   spacings of the rect and the cubic grid. */
static int32_t voxels(int32_t n, ost_pm s, ost_pm c)
{
    int32_t m = 1;
    while (wide_order(wide_times(wide_of(m), wide_of(c)), wide_times(wide_of(n), wide_of(s))) < 0 && m < OST_DIM_MAX)
        m++;
    return m;
}

static ost_pm first_centre(ost_pm origin, ost_pm s, ost_pm c)
{
    return origin + wide_to_int64(wide_nearest(wide_of(c - s), wide_of(2)));
}

ost_geometry steps_cubic(const ost_geometry *rect, ost_pm cubic)
{
    const ost_pm3 s = rect->spacing, o = rect->origin;
    return (ost_geometry){.dims = {voxels(rect->dims.x, s.x, cubic), voxels(rect->dims.y, s.y, cubic),
                                   voxels(rect->dims.z, s.z, cubic)},
                          .spacing = {cubic, cubic, cubic},
                          .origin = {first_centre(o.x, s.x, cubic), first_centre(o.y, s.y, cubic),
                                     first_centre(o.z, s.z, cubic)}};
}
