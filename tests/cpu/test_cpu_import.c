/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Compares the results of importing on the backends cpu and ref, byte by byte. Grids, spacings, thresholds and chunk
 * sizes are random. The tests use every instruction set of this machine, and 1, 2, 3 and 7 threads.
 * Covers: AR-CT-4, AR-CT-5, AR-CT-6, AR-CUB-1, AR-CUB-2, AR-CUB-3, AR-CHK-1, AR-CHK-2, AR-CHK-3, AR-DIG-2
 */
#include "harness.h"

#include <osteon/backend.h>

#include "core/backend.h"
#include "core/chunk_grid.h"
#include "core/isa.h"
#include "cpu/bone/bone.h"
#include "cpu/ref/ref.h"

static const int threads_of[] = {1, 2, 3, 7};
static const int chunk_of[] = {16, 32, 64};

/* Opens the backend with the next instruction set and thread count that this machine supports. */
static ost_backend *open_next(unsigned *turn)
{
    ost_error err = {0};
    ost_backend *backend;
    ost_isa isa;
    do
        isa = (ost_isa)(*turn / 4 % OST_ISA_COUNT);
    while (!ost_isa_available(isa) && (*turn += 4));
    char spec[64];
    snprintf(spec, sizeof spec, "cpu:isa=%s,threads=%d", ost_isa_name(isa), threads_of[*turn % 4]);
    ++*turn;
    assert_ok(ost_backend_open(spec, &backend, &err));
    return backend;
}

static ost_backend *open_ref(void)
{
    ost_error err = {0};
    ost_backend *backend;
    assert_ok(ost_backend_open("ref", &backend, &err));
    return backend;
}

static int16_t *random_voxels(test_rng *rng, int64_t count, int32_t threshold)
{
    int16_t *voxels = malloc((size_t)count * sizeof *voxels);
    assert_non_null(voxels);
    /* The array consists of runs of four kinds: zeros, arbitrary values, values near the threshold, and INT16_MIN. */
    int kind = 0;
    for (int64_t i = 0, left = 0; i < count; i++, left--) {
        if (left == 0) {
            left = rng_range(rng, 1, 9000);
            kind = (int)rng_range(rng, 0, 3);
        }
        int64_t v = kind == 0   ? 0
                    : kind == 1 ? rng_range(rng, INT16_MIN, INT16_MAX)
                                : rng_range(rng, threshold - 2, threshold + 1);
        voxels[i] = (int16_t)(kind == 3 ? INT16_MIN : v);
    }
    return voxels;
}

static int16_t *download_grid(const ost_grid *grid)
{
    ost_error err = {0};
    const ost_geometry *g = ost_grid_geometry(grid);
    int16_t *voxels = malloc((size_t)ost_dims_count(g->dims) * sizeof *voxels);
    assert_non_null(voxels);
    assert_ok(ost_grid_download(grid, 0, g->dims.z, voxels, &err));
    return voxels;
}

static void assert_equal_grids(const ost_grid *a, const ost_grid *b)
{
    assert_true(ost_geometry_equal(ost_grid_geometry(a), ost_grid_geometry(b)));
    int16_t *va = download_grid(a), *vb = download_grid(b);
    assert_memory_equal(va, vb, (size_t)ost_dims_count(ost_grid_geometry(a)->dims) * sizeof *va);
    free(va);
    free(vb);
}

/* Compares memory use, counts, downloaded voxels and digests; the internal layout may differ between backends. */
static void assert_equal_bones(const ost_bone *a, const ost_bone *b)
{
    ost_error err = {0};
    ost_bone_info ia, ib;
    assert_ok(ost_bone_info_get(a, &ia, &err));
    assert_ok(ost_bone_info_get(b, &ib, &err));
    assert_int_equal(ia.active_chunks, ib.active_chunks);
    assert_int_equal(ia.active_voxels, ib.active_voxels);
    assert_int_equal(ia.chunk_bytes, ib.chunk_bytes);
    ost_dims dims = ia.geometry.dims;
    size_t bytes = (size_t)ost_dims_count(dims) * sizeof(int16_t);
    int16_t *va = malloc(bytes), *vb = malloc(bytes);
    ost_digest da, db;
    assert_non_null(va);
    assert_non_null(vb);
    assert_ok(ost_bone_download(a, 0, dims.z, va, &err));
    assert_ok(ost_bone_download(b, 0, dims.z, vb, &err));
    assert_memory_equal(va, vb, bytes);
    assert_ok(ost_bone_digest(a, NULL, &da, &err));
    assert_ok(ost_bone_digest(b, NULL, &db, &err));
    assert_memory_equal(&da, &db, sizeof da);
    free(va);
    free(vb);
}

/* Checks that chunks made from a grid equal chunks made by uploading the grid's slices, including padding and
   occupancy. */
static void assert_equal_chunks(const ost_bone *made, const ost_grid *cube)
{
    ost_error err = {0};
    ost_bone *other;
    int16_t *voxels = download_grid(cube);
    assert_ok(ost_bone_create(made->backend, &made->geometry, made->chunk_size, made->threshold, &other, &err));
    assert_ok(ost_bone_upload(other, 0, made->geometry.dims.z, voxels, &err));
    free(voxels);
    const cpu_bone *x = (const cpu_bone *)made, *y = (const cpu_bone *)other;
    assert_int_equal(x->count, y->count);
    for (int64_t i = 0; i < x->count; i++) {
        assert_int_equal(x->chunks[i].active, y->chunks[i].active);
        assert_int_equal(x->chunks[i].density != NULL, y->chunks[i].density != NULL);
        if (!x->chunks[i].density)
            continue;
        assert_int_equal((uintptr_t)x->chunks[i].density % 64, 0);
        assert_int_equal(x->chunks[i].highest, y->chunks[i].highest);
        assert_memory_equal(x->chunks[i].density, y->chunks[i].density, ost_chunk_bytes(made->chunk_size));
    }
    ost_bone_free(other);
}

static void rect_to_cubic_to_chunks(void **state)
{
    (void)state;
    test_rng rng = rng_seeded("rect to cubic to chunks");
    ost_error err = {0};
    ost_backend *ref = open_ref();
    unsigned turn = 0;
    for (int round = 0; round < 120; round++) {
        int32_t most = round % 8 == 0 ? 160 : 70;
        const ost_pm mm = OST_PM_PER_MM;
        const ost_pm steps[] = {mm * 47 / 100, mm, mm / 3, mm * 3 / 10, mm * 29 / 10};
        ost_geometry g = {
            .dims = {(int32_t)rng_range(&rng, 1, most), (int32_t)rng_range(&rng, 1, most),
                     (int32_t)rng_range(&rng, 1, most)},
            .spacing = {steps[rng_range(&rng, 0, 3)], steps[rng_range(&rng, 0, 3)], steps[rng_range(&rng, 0, 3)]},
            .origin = {rng_range(&rng, -mm, mm), 0, 7},
        };
        ost_pm cubic = round % 2 ? g.spacing.x : steps[rng_range(&rng, 0, 4)];
        ost_resample rule = (ost_resample)rng_range(&rng, 0, 2);
        int32_t threshold = round % 5 == 0 ? 1 : round % 5 == 1 ? INT16_MAX : (int32_t)rng_range(&rng, 1, 2000);
        int n = chunk_of[rng_range(&rng, 0, 2)];
        int16_t *voxels = random_voxels(&rng, ost_dims_count(g.dims), threshold);
        ost_backend *backends[2] = {ref, open_next(&turn)};
        ost_grid *rect[2], *cube[2], *again[2];
        ost_bone *bone[2];
        for (int b = 0; b < 2; b++) {
            assert_ok(ost_grid_create(backends[b], &g, &rect[b], &err));
            assert_ok(ost_grid_upload(rect[b], 0, g.dims.z, voxels, &err));
            assert_ok(ost_rect_to_cubic(rect[b], cubic, rule, &cube[b], &err));
            /* Changing the rect grid afterwards must not change the cubic grid. */
            assert_ok(
                ost_grid_upload(rect[b], 0, 1, voxels + ost_dims_count(g.dims) / g.dims.z * (g.dims.z - 1), &err));
            assert_ok(ost_cubic_to_chunks(cube[b], n, threshold, &bone[b], &err));
        }
        assert_equal_grids(rect[0], rect[1]);
        assert_equal_grids(cube[0], cube[1]);
        assert_equal_bones(bone[0], bone[1]);
        assert_equal_chunks(bone[1], cube[1]);
        for (int b = 0; b < 2; b++) {
            ost_grid_free(rect[b]); /* The cubic grid must remain valid. */
            assert_ok(ost_rect_to_cubic(cube[b], cubic * 2, rule, &again[b], &err));
            ost_bone_free(bone[b]);
            assert_ok(ost_cubic_to_chunks(again[b], n, threshold, &bone[b], &err));
            /*
             * A slice is written unless it is larger than the array of random voxels. It is sufficient that
             * some rounds write a slice.
             */
            int64_t slice = (int64_t)ost_grid_geometry(again[b])->dims.x * ost_grid_geometry(again[b])->dims.y;
            if (slice <= ost_dims_count(g.dims))
                assert_ok(ost_grid_upload(again[b], 0, 1, voxels, &err));
        }
        assert_equal_grids(again[0], again[1]);
        assert_equal_grids(cube[0], cube[1]);
        assert_equal_bones(bone[0], bone[1]);
        for (int b = 0; b < 2; b++) {
            ost_grid_free(again[b]);
            ost_grid_free(cube[b]);
            ost_bone_free(bone[b]);
        }
        ost_backend_close(backends[1]);
        free(voxels);
    }
    ost_backend_close(ref);
}

/*
 * Returns voxels with densities from -1 to 1. A few voxels are at the threshold or at the maximum density, so that
 * interpolated means may also be active.
 */
static int16_t *sparse_voxels(test_rng *rng, int64_t count, int32_t threshold)
{
    int16_t *voxels = malloc((size_t)count * sizeof *voxels);
    assert_non_null(voxels);
    const int64_t one_in = rng_range(rng, 1, count + 1);
    for (int64_t i = 0; i < count; i++)
        voxels[i] = (int16_t)(rng_range(rng, 1, one_in) > 1 ? rng_range(rng, -1, 1)
                              : rng_range(rng, 0, 1)        ? threshold
                                                            : INT16_MAX);
    return voxels;
}

/*
 * Tests the linear rule along z only, along two axes and along three axes. Spacings are nearly equal or very different,
 * and some grids have one voxel along an axis. Few voxels are active, so that some chunks that can be skipped are next
 * to chunks that must be processed.
 */
static void interpolated_to_chunks(void **state)
{
    (void)state;
    test_rng rng = rng_seeded("interpolated to chunks");
    ost_error err = {0};
    ost_backend *ref = open_ref();
    unsigned turn = 0;
    for (int round = 0; round < 160; round++) {
        const ost_pm x = rng_range(&rng, 300, 1500) * (OST_PM_PER_MM / 1000), nearly = x + rng_range(&rng, -2, 2);
        const ost_pm any = rng_range(&rng, 300, 3000) * (OST_PM_PER_MM / 1000);
        ost_geometry g = {
            .dims = {(int32_t)rng_range(&rng, 1, 70), (int32_t)rng_range(&rng, 1, 70), (int32_t)rng_range(&rng, 1, 30)},
            .spacing = {x, round % 4 == 3 ? any : round % 4 == 2 ? nearly : x, round % 8 == 0 ? nearly : any},
        };
        const ost_pm cubic = round % 2   ? x
                             : round % 4 ? g.spacing.z
                                         : rng_range(&rng, 400, 4000) * (OST_PM_PER_MM / 1000);
        const int32_t threshold = round % 5 == 0 ? 1 : round % 5 == 1 ? INT16_MAX : (int32_t)rng_range(&rng, 1, 2000);
        const int n = chunk_of[rng_range(&rng, 0, 2)];
        int16_t *voxels = round % 3 ? sparse_voxels(&rng, ost_dims_count(g.dims), threshold)
                                    : random_voxels(&rng, ost_dims_count(g.dims), threshold);
        ost_backend *backends[2] = {ref, open_next(&turn)};
        ost_grid *rect[2], *cube[2];
        ost_bone *bone[2];
        for (int b = 0; b < 2; b++) {
            assert_ok(ost_grid_create(backends[b], &g, &rect[b], &err));
            assert_ok(ost_grid_upload(rect[b], 0, g.dims.z, voxels, &err));
            assert_ok(ost_rect_to_cubic(rect[b], cubic, OST_RESAMPLE_LINEAR, &cube[b], &err));
            assert_ok(ost_cubic_to_chunks(cube[b], n, threshold, &bone[b], &err));
        }
        assert_equal_bones(bone[0], bone[1]);
        assert_equal_chunks(bone[1], cube[1]);
        assert_equal_grids(cube[0], cube[1]);
        for (int b = 0; b < 2; b++) {
            ost_grid_free(rect[b]);
            ost_grid_free(cube[b]);
            ost_bone_free(bone[b]);
        }
        ost_backend_close(backends[1]);
        free(voxels);
    }
    ost_backend_close(ref);
}

static void repeated_uploads_of_slabs(void **state)
{
    (void)state;
    test_rng rng = rng_seeded("slabs over slabs");
    ost_error err = {0};
    ost_backend *ref = open_ref();
    unsigned turn = 0;
    for (int round = 0; round < 48; round++) {
        ost_geometry g = {
            .dims = {(int32_t)rng_range(&rng, 1, 150), (int32_t)rng_range(&rng, 1, 60),
                     (int32_t)rng_range(&rng, 1, 90)},
            .spacing = {OST_PM_PER_MM, OST_PM_PER_MM, OST_PM_PER_MM},
        };
        int32_t threshold = (int32_t)rng_range(&rng, 1, 500);
        int n = chunk_of[rng_range(&rng, 0, 2)];
        ost_backend *backends[2] = {ref, open_next(&turn)};
        ost_bone *bone[2];
        for (int b = 0; b < 2; b++)
            assert_ok(ost_bone_create(backends[b], &g, n, threshold, &bone[b], &err));
        int64_t slice = (int64_t)g.dims.x * g.dims.y;
        for (int i = 0; i < 6; i++) {
            int32_t z0 = (int32_t)rng_range(&rng, 0, g.dims.z), count = (int32_t)rng_range(&rng, 0, g.dims.z - z0);
            int16_t *voxels = random_voxels(&rng, slice * count + 1, threshold);
            if (i == 4) /* An upload of zeros empties these slices again. */
                memset(voxels, 0, (size_t)(slice * count) * sizeof *voxels);
            for (int b = 0; b < 2; b++)
                assert_ok(ost_bone_upload(bone[b], z0, count, voxels, &err));
            assert_equal_bones(bone[0], bone[1]);
            free(voxels);
        }
        for (int b = 0; b < 2; b++)
            ost_bone_free(bone[b]);
        ost_backend_close(backends[1]);
    }
    ost_backend_close(ref);
}

static void samples_to_rect(void **state)
{
    (void)state;
    test_rng rng = rng_seeded("samples to rect");
    ost_error err = {0};
    ost_backend *ref = open_ref();
    unsigned turn = 0;
    enum { MOST = 150000 };
    ost_sample *samples = malloc(MOST * sizeof *samples);
    assert_non_null(samples);
    for (int round = 0; round < 32; round++) {
        const ost_pm spacings[] = {OST_SPACING_MIN, 470000000, OST_PM_PER_MM / 3, OST_SPACING_MAX};
        const ost_pm s[3] = {spacings[rng_range(&rng, 0, 3)], spacings[rng_range(&rng, 0, 3)],
                             spacings[rng_range(&rng, 0, 3)]};
        ost_geometry g = {
            .dims = {(int32_t)rng_range(&rng, 1, 40), (int32_t)rng_range(&rng, 1, 40), (int32_t)rng_range(&rng, 1, 40)},
            .spacing = {s[0], s[1], s[2]},
            .origin = {rng_range(&rng, -4, 3) * OST_PM_PER_MM * 1000, rng_range(&rng, -1000, 1000), -OST_PM_PER_MM},
        };
        const int32_t dims[3] = {g.dims.x, g.dims.y, g.dims.z};
        const ost_pm origin[3] = {g.origin.x, g.origin.y, g.origin.z};
        bool wild = round % 4 == 0;
        ost_duplicates duplicates = (ost_duplicates)(round / 4 % 4);
        ost_scatter_report report[2] = {{0}, {0}};
        ost_backend *backends[2] = {ref, open_next(&turn)};
        ost_grid *grid[2];
        for (int b = 0; b < 2; b++)
            assert_ok(ost_grid_create(backends[b], &g, &grid[b], &err));
        int64_t line = 1;
        for (int batch = 0; batch < 3; batch++) {
            size_t count = (size_t)rng_range(&rng, 0, batch == 1 ? MOST : 300);
            for (size_t i = 0; i < count; i++) {
                ost_pm p[3];
                for (int a = 0; a < 3; a++) {
                    p[a] = origin[a] + rng_range(&rng, wild ? -1 : 0, dims[a] - !wild) * s[a];
                    /*
                     * The offset from the lattice point is 0 in three of seven cases; otherwise, it is 1/8, 1/4, 3/8
                     * or 1/2 of a voxel in either direction. In addition, the position is changed by -1, 0 or 1 pm.
                     */
                    const int eighths[] = {0, 0, 0, 1, 1, wild ? 4 : 2, wild ? 3 : 1};
                    p[a] += eighths[rng_range(&rng, 0, 6)] * s[a] / 8 * (rng_range(&rng, 0, 1) ? 1 : -1) +
                            rng_range(&rng, -1, 1);
                }
                samples[i] = (ost_sample){.x = p[0], .y = p[1], .z = p[2], .density = (int32_t)rng_range(&rng, -3, 3)};
                if (wild && i % 1000 == 999)
                    samples[i].y = rng_range(&rng, 0, 1) ? INT64_MAX : INT64_MIN;
                /* Two samples may have the same line number. */
                samples[i].line = (uint32_t)(i / (size_t)rng_range(&rng, 1, 2));
            }
            for (int b = 0; b < 2; b++)
                assert_ok(ost_ct_to_rect(grid[b], samples, count, line, duplicates, &report[b], &err));
            line += (int64_t)count;
            const ost_scatter_report *x = &report[0], *y = &report[1];
            assert_int_equal(x->samples, y->samples);
            assert_int_equal(x->duplicates, y->duplicates);
            assert_int_equal(x->off_lattice, y->off_lattice);
            assert_int_equal(x->worst_offset_ppm, y->worst_offset_ppm);
            assert_int_equal(x->worst_line, y->worst_line);
            assert_int_equal(x->rejected_line, y->rejected_line);
            assert_int_equal(x->conflict_line, y->conflict_line);
            assert_int_equal(x->conflict_had, y->conflict_had);
            assert_int_equal(x->conflict_has, y->conflict_has);
            assert_equal_grids(grid[0], grid[1]);
        }
        for (int b = 0; b < 2; b++)
            ost_grid_free(grid[b]);
        ost_backend_close(backends[1]);
    }
    free(samples);
    ost_backend_close(ref);
}

/* A block in use must keep its content, in whatever order blocks are allocated, freed and trimmed. */
static void blocks_keep_their_content(void **state)
{
    (void)state;
    test_rng rng = rng_seeded("chunk pool");
    enum { BYTES = 8704, MOST = 700 };
    ost_chunk_pool *pool = ost_chunk_pool_open(BYTES);
    assert_non_null(pool);
    unsigned char *block[MOST] = {NULL};
    for (int round = 0; round < 200; round++) {
        int from = (int)rng_range(&rng, 0, MOST - 1), to = (int)rng_range(&rng, from, MOST);
        assert_true(ost_chunk_pool_reserve(pool, to - from));
        for (int i = from; i < to; i++)
            if (!block[i] && rng_range(&rng, 0, 2)) {
                block[i] = ost_chunk_pool_take(pool);
                assert_non_null(block[i]);
                assert_int_equal((uintptr_t)block[i] % 64, 0);
                memset(block[i], i % 255 + 1, BYTES);
            }
        for (int i = from; i < to; i++)
            if (block[i] && rng_range(&rng, 0, 3) == 0) {
                ost_chunk_pool_give(pool, block[i]);
                block[i] = NULL;
            }
        ost_chunk_pool_trim(pool);
        for (int i = 0; i < MOST; i++)
            if (block[i] && (block[i][0] != i % 255 + 1 || memcmp(block[i], block[i] + 1, BYTES - 1) != 0))
                fail_msg("round %d: block %d has changed", round, i);
    }
    for (int i = 0; i < MOST; i++)
        if (block[i])
            ost_chunk_pool_give(pool, block[i]);
    ost_chunk_pool_close(pool);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(blocks_keep_their_content),
        cmocka_unit_test(rect_to_cubic_to_chunks),
        cmocka_unit_test(interpolated_to_chunks),
        cmocka_unit_test(repeated_uploads_of_slabs),
        cmocka_unit_test(samples_to_rect),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
