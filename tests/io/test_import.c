/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests the voxels that the import of a file gives: no layer is lost or doubled, every format and every orientation
 * gives the same grid, a written bone is restored, and a crop is a part of the complete grid.
 *
 * Covers: AR-GRID-5, AR-CT-3, AR-CT-4, AR-CHK-1
 */
#include "import_bone.h"

#include "io/text/rect.h"

/* ---------------------------------------------------------- no layer is lost */

/* Makes the rect grid of a text by calling only the two passes of the reader. */
static ost_status rect_of(const char *path, ost_geometry *geometry, int16_t **voxels, ost_scatter_report *report,
                          ost_error *err)
{
    ost_text_source source;
    ost_text_summary summary = {0};
    bool inferred[3];
    ost_grid *rect = NULL;
    *voxels = NULL;
    ost_status status = ost_text_source_open(&source, path, err);
    if (status != OST_OK)
        return status;
    status = ost_text_scan(&source, (ost_pm3){0, 0, 0}, NULL, NULL, NULL, &summary, err);
    if (status == OST_OK)
        status = ost_text_geometry(path, &summary, geometry, inferred, err);
    if (status == OST_OK)
        status = ost_grid_create(backend, geometry, &rect, err);
    if (status == OST_OK) {
        const ost_text_rect_options options = {.full = geometry, .expected = summary.fingerprint};
        status = ost_text_to_rect(&source, &options, rect, report, err);
    }
    if (status == OST_OK) {
        *voxels = malloc((size_t)ost_dims_count(geometry->dims) * sizeof **voxels);
        assert_non_null(*voxels);
        status = ost_grid_download(rect, 0, geometry->dims.z, *voxels, err);
    }
    ost_grid_free(rect);
    ost_text_summary_free(&summary);
    ost_text_source_close(&source);
    return status;
}

/*
 * Tests spacings for which the import described in the thesis leaves up to 29 % of the layers empty and
 * fills the same number of layers twice.
 */
static void no_layer_is_empty_or_doubled(void **state)
{
    (void)state;
    static const int64_t spacings[] = {300000000, 32000000, 488281000, 470000000, 488281250};
    static const int64_t origins[] = {0, -57340000000, 12345600000};
    for (size_t s = 0; s < 5; s++)
        for (size_t o = 0; o < 3; o++)
            for (int decimals = 4; decimals <= 6; decimals += 2)
                for (int axis = 0; axis < 3; axis++) {
                    ct_text ct = {.dims = {4, 3, 2}, .decimals = decimals};
                    ct.dims[axis] = 600;
                    for (int a = 0; a < 3; a++) {
                        ct.spacing[a] = spacings[s];
                        ct.origin[a] = origins[o];
                    }
                    const char *path = in_folder("layers.txt");
                    ct_text_write(path, &ct);
                    ost_error err = {0};
                    ost_geometry g;
                    int16_t *voxels;
                    ost_scatter_report report;
                    assert_ok(rect_of(path, &g, &voxels, &report, &err));
                    assert_int_equal(g.dims.x, ct.dims[0]);
                    assert_int_equal(g.dims.y, ct.dims[1]);
                    assert_int_equal(g.dims.z, ct.dims[2]);
                    assert_int_equal(report.duplicates, 0);
                    assert_int_equal(report.off_lattice, 0);
                    assert_int_equal(report.samples, ct.dims[0] * ct.dims[1] * ct.dims[2]);
                    const int16_t *v = voxels;
                    for (int k = 0; k < ct.dims[2]; k++)
                        for (int j = 0; j < ct.dims[1]; j++)
                            for (int i = 0; i < ct.dims[0]; i++, v++)
                                if (*v != ct_density(i, j, k))
                                    fail_msg(
                                        "spacing %lld origin %lld decimals %d: voxel (%d, %d, %d) has %d, expected %d",
                                        (long long)spacings[s], (long long)origins[o], decimals, i, j, k, *v,
                                        ct_density(i, j, k));
                    /* The imported spacing must be exact if the positions have six decimal places, or if four are
                       enough for it. */
                    if (decimals == 6 || spacings[s] % 100000 == 0) {
                        assert_true(g.spacing.x == spacings[s]);
                        assert_true(g.spacing.y == spacings[s]);
                        assert_true(g.spacing.z == spacings[s]);
                    }
                    free(voxels);
                }
}

/* ---------------------------------------------------------------- formats */

static void assert_same_stage(const ost_import_result *a, const ost_import_result *b, const char *name)
{
    const ost_stage *found[2] = {NULL, NULL};
    const ost_import_result *results[2] = {a, b};
    for (int r = 0; r < 2; r++)
        for (int s = 0; s < results[r]->stage_count; s++)
            if (strcmp(results[r]->stages[s].name, name) == 0)
                found[r] = &results[r]->stages[s];
    assert_non_null(found[0]);
    assert_non_null(found[1]);
    assert_true(found[0]->has_digest && found[1]->has_digest);
    assert_true(ost_digest_equal(&found[0]->digest, &found[1]->digest));
}

static void every_format_gives_the_same_grid(void **state)
{
    (void)state;
    static const struct {
        ost_pm3 spacing, origin;
        int decimals;
    } cases[] = {
        {{470000000, 470000000, 1000000000}, {-57340000000, 12000000, 3000000000}, 4},
        {{488281250, 488281250, 300000000}, {0, -57340000000, 0}, 6},
        {{32000000, 32000000, 32000000}, {1000000, 2000000, 3000000}, 0},
    };
    static const char *const names[] = {"same.txt", "same.nrrd", "same.nii.gz"};
    for (size_t c = 0; c < sizeof cases / sizeof cases[0]; c++) {
        ost_error err = {0};
        ost_volume volume = make_volume((ost_geometry){{37, 35, 40}, cases[c].spacing, cases[c].origin});
        ost_import_result results[3];
        for (int n = 0; n < 3; n++) {
            if (n == 2 && ost_volume_write(in_folder(names[n]), &volume, NULL, &err) == OST_ERR_UNAVAILABLE)
                continue; /* osteon was built without libnifti */
            const ost_write_options write = {.text_decimals = cases[c].decimals};
            assert_ok(ost_volume_write(in_folder(names[n]), &volume, &write, &err));
            assert_ok(import(in_folder(names[n]), &(ost_import_options){.digests = true}, &results[n], &err));
            assert_true(ost_geometry_equal(&results[n].rect, &volume.geometry));
            assert_string_equal(ost_meta_get(&results[n].meta, OST_META_SIDE), "left");
            assert_same_stage(&results[0], &results[n], "rect");
            assert_same_stage(&results[0], &results[n], "cubic");
            assert_same_stage(&results[0], &results[n], "chunks");
        }
        ost_digest direct;
        assert_ok(ost_digest_volume(OST_GRID_RECT, &volume, &direct, &err));
        assert_true(ost_digest_equal(&direct, &results[0].stages[1].digest));
        ost_volume_free(&volume);
    }
}

/*
 * The import receives slices one by one. For each of the 48 orders and directions of a file's axes, the
 * rect grid of the import must equal the volume that ost_volume_read returns.
 */
static void every_orientation_equals_the_volume(void **state)
{
    (void)state;
    enum { X = 3, Y = 4, Z = 5 };
    static const int axes[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
    for (int c = 0; c < 48; c++) {
        ost_error err = {0};
        ost_import_result result;
        ost_volume volume;
        ost_digest direct;
        int step[3][3] = {{0}};
        int16_t voxels[X * Y * Z];
        for (int a = 0; a < 3; a++)
            step[a][axes[c / 8][a]] = c >> a & 1 ? -1 : 1;
        FILE *file = fopen(in_folder("turned.nrrd"), "wb");
        assert_non_null(file);
        fprintf(file, "NRRD0005\ntype: short\nencoding: raw\nendian: little\ndimension: 3\nsizes: %d %d %d\n"
                      "space: left-posterior-superior\nspace directions: (%d,%d,%d) (%d,%d,%d) (%d,%d,%d)\n"
                      "space origin: (1,2,3)\n\n",
                X, Y, Z, step[0][0], step[0][1], step[0][2], step[1][0], step[1][1], step[1][2], step[2][0],
                step[2][1], step[2][2]);
        for (int16_t v = 0; v < X * Y * Z; v++)
            voxels[v] = (int16_t)(v * 10);
        assert_int_equal(fwrite(voxels, sizeof voxels, 1, file), 1);
        assert_int_equal(fclose(file), 0);
        assert_ok(ost_volume_read(in_folder("turned.nrrd"), NULL, &volume, NULL, &err));
        assert_ok(ost_digest_volume(OST_GRID_RECT, &volume, &direct, &err));
        assert_ok(import(in_folder("turned.nrrd"), &(ost_import_options){.digests = true}, &result, &err));
        assert_true(ost_geometry_equal(&result.rect, &volume.geometry));
        assert_string_equal(result.stages[0].name, "rect");
        if (!ost_digest_equal(&direct, &result.stages[0].digest))
            fail_msg("orientation %d: the digest of the rect grid differs from the digest of the volume", c);
        ost_volume_free(&volume);
    }
}

static void written_bone_is_restored(void **state)
{
    (void)state;
    static const char *const names[] = {"bone.nrrd", "bone.nii.gz", "bone.txt"};
    ost_error err = {0};
    ost_volume volume = make_volume(
        (ost_geometry){{33, 20, 17}, {470000000, 470000000, 1000000000}, {-57340000000, 0, 5}});
    assert_ok(ost_volume_write(in_folder("ct.nrrd"), &volume, NULL, &err));
    ost_volume_free(&volume);
    ost_bone *bone;
    ost_import_result first, again;
    const ost_import_options options = {.digests = true, .threshold = 333};
    assert_ok(ost_import(backend, in_folder("ct.nrrd"), &options, &bone, &first, &err));
    for (size_t n = 0; n < 3; n++) {
        ost_status status = ost_bone_write(in_folder(names[n]), bone, &first.meta, NULL, &err);
        if (n == 1 && status == OST_ERR_UNAVAILABLE)
            continue;
        assert_int_equal(status, OST_OK);
        /* If no threshold is given, the threshold in the bone's file is used. */
        assert_ok(import(in_folder(names[n]), &(ost_import_options){.digests = true}, &again, &err));
        assert_same_stage(&first, &again, "chunks");
        assert_string_equal(ost_meta_get(&again.meta, OST_META_THRESHOLD), "333");
    }
    ost_bone_free(bone);
}

/* --------------------------------------------------------------------------- crop */

static void crop_is_a_part_of_the_complete_grid(void **state)
{
    (void)state;
    ost_error err = {0};
    ost_volume volume = make_volume(
        (ost_geometry){{20, 18, 16}, {500000000, 500000000, 500000000}, {-1000000000, 0, 0}});
    assert_ok(ost_volume_write(in_folder("crop.txt"), &volume, NULL, &err));
    assert_ok(ost_volume_write(in_folder("crop.nrrd"), &volume, NULL, &err));
    ost_volume_free(&volume);
    static const char *const names[] = {"crop.txt", "crop.nrrd"};
    const ost_import_options options = {.crop = true, .crop_box = {{3, 4, 5}, {13, 10, 16}}, .threshold = 1};
    for (int n = 0; n < 2; n++) {
        ost_bone *bone;
        ost_import_result result;
        assert_ok(ost_import(backend, in_folder(names[n]), &options, &bone, &result, &err));
        assert_int_equal(result.rect.dims.x, 10);
        assert_int_equal(result.rect.dims.y, 6);
        assert_int_equal(result.rect.dims.z, 11);
        assert_true(result.rect.origin.x == 500000000 && result.rect.origin.y == 2000000000 &&
                    result.rect.origin.z == 2500000000);
        int16_t voxels[10 * 6 * 11], *v = voxels;
        assert_ok(ost_bone_download(bone, 0, 11, voxels, &err));
        for (int k = 5; k < 16; k++)
            for (int j = 4; j < 10; j++)
                for (int i = 3; i < 13; i++, v++)
                    assert_int_equal(*v, ct_density(i, j, k) >= 1 ? ct_density(i, j, k) : 0);
        ost_bone_free(bone);
        static const ost_voxel_box wrong[] = {{{0, 0, 0}, {21, 1, 1}}, {{-1, 0, 0}, {1, 1, 1}}, {{5, 5, 5}, {6, 5, 6}}};
        for (int w = 0; w < 3; w++) {
            ost_import_options bad = {.crop = true, .crop_box = wrong[w]};
            assert_int_equal(import(in_folder(names[n]), &bad, &result, &err), OST_ERR_USAGE);
            assert_non_null(strstr(err.text, "a crop of voxels"));
        }
    }
}

/* By AR-GRID-5 the complete grid must be valid even if only a part of it is imported. */
static void grid_outside_the_crop_is_checked(void **state)
{
    (void)state;
    ost_error err = {0};
    ost_import_result result;
    ost_volume volume;
    const ost_geometry g = {.dims = {200, 1, 1}, .spacing = {1000000000, 1000000000, 1000000000}};
    assert_ok(ost_volume_init(&volume, &g, &err));
    assert_ok(ost_volume_write(in_folder("long.nrrd"), &volume, NULL, &err));
    char text[4096];
    int size = 0;
    for (int i = 0; i < 200; i++)
        size += snprintf(text + size, sizeof text - (size_t)size, "%d 0 0 1\n", i);
    scratch_write(folder, "long.txt", text, (size_t)size);
    static const char *const names[] = {"long.txt", "long.nrrd"};
    for (int n = 0; n < 2; n++) {
        ost_import_options options = {
            .crop = true, .crop_box = {{0, 0, 0}, {10, 1, 1}}, .spacing = {1000000000, 1000000000, 1000000000}};
        assert_ok(import(in_folder(names[n]), &options, &result, &err));
        assert_int_equal(result.rect.dims.x, 10);
        options.spacing.x = 100000000000; /* with this spacing, 199 voxels are 19.9 m */
        if (n == 1)
            assert_int_equal(import(in_folder(names[n]), &options, &result, &err), OST_ERR_RANGE);
    }
    ost_volume_free(&volume);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(no_layer_is_empty_or_doubled),
        cmocka_unit_test(every_format_gives_the_same_grid),
        cmocka_unit_test(every_orientation_equals_the_volume),
        cmocka_unit_test(written_bone_is_restored),
        cmocka_unit_test(crop_is_a_part_of_the_complete_grid),
        cmocka_unit_test(grid_outside_the_crop_is_checked),
    };
    return run_on_backends(tests, set_up, tear_down);
}
