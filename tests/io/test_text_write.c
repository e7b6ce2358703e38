/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests writing volumes as text: the bytes of the file, reading the file back, full disks, and a writing process that
 * is killed.
 *
 * Covers: AR-CT-8, AR-FILE-7, AR-FILE-8
 */
#include "backends.h"

#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>

#include <osteon/io.h>

#include "io/text/write.h"
#include "io/scratch_group.h"

/* Returns options for a text with the given number of decimal places. The options are valid until the next call. */
static const ost_write_options *with_decimals(int decimals)
{
    static ost_write_options options;
    options.text_decimals = decimals;
    return &options;
}

static char path[600];

static int set_up(void **state)
{
    scratch_set_up(state);
    snprintf(path, sizeof path, "%s/out.txt", folder);
    return 0;
}

static void writes_the_expected_bytes(void **state)
{
    (void)state;
    ost_error err = {0};
    int16_t voxels[] = {-32768, -1, 0, 32767, 10, 120, -100, 9};
    ost_volume volume = {
        .geometry = {{2, 2, 2}, {470000000, 500000000, 1000000000}, {-470000000, -1000000000, 7999000000000}},
        .voxels = voxels,
    };
    /* "dims" and "spacing_mm" are properties of the grid and must not be written as facts */
    assert_ok(ost_meta_set(&volume.meta, "dims", "5 5 5", &err));
    assert_ok(ost_meta_set(&volume.meta, "spacing_mm", "3 3 3", &err));
    assert_ok(ost_meta_set(&volume.meta, OST_META_SIDE, " left ", &err));
    assert_ok(ost_meta_set(&volume.meta, "origin_mm", "3 3 3", &err));
    assert_ok(ost_text_write_volume(path, &volume, with_decimals(0), &err));
    char *text = scratch_read(path, NULL);
    assert_string_equal(text, "# osteon dims: 2 2 2\n"
                              "# osteon spacing_mm: 0.47 0.5 1\n"
                              "# osteon origin_mm: -0.47 -1 7999\n"
                              "# osteon side: left\n"
                              "-0.47 -1.00 7999.00 -32768\n"
                              "0.00 -1.00 7999.00 -1\n"
                              "-0.47 -0.50 7999.00 0\n"
                              "0.00 -0.50 7999.00 32767\n"
                              "-0.47 -1.00 8000.00 10\n"
                              "0.00 -1.00 8000.00 120\n"
                              "-0.47 -0.50 8000.00 -100\n"
                              "0.00 -0.50 8000.00 9\n");
    free(text);
    /* With one decimal place, values are rounded half to even, and zero has no minus sign. */
    volume.geometry = (ost_geometry){{2, 1, 1}, {450000000, 500000000, 1000000000}, {-450000000, -20000000, 350000000}};
    assert_ok(ost_text_write_volume(path, &volume, with_decimals(1), &err));
    text = scratch_read(path, NULL);
    assert_non_null(strstr(text, "\n-0.4 0.0 0.4 -32768\n0.0 0.0 0.4 -1\n"));
    free(text);
    /* Integer millimetres are written without a decimal point. */
    volume.geometry = (ost_geometry){{1, 1, 1}, {1000000000, 1000000000, 1000000000}, {-3000000000, 0, 12000000000}};
    assert_ok(ost_text_write_volume(path, &volume, with_decimals(0), &err));
    text = scratch_read(path, NULL);
    assert_non_null(strstr(text, "\n-3 0 12 -32768\n"));
    free(text);
}

static void too_few_decimals_are_refused(void **state)
{
    (void)state;
    ost_error err = {0};
    int16_t voxel = 1;
    ost_volume volume = {.geometry = {{1, 1, 1}, {470000000, 32000000, 1000000000}, {0, 0, 0}}, .voxels = &voxel};
    assert_int_equal(ost_text_write_volume(path, &volume, with_decimals(2), &err), OST_ERR_USAGE);
    assert_non_null(strstr(err.text, "2 decimals are too few for voxels of 0.032 mm"));
    assert_int_equal(ost_text_write_volume(path, &volume, with_decimals(10), &err), OST_ERR_USAGE);
    assert_int_equal(ost_text_write_volume(path, &volume, with_decimals(-1), &err), OST_ERR_USAGE);
    assert_ok(ost_text_write_volume(path, &volume, with_decimals(3), &err));
}

/* For any volume and any number of decimals the import must restore geometry and densities. */
static void import_restores_the_written_volume(void **state)
{
    (void)state;
    test_rng rng = rng_seeded("import_restores_the_written_volume");
    ost_error err = {0};
    ost_backend *backend;
    assert_ok(ost_backend_open(test_backend, &backend, &err));
    for (int round = 0; round < 60; round++) {
        ost_geometry g = {
            .dims = {(int32_t)rng_range(&rng, 1, 20), (int32_t)rng_range(&rng, 1, 20), (int32_t)rng_range(&rng, 1, 20)},
            .spacing = {rng_range(&rng, 50000000, 3000000000), rng_range(&rng, 50000000, 3000000000),
                        rng_range(&rng, 50000000, 3000000000)},
            .origin = {rng_range(&rng, -500000000000, 500000000000), rng_range(&rng, -500000000000, 500000000000),
                       rng_range(&rng, -500000000000, 500000000000)},
        };
        ost_volume volume;
        assert_ok(ost_volume_init(&volume, &g, &err));
        int64_t count = ost_dims_count(g.dims);
        for (int64_t i = 0; i < count; i++)
            volume.voxels[i] = (int16_t)rng_range(&rng, INT16_MIN, INT16_MAX);
        int decimals = (int)rng_range(&rng, 2, 9);
        assert_ok(ost_text_write_volume(path, &volume, with_decimals(decimals), &err));
        ost_bone *bone;
        ost_import_result result;
        assert_ok(ost_import(backend, path, &(ost_import_options){.digests = true}, &bone, &result, &err));
        ost_digest digest;
        assert_ok(ost_digest_volume(OST_GRID_RECT, &volume, &digest, &err));
        assert_string_equal(result.stages[1].name, "rect");
        assert_true(ost_digest_equal(&digest, &result.stages[1].digest));
        assert_int_equal(result.scatter.off_lattice, 0);
        ost_bone_free(bone);
        ost_volume_free(&volume);
    }
    ost_backend_close(backend);
}

/*
 * If the text has no lines for empty voxels, the imported grid is the bounding box of the other voxels. The
 * expected grid is cropped to the lowest and highest indices of these voxels.
 */
static void without_empty_voxels(void **state)
{
    (void)state;
    test_rng rng = rng_seeded("without_empty_voxels");
    ost_error err = {0};
    ost_backend *backend;
    assert_ok(ost_backend_open(test_backend, &backend, &err));
    for (int round = 0; round < 30; round++) {
        const int32_t n = (int32_t)rng_range(&rng, 2, 9);
        const ost_geometry g = {{n, n, n}, {470000000, 500000000, 1000000000}, {-57340000000, 123456789, -3}};
        ost_volume volume, box;
        assert_ok(ost_volume_init(&volume, &g, &err));
        int32_t lo[3] = {n, n, n}, hi[3] = {0, 0, 0};
        for (int i = 0; i < 3; i++) {
            const int32_t at[3] = {(int32_t)rng_range(&rng, 0, n - 1), (int32_t)rng_range(&rng, 0, n - 1),
                                   (int32_t)rng_range(&rng, 0, n - 1)};
            volume.voxels[at[0] + n * (at[1] + n * at[2])] = (int16_t)rng_range(&rng, 1, 3000);
            for (int a = 0; a < 3; a++) {
                lo[a] = at[a] < lo[a] ? at[a] : lo[a];
                hi[a] = at[a] + 1 > hi[a] ? at[a] + 1 : hi[a];
            }
        }
        const ost_geometry cropped = {
            {hi[0] - lo[0], hi[1] - lo[1], hi[2] - lo[2]},
            g.spacing,
            {g.origin.x + lo[0] * g.spacing.x, g.origin.y + lo[1] * g.spacing.y, g.origin.z + lo[2] * g.spacing.z}};
        assert_ok(ost_volume_init(&box, &cropped, &err));
        for (int32_t k = lo[2]; k < hi[2]; k++)
            for (int32_t j = lo[1]; j < hi[1]; j++)
                for (int32_t i = lo[0]; i < hi[0]; i++)
                    box.voxels[i - lo[0] + cropped.dims.x * (j - lo[1] + cropped.dims.y * (k - lo[2]))] =
                        volume.voxels[i + n * (j + n * k)];
        const ost_write_options options = {.text_decimals = (int)rng_range(&rng, 0, 1) * 3, .omit_empty = true};
        assert_ok(ost_text_write_volume(path, &volume, &options, &err));
        ost_bone *bone;
        ost_import_result result;
        ost_digest digest;
        assert_ok(ost_import(backend, path, &(ost_import_options){.digests = true}, &bone, &result, &err));
        assert_ok(ost_digest_volume(OST_GRID_RECT, &box, &digest, &err));
        assert_true(ost_digest_equal(&digest, &result.stages[1].digest));
        assert_true(result.scatter.samples <= 3);
        memset(volume.voxels, 0, (size_t)(n * n * n) * sizeof *volume.voxels);
        assert_int_equal(ost_text_write_volume(path, &volume, &options, &err), OST_ERR_INPUT);
        assert_non_null(strstr(err.text, "every voxel is empty"));
        ost_bone_free(bone);
        ost_volume_free(&volume);
        ost_volume_free(&box);
    }
    ost_backend_close(backend);
}

/*
 * A text that osteon wrote must be refused if it is truncated at any byte. The fact `dims` and
 * the end of the last line reveal the truncation.
 */
static void truncated_text_is_refused(void **state)
{
    (void)state;
    ost_error err = {0};
    ost_backend *backend;
    assert_ok(ost_backend_open(test_backend, &backend, &err));
    int16_t voxels[12];
    for (int i = 0; i < 12; i++)
        voxels[i] = (int16_t)(100 + i * 37);
    ost_volume volume = {.geometry = {{3, 2, 2}, {470000000, 470000000, 1000000000}, {-57340000000, 0, 0}},
                         .voxels = voxels};
    assert_ok(ost_text_write_volume(path, &volume, with_decimals(4), &err));
    size_t size;
    char *text = scratch_read(path, &size);
    /* If the text ends before the first fact is complete, the expected number of lines is unknown. */
    for (size_t cut = 0; cut < size; cut++) {
        ost_bone *bone;
        ost_status status = ost_import(backend, scratch_write(folder, "cut.txt", text, cut), NULL, &bone, NULL, &err);
        assert_int_equal(status, OST_ERR_INPUT);
        assert_non_null(strstr(err.text, "cut.txt:"));
        assert_null(bone);
    }
    free(text);
    ost_backend_close(backend);
}

static ost_volume large_volume(void)
{
    ost_error err = {0};
    ost_volume volume;
    assert_ok(
        ost_volume_init(&volume, &(ost_geometry){{64, 64, 16}, {470000000, 470000000, 1000000000}, {0, 0, 0}}, &err));
    return volume;
}

static void full_disk_leaves_no_file(void **state)
{
    (void)state;
    ost_volume volume = large_volume();
    assert_true(unlink(path) == 0 || access(path, F_OK) != 0);
    int before = scratch_count(folder);
    pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        ost_error err = {0};
        signal(SIGXFSZ, SIG_IGN);
        setrlimit(RLIMIT_FSIZE, &(struct rlimit){500000, 500000});
        ost_status status = ost_text_write_volume(path, &volume, with_decimals(4), &err);
        _exit(status == OST_ERR_IO && strstr(err.text, "out.txt: write failed after 500000 bytes") ? 0 : 1);
    }
    int ended;
    assert_int_equal(waitpid(child, &ended, 0), child);
    assert_int_equal(ended, 0);
    assert_int_equal(scratch_count(folder), before);
    if (access("/dev/full", W_OK) == 0) {
        ost_error err = {0};
        assert_int_equal(ost_text_write_volume("/dev/full", &volume, with_decimals(4), &err), OST_ERR_IO);
        assert_non_null(strstr(err.text, "the disk is full"));
    }
    ost_volume_free(&volume);
}

static void killed_writer_leaves_no_partial_file(void **state)
{
    (void)state;
    test_rng rng = rng_seeded("killed_writer_leaves_no_partial_file");
    ost_volume volume = large_volume();
    struct stat complete;
    ost_error err = {0};
    assert_ok(ost_text_write_volume(path, &volume, with_decimals(4), &err));
    assert_int_equal(stat(path, &complete), 0);
    for (int round = 0; round < 25; round++) {
        unlink(path);
        pid_t child = fork();
        assert_true(child >= 0);
        if (child == 0)
            _exit(ost_text_write_volume(path, &volume, with_decimals(4), NULL) == OST_OK ? 0 : 1);
        usleep((useconds_t)rng_range(&rng, 0, 10000));
        kill(child, SIGKILL);
        int ended;
        assert_int_equal(waitpid(child, &ended, 0), child);
        struct stat st;
        if (stat(path, &st) == 0)
            assert_int_equal(st.st_size, complete.st_size);
    }
    ost_volume_free(&volume);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(writes_the_expected_bytes),
        cmocka_unit_test(too_few_decimals_are_refused),
        cmocka_unit_test(import_restores_the_written_volume),
        cmocka_unit_test(without_empty_voxels),
        cmocka_unit_test(truncated_text_is_refused),
        cmocka_unit_test(full_disk_leaves_no_file),
        cmocka_unit_test(killed_writer_leaves_no_partial_file),
    };
    return run_on_backends(tests, set_up, scratch_tear_down);
}
