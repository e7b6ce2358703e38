/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests the conversion of axes to LPS+. For each of the 48 orientations of three axes, the
 * position of every voxel is computed in two ways: from the file's affine, and from the result's
 * geometry. For the second way, the placement maps the voxel to an element of the result.
 *
 * Covers: AR-GRID-4, AR-FILE-5
 */
#include "harness.h"

#include "io/volume/orient.h"
#include "io/volume/resample.h"

static const int orders[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};

static ost_pm at_axis(ost_pm3 v, int w)
{
    return w == 0 ? v.x : w == 1 ? v.y : v.z;
}

static void all_48_orientations(void **state)
{
    (void)state;
    static const char toward[3][2] = {{'L', 'R'}, {'P', 'A'}, {'S', 'I'}};
    const int32_t sizes[3] = {5, 3, 4};
    const ost_pm lengths[3] = {470000000, 1000000000, 488281250};
    for (int way = 0; way < 48; way++) {
        const int *to = orders[way / 8];
        ost_affine affine = {.origin = {-57340000000, 12345678901, -3}};
        char code[4] = "";
        for (int a = 0; a < 3; a++) {
            bool back = way >> a & 1;
            affine.column[a][to[a]] = back ? -lengths[a] : lengths[a];
            code[a] = toward[to[a]][back];
        }
        ost_placement p;
        ost_error err = {0};
        assert_ok(ost_orient(&affine, sizes, &p, &err));
        assert_false(p.oblique);
        assert_int_equal(p.reoriented, way != 0);
        assert_string_equal(p.code, code);
        const ost_geometry *g = &p.geometry;
        bool seen[60] = {false};
        for (int k = 0; k < sizes[2]; k++)
            for (int j = 0; j < sizes[1]; j++)
                for (int i = 0; i < sizes[0]; i++) {
                    int64_t e = ost_placement_element(&p, i, j, k);
                    assert_true(e >= 0 && e < 60 && !seen[e]);
                    seen[e] = true;
                    const int64_t index[3] = {e % g->dims.x, e / g->dims.x % g->dims.y, e / g->dims.x / g->dims.y};
                    for (int w = 0; w < 3; w++) {
                        ost_pm in_file = affine.origin[w] + i * affine.column[0][w] + j * affine.column[1][w] +
                                         k * affine.column[2][w];
                        assert_int_equal(in_file, at_axis(g->origin, w) + index[w] * at_axis(g->spacing, w));
                    }
                }
    }
}

/*
 * The axes are tilted by less than the limit. The file's voxel that becomes the grid's first voxel must
 * determine every component of the grid's origin. A volume that is stored backward along an axis must give
 * the same grid.
 */
static void reversed_tilted_axes_give_the_same_grid(void **state)
{
    (void)state;
    test_rng rng = rng_seeded("tilted axes");
    for (int round = 0; round < 500; round++) {
        const int *to = orders[rng_range(&rng, 0, 5)];
        int32_t sizes[3];
        ost_affine affine;
        for (int a = 0; a < 3; a++) {
            sizes[a] = (int32_t)rng_range(&rng, 1, 60);
            affine.origin[a] = rng_range(&rng, -100000000000, 100000000000);
            /* The tilt is below the limit: 2 * 64 * 500,000 pm is less than an eighth of 0.6 mm. */
            for (int w = 0; w < 3; w++)
                affine.column[a][w] = w == to[a]
                                          ? rng_range(&rng, 600000000, 900000000) * (rng_range(&rng, 0, 1) ? 1 : -1)
                                          : rng_range(&rng, -500000, 500000);
        }
        ost_error err = {0};
        ost_placement p, again;
        assert_ok(ost_orient(&affine, sizes, &p, &err));
        assert_false(p.oblique);
        for (int w = 0; w < 3; w++) {
            ost_pm first = affine.origin[w];
            for (int a = 0; a < 3; a++)
                first += p.flip[a] ? (sizes[a] - 1) * affine.column[a][w] : 0;
            assert_int_equal(at_axis(p.geometry.origin, w), first);
        }
        int back = (int)rng_range(&rng, 0, 2);
        for (int w = 0; w < 3; w++) {
            affine.origin[w] += (sizes[back] - 1) * affine.column[back][w];
            affine.column[back][w] = -affine.column[back][w];
        }
        assert_ok(ost_orient(&affine, sizes, &again, &err));
        assert_true(ost_geometry_equal(&p.geometry, &again.geometry));
    }
}

/*
 * An axis counts as straight if its tilt moves the farthest voxel by at most 1/8 of a voxel. One picometre
 * more makes the axis tilted. An axis with fewer than 65 voxels is treated as if it had 65 voxels.
 */
static void tilt_limit_is_an_eighth_of_a_voxel(void **state)
{
    (void)state;
    ost_error err = {0};
    ost_placement p;
    const ost_pm voxel = 800000000; /* an eighth of a voxel is 100,000,000 pm */
    ost_affine affine = {.column = {{voxel, 0, 0}, {0, voxel, 0}, {0, 0, voxel}}};
    const int32_t longer[3] = {201, 9, 9}, shorter[3] = {3, 3, 3};
    affine.column[0][1] = 500000; /* 200 steps of 500,000 pm are an eighth of a voxel */
    assert_ok(ost_orient(&affine, longer, &p, &err));
    assert_false(p.oblique);
    affine.column[0][1] = 500001;
    assert_ok(ost_orient(&affine, longer, &p, &err));
    assert_true(p.oblique);
    affine.column[0][1] = -1562500; /* 64 steps of 1,562,500 pm are an eighth of a voxel */
    assert_ok(ost_orient(&affine, shorter, &p, &err));
    assert_false(p.oblique);
    affine.column[0][1] = -1562501;
    assert_ok(ost_orient(&affine, shorter, &p, &err));
    assert_true(p.oblique);
}

static void reports_angle_and_refuses_parallel_axes(void **state)
{
    (void)state;
    ost_error err = {0};
    ost_placement p;
    const int32_t sizes[3] = {10, 10, 10};
    /* the x and y axes of this grid are rotated by 30 degrees: cos and sin of 30 degrees, times 1 mm */
    ost_affine turned = {.column = {{866025404, 500000000, 0}, {-500000000, 866025404, 0}, {0, 0, 1000000000}}};
    assert_ok(ost_orient(&turned, sizes, &p, &err));
    assert_true(p.oblique);
    assert_true(p.degrees > 29.99 && p.degrees < 30.01);
    ost_affine flat = {.column = {{1000000000, 0, 0}, {2000000000, 0, 0}, {0, 0, 1000000000}}};
    assert_int_equal(ost_orient(&flat, sizes, &p, &err), OST_ERR_INPUT);
    ost_affine huge = {.column = {{100000000001, 0, 0}, {0, 1000000000, 0}, {0, 0, 1000000000}}};
    assert_int_equal(ost_orient(&huge, sizes, &p, &err), OST_ERR_RANGE);
}

/*
 * Resamples a volume that is rotated by an angle of the (3, 4, 5) triangle, so that the columns of the affine are
 * exact: (0.6, 0.8, 0), (-0.8, 0.6, 0), (0, 0, 1) mm. To find the nearest file voxel of each result voxel, the test
 * compares the squared distances of all file voxels. If there is a tie, or if the nearest centre is farther than half a
 * voxel along a file axis, the result voxel is not checked.
 */
static void resampling_uses_the_nearest_voxel(void **state)
{
    (void)state;
    ost_error err = {0};
    const ost_affine affine = {.column = {{600000000, 800000000, 0}, {-800000000, 600000000, 0}, {0, 0, 1000000000}},
                               .origin = {1000000000, -2000000000, 500000000}};
    const int32_t sizes[3] = {7, 6, 3};
    ost_placement p;
    ost_geometry g;
    ost_volume out;
    int16_t file[7 * 6 * 3];
    for (int i = 0; i < 126; i++)
        file[i] = (int16_t)(i + 1);
    assert_ok(ost_orient(&affine, sizes, &p, &err));
    assert_true(p.oblique);
    assert_ok(ost_resample_geometry(&affine, sizes, &p, &g, &err));
    assert_int_equal(g.spacing.x, 1000000000);
    assert_int_equal(g.spacing.y, 1000000000);
    assert_int_equal(g.origin.x, 1000000000 - 5 * 800000000LL);
    /* the extents are 6 * 0.6 + 5 * 0.8 = 7.6 mm and 6 * 0.8 + 5 * 0.6 = 7.8 mm */
    assert_int_equal(g.dims.x, 9);
    assert_int_equal(g.dims.y, 9);
    assert_int_equal(g.dims.z, 3);
    assert_ok(ost_volume_init(&out, &g, &err));
    ost_resample_nearest(&affine, sizes, file, &out);
    int inside = 0;
    for (int e = 0; e < 9 * 9 * 3; e++) {
        const int64_t q[3] = {g.origin.x + e % 9 * 1000000000LL, g.origin.y + e / 9 % 9 * 1000000000LL,
                              g.origin.z + e / 81 * 1000000000LL};
        int64_t best = INT64_MAX, second = INT64_MAX;
        int found = 0;
        for (int f = 0; f < 126; f++) {
            const int at[3] = {f % 7, f / 7 % 6, f / 42};
            int64_t square = 0;
            for (int w = 0; w < 3; w++) {
                int64_t d = q[w] - affine.origin[w];
                for (int a = 0; a < 3; a++)
                    d -= at[a] * affine.column[a][w];
                d /= 1000000; /* converts to nanometres, so that the squares do not overflow */
                square += d * d;
            }
            if (square < best) {
                second = best;
                best = square;
                found = f;
            } else if (square < second) {
                second = square;
            }
        }
        if (best == second)
            continue;
        /* The columns are orthonormal, so the offset along file axis a is a dot product. */
        bool within = true, border = false;
        const int at[3] = {found % 7, found / 7 % 6, found / 42};
        for (int a = 0; a < 3; a++) {
            int64_t dot = 0;
            for (int w = 0; w < 3; w++) {
                int64_t d = q[w] - affine.origin[w];
                for (int b = 0; b < 3; b++)
                    d -= at[b] * affine.column[b][w];
                dot += d / 1000000 * (affine.column[a][w] / 1000000);
            }
            within &= dot <= 500000 && dot >= -500000;
            border |= dot == 500000 || dot == -500000;
        }
        if (border)
            continue;
        assert_int_equal(out.voxels[e], within ? file[found] : 0);
        inside += within;
    }
    assert_true(inside > 60);
    ost_volume_free(&out);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(all_48_orientations),
        cmocka_unit_test(reversed_tilted_axes_give_the_same_grid),
        cmocka_unit_test(tilt_limit_is_an_eighth_of_a_voxel),
        cmocka_unit_test(reports_angle_and_refuses_parallel_axes),
        cmocka_unit_test(resampling_uses_the_nearest_voxel),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
