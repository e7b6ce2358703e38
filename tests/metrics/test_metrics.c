/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Metrics against a bone whose cuts are known: a block with a flat face, a
 * sphere reamed into it along a tilted axis, and a hole drilled along another.
 * Covers: REQ-METRICS
 */
#include "harness.h"

#include <math.h>

#include <osteon/metrics.h>

#define MM OST_PM_PER_MM
#define PI 3.14159265358979323846

/* Inward is +x: a right shoulder's. The face is the plane x = 0, the block 40 mm deep, 46 from front to back and 50 high, where the grid ends. */
typedef struct cuts {
    double radius, depth;       /* of the sphere, pressed along its axis through the face's centre */
    double back_deg, up_deg;    /* how far its axis, outward, is turned toward the back (+y) or the head (+z) */
    double hole_radius, hole_depth, hole_y, hole_up_deg;
} cuts;

enum { NX = 88, N = 100 };

static void make(const cuts *c, ost_volume *before, ost_volume *after)
{
    ost_error err = {0};
    const ost_geometry g = {{NX, N, N}, {MM / 2, MM / 2, MM / 2}, {-4 * MM + MM / 4, -25 * MM + MM / 4, -25 * MM + MM / 4}};
    assert_ok(ost_volume_init(before, &g, &err));
    assert_ok(ost_volume_init(after, &g, &err));
    const double outward[3] = {-1, tan(c->back_deg * PI / 180), tan(c->up_deg * PI / 180)};
    const double size = sqrt(outward[0] * outward[0] + outward[1] * outward[1] + outward[2] * outward[2]);
    double centre[3];
    for (int a = 0; a < 3; a++)
        centre[a] = outward[a] / size * (c->radius - c->depth);
    for (int z = 0, i = 0; z < N; z++)
        for (int y = 0; y < N; y++)
            for (int x = 0; x < NX; x++, i++) {
                const double p[3] = {-3.75 + 0.5 * x, -24.75 + 0.5 * y, -24.75 + 0.5 * z};
                const double d[3] = {p[0] - centre[0], p[1] - centre[1], p[2] - centre[2]};
                /* 2 mm of cartilage, 2 mm of plate, then cancellous bone. */
                before->voxels[i] = p[0] < 0 || fabs(p[1]) > 23 ? 0 : p[0] < 2 ? 130 : p[0] < 4 ? 900 : 300;
                const double across[2] = {p[1] - c->hole_y, p[2] + p[0] * tan(c->hole_up_deg * PI / 180)};
                const bool reamed = d[0] * d[0] + d[1] * d[1] + d[2] * d[2] < c->radius * c->radius;
                const bool drilled = p[0] < c->hole_depth && across[0] * across[0] + across[1] * across[1] < c->hole_radius * c->hole_radius;
                after->voxels[i] = reamed || drilled ? 0 : before->voxels[i];
            }
}

static ost_metrics measure(const cuts *c, ost_status expected)
{
    static ost_metrics m;
    ost_error err = {0};
    ost_volume before, after;
    const ost_density_classes classes = ost_density_classes_default();
    const ost_metrics_plan plan = {.at = {0, 0, 0}, .axis = {2, 0, 0}, .depth_mm = c->depth};
    make(c, &before, &after);
    assert_int_equal(ost_metrics_make(&before, &after, 120, &classes, &plan, &m, &err), expected);
    ost_volume_free(&before);
    ost_volume_free(&after);
    return m;
}

#define NEAR(value, expected, bound)                                                              \
    do {                                                                                          \
        print_message("%-24s %9.3f, %9.3f expected\n", #value, (double)(value), (double)(expected)); \
        assert_true(fabs((double)(value) - (expected)) <= (bound));                               \
    } while (0)

/* A cap of a sphere in a plane: volume pi h^2 (R - h / 3), mean depth half of the greatest, nearly. */
static void a_straight_one(void **state)
{
    (void)state;
    const cuts c = {.radius = 27, .depth = 3, .hole_radius = 3, .hole_depth = 22};
    const ost_metrics m = measure(&c, OST_OK);
    const double cap = PI * 9 * (27 - 1), hole_beyond = PI * 9 * 19, rim = 2 * 27 * 3 - 9.0;
    NEAR(m.removed_mm3, cap + hole_beyond, 0.03 * (cap + hole_beyond));
    NEAR(m.floor_mm2, PI * rim - PI * 9, 0.1 * PI * rim); /* what is shallower than half a voxel does not show */
    NEAR(m.sphere_mm, 27, 1);
    NEAR(m.centre_depth_mm, 3, 0.25);
    NEAR(m.depth_max_mm, 3, 0.3);
    NEAR(m.depth_mean_mm, (cap - PI * 9 * 3) / (PI * rim - PI * 9), 0.2);
    NEAR(m.angle_deg, 0, 0.3);
    assert_true(m.fit_rms_mm < 0.3 && m.contact_percent > 95);
    NEAR(m.over_mm3, 0, 6); /* of the hole the rim alone, in cells that it shares with the floor */
    assert_true(m.hole && !m.hole_breach);
    NEAR(m.hole_depth_mm, 22, 0.5);
    NEAR(m.hole_diameter_mm, 6, 0.2);
    NEAR(m.hole_angle_deg, 0, 0.3);
    NEAR(m.hole_entry_mm, 0, 0.2);
    NEAR(m.hole_wall_mm, 6, 0.01);
    /* Of the plate, from 2 to 4 mm, the cap took what lies deeper than 2. */
    const double taken = PI * 1 * (27 - 1.0 / 3);
    NEAR(m.plate_mm3, 2 * (PI * rim - PI * 9), 0.15 * 2 * PI * rim);
    NEAR(m.plate_kept_percent, 100 * (1 - taken / (2 * PI * rim)), 4);
    NEAR(m.removed_by_class_mm3[0] + m.removed_by_class_mm3[1] + m.removed_by_class_mm3[2], m.removed_mm3, 1e-6);
    assert_true(m.removed_by_class_mm3[0] > m.removed_by_class_mm3[2] && m.removed_by_class_mm3[1] > 0);
}

static void tilted_ones(void **state)
{
    (void)state;
    static const struct {
        double back, up;
    } tilts[] = {{8, 0}, {-6, 0}, {0, 7}, {5, -5}};
    for (int i = 0; i < 4; i++) {
        const cuts c = {.radius = 27, .depth = 3, .back_deg = tilts[i].back, .up_deg = tilts[i].up};
        const ost_metrics m = measure(&c, OST_OK);
        const double b = tan(tilts[i].back * PI / 180), u = tan(tilts[i].up * PI / 180);
        NEAR(m.retroversion_deg, tilts[i].back, 0.5);
        NEAR(m.superior_deg, tilts[i].up, 0.5);
        NEAR(m.angle_deg, atan(sqrt(b * b + u * u)) * 180 / PI, 0.5);
        assert_false(m.hole);
    }
}

static void a_crooked_hole(void **state)
{
    (void)state;
    const cuts c = {.radius = 27, .depth = 3, .hole_radius = 3, .hole_depth = 20, .hole_y = 4, .hole_up_deg = 10};
    const ost_metrics m = measure(&c, OST_OK);
    NEAR(m.hole_angle_deg, 10, 0.5);
    NEAR(m.hole_entry_mm, 4, 0.3);
    NEAR(m.hole_depth_mm, 20, 0.5);
    assert_false(m.hole_breach);
    /* Near the block's side, and through it. */
    const cuts near_side = {.radius = 27, .depth = 3, .hole_radius = 3, .hole_depth = 20, .hole_y = 18};
    NEAR(measure(&near_side, OST_OK).hole_wall_mm, 2, 0.75);
    const cuts through = {.radius = 27, .depth = 3, .hole_radius = 3, .hole_depth = 20, .hole_y = 21};
    assert_true(measure(&through, OST_OK).hole_breach);
}

static void too_deep(void **state)
{
    (void)state;
    const cuts deep = {.radius = 27, .depth = 5.5};
    ost_error err = {0};
    static ost_metrics m;
    ost_volume before, after;
    const ost_density_classes classes = ost_density_classes_default();
    const ost_metrics_plan plan = {.axis = {1, 0, 0}, .depth_mm = 3};
    make(&deep, &before, &after);
    assert_ok(ost_metrics_make(&before, &after, 120, &classes, &plan, &m, &err));
    /* The cap below plan and margin is one of 1.5 mm. */
    NEAR(m.over_mm3, PI * 1.5 * 1.5 * (27 - 0.5), 0.12 * PI * 1.5 * 1.5 * 26.5);
    NEAR(m.centre_depth_mm, 5.5, 0.25);
    assert_int_equal(ost_metrics_make(&before, &before, 120, &classes, &plan, &m, &err), OST_ERR_INPUT);
    ost_volume_free(&before);
    ost_volume_free(&after);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_straight_one),
        cmocka_unit_test(tilted_ones),
        cmocka_unit_test(a_crooked_hole),
        cmocka_unit_test(too_deep),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
