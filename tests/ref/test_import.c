/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests the conversions from samples to a rect grid and from a rect grid to a cubic one, on the
 * reference.
 * Covers: AR-CT-4, AR-CT-5, AR-CT-6, AR-CT-9, AR-CUB-1, AR-CUB-2, AR-CUB-3, AR-CUB-4
 *
 * The expected values are computed by hand in the adjacent comments.
 */
#include "ref/scene.h"

static const ost_pm S = 470000 * (OST_PM_PER_MM / 1000000); /* 0.47 mm */

static ost_grid *rect_grid(ost_backend *backend, int32_t x, int32_t y, int32_t z, ost_pm3 origin)
{
    ost_error err = {0};
    ost_geometry g = {.dims = {x, y, z}, .spacing = {S, S, OST_PM_PER_MM}, .origin = origin};
    ost_grid *grid;
    assert_ok(ost_grid_create(backend, &g, &grid, &err));
    return grid;
}

static int16_t voxel_at(const ost_grid *grid, int32_t x, int32_t y, int32_t z)
{
    ost_error err = {0};
    const ost_geometry *g = ost_grid_geometry(grid);
    int16_t *slice = malloc((size_t)g->dims.x * (size_t)g->dims.y * sizeof *slice);
    assert_non_null(slice);
    assert_ok(ost_grid_download(grid, z, 1, slice, &err));
    int16_t value = slice[x + g->dims.x * y];
    free(slice);
    return value;
}

static void worked_example_of_the_specification(void **state)
{
    /*
     * The example of docs/spec/arithmetic.md, AR-CT: the spacing is 0.47 mm and the minimum is -57.34 mm.
     * The position 4.0499 mm deviates from the lattice by 0.38319 of a voxel, and 4.1799 mm by only
     * 0.10659.
     */
    ost_error err = {0};
    ost_grid *grid = rect_grid(*state, 200, 1, 1, (ost_pm3){-57340000000, 0, 0});
    ost_scatter_report report = {0};
    ost_sample far = {.x = 4049900000, .density = 300, .line = 1};
    assert_ok(ost_ct_to_rect(grid, &far, 1, 10, OST_DUPLICATES_ERROR, &report, &err));
    assert_int_equal(report.rejected_line, 11);
    assert_int_equal(report.off_lattice, 1);
    assert_int_equal(report.worst_offset_ppm, 383191); /* 180,100,000 / 470,000,000 = 0.3831914... */
    assert_int_equal(report.worst_line, 11);
    assert_int_equal(voxel_at(grid, 131, 0, 0), 0);
    ost_sample near = {.x = 4179900000, .density = 301, .line = 2};
    assert_ok(ost_ct_to_rect(grid, &near, 1, 10, OST_DUPLICATES_ERROR, &report, &err));
    assert_int_equal(report.off_lattice, 1);
    assert_int_equal(report.rejected_line, 11);
    assert_int_equal(voxel_at(grid, 131, 0, 0), 301);
    ost_grid_free(grid);
}

static void density_beyond_int16_is_refused(void **state)
{
    ost_grid *grid = rect_grid(*state, 4, 1, 1, (ost_pm3){0, 0, 0});
    const int32_t beyond[] = {32768, -32769, 65536 + 300, INT32_MAX, INT32_MIN};
    for (size_t i = 0; i < sizeof beyond / sizeof beyond[0]; i++) {
        ost_error err = {0};
        ost_scatter_report report = {0};
        const ost_sample samples[2] = {{.density = 300}, {.x = S, .density = beyond[i], .line = 1}};
        assert_int_equal(ost_ct_to_rect(grid, samples, 2, 10, OST_DUPLICATES_ERROR, &report, &err), OST_ERR_RANGE);
        assert_non_null(strstr(err.text, "line 11"));
        assert_int_equal(report.samples, 0);
        assert_int_equal(voxel_at(grid, 0, 0, 0), 0);
    }
    ost_grid_free(grid);
}

static void limits_of_lattice_offsets(void **state)
{
    /*
     * The spacing is 8 units. An offset of exactly 1 unit is accepted and not counted. An offset of exactly
     * 3 units is accepted and counted. An offset of 4 units, half a voxel, is rounded to even and rejected.
     */
    ost_error err = {0};
    ost_geometry g = {.dims = {8, 1, 1}, .spacing = {8000000, 8000000, 8000000}};
    const struct {
        int64_t x;
        uint64_t counted;
        int64_t rejected;
        int index;
    } cases[] = {
        {1000000, 0, 0, 0},   {1000001, 1, 0, 0},   {3000000, 1, 0, 0},  {3000001, 1, 7, -1}, {4000000, 1, 7, -1},
        {15000000, 0, 0, 2},  {14999999, 1, 0, 2},  {13000000, 1, 0, 2}, {12999999, 1, 7, -1}, {-3000000, 1, 0, 0},
        /* 7.5 is rounded to 8, which is outside the grid. */
        {-4000001, 1, 7, -1}, {59000000, 1, 0, 7},  {60000000, 1, 7, -1},
        {61000000, 1, 7, -1}, {64000000, 0, 7, -1}, {-8000000, 0, 7, -1}, {OST_LENGTH_MAX, 0, 7, -1},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        ost_grid *grid;
        assert_ok(ost_grid_create(*state, &g, &grid, &err));
        ost_scatter_report report = {0};
        ost_sample sample = {.x = cases[i].x, .density = 500};
        assert_ok(ost_ct_to_rect(grid, &sample, 1, 7, OST_DUPLICATES_ERROR, &report, &err));
        int16_t row[8];
        assert_ok(ost_grid_download(grid, 0, 1, row, &err));
        if (report.off_lattice != cases[i].counted || report.rejected_line != cases[i].rejected)
            fail_msg("x = %lld: %llu samples are counted as off the lattice and the rejected line is %lld; expected "
                     "%lld, %lld",
                     (long long)cases[i].x, (unsigned long long)report.off_lattice, (long long)report.rejected_line,
                     (long long)cases[i].counted, (long long)cases[i].rejected);
        for (int v = 0; v < 8; v++)
            assert_int_equal(row[v], v == cases[i].index ? 500 : 0);
        ost_grid_free(grid);
    }
}

static void duplicate_samples(void **state)
{
    const struct {
        ost_duplicates rule;
        int16_t kept;
        int64_t conflict;
    } cases[] = {{OST_DUPLICATES_ERROR, 200, 3},
                 {OST_DUPLICATES_FIRST, 200, 0},
                 {OST_DUPLICATES_LAST, 150, 0},
                 {OST_DUPLICATES_MAX, 900, 0}};
    const ost_sample samples[] = {{.density = 200, .line = 0}, {.density = 200, .line = 1}, {.density = 900, .line = 2},
                                  {.density = 150, .line = 3}};
    ost_error err = {0};
    for (size_t i = 0; i < 4; i++)
        /* The samples are divided into two batches at each possible position. */
        for (size_t cut = 0; cut <= 4; cut++) {
            ost_grid *grid = rect_grid(*state, 2, 2, 2, (ost_pm3){0, 0, 0});
            ost_scatter_report report = {0};
            assert_ok(ost_ct_to_rect(grid, samples, cut, 1, cases[i].rule, &report, &err));
            assert_ok(ost_ct_to_rect(grid, samples + cut, 4 - cut, 1, cases[i].rule, &report, &err));
            assert_int_equal(report.samples, 4);
            assert_int_equal(report.duplicates, 3);
            assert_int_equal(report.conflict_line, cases[i].conflict);
            if (cases[i].conflict) {
                assert_int_equal(report.conflict_had, 200);
                assert_int_equal(report.conflict_has, 900);
            }
            assert_int_equal(voxel_at(grid, 0, 0, 0), cases[i].kept);
            ost_grid_free(grid);
        }
}

static void zero_density_counts_as_a_sample(void **state)
{
    ost_error err = {0};
    ost_grid *grid = rect_grid(*state, 1, 1, 1, (ost_pm3){0, 0, 0});
    ost_scatter_report report = {0};
    const ost_sample samples[] = {{.density = 0, .line = 0}, {.density = 5, .line = 1}};
    assert_ok(ost_ct_to_rect(grid, samples, 2, 1, OST_DUPLICATES_ERROR, &report, &err));
    assert_int_equal(report.duplicates, 1);
    assert_int_equal(report.conflict_line, 2);
    assert_int_equal(report.conflict_had, 0);
    ost_grid_free(grid);
}

static void every_sample_sets_its_voxel(void **state)
{
    /*
     * Positions k * 0.47 - 57.34 are exact with two decimals. Therefore each voxel receives one
     * sample, and no sample is off the lattice.
     */
    ost_error err = {0};
    enum { NX = 7, NY = 5, NZ = 4 };
    ost_pm3 origin = {-57340000000, -3 * OST_PM_PER_MM, OST_PM_PER_MM / 3};
    ost_grid *grid = rect_grid(*state, NX, NY, NZ, origin);
    ost_sample samples[NX * NY * NZ];
    for (int i = 0; i < NX * NY * NZ; i++) {
        int v = (i * 61) % (NX * NY * NZ); /* This is a permutation, because 61 and 140 have no common divisor. */
        int x = v % NX, y = v / NX % NY, z = v / NX / NY;
        samples[i] = (ost_sample){origin.x + x * S, origin.y + y * S, origin.z + z * OST_PM_PER_MM, v - 70,
                                  (uint32_t)i};
    }
    ost_scatter_report report = {0};
    assert_ok(ost_ct_to_rect(grid, samples, NX * NY * NZ, 1, OST_DUPLICATES_ERROR, &report, &err));
    assert_int_equal(report.samples, NX * NY * NZ);
    assert_int_equal(report.duplicates + report.off_lattice + report.worst_offset_ppm, 0);
    assert_int_equal(report.worst_line + report.rejected_line + report.conflict_line, 0);
    int16_t voxels[NX * NY * NZ];
    assert_ok(ost_grid_download(grid, 0, NZ, voxels, &err));
    for (int v = 0; v < NX * NY * NZ; v++)
        assert_int_equal(voxels[v], v - 70);
    ost_grid_free(grid);
}

/* ---------------------------------------------- rect grid to cubic grid */

static ost_grid *line_grid(ost_backend *backend, int axis, int32_t n, ost_pm spacing)
{
    ost_error err = {0};
    ost_geometry g = {.dims = {1, 1, 1}, .spacing = {OST_PM_PER_MM, OST_PM_PER_MM, OST_PM_PER_MM}};
    (axis == 0 ? &g.dims.x : axis == 1 ? &g.dims.y : &g.dims.z)[0] = n;
    (axis == 0 ? &g.spacing.x : axis == 1 ? &g.spacing.y : &g.spacing.z)[0] = spacing;
    ost_grid *grid;
    int16_t values[8];
    assert_true(n <= 8);
    for (int i = 0; i < n; i++)
        values[i] = (int16_t)(100 + 1000 * i);
    assert_ok(ost_grid_create(backend, &g, &grid, &err));
    assert_ok(ost_grid_upload(grid, 0, g.dims.z, values, &err));
    return grid;
}

static ost_pm3 origin_of(const ost_grid *grid)
{
    return ost_grid_geometry(grid)->origin;
}

static void resampling_to_finer_layers(void **state)
{
    /*
     * Three layers of 1 mm are resampled to 0.47 mm. There are ceil(3 / 0.47) = 7 layers, the first at
     * (0.47 - 1) / 2 = -0.265 mm. In units of the source layers, the centres are at -0.265, 0.205, 0.675,
     * 1.145, 1.615, 2.085 and 2.555. The `linear` rule clamps the first centre to 0 and the last two to 2.
     * The `nearest` rule uses the layers' boxes, which begin at -0.5: the centres lie in the layers 0, 0,
     * 1, 1, 2, 2 and 3; the last is clamped to 2. The `thesis` rule divides 0, 0.47, 0.94, 1.41, 1.88,
     * 2.35 and 2.82 by 1. Each source layer is 1000 denser than the previous layer. Rounding the weights
     * to multiples of 2^-15 does not change the results.
     */
    static const int expected[3][7] = {
        [OST_RESAMPLE_LINEAR] = {100, 305, 775, 1245, 1715, 2100, 2100},
        [OST_RESAMPLE_NEAREST] = {100, 100, 1100, 1100, 2100, 2100, 2100},
        [OST_RESAMPLE_THESIS] = {100, 100, 100, 1100, 1100, 2100, 2100},
    };
    ost_error err = {0};
    for (int axis = 0; axis < 3; axis++)
        for (int rule = 0; rule < 3; rule++) {
            ost_grid *rect = line_grid(*state, axis, 3, OST_PM_PER_MM), *cubic;
            assert_ok(ost_rect_to_cubic(rect, S, (ost_resample)rule, &cubic, &err));
            const ost_geometry *g = ost_grid_geometry(cubic);
            const int32_t dims[3] = {g->dims.x, g->dims.y, g->dims.z};
            /* The other axes have one voxel of 1 mm: ceil(1 / 0.47) = 3 voxels of 0.47 mm. */
            assert_int_equal(dims[axis], 7);
            assert_int_equal(dims[(axis + 1) % 3], 3);
            assert_int_equal(origin_of(cubic).x, -265 * UM);
            assert_int_equal(origin_of(cubic).y, -265 * UM);
            assert_int_equal(origin_of(cubic).z, -265 * UM);
            int16_t voxels[7 * 3 * 3];
            assert_ok(ost_grid_download(cubic, 0, g->dims.z, voxels, &err));
            for (int v = 0; v < 63; v++) {
                const int at[3] = {v % dims[0], v / dims[0] % dims[1], v / dims[0] / dims[1]};
                assert_int_equal(voxels[v], expected[rule][at[axis]]);
            }
            ost_grid_free(cubic);
            ost_grid_free(rect);
        }
}

static void resampling_to_coarser_layers(void **state)
{
    /*
     * Seven layers of 0.3 mm are resampled to 0.47 mm. There are ceil(2.1 / 0.47) = 5 layers, the first at
     * (0.47 - 0.3) / 2 = 0.085 mm. For the `linear` rule, the centres are at 0.2833, 1.85, 3.4167, 4.9833
     * and 6.55 source layers; the last centre is clamped to 6. For the `nearest` rule, the boxes begin half
     * a layer earlier, and the centres lie in the layers 0, 2, 3, 5 and 7; the last is clamped to 6. The
     * `thesis` rule divides 0, 0.47, 0.94, 1.41 and 1.88 by 0.3, which gives the layers 0, 1, 3, 4 and 6.
     */
    static const int expected[3][5] = {
        [OST_RESAMPLE_LINEAR] = {383, 1950, 3517, 5083, 6100},
        [OST_RESAMPLE_NEAREST] = {100, 2100, 3100, 5100, 6100},
        [OST_RESAMPLE_THESIS] = {100, 1100, 3100, 4100, 6100},
    };
    ost_error err = {0};
    for (int rule = 0; rule < 3; rule++) {
        ost_grid *rect = line_grid(*state, 2, 7, 300 * UM), *cubic;
        assert_ok(ost_rect_to_cubic(rect, S, (ost_resample)rule, &cubic, &err));
        assert_int_equal(ost_grid_geometry(cubic)->dims.z, 5);
        assert_int_equal(origin_of(cubic).z, 85 * UM);
        for (int z = 0; z < 5; z++)
            assert_int_equal(voxel_at(cubic, 0, 0, z), expected[rule][z]);
        ost_grid_free(cubic);
        ost_grid_free(rect);
    }
}

static void origins_round_half_to_even(void **state)
{
    /* The cubic spacing c is 1 mm. With the rect spacings s of this table, (c - s) / 2 is -1/2, -3/2, 1/2 and 5/2 pm.
       These values are rounded to 0, -2, 0 and 2. */
    static const struct {
        ost_pm more, moved;
    } cases[] = {{1, 0}, {3, -2}, {-1, 0}, {-5, 2}};
    ost_error err = {0};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        ost_grid *rect = line_grid(*state, 1, 2, OST_PM_PER_MM + cases[i].more), *cubic;
        assert_ok(ost_rect_to_cubic(rect, OST_PM_PER_MM, OST_RESAMPLE_LINEAR, &cubic, &err));
        assert_int_equal(origin_of(cubic).y, cases[i].moved);
        ost_grid_free(cubic);
        ost_grid_free(rect);
    }
}

/*
 * Resamples 2 x 2 x 2 voxels of 1.5 mm to 3 x 3 x 3 voxels of 1 mm. Returns the density of the
 * central voxel, for which t = (3 - 1.5) / 3 = 1/2 on every axis.
 */
static int16_t mean_of_eight(ost_backend *backend, const int16_t voxels[8])
{
    ost_error err = {0};
    const ost_geometry g = cubic_geometry(2, 2, 2, 3 * OST_PM_PER_MM / 2, (ost_pm3){0, 0, 0});
    ost_grid *rect, *cubic;
    assert_ok(ost_grid_create(backend, &g, &rect, &err));
    assert_ok(ost_grid_upload(rect, 0, 2, voxels, &err));
    assert_ok(ost_rect_to_cubic(rect, OST_PM_PER_MM, OST_RESAMPLE_LINEAR, &cubic, &err));
    const int16_t mean = voxel_at(cubic, 1, 1, 1);
    ost_grid_free(cubic);
    ost_grid_free(rect);
    return mean;
}

static void means_round_once_and_half_to_even(void **state)
{
    /*
     * The tested means are 5/8, the ties 12/8 and 20/8, the negatives of these three means, and the
     * extremes of int16. 5/8 must be rounded to 1; rounding after each axis would give 2, 1 and
     * finally 0.
     */
    static const struct {
        int16_t voxels[8];
        int mean;
    } cases[] = {
        {{5}, 1},
        {{0, 12}, 2},
        {{0, 0, 20}, 2},
        {{0, 0, 0, -5}, -1},
        {{0, 0, 0, 0, -12}, -2},
        {{0, 0, 0, 0, 0, -20}, -2},
        {{32767, 32767, 32767, 32767, 32767, 32767, 32767, 32767}, 32767},
        {{-32768, -32768, -32768, -32768, -32768, -32768, -32768, -32768}, -32768},
        {{32767, -32768, 32767, -32768, 32767, -32768, 32767, -32768}, 0}, /* -1/2 */
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++)
        assert_int_equal(mean_of_eight(*state, cases[i].voxels), cases[i].mean);
}

static void means_are_between_their_inputs(void **state)
{
    /* AR-CUB-2: no cubic voxel may be denser than the densest rect voxel. */
    ost_error err = {0};
    test_rng rng = rng_seeded("means");
    for (int round = 0; round < 20; round++) {
        const ost_geometry g = {
            .dims = {(int32_t)rng_range(&rng, 1, 6), (int32_t)rng_range(&rng, 1, 6), (int32_t)rng_range(&rng, 1, 6)},
            .spacing = {rng_range(&rng, 200, 3000) * UM + 1, rng_range(&rng, 200, 3000) * UM,
                        rng_range(&rng, 200, 3000) * UM}};
        const int16_t lo = (int16_t)rng_range(&rng, INT16_MIN, INT16_MAX), hi = (int16_t)rng_range(&rng, lo, INT16_MAX);
        int16_t voxels[216], *out;
        ost_grid *rect, *cubic;
        for (int v = 0; v < 216; v++)
            voxels[v] = (int16_t)rng_range(&rng, lo, hi);
        assert_ok(ost_grid_create(*state, &g, &rect, &err));
        assert_ok(ost_grid_upload(rect, 0, g.dims.z, voxels, &err));
        assert_ok(ost_rect_to_cubic(rect, rng_range(&rng, 300, 2000) * UM, OST_RESAMPLE_LINEAR, &cubic, &err));
        const size_t count = voxel_count(ost_grid_geometry(cubic));
        out = malloc(count * sizeof *out);
        assert_non_null(out);
        assert_ok(ost_grid_download(cubic, 0, ost_grid_geometry(cubic)->dims.z, out, &err));
        for (size_t v = 0; v < count; v++)
            assert_in_range(out[v] + 32768, lo + 32768, hi + 32768);
        free(out);
        ost_grid_free(cubic);
        ost_grid_free(rect);
    }
}

static void seventh_digit_changes_at_most_one_rounding(void **state)
{
    /*
     * 60 layers of 0.4882812 or 0.4882813 mm are resampled to 0.4882812 mm. Each layer is 500 denser than
     * the previous layer. The last centre deviates by 59.5 * 2 * 10^-7 of a layer, which changes the
     * density by 500 * 1.2 * 10^-5. With the `linear` rule, the densities of the two spacings therefore differ by at
     * most 1. With the `nearest` rule, they are equal. With the `thesis` rule, layer i > 0 has the source layer
     * floor(i c / s), which is i for the first spacing and i - 1 for the second.
     */
    static const ost_pm near[2] = {488281200, 488281300};
    ost_error err = {0};
    int16_t voxels[60], got[3][2][60];
    for (int i = 0; i < 60; i++)
        voxels[i] = (int16_t)(500 * i);
    for (int rule = 0; rule < 3; rule++)
        for (int s = 0; s < 2; s++) {
            const ost_geometry g = {.dims = {1, 1, 60}, .spacing = {near[0], near[0], near[s]}};
            ost_grid *rect, *cubic;
            assert_ok(ost_grid_create(*state, &g, &rect, &err));
            assert_ok(ost_grid_upload(rect, 0, 60, voxels, &err));
            assert_ok(ost_rect_to_cubic(rect, near[0], (ost_resample)rule, &cubic, &err));
            assert_ok(ost_grid_download(cubic, 0, 60, got[rule][s], &err));
            assert_in_range(origin_of(cubic).z + 100, 0, 200);
            ost_grid_free(cubic);
            ost_grid_free(rect);
        }
    for (int i = 0; i < 60; i++) {
        assert_in_range(got[OST_RESAMPLE_LINEAR][1][i] - got[OST_RESAMPLE_LINEAR][0][i] + 1, 0, 2);
        assert_int_equal(got[OST_RESAMPLE_NEAREST][1][i], got[OST_RESAMPLE_NEAREST][0][i]);
        assert_int_equal(got[OST_RESAMPLE_THESIS][1][i], i ? 500 * (i - 1) : 0);
    }
}

static void equal_spacing_changes_nothing(void **state)
{
    ost_error err = {0};
    test_rng rng = rng_seeded("equal spacing");
    ost_geometry g = cubic_geometry(9, 8, 7, 32 * UM, (ost_pm3){5, -6, 7});
    int16_t *voxels = random_densities(&rng, &g, 4), *back = malloc(voxel_count(&g) * sizeof *back);
    ost_grid *rect, *cubic;
    assert_ok(ost_grid_create(*state, &g, &rect, &err));
    assert_ok(ost_grid_upload(rect, 0, 7, voxels, &err));
    for (int rule = 0; rule < 3; rule++) {
        assert_ok(ost_rect_to_cubic(rect, 32 * UM, (ost_resample)rule, &cubic, &err));
        assert_true(ost_geometry_equal(&g, ost_grid_geometry(cubic)));
        assert_ok(ost_grid_download(cubic, 0, 7, back, &err));
        assert_same_voxels(back, voxels, &g);
        ost_grid_free(cubic);
    }
    assert_int_equal(ost_rect_to_cubic(rect, 32 * UM, (ost_resample)3, &cubic, &err), OST_ERR_USAGE);
    assert_int_equal(ost_rect_to_cubic(rect, 32 * UM, (ost_resample)-1, &cubic, &err), OST_ERR_USAGE);
    ost_grid_free(rect);
    free(back);
    free(voxels);
}

static void the_thesis_tables(void **state)
{
    /*
     * Tables 3.1 and 3.2 of the thesis. The 201 layers of 1 mm of the scapula become 428 layers
     * of 0.47 mm (docs/design/thesis-notes.md).
     */
    const struct {
        ost_dims rect;
        ost_pm in_plane, between;
        ost_dims cubic, chunks;
    } models[] = {
        {{314, 320, 604}, 32 * UM, 32 * UM, {314, 320, 604}, {10, 10, 19}},
        {{314, 316, 360}, 32 * UM, 32 * UM, {314, 316, 360}, {10, 10, 12}},
        {{156, 156, 313}, 32 * UM, 32 * UM, {156, 156, 313}, {5, 5, 10}},
        {{256, 234, 201}, 470 * UM, 1000 * UM, {256, 234, 428}, {8, 8, 14}},
        {{49, 81, 41}, 470 * UM, 1000 * UM, {49, 81, 88}, {2, 3, 3}},
    };
    ost_error err = {0};
    /* The dimensions of the two largest models are checked after this loop. */
    for (size_t i = 2; i < sizeof models / sizeof models[0]; i++) {
        ost_geometry g = {.dims = models[i].rect,
                          .spacing = {models[i].in_plane, models[i].in_plane, models[i].between}};
        ost_grid *rect, *cubic;
        assert_ok(ost_grid_create(*state, &g, &rect, &err));
        assert_ok(ost_rect_to_cubic(rect, models[i].in_plane, OST_RESAMPLE_LINEAR, &cubic, &err));
        ost_geometry c = *ost_grid_geometry(cubic);
        assert_memory_equal(&c.dims, &models[i].cubic, sizeof c.dims);
        ost_grid_free(cubic);
        ost_grid_free(rect);
    }
    for (size_t i = 0; i < sizeof models / sizeof models[0]; i++) {
        ost_geometry g = cubic_geometry(models[i].cubic.x, models[i].cubic.y, models[i].cubic.z, models[i].in_plane,
                                        (ost_pm3){0, 0, 0});
        ost_bone *bone;
        ost_bone_info info;
        assert_ok(ost_bone_create(*state, &g, 32, 120, &bone, &err));
        assert_ok(ost_bone_info_get(bone, &info, &err));
        assert_memory_equal(&info.chunk_dims, &models[i].chunks, sizeof info.chunk_dims);
        ost_bone_free(bone);
    }
}

static void reference_has_no_options(void **state)
{
    (void)state;
    ost_error err = {0};
    ost_backend *backend;
    assert_int_equal(ost_backend_open("ref:threads=2", &backend, &err), OST_ERR_USAGE);
    assert_non_null(strstr(err.text, "threads"));
    assert_ok(ost_backend_open("ref:", &backend, &err));
    ost_backend_close(backend);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(worked_example_of_the_specification),
        cmocka_unit_test(density_beyond_int16_is_refused),
        cmocka_unit_test(limits_of_lattice_offsets),
        cmocka_unit_test(duplicate_samples),
        cmocka_unit_test(zero_density_counts_as_a_sample),
        cmocka_unit_test(every_sample_sets_its_voxel),
        cmocka_unit_test(resampling_to_finer_layers),
        cmocka_unit_test(resampling_to_coarser_layers),
        cmocka_unit_test(origins_round_half_to_even),
        cmocka_unit_test(seventh_digit_changes_at_most_one_rounding),
        cmocka_unit_test(means_round_once_and_half_to_even),
        cmocka_unit_test(means_are_between_their_inputs),
        cmocka_unit_test(equal_spacing_changes_nothing),
        cmocka_unit_test(the_thesis_tables),
        cmocka_unit_test(reference_has_no_options),
    };
    return run_on_backends(tests, open_test_backend, close_test_backend);
}
