/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests the search for spheres. The volumes contain shapes that formulas define: a head (a ball on a shaft), a
 * socket (a block with a dish cut out), and hollow balls. The expected centres and radii are those in the formulas.
 *
 * Covers: REQ-SPHERES
 */
#include <math.h>

#include <osteon/anatomy.h>

#include "harness.h"

enum { SEEDS = 12 };
#define MM OST_PM_PER_MM

typedef struct shape {
    double centre[3], radius;
    double shaft;     /* radius of a cylinder from the centre towards -z; 0 if there is none */
    double cavity;    /* radius of a hollow in the ball; 0 if there is none */
    bool socket;      /* true if the ball is a hollow in a block that lies below the ball's centre */
    bool box;         /* true if the volume is a cube instead of a ball */
    int noise;        /* maximum absolute value of the noise, in HU */
} shape;

static double between(test_rng *rng, double lo, double hi)
{
    return lo + (hi - lo) * (double)rng_range(rng, 0, 1000000) / 1e6;
}

static bool is_solid(const shape *s, const double p[3])
{
    const double d[3] = {p[0] - s->centre[0], p[1] - s->centre[1], p[2] - s->centre[2]};
    const double r = sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
    if (s->box)
        return fmax(fmax(fabs(d[0]), fabs(d[1])), fabs(d[2])) < s->radius;
    if (s->socket)
        return fabs(d[0]) < 18 && fabs(d[1]) < 14 && d[2] < -0.8 * s->radius && d[2] > -2 * s->radius &&
               r >= s->radius;
    if (s->shaft > 0 && d[2] < 0 && hypot(d[0], d[1]) < s->shaft)
        return true;
    return r < s->radius && r >= s->cavity;
}

static ost_volume draw(const shape *s, const double spacing[3], const double size[3], test_rng *rng)
{
    ost_geometry g = {.origin = {-20 * MM, 30 * MM, 7 * MM}};
    ost_pm *const step[3] = {&g.spacing.x, &g.spacing.y, &g.spacing.z};
    int32_t *const n[3] = {&g.dims.x, &g.dims.y, &g.dims.z};
    for (int a = 0; a < 3; a++) {
        *step[a] = (ost_pm)(spacing[a] * 1e9);
        *n[a] = (int32_t)(size[a] / spacing[a]);
    }
    ost_volume v;
    ost_error err = {0};
    assert_ok(ost_volume_init(&v, &g, &err));
    size_t i = 0;
    for (int32_t z = 0; z < g.dims.z; z++)
        for (int32_t y = 0; y < g.dims.y; y++)
            for (int32_t x = 0; x < g.dims.x; x++) {
                const double p[3] = {-20 + x * spacing[0], 30 + y * spacing[1], 7 + z * spacing[2]};
                v.voxels[i++] = (int16_t)((is_solid(s, p) ? 700 : 40) + rng_range(rng, -s->noise, s->noise));
            }
    return v;
}

static double off_centre(const ost_sphere *s, const double centre[3])
{
    const double d[3] = {ost_pm_to_mm(s->centre.x) - centre[0], ost_pm_to_mm(s->centre.y) - centre[1],
                         ost_pm_to_mm(s->centre.z) - centre[2]};
    return sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
}

static void random_spacing(test_rng *rng, double spacing[3])
{
    spacing[0] = spacing[1] = between(rng, 0.4, 1.5);
    spacing[2] = between(rng, 0.5, 3);
}

/* Tests a ball on a shaft. The radius of the shaft is two thirds of the radius of the ball. */
static void finds_a_ball_on_a_shaft(void **state)
{
    (void)state;
    ost_error err = {0};
    test_rng seeds = rng_seeded(__func__);
    for (int i = 0; i < SEEDS; i++) {
        const uint64_t seed = rng_next(&seeds);
        test_rng rng = {seed};
        double spacing[3];
        random_spacing(&rng, spacing);
        shape s = {.radius = between(&rng, 18, 31), .noise = 60};
        for (int a = 0; a < 3; a++)
            s.centre[a] = (const double[3]){-20, 30, 7}[a] + between(&rng, 35, 45);
        s.shaft = s.radius * 2 / 3;
        s.cavity = seed % 2 ? s.radius - 4 : 0;
        ost_volume v = draw(&s, spacing, (const double[3]){80, 80, 80}, &rng);
        ost_sphere found[4];
        int count;
        assert_ok(ost_spheres_find(&(ost_anatomy_bone){&v, 300, 32767}, NULL, found, 4, &count, &err));
        const double off = off_centre(&found[0], s.centre), wider = ost_pm_to_mm(found[0].radius) - s.radius;
        if (off > 0.6 || fabs(wider) > 0.4)
            fail_msg("seed %llu: error of the centre %.2f mm, of the radius %.2f mm", (unsigned long long)seed, off,
                     wider);
        assert_true(found[0].residual_mm < 0.7);
        assert_true(found[0].coverage > 0.5 && found[0].coverage < 1);
        /* The detected part of the sphere is the side opposite the shaft. */
        assert_true(found[0].facing[2] > 0.9);
        ost_volume_free(&v);
    }
}

/* Tests a dish of 36 x 28 mm in a block. */
static void finds_a_dish(void **state)
{
    (void)state;
    ost_error err = {0};
    test_rng seeds = rng_seeded(__func__);
    for (int i = 0; i < SEEDS; i++) {
        const uint64_t seed = rng_next(&seeds);
        test_rng rng = {seed};
        double spacing[3];
        random_spacing(&rng, spacing);
        spacing[2] = spacing[2] > 1.5 ? 1.5 : spacing[2];
        shape s = {.radius = between(&rng, 24, 38), .noise = 60, .socket = true};
        for (int a = 0; a < 3; a++)
            s.centre[a] = (const double[3]){-20, 30, 7}[a] + (a == 2 ? 70 : between(&rng, 28, 32));
        ost_volume v = draw(&s, spacing, (const double[3]){60, 60, 60}, &rng);
        ost_sphere found[2];
        int count;
        const ost_sphere_options concave = {.concave = true};
        assert_ok(ost_spheres_find(&(ost_anatomy_bone){&v, 300, 32767}, &concave, found, 2, &count, &err));
        const double off = off_centre(&found[0], s.centre), wider = ost_pm_to_mm(found[0].radius) - s.radius;
        if (off > 3 || fabs(wider) > 3)
            fail_msg("seed %llu: error of the centre %.2f mm, of the radius %.2f mm", (unsigned long long)seed, off,
                     wider);
        assert_true(found[0].facing[2] < -0.98);
        ost_volume_free(&v);
    }
}

/* Two runs must give the same bytes, and lengths must be multiples of 0.01 mm. */
static void result_is_deterministic(void **state)
{
    (void)state;
    ost_error err = {0};
    test_rng rng = {7};
    const shape s = {.centre = {20, 70, 47}, .radius = 24, .shaft = 15, .noise = 100};
    ost_volume v = draw(&s, (const double[3]){1, 1, 2}, (const double[3]){80, 80, 80}, &rng);
    ost_sphere a[3], b[3];
    int n, m;
    assert_ok(ost_spheres_find(&(ost_anatomy_bone){&v, 300, 32767}, NULL, a, 3, &n, &err));
    assert_ok(ost_spheres_find(&(ost_anatomy_bone){&v, 300, 32767}, NULL, b, 3, &m, &err));
    assert_int_equal(n, m);
    assert_memory_equal(a, b, sizeof *a * (size_t)n);
    assert_int_equal(a[0].centre.x % (MM / 100), 0);
    assert_int_equal(a[0].radius % (MM / 100), 0);
    ost_volume_free(&v);
}

static void refused(ost_status got, ost_status expected, const char *text, const ost_error *err)
{
    assert_int_equal(got, expected);
    assert_non_null(strstr(err->text, text));
}

static void refuses_invalid_input(void **state)
{
    (void)state;
    ost_error err = {0};
    test_rng rng = {1};
    const shape s = {.centre = {10, 60, 37}, .radius = 8, .box = true};
    ost_volume v = draw(&s, (const double[3]){1, 1, 1}, (const double[3]){60, 60, 60}, &rng);
    const ost_anatomy_bone bone = {&v, 300, 32767};
    ost_sphere found[1];
    int count = 5;
    /* A small cube contains no sphere of an allowed radius. */
    refused(ost_spheres_find(&bone, NULL, found, 1, &count, &err), OST_ERR_INPUT, "no spherical surface", &err);
    assert_int_equal(count, 0);
    refused(ost_spheres_find(&(ost_anatomy_bone){&v, 5, 5}, NULL, found, 1, &count, &err), OST_ERR_INPUT, "no ", &err);
    refused(ost_spheres_find(&(ost_anatomy_bone){&v, 0, 5}, NULL, found, 1, &count, &err), OST_ERR_RANGE,
            "bone from 0", &err);
    ost_sphere_options o = {.radius_min = 20 * MM, .radius_max = 10 * MM};
    refused(ost_spheres_find(&bone, &o, found, 1, &count, &err), OST_ERR_RANGE, "radii from 20 to 10", &err);
    o = (ost_sphere_options){.has_near = true};
    refused(ost_spheres_find(&bone, &o, found, 1, &count, &err), OST_ERR_RANGE, "reach", &err);
    refused(ost_spheres_find(&bone, NULL, found, 99, &count, &err), OST_ERR_RANGE, "99 spheres", &err);
    refused(ost_spheres_find(NULL, NULL, found, 1, &count, &err), OST_ERR_USAGE, "volume", &err);
    ost_volume_free(&v);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(finds_a_ball_on_a_shaft),
        cmocka_unit_test(finds_a_dish),
        cmocka_unit_test(result_is_deterministic),
        cmocka_unit_test(refuses_invalid_input),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
