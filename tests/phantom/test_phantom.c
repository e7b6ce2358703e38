/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests generated bones: names, options, seeds, sides, and the data in their headers. The grids
 * are coarse; the other files of this folder test the bones at full size.
 *
 * Covers: REQ-PHANTOM, AR-GRID-1
 */
#include <math.h>

#include "phantom_checks.h"

#include "phantom/scapula.h"

#define MM OST_PM_PER_MM

static ost_volume make(ost_phantom_kind kind, ost_phantom_options options)
{
    ost_error err = {0};
    ost_volume v;
    assert_ok(ost_phantom_make(kind, &options, &v, &err));
    return v;
}

static void test_names(void **state)
{
    (void)state;
    assert_string_equal(ost_phantom_name(OST_PHANTOM_SCAPULA), "scapula");
    assert_string_equal(ost_phantom_name(OST_PHANTOM_GLENOID), "glenoid");
    assert_string_equal(ost_phantom_name(OST_PHANTOM_TRABECULAR), "trabecular");
    assert_string_equal(ost_phantom_name(OST_PHANTOM_TRABECULAR2), "trabecular2");
    assert_string_equal(ost_phantom_name(OST_PHANTOM_FOAM), "foam");
    assert_string_equal(ost_phantom_name(OST_PHANTOM_SHOULDER), "shoulder");
    assert_string_equal(ost_phantom_name(OST_PHANTOM_COUNT), "unknown");
}

/* Expected sizes of the scapula: 256 * 0.47 = 120.32 mm, 234 * 0.47 = 109.98 mm, and 201 mm. Expected sizes of a
   core: 314, 316 and 360 voxels of 0.032 mm, which are 10.048, 10.112 and 11.52 mm. */
static void test_dims_follow_spacing_and_scale(void **state)
{
    (void)state;
    ost_volume v = make(OST_PHANTOM_SCAPULA, (ost_phantom_options){.spacing = {2 * MM, 3 * MM, 4 * MM}});
    assert_int_equal(v.geometry.dims.x, 61);
    assert_int_equal(v.geometry.dims.y, 37);
    assert_int_equal(v.geometry.dims.z, 51);
    assert_int_equal(v.geometry.spacing.y, 3 * MM);
    ost_volume_free(&v);

    v = make(OST_PHANTOM_SCAPULA, (ost_phantom_options){.spacing = {2 * MM, 3 * MM, 4 * MM}, .scale = 0.5});
    assert_int_equal(v.geometry.dims.x, 31);
    assert_int_equal(v.geometry.dims.y, 19);
    assert_int_equal(v.geometry.dims.z, 26);
    ost_volume_free(&v);

    v = make(OST_PHANTOM_TRABECULAR2, (ost_phantom_options){.spacing = {MM / 5, MM / 5, MM / 5}});
    assert_int_equal(v.geometry.dims.x, 51);
    assert_int_equal(v.geometry.dims.y, 51);
    assert_int_equal(v.geometry.dims.z, 58);
    ost_volume_free(&v);
}

static void test_seed_determines_grid(void **state)
{
    (void)state;
    for (int kind = 0; kind < OST_PHANTOM_COUNT; kind++) {
        bool core = kind >= OST_PHANTOM_TRABECULAR && kind <= OST_PHANTOM_FOAM;
        ost_phantom_options o = {.spacing = core ? (ost_pm3){MM / 5, MM / 5, MM / 5}
                                                 : (ost_pm3){3 * MM, 3 * MM, 3 * MM}};
        ost_volume a = make((ost_phantom_kind)kind, o);
        o.seed = 1; /* seed 0 selects the default, which is seed 1 */
        ost_volume b = make((ost_phantom_kind)kind, o);
        o.seed = 2;
        ost_volume c = make((ost_phantom_kind)kind, o);
        ost_digest da = digest_of(&a), db = digest_of(&b), dc = digest_of(&c);
        assert_true(ost_digest_equal(&da, &db));
        assert_false(ost_digest_equal(&da, &dc));
        assert_string_equal(ost_meta_get(&a.meta, "seed"), "1");
        assert_string_equal(ost_meta_get(&c.meta, "seed"), "2");
        assert_string_equal(ost_meta_get(&a.meta, OST_META_KIND), "ct");
        ost_volume_free(&a);
        ost_volume_free(&b);
        ost_volume_free(&c);
    }
}

static void test_left_is_mirror_of_right(void **state)
{
    (void)state;
    ost_phantom_options o = {.spacing = {2 * MM, 2 * MM, 3 * MM}, .seed = 7};
    ost_volume right = make(OST_PHANTOM_SCAPULA, o);
    o.left = true;
    ost_volume left = make(OST_PHANTOM_SCAPULA, o);
    ost_dims d = right.geometry.dims;
    for (int64_t row = 0; row < (int64_t)d.y * d.z; row++)
        for (int i = 0; i < d.x; i++)
            assert_int_equal(left.voxels[row * d.x + i], right.voxels[row * d.x + d.x - 1 - i]);
    /* The grids are mirrored at x = 0: the first voxel of the left bone is the mirror image of the last voxel of the
       right bone. */
    assert_int_equal(left.geometry.origin.x, -(right.geometry.origin.x + (d.x - 1) * right.geometry.spacing.x));
    assert_int_equal(left.geometry.origin.y, right.geometry.origin.y);
    double at[2][3], axis[2][3];
    read_vector(&right, OST_META_GLENOID_AT, at[0]);
    read_vector(&left, OST_META_GLENOID_AT, at[1]);
    read_vector(&right, OST_META_GLENOID_AXIS, axis[0]);
    read_vector(&left, OST_META_GLENOID_AXIS, axis[1]);
    assert_true(at[0][0] == -at[1][0] && at[0][1] == at[1][1] && at[0][2] == at[1][2]);
    assert_true(axis[0][0] == -axis[1][0] && axis[0][1] == axis[1][1] && axis[0][2] == axis[1][2]);
    assert_string_equal(ost_meta_get(&right.meta, OST_META_SIDE), "right");
    assert_string_equal(ost_meta_get(&left.meta, OST_META_SIDE), "left");
    ost_volume_free(&left);
    ost_volume_free(&right);
}

/*
 * In LPS+ a right glenoid lies at negative x. The glenoid faces the patient's right and slightly forward,
 * so its inward axis points to +x and +y.
 */
static void test_glenoid_faces_outward(void **state)
{
    (void)state;
    for (uint64_t seed = 1; seed <= 3; seed++) {
        ost_volume v = make(OST_PHANTOM_SCAPULA, (ost_phantom_options){.spacing = {MM, MM, 2 * MM}, .seed = seed});
        double at[3], axis[3], p[3];
        read_vector(&v, OST_META_GLENOID_AT, at);
        read_vector(&v, OST_META_GLENOID_AXIS, axis);
        double length2 = axis[0] * axis[0] + axis[1] * axis[1] + axis[2] * axis[2];
        assert_true(length2 > 0.999 && length2 < 1.001);
        assert_true(at[0] < -100 && axis[0] > 0.7 && axis[1] > 0.2);
        for (int side = -1; side <= 1; side += 2) {
            for (int a = 0; a < 3; a++)
                p[a] = at[a] + side * 5 * axis[a];
            assert_true((density_at(&v, p) >= ACTIVE_HU) == (side > 0));
        }
        ost_volume_free(&v);
    }
}

/* For every seed the bone must be one connected piece that does not touch the sides of the box. */
static void test_bone_is_connected_for_all_seeds(void **state)
{
    (void)state;
    test_rng rng = rng_seeded("whole bone");
    for (int n = 0; n < 3; n++) {
        uint64_t seed = (uint64_t)rng_range(&rng, 1, INT64_MAX);
        ost_volume v = make(OST_PHANTOM_SCAPULA,
                            (ost_phantom_options){.spacing = {5 * MM / 4, 5 * MM / 4, 5 * MM / 4}, .seed = seed});
        int64_t greatest, all;
        count_connected(&v, &greatest, &all);
        assert_int_equal(greatest, all);
        ost_dims d = v.geometry.dims;
        for (int k = 0; k < d.z; k++)
            for (int j = 0; j < d.y; j++)
                for (int i = 0; i < d.x; i++)
                    if (i == 0 || j == 0 || k == 0 || i == d.x - 1 || j == d.y - 1 || k == d.z - 1)
                        assert_true(v.voxels[i + (int64_t)d.x * (j + (int64_t)d.y * k)] < ACTIVE_HU);
        ost_volume_free(&v);
    }
}

/*
 * A block is skipped if its centre is far enough from the bone (ct.c). Skipping is correct only if
 * a computed distance is at most 1.5 times the true distance.
 */
static void test_error_of_distances(void **state)
{
    (void)state;
    ost_error err = {0};
    test_rng rng = rng_seeded("distances");
    ost_scapula s;
    assert_ok(ost_scapula_init(&s, (uint64_t)rng_range(&rng, 1, INT64_MAX), &err));
    for (int n = 0; n < 100000; n++) {
        ost_v3 p = {(double)rng_range(&rng, -20000, 130000) / 1000, (double)rng_range(&rng, -65000, 45000) / 1000,
                    (double)rng_range(&rng, -130000, 55000) / 1000};
        ost_v3 d = {(double)rng_range(&rng, -1000, 1000), (double)rng_range(&rng, -1000, 1000),
                    (double)rng_range(&rng, 1, 1000)};
        ost_scapula_sample a, b;
        ost_scapula_part part;
        ost_scapula_near(&s, p, 3.001, &part);
        ost_scapula_at(&part, p, &a);
        ost_scapula_at(&part, ost_v3_mad(p, d, 3 / ost_v3_length(d)), &b);
        if (a.bone > 4 && b.bone < 4)
            assert_true(a.bone - b.bone < 1.5 * 3 * s.size);
        if (a.cartilage > 8)
            assert_true(b.cartilage > 1);
    }
    ost_scapula_free(&s);
}

static double thousandths(test_rng *rng, int lo, int hi)
{
    return (double)rng_range(rng, lo, hi) / 1000;
}

/*
 * ost_bar_near selects segments of a bar for a ball. Within the ball, the distance from the selected segments must be
 * bit-identical to the distance from all segments. The tested bars are up to 40 times as wide as thick. For such a bar,
 * ost_bar_distance sometimes skips the nearest segment and returns a greater distance; ost_bar_blend must use the same
 * distance.
 */
static void test_selected_segments_give_exact_distance(void **state)
{
    (void)state;
    test_rng rng = rng_seeded("parts of bars");
    int fewer = 0, unchanged = 0;
    for (int round = 0; round < 40; round++) {
        ost_bar bar;
        ost_bar_node nodes[7];
        const double flat = round % 2 ? 40 : 2;
        for (int i = 0; i < 7; i++) {
            nodes[i].at = (ost_v3){12 * i, thousandths(&rng, -9000, 9000), thousandths(&rng, -9000, 9000)};
            nodes[i].wide = thousandths(&rng, 4000, 8000);
            nodes[i].thick = nodes[i].wide * thousandths(&rng, 1000, 1500) / flat;
            nodes[i].side = (ost_v3){thousandths(&rng, -200, 200), thousandths(&rng, -1000, 1000), 1};
        }
        ost_bar_init(&bar, nodes, 7, 3);
        assert_int_equal(bar.count, 18);
        for (int ball = 0; ball < 250; ball++) {
            const ost_v3 centre = {thousandths(&rng, -25000, 97000), thousandths(&rng, -30000, 30000),
                                   thousandths(&rng, -30000, 30000)};
            const double radius = thousandths(&rng, 0, 4000);
            ost_bar_part part;
            ost_bar_near(&bar, centre, radius, &part);
            fewer += part.count < bar.count;
            for (int n = 0; n < 10; n++) {
                const ost_v3 d = {(double)rng_range(&rng, -1000, 1000), (double)rng_range(&rng, -1000, 1000),
                                  (double)rng_range(&rng, 1, 1000)};
                const double share = (double)rng_range(&rng, 0, 2) / 2;
                const ost_v3 p = ost_v3_mad(centre, d, 0.999 * radius / ost_v3_length(d) * share);
                const double a = thousandths(&rng, -5000, 20000);
                const double expected = ost_blend(a, ost_bar_distance(&bar, p, 14), 7);
                const double got = ost_bar_blend(&part, a, p, 14, 7);
                assert_memory_equal(&got, &expected, sizeof got);
                unchanged += got == a;
            }
        }
    }
    print_message("# %d of 10000 balls need only some of the segments; at %d of 100000 points the bar does not change "
                  "the distance\n",
                  fewer, unchanged);
    assert_true(fewer > 2000 && unchanged > 2000 && unchanged < 98000);
}

static void test_bad_options(void **state)
{
    (void)state;
    ost_error err = {0};
    ost_volume v;
    assert_int_equal(ost_phantom_make(OST_PHANTOM_COUNT, NULL, &v, &err), OST_ERR_USAGE);
    assert_null(v.voxels);
    const double scales[] = {-1, 0.01, 1000, (double)INFINITY, (double)NAN};
    for (size_t i = 0; i < sizeof scales / sizeof *scales; i++) {
        ost_phantom_options o = {.scale = scales[i]};
        assert_int_equal(ost_phantom_make(OST_PHANTOM_SCAPULA, &o, &v, &err), OST_ERR_RANGE);
        assert_non_null(strstr(err.text, "scale"));
    }
    const ost_pm spacings[] = {-1, 1, OST_SPACING_MIN - 1, OST_SPACING_MAX + 1, INT64_MAX};
    for (size_t i = 0; i < sizeof spacings / sizeof *spacings; i++) {
        ost_phantom_options o = {.spacing = {0, spacings[i], 0}};
        assert_int_equal(ost_phantom_make(OST_PHANTOM_FOAM, &o, &v, &err), OST_ERR_RANGE);
        assert_non_null(strstr(err.text, "along y"));
    }
    /* On one axis, 120.32 mm / 10 um = 12,032 voxels are allowed. The complete grid of 12,032 x 10,998 x 20,100
       voxels is too large. */
    ost_phantom_options o = {.spacing = {MM / 100, MM / 100, MM / 50}};
    assert_int_equal(ost_phantom_make(OST_PHANTOM_SCAPULA, &o, &v, &err), OST_ERR_RANGE);
    assert_non_null(strstr(err.text, "2^31"));
}

static bool cancel_halfway(void *user, const char *stage, double share)
{
    assert_string_equal(stage, "generating");
    *(double *)user = share;
    return share < 0.5;
}

static void test_progress(void **state)
{
    (void)state;
    static const ost_phantom_kind kinds[] = {OST_PHANTOM_GLENOID, OST_PHANTOM_TRABECULAR};
    for (int k = 0; k < 2; k++) {
        ost_error err = {0};
        ost_volume v;
        double last = -1;
        const ost_pm spacing = 3 * MM / 10;
        const ost_phantom_options o = {
            .spacing = {spacing, spacing, spacing}, .progress = cancel_halfway, .progress_user = &last};
        assert_int_equal(ost_phantom_make(kinds[k], &o, &v, &err), OST_ERR_CANCELLED);
        assert_null(v.voxels);
        assert_true(last >= 0.5 && last < 0.7);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_names),
        cmocka_unit_test(test_dims_follow_spacing_and_scale),
        cmocka_unit_test(test_seed_determines_grid),
        cmocka_unit_test(test_left_is_mirror_of_right),
        cmocka_unit_test(test_glenoid_faces_outward),
        cmocka_unit_test(test_bone_is_connected_for_all_seeds),
        cmocka_unit_test(test_error_of_distances),
        cmocka_unit_test(test_selected_segments_give_exact_distance),
        cmocka_unit_test(test_bad_options),
        cmocka_unit_test(test_progress),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
