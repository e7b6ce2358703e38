/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests the counts of bone voxels in front of a face, along the axis and under a tool. The expected counts are
 * computed here according to the definitions in docs/reference/metrics.md.
 * Covers: REQ-SITE
 */
#include "ref/scene.h"

#include <math.h>

#include <osteon/sim.h>

/*
 * Tests random voxels, axes, centres and limits. Because the test and the library round differently, a count
 * may differ by one voxel that lies on a border.
 */
static void random_sites(void **state)
{
    ost_backend *backend = *state;
    test_rng rng = rng_seeded("sites");
    for (int n = 0; n < 20; n++) {
        ost_error err = {0};
        const ost_geometry g = cubic_geometry((int32_t)rng_range(&rng, 20, 40), (int32_t)rng_range(&rng, 20, 40),
                                              (int32_t)rng_range(&rng, 1, 40), rng_range(&rng, 500, 1500) * UM,
                                              (ost_pm3){rng_range(&rng, -30000, 0) * UM,
                                                        rng_range(&rng, -30000, 0) * UM,
                                                        rng_range(&rng, -30000, 0) * UM});
        int16_t *voxels = random_densities(&rng, &g, 4);
        ost_bone *bone = bone_of(backend, &g, 16, voxels);
        const ost_glenoid site = {.at = {rng_range(&rng, -9000, 9000) * UM, rng_range(&rng, -9000, 9000) * UM,
                                         rng_range(&rng, -9000, 9000) * UM},
                                  .axis = {(double)rng_range(&rng, -100, 100), (double)rng_range(&rng, -100, 100),
                                           (double)rng_range(&rng, 1, 100)}};
        const double radius = n % 3 ? (double)rng_range(&rng, 3, 25) : 0,
                     reach = n % 4 ? (double)rng_range(&rng, 5, 40) : 0;
        const double size = sqrt(site.axis[0] * site.axis[0] + site.axis[1] * site.axis[1] +
                                 site.axis[2] * site.axis[2]);
        const double s = ost_pm_to_mm(g.spacing.x);
        int64_t front = 0, inward = 0, outward = 0, v = 0;
        for (int32_t k = 0; k < g.dims.z; k++)
            for (int32_t j = 0; j < g.dims.y; j++)
                for (int32_t i = 0; i < g.dims.x; i++, v++) {
                    if (voxels[v] < 120)
                        continue;
                    const double p[3] = {ost_pm_to_mm(g.origin.x - site.at.x + i * g.spacing.x),
                                         ost_pm_to_mm(g.origin.y - site.at.y + j * g.spacing.y),
                                         ost_pm_to_mm(g.origin.z - site.at.z + k * g.spacing.z)};
                    const double w = (p[0] * site.axis[0] + p[1] * site.axis[1] + p[2] * site.axis[2]) / size;
                    const double r = sqrt(fmax(0, p[0] * p[0] + p[1] * p[1] + p[2] * p[2] - w * w)), bend = fmin(r, 18);
                    front += w < -(3 + bend * bend / 60) && (radius == 0 || r <= radius) && (reach == 0 || w >= -reach);
                    inward += r <= 4 && w >= 1 && w < 11;
                    outward += r <= 4 && w >= -11 && w < -1;
                }
        int64_t found;
        double in, out;
        assert_ok(ost_bone_in_front(bone, &site, radius, reach, &found, &err));
        assert_true(llabs(found - front) <= 1);
        assert_ok(ost_bone_along_axis(bone, &site, &in, &out, &err));
        const double share = 100 * s * s * s / (acos(-1) * 16 * 10);
        assert_true(fabs(in - fmin(100, (double)inward * share)) <= share * 1.001);
        assert_true(fabs(out - fmin(100, (double)outward * share)) <= share * 1.001);
        ost_bone_free(bone);
        free(voxels);
    }
}

/*
 * Makes a block of bone from x_from to x_to mm along x, and 40 x 40 mm wide. Its voxels are 1 mm wide, and
 * their centres are at odd multiples of 1/2 mm.
 */
static ost_bone *slab(ost_backend *backend, int32_t x_from, int32_t x_to)
{
    const ost_geometry g = cubic_geometry(60, 40, 40, OST_PM_PER_MM, (ost_pm3){-39500 * UM, -19500 * UM, -19500 * UM});
    int16_t *voxels = calloc(voxel_count(&g), sizeof *voxels);
    assert_non_null(voxels);
    for (size_t v = 0; v < voxel_count(&g); v++) {
        const int32_t x = (int32_t)(v % 60) - 40;
        voxels[v] = x >= x_from && x < x_to ? 500 : 0;
    }
    ost_bone *bone = bone_of(backend, &g, 32, voxels);
    free(voxels);
    return bone;
}

static void faces_heads_and_reversed_axes(void **state)
{
    ost_backend *backend = *state;
    ost_error err = {0};
    const ost_glenoid right = {.axis = {1, 0, 0}}, reversed = {.axis = {-1, 0, 0}}, none = {.axis = {0, 0, 0}};
    int64_t voxels;
    double in, out;
    ost_bone *alone = slab(backend, 0, 20), *headed = slab(backend, -30, 20);
    assert_ok(ost_bone_in_front(alone, &right, 18, 30, &voxels, &err));
    assert_int_equal(voxels, 0);
    assert_ok(ost_bone_along_axis(alone, &right, &in, &out, &err));
    assert_true(in > 95 && out == 0);
    assert_ok(ost_bone_along_axis(alone, &reversed, &in, &out, &err));
    assert_true(in == 0 && out > 95);
    assert_ok(ost_bone_in_front(headed, &right, 18, 30, &voxels, &err));
    /* The zone is a cylinder of 30 mm depth and 18 mm radius without the bowl (site.c). Its volume is
       pi 18^2 (27 - 18^2 / 120) mm^3. */
    const double expected = acos(-1) * 18 * 18 * (27 - 18 * 18 / 120.0);
    assert_true(fabs((double)voxels - expected) < expected * 0.02);
    assert_int_equal(ost_bone_in_front(alone, &none, 18, 30, &voxels, &err), OST_ERR_USAGE);
    ost_bone_free(alone);
    ost_bone_free(headed);
}

/*
 * The tool is a cube of 4 mm without rotation. Its lower part cuts, and its upper part does not.
 * At any position, the voxels that the tool covers form a box.
 */
static void overlaps(void **state)
{
    ost_backend *backend = *state;
    ost_error err = {0};
    ost_tool_volume volume = {
        .geometry = {.dims = {4, 4, 4}, .voxel = OST_PM_PER_MM, .corner = {-2 * OST_PM_PER_MM, -2 * OST_PM_PER_MM, 0}}};
    uint8_t cells[64];
    for (int v = 0; v < 64; v++)
        cells[v] = v < 32 ? 1 : 2;
    volume.voxels = cells;
    ost_tool *tool;
    assert_ok(ost_tool_upload(backend, &volume, &tool, &err));
    ost_bone *bone = slab(backend, 0, 20);
    static const struct {
        int mm, expected;
    } cases[] = {{-10, 0}, {-2, 0}, {-1, 16}, {0, 32}, {1, 48}, {2, 64}, {10, 64}, {22, 0}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        int64_t voxels;
        ost_pose pose = ost_pose_identity();
        pose.t = (ost_pm3){cases[i].mm * OST_PM_PER_MM, 0, 0};
        assert_ok(ost_bone_overlap(bone, tool, &pose, &voxels, &err));
        assert_int_equal(voxels, cases[i].expected);
    }
    ost_bone_free(bone);
    ost_tool_free(tool);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(random_sites), cmocka_unit_test(faces_heads_and_reversed_axes),
                                       cmocka_unit_test(overlaps)};
    return run_on_backends(tests, open_test_backend, close_test_backend);
}
