/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Makes a spherical burr. It consists of a sphere, whose lowest point is at z = 0, and a shaft. The shaft has a third
 * of the sphere's diameter and ends `length` above the sphere's top.
 *
 *         | |
 *        ,| |.   the shaft leaves the sphere where it has the shaft's radius
 *       (     )
 *        `---'  z = 0
 *
 * The number of circles of latitude is half the number of segments. The circles are
 * equally spaced, and the circles above the root of the shaft are omitted.
 */
#include "phantom/tool_shape.h"

/*
 * Computes radius and height of the circle of latitude k, from the south pole (k = 0) to the north pole (k = n).
 */
static void latitude(int k, int n, ost_pm sphere, ost_pm *radius, ost_pm *z)
{
    ost_q60 c, s;
    ost_circle(k, 2 * (int64_t)n, &c, &s);
    *radius = ost_q60_times(sphere, s);
    *z = sphere - ost_q60_times(sphere, c);
}

ost_status ost_tool_make_burr(const ost_tool_options *options, ost_mesh *out, ost_error *err)
{
    const ost_pm sphere = options->diameter / 2, shaft = options->diameter / 6;
    const ost_pm top = options->diameter + options->length;
    const int n = options->segments / 2;
    ost_pm radius, z;
    ost_skin skin;
    ost_status status;
    if (options->part == OST_TOOL_SHAFT) {
        status = ost_skin_init(&skin, out, options->segments, 2, sphere, top, err);
        if (status != OST_OK)
            return status;
        ost_skin_circle(&skin, shaft, sphere);
        ost_skin_circle(&skin, shaft, top);
        return OST_OK;
    }
    const bool head = options->part == OST_TOOL_HEAD;
    int latitudes = 0;
    for (int k = 1; k < n; k++) {
        latitude(k, n, sphere, &radius, &z);
        if (head || z <= sphere || radius > shaft)
            latitudes++;
    }
    status = ost_skin_init(&skin, out, options->segments, latitudes + (head ? 0 : 2), 0, head ? options->diameter : top,
                           err);
    if (status != OST_OK)
        return status;
    for (int k = 1; k <= latitudes; k++) {
        latitude(k, n, sphere, &radius, &z);
        ost_skin_circle(&skin, radius, z);
    }
    if (head)
        return OST_OK;
    const ost_pm root = sphere + ost_isqrt((unsigned __int128)((__int128)sphere * sphere - (__int128)shaft * shaft));
    ost_skin_circle(&skin, shaft, root);
    ost_skin_circle(&skin, shaft, top);
    return OST_OK;
}
