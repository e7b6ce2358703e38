/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Compares forces with formulas for a sphere that is pressed into a plane, and for planar and hemispherical
 * reaming. Further tests check the shell of a spherical tool, a tool that does not cut, and the densities of
 * single voxels that a backend returns.
 * Covers: REQ-FORCE
 */
#include "force/press.h"

static ost_shell_point points[OST_SHELL_MAX];

static ost_pose at_mm(double x, double y, double z)
{
    return (ost_pose){.t = {(ost_pm)(x * 1e9), (ost_pm)(y * 1e9), (ost_pm)(z * 1e9)}, .qw = OST_Q30_ONE};
}

/*
 * Fills `points` with points on the part of a sphere below z = top * radius. The points represent equal
 * areas and are spaced by the golden angle. The centre of the sphere is the origin.
 */
static void sphere_points(double radius, double top)
{
    for (int i = 0; i < OST_SHELL_MAX; i++) {
        const double z = -1 + (top + 1) * (i + 0.5) / OST_SHELL_MAX, r = sqrt(1 - z * z), angle = i * 2.399963229728653;
        const double n[3] = {r * cos(angle), r * sin(angle), z};
        points[i].area = 2 * PI * radius * radius * (top + 1) / OST_SHELL_MAX;
        points[i].cutting = true;
        for (int a = 0; a < 3; a++) {
            points[i].at[a] = radius * n[a];
            points[i].inward[a] = -n[a];
        }
    }
}

/*
 * A sphere of radius R is pressed into the bone to a depth h. With stiffness k, the pressure at a point is k times the
 * depth of the point along its normal. The sum over the spherical cap is pi * k * R * h^2. The tool is surrounded by an
 * elastic layer of thickness L, so the radius of contact is R + L, but the areas are computed for the radius R. The
 * force is therefore multiplied by R^2 / (R + L)^2.
 */
static void sphere_pressed_into_a_plane(void **state)
{
    skip_without_samples(*state);
    enum { PLACES = 40 };
    ost_error err = {0};
    const double radius = 8e-3, layer = 2e-3, k = 1e7, top = (60 - 0.5) * 0.2e-3, deep = 1.6e-3;
    ost_bone *bone = half_space(*state, 100, 70, MM / 5, 60, REFERENCE_HU);
    sphere_points(radius, 1);
    ost_force_params params = ost_force_defaults();
    params.mode = OST_FORCE_INSTANT;
    params.scale = 1;
    params.stiffness = 1e6;
    params.layer = layer;
    params.layer_stiffness = k;
    ost_force *force = force_of(bone, &params, points, OST_SHELL_MAX);
    double sum = 0, across = 0;
    ost_force_result r;
    for (int i = 0; i < PLACES; i++) {
        /* In each round the tool has a different position relative to the voxels. */
        const double shift = 0.2 * i / PLACES;
        const ost_pose pose = at_mm(10 + 3 * shift, 10 + 7 * shift, (top + radius + layer - deep) * 1e3);
        assert_ok(ost_force_step(force, 0, &pose, 1e-3, &r, &err));
        assert_memory_equal(&r.tool, &pose, sizeof pose);
        sum += r.axial_n / PLACES;
        across += r.off_axis_n / PLACES;
    }
    assert_near("sphere in a plane, N", sum, PI * k * radius * radius / (radius + layer) * deep * deep, 0.04);
    assert_true(across < 0.15 * sum);
    const ost_pose away = at_mm(10, 10, (top + radius + layer) * 1e3 + 0.3);
    assert_ok(ost_force_step(force, 0, &away, 1e-3, &r, &err));
    assert_true(r.touching == 0 && r.axial_n == 0 && r.power_w == 0);
    ost_force_free(force);
    ost_bone_free(bone);
}

/* The sum of the stiffness of all points must never exceed the coupling's stiffness. */
static void stiffness_is_bounded(void **state)
{
    skip_without_samples(*state);
    ost_error err = {0};
    ost_bone *bone = half_space(*state, 60, 60, MM / 2, 50, REFERENCE_HU);
    sphere_points(5e-3, 1);
    ost_force_params params = ost_force_defaults();
    params.mode = OST_FORCE_INSTANT;
    params.layer_stiffness = 1e12;
    ost_force *force = force_of(bone, &params, points, OST_SHELL_MAX);
    ost_force_result a, b;
    const ost_pose first = at_mm(15, 15, 24.75 + 6), second = at_mm(15, 15, 24.75 + 5.5);
    assert_ok(ost_force_step(force, 0, &first, 1e-3, &a, &err));
    assert_ok(ost_force_step(force, 0, &second, 1e-3, &b, &err));
    assert_true(a.force_n[2] > 0.01 && b.force_n[2] > a.force_n[2]);
    assert_true(b.force_n[2] <= params.stiffness * 2 * params.layer);
    ost_force_free(force);
    ost_bone_free(bone);
}

static double speed_of(const ost_pose *before, const ost_force_result *after)
{
    return (double)(before->t.z - after->tool.t.z) * 1e-12 / 1e-3;
}

/*
 * A rotating disc of radius R is pressed into the bone at speed v. Let u be the cutting energy per volume, mu the ratio
 * of tangential to normal force, and w the angular speed. The pressure at radius r is p = u * v / (mu * w * r). Within
 * r0 = 1 mm the cutting speed at r0 is used, so the force is F = 2 * pi * u * v * (R - r0 / 2) / (mu * w). The power is
 * u * v times the area.
 */
static void planar_reaming(void **state)
{
    skip_without_samples(*state);
    enum { SPOKES = 32, RINGS = OST_SHELL_MAX / SPOKES };
    ost_error err = {0};
    const double radius = 10e-3, r0 = 1e-3;
    ost_bone *bone = half_space(*state, 60, 60, MM / 2, 50, REFERENCE_HU);
    for (int i = 0; i < RINGS * SPOKES; i++) {
        const int ring = i / SPOKES;
        const double lo = radius * ring / RINGS, hi = lo + radius / RINGS, r = (lo + hi) / 2,
                     angle = 2 * PI * (i % SPOKES) / SPOKES;
        points[i] = (ost_shell_point){.at = {r * cos(angle), r * sin(angle), 0},
                                      .inward = {0, 0, 1},
                                      .area = PI * (hi * hi - lo * lo) / SPOKES,
                                      .cutting = true};
    }
    const ost_force_params params = ost_force_defaults();
    const double u = ost_force_energy(&params, REFERENCE_HU);
    assert_near("energy of reference bone", u, 30e6, 1e-3);
    ost_force *force = force_of(bone, &params, points, OST_SHELL_MAX);
    /*
     * The tool starts on the surface. The device pulls the tool down by 5 mm. The force and the power must have the
     * values that the formulas give for the tool's speed.
     */
    const ost_pose start = at_mm(15, 15, 24.75), down = at_mm(15, 15, 24.75 - 5);
    ost_force_result r;
    assert_ok(ost_force_step(force, 0, &start, 1e-3, &r, &err));
    assert_int_equal(r.touching, OST_SHELL_MAX);
    const ost_pose before = r.tool;
    assert_ok(ost_force_step(force, 0, &down, 1e-3, &r, &err));
    const double v = speed_of(&before, &r);
    assert_true(v > 0 && v < 0.1);
    assert_near("planar reaming, N", r.axial_n,
                2 * PI * u * v * (radius - r0 / 2) / (params.cutting_ratio * params.speed), 0.01);
    assert_near("planar reaming, W", r.power_w, u * v * PI * radius * radius, 0.01);
    assert_near("planar reaming, N m", r.cutting_nm, u * v * PI * radius * radius / params.speed, 0.01);
    /* The scaled force acts on the hand. It points upward and has no lateral component. */
    assert_near("felt, N", r.force_n[2], params.scale * r.axial_n, 1e-3);
    assert_true(fabs(r.force_n[0]) < 1e-6 * r.axial_n && r.off_axis_n < 1e-6 * r.axial_n);

    /* With the same force, bone of half the density is cut four times as fast. */
    ost_bone *soft = half_space(*state, 60, 60, MM / 2, 50, (int16_t)lrint((0.975 - 0.131) / 1.067e-3));
    ost_force *easy = force_of(soft, &params, points, OST_SHELL_MAX);
    ost_force_result s;
    assert_ok(ost_force_step(easy, 0, &start, 1e-3, &s, &err));
    assert_ok(ost_force_step(easy, 0, &down, 1e-3, &s, &err));
    assert_near("speed over force in half the density", speed_of(&before, &s) / s.axial_n, 4 * v / r.axial_n, 0.01);
    ost_force_free(easy);
    ost_bone_free(soft);
    ost_force_free(force);
    ost_bone_free(bone);
}

/*
 * The force on a reaming hemisphere is F = (2 * pi * u * R * v / (mu * w)) * (I + R / r0 * (1 - cos^3 t0) / 3). Here
 * sin t0 = r0 / R, and I is the integral of cos^2 from t0 to pi/2.
 */
static void hemispherical_reaming(void **state)
{
    skip_without_samples(*state);
    ost_error err = {0};
    const double radius = 8e-3, r0 = 1e-3, t0 = asin(r0 / radius);
    ost_bone *bone = half_space(*state, 60, 60, MM / 2, 60, REFERENCE_HU);
    sphere_points(radius, 0);
    const ost_force_params params = ost_force_defaults();
    const double u = ost_force_energy(&params, REFERENCE_HU);
    ost_force *force = force_of(bone, &params, points, OST_SHELL_MAX);
    const ost_pose start = at_mm(15, 15, 15), down = at_mm(15, 15, 10);
    ost_force_result r;
    assert_ok(ost_force_step(force, 0, &start, 1e-3, &r, &err));
    const ost_pose before = r.tool;
    assert_ok(ost_force_step(force, 0, &down, 1e-3, &r, &err));
    const double v = speed_of(&before, &r);
    const double shape = PI / 4 - t0 / 2 - sin(2 * t0) / 4 + radius / r0 * (1 - pow(cos(t0), 3)) / 3;
    assert_near("hemispherical reaming, N", r.axial_n,
                2 * PI * u * radius * v / (params.cutting_ratio * params.speed) * shape, 0.02);
    assert_near("hemispherical reaming, W", r.power_w, u * v * PI * radius * radius, 0.02);
    ost_force_free(force);
    ost_bone_free(bone);
}

/* A tool that does not rotate or has no blade does not cut: it stops at the bone and slides along the surface. */
static void tool_that_does_not_cut_stops_and_slides(void **state)
{
    skip_without_samples(*state);
    ost_error err = {0};
    ost_bone *bone = half_space(*state, 60, 60, MM / 2, 40, 300);
    sphere_points(5e-3, 1);
    for (int blunt = 0; blunt < 2; blunt++) {
        ost_force_params params = ost_force_defaults();
        params.speed = blunt ? params.speed : 0;
        for (size_t i = 0; i < OST_SHELL_MAX; i++)
            points[i].cutting = !blunt;
        ost_force *force = force_of(bone, &params, points, OST_SHELL_MAX);
        ost_force_result r;
        const double surface_mm = 19.75 + 5;
        for (int i = 0; i < 400; i++) {
            /* The device moves down to 4 mm below the surface, then along x. */
            const ost_pose pose = at_mm(12 + (i < 200 ? 0 : 0.02 * (i - 200)), 15,
                                        surface_mm + 2 - (i < 200 ? 0.03 * i : 6));
            assert_ok(ost_force_step(force, 0, &pose, 1e-3, &r, &err));
            assert_true((double)r.tool.t.z * 1e-9 > surface_mm - 0.1);
        }
        assert_near("force at a depth of 4 mm, N", r.force_n[2],
                    params.stiffness * ((double)r.tool.t.z * 1e-12 - (surface_mm - 4) * 1e-3), 0.02);
        assert_true(r.force_n[2] > 0.9);
        /* The steps between voxels slow down a blunt tool, but by less than 40 %. */
        assert_near("sliding distance, mm", (double)r.tool.t.x * 1e-9 - 12, 0.02 * 199, 0.4);
        assert_true(r.power_w == 0);
        ost_force_free(force);
    }
    ost_bone_free(bone);
}

/* If a device passes through a plate of 1 mm within one tick, the tool must not pass through the plate. */
static void tool_does_not_pass_through_a_plate(void **state)
{
    skip_without_samples(*state);
    ost_error err = {0};
    ost_bone *bone = half_space(*state, 60, 60, MM / 2, 2, 300);
    sphere_points(5e-3, 1);
    ost_force_params params = ost_force_defaults();
    params.speed = 0;
    ost_force *force = force_of(bone, &params, points, OST_SHELL_MAX);
    ost_force_result r;
    for (int i = 0; i < 20; i++) {
        const ost_pose pose = at_mm(15, 15, 20 - 4.5 * i > -10 ? 20 - 4.5 * i : -10);
        assert_ok(ost_force_step(force, 0, &pose, 1e-3, &r, &err));
    }
    assert_true((double)r.tool.t.z * 1e-9 > 5);
    ost_force_free(force);
    ost_bone_free(bone);
}

/*
 * If all parameters are within their bounds, the contact force must not exceed what a hand can
 * exert, however far away the device is.
 */
static void contact_force_is_bounded(void **state)
{
    skip_without_samples(*state);
    ost_error err = {0};
    ost_bone *bone = half_space(*state, 60, 60, MM / 2, 50, REFERENCE_HU);
    sphere_points(4e-3, 1);
    for (int mode = 0; mode < 2; mode++)
        for (int kind = 0; kind < 4; kind++) {
            ost_force_params params = ost_force_defaults();
            params.mode = mode ? OST_FORCE_INSTANT : OST_FORCE_ENERGY;
            params.scale = kind == 1 ? 0.01 : params.scale;
            params.energy = kind == 2 ? 1e12 : params.energy;
            params.stiffness = kind == 3 ? 1e6 : params.stiffness;
            ost_force *force = force_of(bone, &params, points, OST_SHELL_MAX);
            ost_force_result r;
            double most = 0;
            for (int i = 0; i < 400; i++) {
                /* The device moves to 15 mm below the surface at 0.1 m/s. */
                const ost_pose pose = at_mm(15, 15, 30 - fmin(i * 0.1, 20));
                assert_ok(ost_force_step(force, 0, &pose, 1e-3, &r, &err));
                most = fmax(most, sqrt(r.axial_n * r.axial_n + r.off_axis_n * r.off_axis_n));
            }
            print_message("mode %d, parameters %d: contact force at most %.1f N\n", mode, kind, most);
            assert_true(most > 0 && most < 400);
            ost_force_free(force);
        }
    ost_bone_free(bone);
}

/* The shell of a voxelized ball has the ball's area, volume and normals. */
static void shell_equals_the_surface_of_a_ball(void **state)
{
    (void)state;
    ost_error err = {0};
    for (int n = 24; n <= (test_rounds(3) == 3 ? 96 : 24); n *= 2) {
        const double s = 16e-3 / n, radius = 7e-3;
        ost_tool_volume tool;
        ost_shell shell;
        assert_ok(ost_tool_volume_init(&tool, &(ost_tool_geometry){{n, n, n}, 16 * MM / n, {-8 * MM, -8 * MM, -8 * MM}},
                                       &err));
        for (int z = 0, i = 0; z < n; z++)
            for (int y = 0; y < n; y++)
                for (int x = 0; x < n; x++, i++) {
                    const double c[3] = {(x + 0.5) * s - 8e-3, (y + 0.5) * s - 8e-3, (z + 0.5) * s - 8e-3};
                    if (c[0] * c[0] + c[1] * c[1] + c[2] * c[2] < radius * radius)
                        tool.voxels[i] = z < n / 2 ? OST_TOOL_CUTTING : OST_TOOL_NONCUTTING;
                }
        assert_ok(ost_shell_make(&tool, &shell, &err));
        assert_true(shell.count > 100 && shell.count <= OST_SHELL_MAX);
        double area = 0, volume = 0, sum[3] = {0}, cutting = 0;
        for (size_t i = 0; i < shell.count; i++) {
            const ost_shell_point *p = &shell.points[i];
            const double r = sqrt(p->at[0] * p->at[0] + p->at[1] * p->at[1] + p->at[2] * p->at[2]);
            double along = 0;
            for (int a = 0; a < 3; a++) {
                along -= p->at[a] * p->inward[a];
                sum[a] += p->area * p->inward[a];
            }
            area += p->area;
            volume += p->area * along / 3;
            cutting += p->cutting ? p->area : 0;
            assert_true(fabs(r - radius) < s + 0.05 * radius && along / r > 0.95);
        }
        assert_near("area, m2", area, 4 * PI * radius * radius, 0.06);
        assert_near("volume, m3", volume, 4 * PI / 3 * radius * radius * radius, 0.08);
        assert_near("half of it cuts", cutting, area / 2, 0.1);
        for (int a = 0; a < 3; a++)
            assert_true(fabs(sum[a]) < 0.01 * area);
        ost_shell_free(&shell);
        ost_tool_volume_free(&tool);
    }
    ost_tool_volume empty;
    ost_shell none;
    assert_ok(ost_tool_volume_init(&empty, &(ost_tool_geometry){{8, 8, 8}, MM, {0, 0, 0}}, &err));
    assert_int_equal(ost_shell_make(&empty, &none, &err), OST_ERR_INPUT);
    ost_tool_volume_free(&empty);
}

static void invalid_parameters_are_refused(void **state)
{
    skip_without_samples(*state);
    ost_error err = {0};
    ost_force *force;
    ost_bone *bone = half_space(*state, 16, 16, MM, 8, 300);
    ost_force_params p = ost_force_defaults();
    p.scale = NAN;
    assert_int_equal(ost_force_create(bone, &p, &force, &err), OST_ERR_RANGE);
    assert_non_null(strstr(err.text, "scale"));
    assert_int_equal(ost_force_create(NULL, NULL, &force, &err), OST_ERR_USAGE);
    assert_ok(ost_force_create(bone, NULL, &force, &err));
    ost_force_result r;
    const ost_pose pose = at_mm(0, 0, 0);
    assert_int_equal(ost_force_step(force, 0, &pose, 1e-3, &r, &err), OST_ERR_USAGE);
    ost_force_free(force);
    ost_bone_free(bone);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sphere_pressed_into_a_plane),
        cmocka_unit_test(stiffness_is_bounded),
        cmocka_unit_test(planar_reaming),
        cmocka_unit_test(hemispherical_reaming),
        cmocka_unit_test(tool_that_does_not_cut_stops_and_slides),
        cmocka_unit_test(tool_does_not_pass_through_a_plate),
        cmocka_unit_test(contact_force_is_bounded),
        cmocka_unit_test(shell_equals_the_surface_of_a_ball),
        cmocka_unit_test(invalid_parameters_are_refused),
    };
    return run_on_backends(tests, open_test_backend, close_test_backend);
}
