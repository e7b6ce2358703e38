/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Phantoms of scapulae in random poses, for the landmark tests.
 *
 *   phantom --rotated and resampled at random--> CT with noise, and the true landmarks in the frame of the CT
 */
#ifndef OST_TESTS_ANATOMY_SCENE_H
#define OST_TESTS_ANATOMY_SCENE_H

#include <math.h>

#include <osteon/io.h>
#include <osteon/phantom.h>
#include <osteon/sim.h>

#include "harness.h"

enum { SCENE_THRESHOLD = 250 }; /* cartilage is below this threshold */

typedef struct scene {
    ost_volume ct;
    /* `axis` is a direction; the others are positions in mm; `glenoid` is on the surface of the cartilage */
    double glenoid[3], axis[3], trigonum[3], inferior[3];
    bool left;
    double spacing[3];
} scene;

static inline double scene_between(test_rng *rng, double lo, double hi)
{
    return lo + (hi - lo) * (double)rng_range(rng, 0, 1000000) / 1e6;
}

static inline void scene_read(const ost_meta *meta, const char *key, double out[3])
{
    ost_error err = {0};
    ost_pm3 p;
    bool there;
    assert_ok(ost_point_from_meta(meta, key, &p, &there, &err));
    assert_true(there);
    out[0] = ost_pm_to_mm(p.x);
    out[1] = ost_pm_to_mm(p.y);
    out[2] = ost_pm_to_mm(p.z);
}

/* Computes out = R v for the rotation matrix R with the given rows. */
static inline void scene_turn(double rotation[3][3], const double v[3], double out[3])
{
    for (int r = 0; r < 3; r++)
        out[r] = rotation[r][0] * v[0] + rotation[r][1] * v[1] + rotation[r][2] * v[2];
}

/* Makes a random rotation from a unit quaternion. */
static inline void scene_rotation(test_rng *rng, double rotation[3][3])
{
    double q[4], square;
    do {
        square = 0;
        for (int i = 0; i < 4; i++) {
            q[i] = scene_between(rng, -1, 1);
            square += q[i] * q[i];
        }
    } while (square > 1 || square < 0.01);
    for (int i = 0; i < 4; i++)
        q[i] /= sqrt(square);
    const double w = q[0], x = q[1], y = q[2], z = q[3];
    const double m[3][3] = {{1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)},
                            {2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)},
                            {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)}};
    memcpy(rotation, m, sizeof m);
}

/* Returns the density of the phantom at a point by trilinear interpolation, or -100 outside the phantom's grid. */
static inline double scene_density(const ost_volume *v, const double p[3])
{
    const ost_geometry *g = &v->geometry;
    const double o[3] = {ost_pm_to_mm(g->origin.x), ost_pm_to_mm(g->origin.y), ost_pm_to_mm(g->origin.z)},
                 s[3] = {ost_pm_to_mm(g->spacing.x), ost_pm_to_mm(g->spacing.y), ost_pm_to_mm(g->spacing.z)};
    const int32_t n[3] = {g->dims.x, g->dims.y, g->dims.z};
    int32_t c[3];
    double t[3], sum = 0;
    for (int a = 0; a < 3; a++) {
        const double at = (p[a] - o[a]) / s[a];
        if (!(at >= 0 && at < n[a] - 1))
            return -100;
        c[a] = (int32_t)at;
        t[a] = at - c[a];
    }
    const int16_t *voxel = v->voxels + (size_t)c[0] + (size_t)n[0] * ((size_t)c[1] + (size_t)n[1] * (size_t)c[2]);
    for (int k = 0; k < 8; k++) {
        const double weight = (k & 1 ? t[0] : 1 - t[0]) * (k & 2 ? t[1] : 1 - t[1]) * (k & 4 ? t[2] : 1 - t[2]);
        const size_t row = (size_t)(k >> 1 & 1) + (size_t)n[1] * (size_t)(k >> 2);
        sum += weight * voxel[(size_t)(k & 1) + (size_t)n[0] * row];
    }
    return sum;
}

/* Makes a scene. The seed determines the side, the rotation, the spacing (0.5 to 1.5 mm in a slice, 0.5 to 3 mm
   between slices) and the noise (up to 40 HU). */
static inline void scene_make(uint64_t seed, scene *out)
{
    ost_error err = {0};
    test_rng rng = {seed};
    double rotation[3][3], lo[3] = {1e9, 1e9, 1e9}, hi[3] = {-1e9, -1e9, -1e9};
    ost_volume phantom;
    *out = (scene){.left = rng_range(&rng, 0, 1) == 1};
    const ost_pm step = OST_PM_PER_MM * 8 / 10;
    const ost_phantom_options options = {
        .seed = (uint64_t)rng_range(&rng, 1, 1000000), .spacing = {step, step, step}, .left = out->left};
    assert_ok(ost_phantom_make(OST_PHANTOM_SCAPULA, &options, &phantom, &err));
    scene_rotation(&rng, rotation);
    out->spacing[0] = out->spacing[1] = scene_between(&rng, 0.5, 1.5);
    out->spacing[2] = scene_between(&rng, 0.5, 3);
    const int64_t noise = rng_range(&rng, 0, 40);
    static const char *const keys[4] = {OST_META_GLENOID_AT, OST_META_GLENOID_AXIS, OST_META_TRIGONUM,
                                        OST_META_INFERIOR_ANGLE};
    double *const to[4] = {out->glenoid, out->axis, out->trigonum, out->inferior};
    for (int i = 0; i < 4; i++) {
        double p[3];
        scene_read(&phantom.meta, keys[i], p);
        scene_turn(rotation, p, to[i]);
    }
    /* Computes the bounding box of the rotated bone. */
    const ost_geometry *g = &phantom.geometry;
    const double o[3] = {ost_pm_to_mm(g->origin.x), ost_pm_to_mm(g->origin.y), ost_pm_to_mm(g->origin.z)};
    size_t i = 0;
    for (int32_t z = 0; z < g->dims.z; z++)
        for (int32_t y = 0; y < g->dims.y; y++)
            for (int32_t x = 0; x < g->dims.x; x++)
                if (phantom.voxels[i++] >= SCENE_THRESHOLD) {
                    const double p[3] = {o[0] + 0.8 * x, o[1] + 0.8 * y, o[2] + 0.8 * z};
                    double q[3];
                    scene_turn(rotation, p, q);
                    for (int a = 0; a < 3; a++) {
                        lo[a] = fmin(lo[a], q[a]);
                        hi[a] = fmax(hi[a], q[a]);
                    }
                }
    ost_geometry grid;
    ost_pm *const spacing[3] = {&grid.spacing.x, &grid.spacing.y, &grid.spacing.z},
           *const origin[3] = {&grid.origin.x, &grid.origin.y, &grid.origin.z};
    int32_t *const n[3] = {&grid.dims.x, &grid.dims.y, &grid.dims.z};
    for (int a = 0; a < 3; a++) {
        *spacing[a] = (ost_pm)(out->spacing[a] * 1e6) * 1000;
        *origin[a] = (ost_pm)((lo[a] - 6) * 1e6) * 1000;
        *n[a] = (int32_t)((hi[a] - lo[a] + 12) / out->spacing[a]) + 1;
    }
    assert_ok(ost_volume_init(&out->ct, &grid, &err));
    /*
     * The density of a voxel is the mean of the densities at `layers` positions along z, which are at most 0.8 mm
     * apart.
     */
    const int layers = (int)ceil(out->spacing[2] / 0.8);
    i = 0;
    for (int32_t z = 0; z < grid.dims.z; z++)
        for (int32_t y = 0; y < grid.dims.y; y++)
            for (int32_t x = 0; x < grid.dims.x; x++) {
                double sum = 0;
                for (int k = 0; k < layers; k++) {
                    const double q[3] = {
                        ost_pm_to_mm(grid.origin.x + x * grid.spacing.x),
                        ost_pm_to_mm(grid.origin.y + y * grid.spacing.y),
                        ost_pm_to_mm(grid.origin.z + z * grid.spacing.z) +
                            ((k + 0.5) / layers - 0.5) * out->spacing[2]};
                    /* The inverse of a rotation is its transpose. */
                    double p[3];
                    for (int a = 0; a < 3; a++)
                        p[a] = rotation[0][a] * q[0] + rotation[1][a] * q[1] + rotation[2][a] * q[2];
                    sum += scene_density(&phantom, p);
                }
                out->ct.voxels[i++] = (int16_t)(sum / layers + (double)rng_range(&rng, -noise, noise));
            }
    ost_volume_free(&phantom);
}

#endif
