/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests that the surface of any set of voxels is closed, faces outward and encloses the right
 * volume.
 */
#include "harness.h"

#include <math.h>

#include <osteon/grid.h>
#include <osteon/mesh.h>

#include "mesh/surface.h"

static ost_volume volume_of(int32_t x, int32_t y, int32_t z)
{
    ost_error err = {0};
    ost_volume volume = {0};
    const ost_geometry geometry = {
        {x, y, z}, {OST_PM_PER_MM / 2, OST_PM_PER_MM, 700000000}, {-3 * OST_PM_PER_MM, 5, 7 * OST_PM_PER_MM}};
    assert_ok(ost_volume_init(&volume, &geometry, &err));
    return volume;
}

static void assert_closed(const ost_volume *volume, int32_t threshold, ost_surface_placement placement, double *mm3)
{
    ost_error err = {0};
    ost_mesh mesh = {0};
    size_t open_edges = 99;
    assert_ok(ost_surface_extract(volume, threshold, placement, &mesh, &err));
    assert_ok(ost_mesh_open_edges(&mesh, &open_edges, &err));
    assert_int_equal(open_edges, 0);
    *mm3 = ost_mesh_volume_mm3(&mesh);
    assert_true(*mm3 > 0);
    ost_mesh_free(&mesh);
}

/* Tests random voxels with fill densities from 2 to 98 %. All 256 patterns of the eight voxels around a corner occur,
   in many combinations of adjacent corners. */
static void surface_of_random_voxels_is_closed(void **state)
{
    (void)state;
    test_rng rng = rng_seeded("surface of noise");
    for (int round = 0; round < 40; round++) {
        ost_volume volume = volume_of((int32_t)rng_range(&rng, 1, 14), (int32_t)rng_range(&rng, 1, 14),
                                      (int32_t)rng_range(&rng, 1, 14));
        int64_t n = ost_dims_count(volume.geometry.dims), share = rng_range(&rng, 2, 98);
        volume.voxels[0] = 500;
        for (int64_t v = 1; v < n; v++)
            volume.voxels[v] = rng_range(&rng, 0, 99) < share ? (int16_t)rng_range(&rng, 120, 2000)
                                                              : (int16_t)rng_range(&rng, -1000, 119);
        double mm3;
        assert_closed(&volume, 120, OST_SURFACE_DENSITY, &mm3);
        assert_closed(&volume, 120, OST_SURFACE_SMOOTH, &mm3);
        ost_volume_free(&volume);
    }
}

/*
 * Makes a ball whose densities depend linearly on the distance from its surface. The surface at the threshold density
 * must enclose the ball's volume to within 1 %, and the smoothed surface must enclose it to within 3 %.
 */
static void surface_of_ball_encloses_volume(void **state)
{
    (void)state;
    const double radius = 8, pi = 3.14159265358979;
    ost_volume volume = volume_of(44, 24, 32);
    for (int32_t k = 0; k < 32; k++)
        for (int32_t j = 0; j < 24; j++)
            for (int32_t i = 0; i < 44; i++) {
                double x = (i - 21.7) * 0.5, y = j - 11.6, z = (k - 15.2) * 0.7;
                volume.voxels[i + 44 * (j + 24 * k)] = (int16_t)lround(1000 +
                                                                       100 * (radius - sqrt(x * x + y * y + z * z)));
            }
    double mm3, ball = 4.0 / 3 * pi * radius * radius * radius;
    assert_closed(&volume, 1000, OST_SURFACE_DENSITY, &mm3);
    assert_true(fabs(mm3 / ball - 1) < 0.01);
    assert_closed(&volume, 1000, OST_SURFACE_SMOOTH, &mm3);
    assert_true(fabs(mm3 / ball - 1) < 0.03);
    ost_volume_free(&volume);
}

static void volume_without_bone_is_refused(void **state)
{
    (void)state;
    ost_error err = {0};
    ost_mesh mesh = {0};
    ost_volume volume = volume_of(3, 3, 3);
    assert_int_equal(ost_surface_extract(&volume, 120, OST_SURFACE_DENSITY, &mesh, &err), OST_ERR_INPUT);
    assert_null(mesh.triangles);
    ost_volume_free(&volume);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(surface_of_random_voxels_is_closed),
        cmocka_unit_test(surface_of_ball_encloses_volume),
        cmocka_unit_test(volume_without_bone_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
