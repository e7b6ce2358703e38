/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests the metrics of a bone with known cuts. The bone is a block with a flat face. A sphere is reamed into the face
 * along a tilted axis, and a hole is drilled along another axis. The input includes the poses of the tools. Further
 * tests compare the results for landmarks and a rim with closed forms.
 *
 * Covers: REQ-METRICS
 */
#include "near.h"

/*
 * The bone belongs to a right shoulder. The inward direction is +x. The face is the plane x = 0. The block is 40 mm
 * deep, 46 mm from front to back, and 50 mm high, which is the height of the grid.
 */
typedef struct cuts {
    /*
     * Radius and depth of the reamed sphere. The depth is measured along the sphere's axis
     * through the face's centre.
     */
    double radius, depth;
    double back_deg, up_deg;    /* tilts of the sphere's outward axis, toward the back (+y) and toward the head (+z) */
    double entry_y, entry_z;    /* position where the sphere's axis passes through the face */
    double hole_radius, hole_depth, hole_y, hole_up_deg;
    double planned;             /* planned depth; 0 means that it equals the depth of the cut */
} cuts;

enum { NX = 88, N = 100 };

static void make(const cuts *c, ost_volume *before, ost_volume *after)
{
    ost_error err = {0};
    const ost_geometry g = {
        {NX, N, N}, {MM / 2, MM / 2, MM / 2}, {-4 * MM + MM / 4, -25 * MM + MM / 4, -25 * MM + MM / 4}};
    assert_ok(ost_volume_init(before, &g, &err));
    assert_ok(ost_volume_init(after, &g, &err));
    const double outward[3] = {-1, tan(c->back_deg * PI / 180), tan(c->up_deg * PI / 180)};
    const double size = sqrt(outward[0] * outward[0] + outward[1] * outward[1] + outward[2] * outward[2]);
    double centre[3];
    for (int a = 0; a < 3; a++)
        centre[a] = outward[a] / size * (c->radius - c->depth);
    centre[1] += c->entry_y;
    centre[2] += c->entry_z;
    for (int z = 0, i = 0; z < N; z++)
        for (int y = 0; y < N; y++)
            for (int x = 0; x < NX; x++, i++) {
                const double p[3] = {-3.75 + 0.5 * x, -24.75 + 0.5 * y, -24.75 + 0.5 * z};
                const double d[3] = {p[0] - centre[0], p[1] - centre[1], p[2] - centre[2]};
                /* Below the face there are 2 mm of cartilage, 2 mm of plate, and then cancellous bone. */
                before->voxels[i] = p[0] < 0 || fabs(p[1]) > 23 ? 0 : p[0] < 2 ? 130 : p[0] < 4 ? 900 : 300;
                const double across[2] = {p[1] - c->hole_y, p[2] + p[0] * tan(c->hole_up_deg * PI / 180)};
                const bool reamed = d[0] * d[0] + d[1] * d[1] + d[2] * d[2] < c->radius * c->radius;
                const bool drilled = p[0] < c->hole_depth &&
                                     across[0] * across[0] + across[1] * across[1] < c->hole_radius * c->hole_radius;
                after->voxels[i] = reamed || drilled ? 0 : before->voxels[i];
            }
}

/*
 * The tools' poses. The reamer and the drill each enter along their own axis by 0.1 mm per tick
 * and return without cutting.
 */
enum { REAMER, DRILL, TICKS_MAX = 1000 };
static const ost_metrics_tool tools[] = {{.kind = OST_METRICS_REAMER, .radius_mm = 18, .length_mm = 20},
                                         {.kind = OST_METRICS_DRILL, .radius_mm = 3, .length_mm = 30}};

static ost_metrics_motion motion_of(const cuts *c)
{
    static ost_motion ticks[TICKS_MAX];
    const double back = tan(c->back_deg * PI / 180), up = tan(c->up_deg * PI / 180),
                 size = sqrt(1 + back * back + up * up);
    const double axis[2][3] = {{1 / size, -back / size, -up / size},
                               {cos(c->hole_up_deg * PI / 180), 0, -sin(c->hole_up_deg * PI / 180)}};
    const double entry[2][2] = {{c->entry_y, c->entry_z}, {c->hole_y, 0}};
    /* The drill's tip reaches the depth of the hole along x. The reamer's tip moves along the reamer's axis by the
       depth of the cut. */
    const double deep[2] = {c->depth, c->hole_depth / axis[DRILL][0]};
    size_t count = 0;
    for (int tool = 0; tool < 2; tool++)
        for (int k = 0; k <= 2 * (int)lrint(deep[tool] * 10); k++) {
            const int in = (int)lrint(deep[tool] * 10);
            const double far = k < in ? k * 0.1 : deep[tool] - (k - in) * 0.1;
            ticks[count] = (ost_motion){
                .t_s = (double)count * 1e-3, .tool = tool, .removed = k <= in && deep[tool] > 0 ? 5u : 0u};
            for (int a = 0; a < 3; a++) {
                ticks[count].axis[a] = axis[tool][a];
                ticks[count].mm[a] = far * axis[tool][a] + (a ? entry[tool][a - 1] : 0);
            }
            count++;
        }
    return (ost_metrics_motion){tools, 2, ticks, count};
}

static ost_metrics measure(const cuts *c, ost_status expected)
{
    static ost_metrics m;
    ost_error err = {0};
    ost_volume before, after;
    const ost_density_classes classes = ost_density_classes_default();
    const ost_metrics_plan plan = {
        .at = {0, 0, 0}, .axis = {2, 0, 0}, .depth_mm = c->planned > 0 ? c->planned : c->depth};
    const ost_metrics_motion motion = motion_of(c);
    make(c, &before, &after);
    assert_int_equal(ost_metrics_make(&before, &after, 120, &classes, &plan, &motion, &m, &err), expected);
    ost_volume_free(&before);
    ost_volume_free(&after);
    return m;
}

/* Tests a spherical cap below a plane. Its volume is pi h^2 (R - h / 3), and its mean depth is nearly half of its
   maximum depth. */
static void straight_cut(void **state)
{
    (void)state;
    const cuts c = {.radius = 27, .depth = 3, .hole_radius = 3, .hole_depth = 22};
    const ost_metrics m = measure(&c, OST_OK);
    const double cap = PI * 9 * (27 - 1), hole_beyond = PI * 9 * 19, rim = 2 * 27 * 3 - 9.0;
    NEAR(m.removed_mm3, cap + hole_beyond, 0.03 * (cap + hole_beyond));
    NEAR(m.floor_mm2, PI * rim - PI * 9, 0.1 * PI * rim); /* cuts shallower than half a voxel are not measured */
    NEAR(m.sphere_mm, 27, 1);
    NEAR(m.centre_depth_mm, 3, 0.25);
    /* the hole and the cells adjacent to the hole are excluded */
    NEAR(m.depth_max_mm, 3 - 3.75 * 3.75 / (2 * 27), 0.3);
    NEAR(m.depth_mean_mm, (cap - PI * 9 * 3) / (PI * rim - PI * 9), 0.2);
    assert_true(m.reamed);
    NEAR(m.tilt_deg, 0, 1e-6);
    NEAR(m.entry_mm, 0, 1e-6);
    NEAR(m.reach_mm, 3, 1e-6);
    assert_true(m.fit_rms_mm < 0.3 && m.contact_percent > 95);
    NEAR(m.over_mm3, 0, 0.3);
    assert_true(m.hole && !m.hole_breach);
    NEAR(m.hole_depth_mm, 22, 1e-6);
    NEAR(m.hole_diameter_mm, 6, 0.2);
    NEAR(m.hole_angle_deg, 0, 1e-6);
    NEAR(m.hole_entry_mm, 0, 1e-6);
    NEAR(m.hole_wall_mm, 6, 0.01);
    /* The plate lies at depths of 2 to 4 mm. The cap removed the part of the plate that is between 2 and 3 mm deep. */
    const double taken = PI * 1 * (27 - 1.0 / 3);
    NEAR(m.plate_mm3, 2 * (PI * rim - PI * 9), 0.15 * 2 * PI * rim);
    NEAR(m.plate_kept_percent, 100 * (1 - taken / (2 * PI * rim)), 4);
    NEAR(m.removed_by_class_mm3[0] + m.removed_by_class_mm3[1] + m.removed_by_class_mm3[2], m.removed_mm3, 1e-6);
    assert_true(m.removed_by_class_mm3[0] > m.removed_by_class_mm3[2] && m.removed_by_class_mm3[1] > 0);
}

/* The measured tilt and the measured entry position must be those of the cut. A displacement must not affect the
   measured tilt, and a tilt must not affect the measured position. */
static void tilted_and_displaced_cuts(void **state)
{
    (void)state;
    static const struct {
        double back, up, y, z;
    } tilts[] = {{8, 0, 0, 0}, {-6, 0, 0, 0},   {0, 7, 0, 0}, {5, -5, 0, 0},
                 {0, 0, 3, 0}, {0, 0, -1.5, 2}, {4, 3, 2, -2}};
    for (size_t i = 0; i < sizeof tilts / sizeof tilts[0]; i++) {
        const cuts c = {.radius = 27,
                        .depth = 3,
                        .back_deg = tilts[i].back,
                        .up_deg = tilts[i].up,
                        .entry_y = tilts[i].y,
                        .entry_z = tilts[i].z};
        const ost_metrics m = measure(&c, OST_OK);
        const double b = tan(tilts[i].back * PI / 180), u = tan(tilts[i].up * PI / 180);
        NEAR(m.version_error_deg, tilts[i].back, 0.1);
        NEAR(m.inclination_error_deg, tilts[i].up, 0.1);
        NEAR(m.version_deg - m.version_planned_deg, tilts[i].back, 0.1);
        NEAR(m.tilt_deg, atan(sqrt(b * b + u * u)) * 180 / PI, 0.1);
        NEAR(m.entry_mm, sqrt(tilts[i].y * tilts[i].y + tilts[i].z * tilts[i].z), 0.1);
        assert_false(m.hole);
    }
}

static void hole_at_an_angle(void **state)
{
    (void)state;
    const cuts c = {.radius = 27, .depth = 3, .hole_radius = 3, .hole_depth = 20, .hole_y = 4, .hole_up_deg = 10};
    const ost_metrics m = measure(&c, OST_OK);
    NEAR(m.hole_angle_deg, 10, 0.1);
    NEAR(m.hole_entry_mm, 4, 0.1);
    NEAR(m.hole_depth_mm, 20, 0.01);
    assert_false(m.hole_breach);
    /* In the first case, the hole is near the side of the block. In the second case, it breaks through the side. */
    const cuts near_side = {.radius = 27, .depth = 3, .hole_radius = 3, .hole_depth = 20, .hole_y = 18};
    NEAR(measure(&near_side, OST_OK).hole_wall_mm, 2, 0.75);
    const cuts through = {.radius = 27, .depth = 3, .hole_radius = 3, .hole_depth = 20, .hole_y = 21};
    assert_true(measure(&through, OST_OK).hole_breach);
}

static void over_reaming(void **state)
{
    (void)state;
    const cuts deep = {.radius = 27, .depth = 5.5};
    ost_error err = {0};
    static ost_metrics m;
    ost_volume before, after;
    const ost_density_classes classes = ost_density_classes_default();
    const ost_metrics_plan plan = {.axis = {1, 0, 0}, .depth_mm = 3};
    make(&deep, &before, &after);
    assert_ok(ost_metrics_make(&before, &after, 120, &classes, &plan, NULL, &m, &err));
    NEAR(m.over_max_mm, 2.5, 0.3);
    NEAR(m.over_percent, 100 * (2 * 27 * 1.5 - 1.5 * 1.5) / (2 * 27 * 5.5 - 5.5 * 5.5), 4);
    /* The part of the cap that is deeper than the planned depth plus the margin is a cap of height 1.5 mm. */
    NEAR(m.over_mm3, PI * 1.5 * 1.5 * (27 - 0.5), 0.12 * PI * 1.5 * 1.5 * 26.5);
    NEAR(m.centre_depth_mm, 5.5, 0.25);
    assert_int_equal(ost_metrics_make(&before, &before, 120, &classes, &plan, NULL, &m, &err), OST_ERR_INPUT);
    ost_volume_free(&before);
    ost_volume_free(&after);
}

/*
 * Over-reaming must grow with the depth. The sum of the planned depth and the margin is 4 mm, so the
 * over-reaming of a cut of depth d is a cap of height h = d - 4 mm, whose volume is pi h^2 (R - h / 3). The cap
 * must not count as a hole at any depth, and a drilled hole must not increase the over-reaming.
 */
static void over_reaming_grows_with_depth(void **state)
{
    (void)state;
    double last = 0;
    for (int depth = 4; depth <= 14; depth += 2)
        for (int drilled = 0; drilled < 2; drilled++) {
            const cuts c = {.radius = 27,
                            .depth = depth,
                            .planned = 3,
                            .hole_radius = drilled ? 3 : 0,
                            .hole_depth = drilled ? 22 : 0};
            const ost_metrics m = measure(&c, OST_OK);
            const double h = depth - 4, cap = PI * h * h * (27 - h / 3);
            /* The drill follows the reamer. The part of the over-reaming cap that lies in the drill's cylinder is not
               counted. */
            const double hole = drilled ? PI * 9 * h : 0;
            NEAR(m.over_mm3, cap - hole, 0.04 * cap + 5 + (drilled ? 0.2 * hole : 0));
            NEAR(m.over_max_mm, drilled ? fmax(0, m.over_max_mm) : depth - 3, 0.3);
            NEAR(m.reach_mm, depth, 1e-6);
            assert_int_equal(m.hole, drilled);
            if (!drilled) {
                assert_true(m.over_mm3 >= last);
                last = m.over_mm3;
            }
        }
}

/*
 * The landmarks are placed so that the scapula's lateral axis is rotated by a given angle relative to the plan's
 * axis. The version or the inclination of the plan's axis must equal this angle.
 */
static void angles_in_scapula_frame(void **state)
{
    (void)state;
    const double turn = 5 * PI / 180, c = 100 * cos(turn), s = 100 * sin(turn);
    const cuts cut = {.radius = 27, .depth = 3, .back_deg = 8, .up_deg = -4};
    ost_error err = {0};
    static ost_metrics m;
    ost_volume before, after;
    const ost_density_classes classes = ost_density_classes_default();
    const ost_metrics_motion motion = motion_of(&cut);
    make(&cut, &before, &after);
    ost_metrics_plan plan = {.axis = {1, 0, 0}, .depth_mm = 3};
    assert_ok(ost_metrics_make(&before, &after, 120, &classes, &plan, &motion, &m, &err));
    assert_false(m.scapular);
    plan.landmarks = true;
    plan.trigonum = (ost_pm3){(ost_pm)(c * MM), (ost_pm)(s * MM), 0};
    plan.inferior = (ost_pm3){(ost_pm)(0.8 * c * MM), (ost_pm)(0.8 * s * MM), -110 * MM};
    assert_ok(ost_metrics_make(&before, &after, 120, &classes, &plan, &motion, &m, &err));
    assert_true(m.scapular);
    NEAR(m.version_planned_deg, 5, 1e-6);
    NEAR(m.inclination_planned_deg, 0, 1e-6);
    NEAR(m.version_deg, 13, 0.1);
    NEAR(m.inclination_deg, -4, 0.1);
    NEAR(m.version_error_deg, 8, 0.1);
    NEAR(m.inclination_error_deg, -4, 0.1);
    plan.trigonum = (ost_pm3){(ost_pm)(c * MM), 0, (ost_pm)(s * MM)};
    plan.inferior = (ost_pm3){(ost_pm)(c * MM) - 20 * MM, 0, -110 * MM};
    assert_ok(ost_metrics_make(&before, &after, 120, &classes, &plan, &motion, &m, &err));
    NEAR(m.version_planned_deg, 0, 1e-6);
    NEAR(m.inclination_planned_deg, 5, 1e-6);
    NEAR(m.version_deg, 8, 0.1);
    NEAR(m.inclination_deg, 1, 0.1);
    /* In a left shoulder, the medial direction is -x; the posterior direction is unchanged. */
    plan = (ost_metrics_plan){.axis = {-1, 0, 0},
                              .left = true,
                              .depth_mm = 3,
                              .landmarks = true,
                              .trigonum = {(ost_pm)(-c * MM), (ost_pm)(s * MM), 0},
                              .inferior = {(ost_pm)(-c * MM), (ost_pm)(s * MM), -110 * MM}};
    assert_ok(ost_metrics_make(&before, &after, 120, &classes, &plan, &motion, &m, &err));
    NEAR(m.version_planned_deg, 5, 1e-6);
    /* Collinear landmarks define no frame. */
    plan.inferior = (ost_pm3){2 * plan.trigonum.x, 2 * plan.trigonum.y, 0};
    assert_ok(ost_metrics_make(&before, &after, 120, &classes, &plan, &motion, &m, &err));
    assert_false(m.scapular);
    ost_volume_free(&before);
    ost_volume_free(&after);
}

/*
 * Tests a tapering stump with an oval face of 26 x 34 mm. The half axes of its cross-section decrease by
 * 0.4 mm per millimetre of depth. A sphere whose centre is not on the stump's axis cuts into the stump.
 */
static void rim_of_oval_face(void **state)
{
    (void)state;
    enum { SIZE = 96 };
    const double a = 13, b = 17, taper = 0.4, radius = 27, depth = 3, off_y = 5;
    ost_error err = {0};
    static ost_metrics m;
    ost_volume before, after;
    const ost_density_classes classes = ost_density_classes_default();
    const ost_geometry g = {
        {40, SIZE, SIZE}, {MM / 2, MM / 2, MM / 2}, {-4 * MM + MM / 4, -24 * MM + MM / 4, -24 * MM + MM / 4}};
    assert_ok(ost_volume_init(&before, &g, &err));
    assert_ok(ost_volume_init(&after, &g, &err));
    for (int z = 0, i = 0; z < SIZE; z++)
        for (int y = 0; y < SIZE; y++)
            for (int x = 0; x < 40; x++, i++) {
                const double p[3] = {-3.75 + 0.5 * x, -23.75 + 0.5 * y, -23.75 + 0.5 * z},
                             u = p[1] / (a - taper * p[0]), v = p[2] / (b - taper * p[0]);
                const double d[3] = {p[0] + radius - depth, p[1] - off_y, p[2]};
                before.voxels[i] = p[0] >= 0 && u * u + v * v <= 1 ? 500 : 0;
                after.voxels[i] = d[0] * d[0] + d[1] * d[1] + d[2] * d[2] < radius * radius ? 0 : before.voxels[i];
            }
    const ost_metrics_plan plan = {.axis = {1, 0, 0}, .depth_mm = depth};
    assert_ok(ost_metrics_make(&before, &after, 120, &classes, &plan, NULL, &m, &err));
    /*
     * Computes for each direction, by fixed-point iteration, the position where the stump's side
     * and the sphere meet.
     */
    int lowered = 0;
    double most = 0, side[2] = {0, 0};
    for (int k = 0; k < 7200; k++) {
        const double y = cos(k * PI / 3600), z = sin(k * PI / 3600);
        double down = 0, r = 0;
        for (int i = 0; i < 50; i++) {
            const double p = a - taper * down, q = b - taper * down;
            r = 1 / sqrt(y * y / (p * p) + z * z / (q * q));
            down = fmax(0,
                        sqrt(radius * radius - (r * y - off_y) * (r * y - off_y) - r * z * r * z) - (radius - depth));
        }
        lowered += down > 1;
        most = fmax(most, down);
        if (k % 3600 == 0)
            side[k / 3600] = r;
    }
    NEAR(m.rim_seen_percent, 100, 0.1);
    NEAR(m.rim_lowered_percent, 100 * lowered / 7200.0, 5);
    NEAR(m.rim_lowered_mm, most, 0.5);
    NEAR(m.width_before_mm, 2 * a, 0.75);
    NEAR(m.height_before_mm, 2 * b, 0.75);
    NEAR(m.width_after_mm, side[0] + side[1], 0.75);
    /* Nothing was cut near the rim, so the rim is not lowered. */
    ost_volume_free(&after);
    assert_ok(ost_volume_init(&after, &g, &err));
    for (int i = 0; i < 40 * SIZE * SIZE; i++) {
        const int y = i / 40 % SIZE - SIZE / 2, z = i / 40 / SIZE - SIZE / 2;
        after.voxels[i] = y * y + z * z < 100 && i % 40 < 10 ? 0 : before.voxels[i];
    }
    assert_ok(ost_metrics_make(&before, &after, 120, &classes, &plan, NULL, &m, &err));
    NEAR(m.rim_lowered_percent, 0, 1e-9);
    NEAR(m.width_after_mm, m.width_before_mm, 1e-9);
    ost_volume_free(&before);
    ost_volume_free(&after);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(straight_cut),
        cmocka_unit_test(tilted_and_displaced_cuts),
        cmocka_unit_test(hole_at_an_angle),
        cmocka_unit_test(over_reaming),
        cmocka_unit_test(over_reaming_grows_with_depth),
        cmocka_unit_test(angles_in_scapula_frame),
        cmocka_unit_test(rim_of_oval_face),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
