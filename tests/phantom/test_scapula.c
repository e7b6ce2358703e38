/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests the scapula and its glenoid at the thesis' size: the numbers of Tables 3.1 and 3.2, the
 * connectedness of the bone, and the layers that a reamer cuts.
 *
 * Measured for seed 1: 202 of 896 chunks of the scapula are active (the thesis: 202 in Table 3.2,
 * 199 in Table 3.7), and 18 of 18 chunks of the glenoid.
 *
 * Covers: REQ-PHANTOM, AR-CUB-1, AR-CUB-2
 */
#include "phantom_checks.h"

static ost_volume scapula, glenoid;

static int set_up(void **state)
{
    (void)state;
    ost_error err = {0};
    if (ost_phantom_make(OST_PHANTOM_SCAPULA, NULL, &scapula, &err) != OST_OK ||
        ost_phantom_make(OST_PHANTOM_GLENOID, NULL, &glenoid, &err) != OST_OK) {
        print_error("%s\n", err.text);
        return -1;
    }
    return 0;
}

static int tear_down(void **state)
{
    (void)state;
    ost_volume_free(&scapula);
    ost_volume_free(&glenoid);
    return 0;
}

static void assert_grid(const ost_volume *v, int x, int y, int z)
{
    assert_int_equal(v->geometry.dims.x, x);
    assert_int_equal(v->geometry.dims.y, y);
    assert_int_equal(v->geometry.dims.z, z);
    assert_int_equal(v->geometry.spacing.x, INT64_C(470000000));
    assert_int_equal(v->geometry.spacing.y, INT64_C(470000000));
    assert_int_equal(v->geometry.spacing.z, INT64_C(1000000000));
}

static void test_tables_3_1_and_3_2(void **state)
{
    (void)state;
    assert_grid(&scapula, 256, 234, 201);
    assert_grid(&glenoid, 49, 81, 41);
    chunk_count s = count_chunks(&scapula), g = count_chunks(&glenoid);
    print_message("# scapula: %lld of %lld chunks active, %lld active voxels; glenoid: %lld of %lld chunks\n",
                  (long long)s.active, (long long)s.all, (long long)s.active_voxels, (long long)g.active,
                  (long long)g.all);
    assert_int_equal(s.all, 896);
    assert_in_range(s.active, 195, 209);
    assert_int_equal(g.all, 18);
    assert_int_equal(g.active, 18);
}

static void test_bone_is_connected(void **state)
{
    (void)state;
    int64_t greatest, all;
    count_connected(&scapula, &greatest, &all);
    assert_true(all > 400000);
    assert_int_equal(greatest, all);
}

/* The smaller phantom must be a crop of the larger one, voxel for voxel. */
static void test_glenoid_is_crop_of_scapula(void **state)
{
    (void)state;
    const ost_geometry *g = &glenoid.geometry, *s = &scapula.geometry;
    int64_t at[3] = {(g->origin.x - s->origin.x) / s->spacing.x, (g->origin.y - s->origin.y) / s->spacing.y,
                     (g->origin.z - s->origin.z) / s->spacing.z};
    assert_int_equal(s->origin.x + at[0] * s->spacing.x, g->origin.x);
    assert_int_equal(s->origin.y + at[1] * s->spacing.y, g->origin.y);
    assert_int_equal(s->origin.z + at[2] * s->spacing.z, g->origin.z);
    for (int k = 0; k < g->dims.z; k++)
        for (int j = 0; j < g->dims.y; j++)
            assert_memory_equal(glenoid.voxels + (int64_t)g->dims.x * (j + (int64_t)g->dims.y * k),
                                scapula.voxels + at[0] + s->dims.x * (at[1] + j + s->dims.y * (at[2] + k)),
                                (size_t)g->dims.x * sizeof(int16_t));
    assert_string_equal(ost_meta_get(&glenoid.meta, OST_META_GLENOID_AT),
                        ost_meta_get(&scapula.meta, OST_META_GLENOID_AT));
}

/*
 * Samples the density every 0.05 mm along the axis, from outside the face inward. The expected order of the
 * layers is soft tissue, cartilage [120, 150), compact bone [650, ...) and spongy bone [150, 650).
 */
static void test_layers_along_the_axis(void **state)
{
    (void)state;
    double at[3], axis[3];
    read_vector(&scapula, OST_META_GLENOID_AT, at);
    read_vector(&scapula, OST_META_GLENOID_AXIS, axis);
    double face = -100, bone = -100, plate_from = -100, plate_to = -100, spongy = 0;
    int samples = 0;
    for (double t = -4; t < 16; t += 0.05) {
        double p[3] = {at[0] + t * axis[0], at[1] + t * axis[1], at[2] + t * axis[2]}, hu = density_at(&scapula, p);
        if (face < -50 && hu >= 120)
            face = t;
        if (bone < -50 && hu >= 150)
            bone = t;
        if (plate_from < -50 && hu >= 650)
            plate_from = t;
        if (plate_from > -50 && plate_to < -50 && hu < 650)
            plate_to = t;
        if (plate_to > -50 && t > plate_to + 1) {
            spongy += hu;
            samples++;
            assert_in_range((int)hu, 150, 500);
        }
    }
    print_message("# face %.2f mm, cartilage %.2f mm, plate %.2f mm, spongy bone %.0f HU\n", face, bone - face,
                  plate_to - plate_from, spongy / samples);
    assert_true(face > -0.5 && face < 0.5);
    assert_true(bone - face > 1.5 && bone - face < 2.5);
    assert_true(plate_to - plate_from > 1.4 && plate_to - plate_from < 2.6);
    assert_true(samples > 100);
}

static void test_densities(void **state)
{
    (void)state;
    int64_t count = ost_dims_count(scapula.geometry.dims), in_class[4] = {0};
    int lowest = 32767, highest = -32768;
    for (int64_t i = 0; i < count; i++) {
        int hu = scapula.voxels[i];
        lowest = hu < lowest ? hu : lowest;
        highest = hu > highest ? hu : highest;
        in_class[hu < 120 ? 0 : hu < 150 ? 1 : hu < 650 ? 2 : 3]++;
    }
    assert_in_range(lowest + 1024, 0, 400); /* the lowest density is that of air in the lung */
    assert_in_range(highest, 1200, 2000);
    int64_t active = count - in_class[0];
    print_message("# %lld active voxels: %lld of cartilage, %lld of spongy bone, %lld of compact bone\n",
                  (long long)active, (long long)in_class[1], (long long)in_class[2], (long long)in_class[3]);
    assert_true(in_class[1] > 5000);
    assert_true(in_class[2] > active / 5);
    assert_true(in_class[3] > active / 5);
}

/*
 * The bone is denser at the back (Frich et al.). The test compares the densities on both sides of the axis,
 * at depths of 6 to 10 mm.
 */
static void test_denser_posteriorly(void **state)
{
    (void)state;
    double at[3], axis[3];
    read_vector(&scapula, OST_META_GLENOID_AT, at);
    read_vector(&scapula, OST_META_GLENOID_AXIS, axis);
    /* This direction lies in the axial plane, is perpendicular to the glenoid's axis, and points backward (+y). */
    double back[3] = {-axis[1], axis[0], 0}, mean[2] = {0, 0};
    for (int side = 0; side < 2; side++)
        for (double u = 4; u < 8; u += 0.25)
            for (double t = 6; t < 10; t += 0.25) {
                double p[3], s = side ? -u : u;
                for (int a = 0; a < 3; a++)
                    p[a] = at[a] + t * axis[a] + s * back[a];
                mean[side] += density_at(&scapula, p) / 256;
            }
    print_message("# mean density of spongy bone: posterior %.0f HU, anterior %.0f HU\n", mean[0], mean[1]);
    assert_true(mean[0] > mean[1] + 15);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_tables_3_1_and_3_2),
        cmocka_unit_test(test_bone_is_connected),
        cmocka_unit_test(test_glenoid_is_crop_of_scapula),
        cmocka_unit_test(test_layers_along_the_axis),
        cmocka_unit_test(test_densities),
        cmocka_unit_test(test_denser_posteriorly),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
