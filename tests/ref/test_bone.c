/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests uploads and downloads of slices, the threshold, leaves, digests and memory of bones.
 * Covers: AR-CHK-1, AR-CHK-2, AR-CHK-3, AR-CHK-4, AR-DIG-2, AR-LAW-1
 */
#include "ref/scene.h"

#include "core/chunk_grid.h"

static const int sizes[] = {16, 32, 64};

/* The dimensions are not multiples of 16, so that chunks and leaves extend beyond the grid. */
static ost_geometry odd_geometry(void)
{
    return cubic_geometry(70, 37, 41, 470 * UM, (ost_pm3){1, 2, 3});
}

static void apply_threshold(int16_t *voxels, const ost_geometry *g)
{
    for (size_t i = 0; i < voxel_count(g); i++)
        voxels[i] = voxels[i] >= 120 ? voxels[i] : 0;
}

static void download_equals_upload(void **state)
{
    ost_error err = {0};
    test_rng rng = rng_seeded("slices");
    ost_geometry g = odd_geometry();
    int16_t *voxels = random_densities(&rng, &g, 4);
    for (int s = 0; s < 3; s++) {
        ost_bone *bone;
        assert_ok(ost_bone_create(*state, &g, sizes[s], 120, &bone, &err));
        size_t slice = (size_t)g.dims.x * (size_t)g.dims.y;
        for (int32_t z = 0; z < g.dims.z;) { /* The bone is uploaded in slabs of different sizes. */
            int32_t count = (int32_t)rng_range(&rng, 0, g.dims.z - z);
            assert_ok(ost_bone_upload(bone, z, count, voxels + slice * (size_t)z, &err));
            z += count;
        }
        int16_t *down = content(bone, &g);
        int16_t *expected = malloc(voxel_count(&g) * sizeof *expected);
        memcpy(expected, voxels, voxel_count(&g) * sizeof *expected);
        apply_threshold(expected, &g);
        assert_same_voxels(down, expected, &g);
        assert_ok(ost_bone_download(bone, 17, 3, down, &err));
        assert_memory_equal(down, expected + 17 * slice, 3 * slice * sizeof *down);
        free(expected);
        free(down);
        ost_bone_free(bone);
    }
    free(voxels);
}

static void import_and_upload_agree(void **state)
{
    ost_error err = {0};
    test_rng rng = rng_seeded("import");
    ost_geometry g = odd_geometry();
    int16_t *voxels = random_densities(&rng, &g, 2);
    ost_grid *cubic;
    assert_ok(ost_grid_create(*state, &g, &cubic, &err));
    assert_ok(ost_grid_upload(cubic, 0, g.dims.z, voxels, &err));
    for (int s = 0; s < 3; s++) {
        ost_bone *imported, *uploaded = bone_of(*state, &g, sizes[s], voxels);
        assert_ok(ost_cubic_to_chunks(cubic, sizes[s], 120, &imported, &err));
        ost_digest a = digest_of(imported), b = digest_of(uploaded);
        assert_true(ost_digest_equal(&a, &b));
        ost_bone_free(imported);
        ost_bone_free(uploaded);
    }
    ost_grid_free(cubic);
    free(voxels);
}

static void the_threshold_is_inclusive(void **state)
{
    ost_error err = {0};
    ost_geometry g = cubic_geometry(4, 1, 1, OST_PM_PER_MM, (ost_pm3){0, 0, 0});
    const int16_t voxels[] = {119, 120, -1000, 32767};
    ost_bone *bone = bone_of(*state, &g, 16, voxels);
    int16_t *down = content(bone, &g);
    assert_int_equal(down[0], 0);
    assert_int_equal(down[1], 120);
    assert_int_equal(down[2], 0);
    assert_int_equal(down[3], 32767);
    ost_bone_info info;
    assert_ok(ost_bone_info_get(bone, &info, &err));
    assert_int_equal(info.active_voxels, 2);
    assert_int_equal(info.active_chunks, 1);
    assert_int_equal(info.chunk_bytes, 16 * 16 * 16 * 2 + 16 * 16 * 16 / 8);
    free(down);
    ost_bone_free(bone);
}

static void chunk_size_does_not_change_the_digest(void **state)
{
    ost_error err = {0};
    test_rng rng = rng_seeded("chunk size");
    ost_geometry g = odd_geometry();
    for (int share = 0; share <= 8; share += 4) { /* no voxel, half of the voxels, or all voxels are active */
        int16_t *voxels = random_densities(&rng, &g, share);
        ost_digest leaves[3][3 * 2 * 2], roots[3];
        for (int s = 0; s < 3; s++) {
            ost_bone *bone = bone_of(*state, &g, sizes[s], voxels);
            assert_ok(ost_bone_digest(bone, leaves[s], &roots[s], &err));
            ost_bone_free(bone);
        }
        for (int s = 1; s < 3; s++) {
            assert_memory_equal(leaves[0], leaves[s], sizeof leaves[0]);
            assert_true(ost_digest_equal(&roots[0], &roots[s]));
        }
        free(voxels);
    }
}

static void leaves_equal_those_of_the_dense_grid(void **state)
{
    /* Each leaf is copied voxel by voxel from the dense grid and hashed separately. The bone has only one active
       voxel. */
    ost_error err = {0};
    test_rng rng = rng_seeded("leaves");
    ost_geometry g = odd_geometry();
    int16_t *voxels = random_densities(&rng, &g, 0);
    voxels[33 + 70 * (5 + 37 * 40)] = 777;
    ost_bone *bone = bone_of(*state, &g, 16, voxels);
    apply_threshold(voxels, &g);
    ost_digest leaves[3 * 2 * 2];
    assert_ok(ost_bone_digest(bone, leaves, NULL, &err));
    int16_t *leaf = malloc(OST_LEAF * OST_LEAF * OST_LEAF * sizeof *leaf);
    for (int l = 0; l < 3 * 2 * 2; l++) {
        int lx = l % 3, ly = l / 3 % 2, lz = l / 6;
        for (int v = 0; v < OST_LEAF * OST_LEAF * OST_LEAF; v++) {
            int x = lx * 32 + v % 32, y = ly * 32 + v / 32 % 32, z = lz * 32 + v / 1024;
            leaf[v] = x < 70 && y < 37 && z < 41 ? voxels[x + 70 * (y + 37 * z)] : 0;
        }
        ost_digest expected;
        assert_ok(ost_digest_leaf16(leaf, &expected, &err));
        assert_true(ost_digest_equal(&expected, &leaves[l]));
    }
    free(leaf);
    free(voxels);
    ost_bone_free(bone);
}

static void memory_depends_on_active_chunks(void **state)
{
    ost_error err = {0};
    ost_geometry g = odd_geometry();
    size_t slice = (size_t)g.dims.x * (size_t)g.dims.y;
    int16_t *voxels = calloc(voxel_count(&g), sizeof *voxels);
    voxels[slice * 20 + 5] = 500;
    for (int s = 0; s < 3; s++) {
        ost_bone *bone = bone_of(*state, &g, sizes[s], voxels);
        ost_bone_info info;
        assert_ok(ost_bone_info_get(bone, &info, &err));
        assert_int_equal(info.active_chunks, 1);
        assert_int_equal(info.active_voxels, 1);
        int16_t *zeros = calloc(slice, sizeof *zeros);
        assert_ok(ost_bone_upload(bone, 20, 1, zeros, &err));
        assert_ok(ost_bone_info_get(bone, &info, &err));
        assert_int_equal(info.active_chunks, 0);
        assert_int_equal(info.chunk_bytes, 0);
        free(zeros);
        ost_bone_free(bone);
    }
    free(voxels);
}

/*
 * Other tests derive memory sizes from the counts of active voxels. This test examines the chunks directly:
 * memory may be allocated only for a chunk with an active voxel.
 */
static void empty_chunks_have_no_memory(void **state)
{
    (void)state;
    ost_error err = {0};
    const ost_geometry g = odd_geometry();
    const size_t slice = (size_t)g.dims.x * (size_t)g.dims.y;
    int16_t *voxels = calloc(slice, sizeof *voxels);
    for (int s = 0; s < 3; s++) {
        ost_chunk_grid grid;
        assert_ok(ost_chunk_grid_init(&grid, g.dims, sizes[s], 120, &err));
        /* In step 0, all voxels are below the threshold. In step 1, one voxel is at the threshold. In step 2, all
           voxels are below the threshold again. */
        for (int step = 0; step < 3; step++) {
            int64_t allocated = 0;
            voxels[5] = (int16_t)(step == 1 ? 120 : step == 0 ? 119 : 0);
            assert_ok(ost_chunk_grid_upload(&grid, 20, 1, voxels, &err));
            for (int64_t i = 0; i < grid.count; i++)
                allocated += grid.chunks[i].density != NULL;
            assert_int_equal(allocated, step == 1);
        }
        ost_chunk_grid_free(&grid);
    }
    free(voxels);
}

static void occupancy_equals_the_active_voxels(void **state)
{
    (void)state;
    ost_error err = {0};
    test_rng rng = rng_seeded("occupancy");
    ost_geometry g = odd_geometry();
    int16_t *voxels = random_densities(&rng, &g, 3);
    for (int s = 0; s < 3; s++) {
        ost_chunk_grid grid;
        int n = sizes[s];
        assert_ok(ost_chunk_grid_init(&grid, g.dims, n, 120, &err));
        assert_ok(ost_chunk_grid_upload(&grid, 0, g.dims.z, voxels, &err));
        for (int64_t c = 0; c < grid.count; c++) {
            const ost_chunk *chunk = &grid.chunks[c];
            int active = 0;
            for (int v = 0; chunk->density && v < n * n * n; v++) {
                int x = (int)(c % grid.chunk_dims.x) * n + v % n,
                    y = (int)(c / grid.chunk_dims.x % grid.chunk_dims.y) * n + v / n % n,
                    z = (int)(c / grid.chunk_dims.x / grid.chunk_dims.y) * n + v / n / n;
                bool expected = x < 70 && y < 37 && z < 41 && voxels[x + 70 * (y + 37 * z)] >= 120;
                bool bit = chunk->occupancy[v / 32] >> (v % 32) & 1;
                assert_int_equal(bit, expected);
                assert_int_equal(chunk->density[v] != 0, expected);
                active += expected;
            }
            assert_int_equal(chunk->active, active);
            assert_int_equal(chunk->density != NULL, active > 0);
        }
        ost_chunk_grid_free(&grid);
    }
    free(voxels);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(download_equals_upload),
        cmocka_unit_test(import_and_upload_agree),
        cmocka_unit_test(the_threshold_is_inclusive),
        cmocka_unit_test(chunk_size_does_not_change_the_digest),
        cmocka_unit_test(leaves_equal_those_of_the_dense_grid),
        cmocka_unit_test(memory_depends_on_active_chunks),
        cmocka_unit_test(empty_chunks_have_no_memory),
        cmocka_unit_test(occupancy_equals_the_active_voxels),
    };
    return run_on_backends(tests, open_test_backend, close_test_backend);
}
