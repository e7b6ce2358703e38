/* SPDX-License-Identifier: Apache-2.0 */
/* Helpers for the OpenGL tests: bodies, cameras, and the comparison of two frames. */
#ifndef OST_TESTS_RENDER_GL_SCENE_H
#define OST_TESTS_RENDER_GL_SCENE_H

#include <math.h>

#include "harness.h"
#include "render/points/frame.h"

static inline ost_geometry grid(int x, int y, int z, ost_pm spacing)
{
    return (ost_geometry){{x, y, z}, {spacing, spacing, spacing}, {-3 * OST_PM_PER_MM, 0, 7 * OST_PM_PER_MM}};
}

/* Makes a body of three lobes with a bowl and holes. */
static inline ost_volume body(test_rng *rng, int n, ost_pm spacing)
{
    ost_error err = {0};
    ost_volume v;
    const ost_geometry g = grid(n, n, n, spacing);
    assert_ok(ost_volume_init(&v, &g, &err));
    const double lobe[3][4] = {{0.38, 0.5, 0.55, 0.26}, {0.62, 0.45, 0.4, 0.28}, {0.5, 0.62, 0.7, 0.2}};
    for (int k = 0; k < n; k++)
        for (int j = 0; j < n; j++)
            for (int i = 0; i < n; i++) {
                bool in = false;
                for (int l = 0; l < 3; l++)
                    in = in ||
                         hypot(hypot(i - lobe[l][0] * n, j - lobe[l][1] * n), k - lobe[l][2] * n) < lobe[l][3] * n;
                in = in && hypot(hypot(i - 0.62 * n, j - 0.1 * n), k - 0.4 * n) > 0.16 * n;
                v.voxels[i + (size_t)n * (size_t)(j + n * k)] = in && rng_range(rng, 0, 60) != 0 ? 700 : 0;
            }
    return v;
}

static inline ost_surface surface_of(const ost_volume *v)
{
    ost_error err = {0};
    ost_surface s;
    assert_ok(ost_surface_init(&s, &v->geometry, &err));
    assert_ok(ost_surface_set_volume(&s, v, 120, &err));
    assert_ok(ost_surface_update(&s, &err));
    return s;
}

/*
 * Returns a camera that looks at the point `aside` voxels from the body's middle along x. The camera is
 * `distance` voxels from this point, in the direction (x, y, z).
 */
static inline ost_camera look(const ost_geometry *g, double x, double y, double z, double distance, double aside,
                              int width, int height)
{
    ost_error err = {0};
    ost_camera c = {.focal_milli = (int32_t)(1207.10678 * height), .width = width, .height = height};
    const double mm = 1e-9 * (double)g->spacing.x, length = sqrt(x * x + y * y + z * z), up[3] = {0, 0, 1};
    const double at[3] = {-3 + mm * (0.5 * g->dims.x + aside), mm * 0.5 * g->dims.y, 7 + mm * 0.5 * g->dims.z};
    const double from[3] = {at[0] + mm * distance * x / length, at[1] + mm * distance * y / length,
                            at[2] + mm * distance * z / length};
    assert_ok(ost_camera_look_at(from, at, up, &c, &err));
    return c;
}

typedef struct difference {
    int colour, face, depth; /* each member counts the pixels that differ in this property */
} difference;

static inline difference compare(const ost_frame *a, const ost_frame *b)
{
    difference d = {0};
    for (int y = 0; y < a->height; y++)
        for (int x = 0; x < a->width; x++) {
            const size_t at = (size_t)y * (size_t)a->planes.stride + (size_t)x;
            const bool face = a->planes.face[at] != b->planes.face[at];
            d.colour += a->planes.colour[at] != b->planes.colour[at];
            d.face += face;
            if (!face && a->planes.face[at] != OST_NO_FACE)
                d.depth += !(fabsf(a->planes.depth[at] - b->planes.depth[at]) <= 1e-5f * a->planes.depth[at]);
        }
    return d;
}

#endif
