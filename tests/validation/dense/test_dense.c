/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Compares the dense backend without a deviation with the reference: every grid, report, count
 * and digest of random scenes, with every chunk size.
 *
 * Covers: AR-CT-4..6, AR-CUB-2, AR-CUB-3, AR-CHK-1..4, AR-VOX-1..7, AR-MAP-4, AR-MAP-5, AR-REM-1..6, AR-CLS-1, AR-DIG-2
 */
#include "validation/dense/difference.h"

static void dense_equals_reference(void **state)
{
    (void)state;
    test_rng rng = rng_seeded("dense against ref");
    ost_error err = {0};
    ost_backend *ref, *dense;
    uint64_t hit = 0, touched = 0, leaks = 0;
    assert_ok(ost_backend_open("ref", &ref, &err));
    assert_ok(dense_open(NULL, &dense, &err));
    assert_string_equal(ost_backend_name(dense), "dense");
    for (int round = 0; round < 40; round++) {
        scene *s = make_scene(&rng, round % 8 == 7 ? EMPTY : VARIED);
        outcome *a = run_scene(s, ref, 0);
        for (int n = 16; n <= 64; n *= 2) {
            outcome *b = run_scene(s, dense, n);
            /* the reports have chunks of different sizes, so only totals and grids are compared */
            if (n != s->chunk_size) {
                assert_true(ost_digest_equal(&a->root, &b->root));
                for (int e = 0; e < EVENTS; e++) {
                    assert_int_equal(a->reports[e].total_voxels, b->reports[e].total_voxels);
                    assert_int_equal(a->reports[e].touched_voxels, b->reports[e].touched_voxels);
                    assert_memory_equal(a->reports[e].density, b->reports[e].density, sizeof a->reports[e].density);
                }
            } else {
                const difference f = first_difference(s, a, b);
                if (f.any)
                    fail_msg("round %d: first difference from the reference in stage %s, call %d, voxel (%d, %d, %d)%s",
                             round, deviation_stage_name(f.stage), (int)f.call, f.voxel[0], f.voxel[1], f.voxel[2],
                             f.report ? ", report" : "");
                for (int e = 0; e < EVENTS; e++) {
                    assert_same_report(&b->reports[e], &a->reports[e]);
                    hit += b->reports[e].total_voxels;
                    touched += b->reports[e].touched_voxels;
                }
                for (int i = 0; i < 2; i++) {
                    assert_int_equal(a->info[i].active_voxels, b->info[i].active_voxels);
                    assert_int_equal(a->info[i].active_chunks, b->info[i].active_chunks);
                    assert_int_equal(a->info[i].chunk_bytes, b->info[i].chunk_bytes);
                }
                leaks += b->voxelize.leaking_rows;
            }
            free_outcome(b);
        }
        free_outcome(a);
        free_scene(s);
    }
    assert_true(hit > 0 && touched > 0 && leaks > 0); /* the scenes must contain hits, touched voxels and open meshes */
    const deviation_record record = dense_record(dense);
    assert_int_equal(record.acted, 0);
    assert_int_equal(record.changed, 0);
    ost_backend_close(dense);
    ost_backend_close(ref);
}

/*
 * Tests invalid samples: positions off the lattice, outside the grid and beyond all valid
 * lengths; conflicting densities; and line numbers out of order.
 */
static void invalid_samples_are_reported(void **state)
{
    (void)state;
    test_rng rng = rng_seeded("bad samples");
    ost_error err = {0};
    const ost_geometry g = {
        .dims = {5, 4, 3}, .spacing = {470 * UM, 470 * UM, OST_PM_PER_MM}, .origin = {-57340 * UM, 0, 3}};
    ost_backend *backends[2];
    assert_ok(ost_backend_open("ref", &backends[0], &err));
    assert_ok(dense_open(NULL, &backends[1], &err));
    for (int round = 0; round < 300; round++) {
        ost_sample samples[40];
        for (int i = 0; i < 40; i++) {
            const int64_t off = rng_range(&rng, 0, 19) ? rng_range(&rng, -60, 60) * UM
                                                       : rng_range(&rng, -500, 500) * UM;
            samples[i] = (ost_sample){
                .x = g.origin.x + rng_range(&rng, 0, 4) * g.spacing.x + off,
                .y = g.origin.y + rng_range(&rng, 0, 3) * g.spacing.y + (rng_range(&rng, 0, 9) ? 0 : g.spacing.y / 8),
                .z = g.origin.z + rng_range(&rng, 0, 2) * g.spacing.z +
                     (rng_range(&rng, 0, 9) ? 0 : 3 * g.spacing.z / 8),
                .density = (int32_t)rng_range(&rng, 100, 103),
                .line = (uint32_t)rng_range(&rng, 0, 60),
            };
        }
        if (round % 7 == 0)
            samples[rng_range(&rng, 0, 39)].y = round % 14 ? OST_LENGTH_MAX + 1 : INT64_MIN;
        for (int rule = OST_DUPLICATES_ERROR; rule <= OST_DUPLICATES_MAX; rule++) {
            ost_scatter_report reports[2] = {{0}, {0}};
            int16_t *voxels[2];
            for (int b = 0; b < 2; b++) {
                ost_grid *grid;
                assert_ok(ost_grid_create(backends[b], &g, &grid, &err));
                assert_ok(ost_ct_to_rect(grid, samples, 17, 5, (ost_duplicates)rule, &reports[b], &err));
                assert_ok(ost_ct_to_rect(grid, samples + 17, 23, 70, (ost_duplicates)rule, &reports[b], &err));
                voxels[b] = all_of(grid);
                ost_grid_free(grid);
            }
            assert_true(same_scatter(&reports[0], &reports[1]));
            assert_memory_equal(voxels[0], voxels[1], voxel_count(&g) * sizeof *voxels[0]);
            free(voxels[0]);
            free(voxels[1]);
        }
    }
    ost_backend_close(backends[0]);
    ost_backend_close(backends[1]);
}

/*
 * A bone that is uploaded slice by slice, in any order, must equal a bone that is uploaded in one call.
 * Downloaded slices must equal the uploaded slices.
 */
static void slices_equal_complete_grid(void **state)
{
    (void)state;
    test_rng rng = rng_seeded("slices");
    ost_error err = {0};
    const ost_geometry g = cubic_geometry(33, 17, 21, 470 * UM, (ost_pm3){1, 2, 3});
    int16_t *voxels = random_densities(&rng, &g, 3);
    const size_t slice = (size_t)g.dims.x * (size_t)g.dims.y;
    ost_backend *ref, *dense;
    assert_ok(ost_backend_open("ref", &ref, &err));
    assert_ok(dense_open(NULL, &dense, &err));
    ost_bone *complete = bone_of(ref, &g, 16, voxels), *parts;
    assert_ok(ost_bone_create(dense, &g, 32, 120, &parts, &err));
    for (int32_t z = g.dims.z; z > 0;) {
        const int32_t count = (int32_t)rng_range(&rng, 1, z);
        z -= count;
        assert_ok(ost_bone_upload(parts, z, count, voxels + (size_t)z * slice, &err));
    }
    const ost_digest a = digest_of(complete), b = digest_of(parts);
    assert_true(ost_digest_equal(&a, &b));
    int16_t *one = malloc(slice * sizeof *one), *all = content(complete, &g);
    assert_non_null(one);
    for (int32_t z = 0; z < g.dims.z; z++) {
        assert_ok(ost_bone_download(parts, z, 1, one, &err));
        assert_memory_equal(one, all + (size_t)z * slice, slice * sizeof *one);
    }
    free(one);
    free(all);
    free(voxels);
    ost_bone_free(complete);
    ost_bone_free(parts);
    ost_backend_close(ref);
    ost_backend_close(dense);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(dense_equals_reference),
        cmocka_unit_test(invalid_samples_are_reported),
        cmocka_unit_test(slices_equal_complete_grid),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
