/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Helpers for the tests of points: volumes, the visible faces of their voxels, and a second implementation of the
 * shade of a voxel.
 */
#ifndef OST_TESTS_POINTS_VOLUME_H
#define OST_TESTS_POINTS_VOLUME_H

#include "harness.h"

#include <math.h>

#include "render/points/frame.h"
#include "render/points/octahedral.h"

static inline ost_geometry grid(int x, int y, int z)
{
    return (ost_geometry){
        {x, y, z}, {OST_PM_PER_MM, OST_PM_PER_MM, OST_PM_PER_MM}, {-3 * OST_PM_PER_MM, 0, 7 * OST_PM_PER_MM}};
}

/*
 * Makes a ball with holes of single voxels, so that there are also surfaces inside the ball. A ball that is larger than
 * a block extends over blocks that are adjacent along every axis.
 */
static inline ost_volume pitted_ball(test_rng *rng, int x, int y, int z)
{
    ost_error err = {0};
    ost_volume v;
    const ost_geometry g = grid(x, y, z);
    assert_ok(ost_volume_init(&v, &g, &err));
    const double r = 0.48 * (x < y ? (x < z ? x : z) : (y < z ? y : z));
    for (int k = 0; k < z; k++)
        for (int j = 0; j < y; j++)
            for (int i = 0; i < x; i++) {
                const double a = i - 0.5 * (x - 1), b = j - 0.5 * (y - 1), c = k - 0.5 * (z - 1);
                v.voxels[i + (size_t)x * (size_t)(j + y * k)] = a * a + b * b + c * c < r * r &&
                                                                        rng_range(rng, 0, 39) != 0
                                                                    ? 700
                                                                    : 0;
            }
    return v;
}

static inline bool active(const ost_volume *v, int i, int j, int k)
{
    const ost_dims d = v->geometry.dims;
    return i >= 0 && j >= 0 && k >= 0 && i < d.x && j < d.y && k < d.z &&
           v->voxels[i + (size_t)d.x * ((size_t)j + (size_t)d.y * (size_t)k)] >= 120;
}

static inline uint32_t faces(const ost_volume *v, int i, int j, int k)
{
    static const int step[6][3] = {{-1, 0, 0}, {1, 0, 0}, {0, -1, 0}, {0, 1, 0}, {0, 0, -1}, {0, 0, 1}};
    uint32_t mask = 0;
    for (int f = 0; f < 6; f++)
        mask |= (uint32_t)!active(v, i + step[f][0], j + step[f][1], k + step[f][2]) << f;
    return mask;
}

static inline int openness(int value)
{
    const int beyond = value - 36915, bright = 225 - beyond * (beyond > 0 ? 470 : 120) / 61525;
    return bright < 40 ? 40 : bright > 255 ? 255 : bright;
}

/*
 * Mixes the slopes of the coarse-scale average (w) and the fine-scale average (f). If they are at
 * most 45 degrees apart, w alone is used; if they are at least 53 degrees apart, f alone is used.
 */
static inline uint32_t shade_from(const float f[3], const float w[3], int fine, int wide_value)
{
    const float a = sqrtf((f[0] * f[0] + f[1] * f[1]) + f[2] * f[2]),
                b = sqrtf((w[0] * w[0] + w[1] * w[1]) + w[2] * w[2]);
    const float along = (f[0] * w[0] + f[1] * w[1]) + f[2] * w[2];
    float t = b < 120 ? 0 : (along / (a * b > 1 ? a * b : 1) - 0.6f) * 10.0f, out[3];
    t = t > 1 ? 1 : t > 0 ? t : 0;
    for (int i = 0; i < 3; i++)
        out[i] = t > 0 ? f[i] * ((1 - t) * b) + w[i] * (t * a) : f[i];
    const int open = openness(fine), both = openness(8 * wide_value - fine + 6152);
    return ost_octahedral_of(out) | (uint32_t)((float)open + (float)(both - open) * t + 0.5f) << OST_OPEN_SHIFT;
}

#endif
