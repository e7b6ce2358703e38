/* SPDX-License-Identifier: Apache-2.0 */
/* Fixtures for the tests of forces: tools, and bones into which the tools are pressed. */
#ifndef TESTS_FORCE_PRESS_H
#define TESTS_FORCE_PRESS_H

#include "ref/scene.h"

#include <math.h>

#include <osteon/force.h>

#define MM OST_PM_PER_MM
#define PI 3.14159265358979323846

/*
 * Density in HU for which the default parameters give a mass density of 1.95 g/cm3, with a relative error of at most
 * 1e-4.
 */
enum { REFERENCE_HU = 1705 };

/* Makes a bone whose lowest `solid_layers` layers have the density `hu`. The centre of the grid's first voxel is at
   the origin. */
static inline ost_bone *half_space(ost_backend *backend, int32_t nx, int32_t nz, ost_pm s, int32_t solid_layers,
                                   int16_t hu)
{
    const ost_geometry g = cubic_geometry(nx, nx, nz, s, (ost_pm3){0, 0, 0});
    int16_t *voxels = calloc(voxel_count(&g), sizeof *voxels);
    assert_non_null(voxels);
    for (size_t i = 0; i < (size_t)nx * (size_t)nx * (size_t)solid_layers; i++)
        voxels[i] = hu;
    ost_bone *bone = bone_of(backend, &g, 32, voxels);
    free(voxels);
    return bone;
}

static inline ost_force *force_of(const ost_bone *bone, const ost_force_params *params, ost_shell_point *points,
                                  size_t count)
{
    ost_error err = {0};
    ost_force *force;
    const ost_shell shell = {count, points};
    assert_ok(ost_force_create(bone, params, &force, &err));
    assert_ok(ost_force_add_shell(force, &shell, &err));
    return force;
}

static inline void assert_near(const char *what, double got, double expected, double share)
{
    print_message("%s: %.6g, expected %.6g\n", what, got, expected);
    if (!(fabs(got - expected) <= share * fabs(expected)))
        fail_msg("%s: %.6g, expected %.6g to within %.1f %%", what, got, expected, share * 100);
}

#endif
