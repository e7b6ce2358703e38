/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests the import of a file as a bone: no layer is lost or doubled, every format gives the same bone, every invalid
 * file is refused, and memory is bounded by the size of the grid.
 *
 * Covers: REQ-CT-BIG, AR-GRID-5, AR-CT-3, AR-CT-4, AR-CT-5, AR-CT-6, AR-CT-8, AR-CUB-1, AR-CUB-5, AR-CUB-6, AR-CHK-1
 */
#include "backends.h"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <osteon/io.h>

#include "io/text/rect.h"
#include "io/scratch_group.h"

#include "ct_text.h"

static ost_backend *backend;

static int set_up(void **state)
{
    scratch_set_up(state);
    return open_test_backend((void **)&backend);
}

static int tear_down(void **state)
{
    ost_backend_close(backend);
    return scratch_tear_down(state);
}

static const char *in_folder(const char *name)
{
    static char path[4][600];
    static int next;
    char *to = path[next++ % 4];
    snprintf(to, sizeof path[0], "%s/%s", folder, name);
    return to;
}

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
                    /* If four decimals determine the spacing, the imported spacing must be exact. */
                    if (decimals == 6 || spacings[s] % 100000 == 0) {
                        assert_true(g.spacing.x == spacings[s]);
                        assert_true(g.spacing.y == spacings[s]);
                        assert_true(g.spacing.z == spacings[s]);
                    }
                    free(voxels);
                }
}

/* ------------------------------------------------- formats */

static ost_volume make_volume(ost_geometry g)
{
    ost_error err = {0};
    ost_volume volume;
    assert_ok(ost_volume_init(&volume, &g, &err));
    int16_t *v = volume.voxels;
    for (int k = 0; k < g.dims.z; k++)
        for (int j = 0; j < g.dims.y; j++)
            for (int i = 0; i < g.dims.x; i++)
                *v++ = (int16_t)ct_density(i, j, k);
    assert_ok(ost_meta_set(&volume.meta, OST_META_KIND, "ct", &err));
    assert_ok(ost_meta_set(&volume.meta, OST_META_SIDE, "left", &err));
    return volume;
}

static ost_status import(const char *path, const ost_import_options *options, ost_import_result *result, ost_error *err)
{
    ost_bone *bone;
    ost_status status = ost_import(backend, path, options, &bone, result, err);
    ost_bone_free(bone);
    return status;
}

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

/* ----------------------------------------------------------------------- reports */

static void result_describes_the_import(void **state)
{
    (void)state;
    static const char text[] = "# osteon side: right\n"
                               "x y z density\n"
                               "0 0 0 200\n"
                               "0.47 0 0 100\n"
                               "0.94 0 0 -7\n"
                               "0 0.47 1 119\n"
                               "0.4700000001 0.47 1 120\n"
                               "0.94 0.47 1 3000\n";
    ost_error err = {0};
    ost_bone *bone;
    ost_import_result result;
    const char *path = scratch_write(folder, "tell.txt", text, sizeof text - 1);
    assert_ok(
        ost_import(backend, path, &(ost_import_options){.digests = true, .chunk_size = 16}, &bone, &result, &err));
    assert_int_equal(result.kind, OST_FILE_CT_TEXT);
    assert_int_equal(result.rect.dims.x, 3);
    assert_int_equal(result.rect.dims.y, 2);
    assert_int_equal(result.rect.dims.z, 2);
    assert_true(result.rect.spacing.x == 470000000 && result.rect.spacing.y == 470000000 &&
                result.rect.spacing.z == 1000000000);
    assert_int_equal(result.cubic.dims.z, 5); /* two layers of 1 mm become ceil(2 / 0.47) layers of 0.47 mm */
    assert_true(result.spacing_inferred[0] && result.spacing_inferred[1] && result.spacing_inferred[2]);
    assert_int_equal(result.rounded_positions, 1);
    assert_int_equal(result.scatter.samples, 6);
    assert_string_equal(result.volume.encoding, "text");
    assert_string_equal(ost_meta_get(&result.meta, OST_META_SIDE), "right");
    assert_string_equal(ost_meta_get(&result.meta, OST_META_KIND), "bone");
    assert_string_equal(ost_meta_get(&result.meta, OST_META_THRESHOLD), "120");
    static const char *const stages[] = {"samples", "rect", "cubic", "chunks"};
    assert_int_equal(result.stage_count, 4);
    for (int i = 0; i < 4; i++) {
        assert_string_equal(result.stages[i].name, stages[i]);
        assert_true(result.stages[i].has_digest);
        assert_true(result.stages[i].time_ms >= 0);
    }
    /* The test hashes the samples in a single call, as records of 32 bytes in the order of the file. */
    struct {
        int64_t x, y, z;
        int32_t density;
        uint32_t zero;
    } records[6] = {
        {0, 0, 0, 200, 0},
        {470000000, 0, 0, 100, 0},
        {940000000, 0, 0, -7, 0},
        {0, 470000000, 1000000000, 119, 0},
        {470000000, 470000000, 1000000000, 120, 0},
        {940000000, 470000000, 1000000000, 3000, 0},
    };
    ost_digest direct;
    assert_ok(ost_digest_bytes(records, sizeof records, &direct, &err));
    assert_true(ost_digest_equal(&direct, &result.stages[0].digest));

    ost_bone_info info;
    assert_ok(ost_bone_info_get(bone, &info, &err));
    assert_int_equal(info.chunk_size, 16);
    /*
     * The five cubic layers lie at t = 0 (clamped), 0.205, 0.675, 1 and 1 (clamped) between the
     * two layers of the file. A column with the densities 200 and 0 gives 200, 159, 65, 0 and 0.
     * A column with 0 and 3000 gives 0, 615, 2025, 3000 and 3000. In a column with 0 and 120,
     * only the last two voxels are active.
     */
    assert_int_equal(info.active_voxels, 2 + 4 + 2);
    assert_string_equal(ost_meta_get(&result.meta, OST_META_RESAMPLE), "linear");
    ost_bone_free(bone);
}

/* Returns the rule by which a file is resampled. Checks that the bone's header states this rule. */
static ost_resample rule_of(const char *path, const ost_import_options *options, const char *fact)
{
    ost_error err = {0};
    ost_import_result result;
    ost_bone *bone;
    assert_ok(ost_import(backend, path, options, &bone, &result, &err));
    assert_string_equal(ost_meta_get(&result.meta, OST_META_RESAMPLE), fact);
    ost_bone_free(bone);
    return result.resample;
}

/* The file has the labels 200 and 300. Their mean would be a third label, so it must not occur. */
static void labels_are_resampled_by_nearest(void **state)
{
    (void)state;
    static const char nrrd[] =
        "NRRD0004\ntype: short\ndimension: 3\nspace: left-posterior-superior\nsizes: 1 1 2\n"
        "space directions: (1,0,0) (0,1,0) (0,0,1.5)\nkinds: domain domain domain\nendian: little\n"
        "encoding: text\nspace origin: (0,0,0)\n%s\n200 300\n";
    const ost_import_options thesis = {.has_resample = true, .resample = OST_RESAMPLE_THESIS},
                             linear = {.has_resample = true};
    ost_error err = {0};
    char text[400];
    snprintf(text, sizeof text, nrrd, "");
    const char *plain = scratch_write(folder, "plain.nrrd", text, strlen(text));
    assert_int_equal(rule_of(plain, NULL, "linear"), OST_RESAMPLE_LINEAR);
    assert_int_equal(rule_of(plain, &thesis, "thesis"), OST_RESAMPLE_THESIS);
    snprintf(text, sizeof text, nrrd, "Segment0_Name:=scapula\nSegment0_LabelValue:=200\n");
    const char *segmented = scratch_write(folder, "segmented.nrrd", text, strlen(text));
    assert_int_equal(rule_of(segmented, NULL, "nearest"), OST_RESAMPLE_NEAREST);
    assert_int_equal(rule_of(segmented, &linear, "linear"), OST_RESAMPLE_LINEAR);

    const ost_geometry g = {.dims = {1, 1, 2}, .spacing = {OST_PM_PER_MM, OST_PM_PER_MM, 3 * OST_PM_PER_MM / 2}};
    ost_volume volume;
    assert_ok(ost_volume_init(&volume, &g, &err));
    volume.voxels[0] = 200;
    volume.voxels[1] = 300;
    const char *path = in_folder("labels.nii");
    const ost_status status = ost_volume_write(path, &volume, NULL, &err);
    ost_volume_free(&volume);
    if (status == OST_ERR_UNAVAILABLE)
        return; /* osteon was built without libnifti */
    assert_ok(status);
    assert_int_equal(rule_of(path, NULL, "linear"), OST_RESAMPLE_LINEAR);
    /* intent_code is the int16 at byte 68 of a NIfTI-1 header; NIFTI_INTENT_LABEL is 1002 = 0x03ea. */
    static const unsigned char label[2] = {0xea, 0x03};
    FILE *file = fopen(path, "r+b");
    assert_non_null(file);
    assert_int_equal(fseek(file, 68, SEEK_SET), 0);
    assert_int_equal(fwrite(label, 1, 2, file), 2);
    assert_int_equal(fclose(file), 0);
    assert_int_equal(rule_of(path, NULL, "nearest"), OST_RESAMPLE_NEAREST);
    assert_int_equal(rule_of(path, &linear, "linear"), OST_RESAMPLE_LINEAR);
}

/* If a bone is imported without changes of its voxels, the facts about its CT must be preserved. */
static void unchanged_bone_keeps_its_resampling_rule(void **state)
{
    (void)state;
    static const char text[] = "0 0 0 200\n0 0 1 300\n0 0 2 300\n0.5 0 0 200\n0 0.5 0 200\n";
    const ost_import_options nearest = {.has_resample = true, .resample = OST_RESAMPLE_NEAREST},
                             finer = {.cubic = 400000000};
    ost_error err = {0};
    ost_import_result result;
    ost_bone *bone;
    assert_ok(
        ost_import(backend, scratch_write(folder, "ct.txt", text, sizeof text - 1), &nearest, &bone, &result, &err));
    const char *path = in_folder("kept.nrrd");
    assert_ok(ost_bone_write(path, bone, &result.meta, NULL, &err));
    ost_bone_free(bone);
    rule_of(path, NULL, "nearest");
    rule_of(path, &finer, "linear");
}

static void given_spacings_are_used(void **state)
{
    (void)state;
    static const char text[] = "# osteon spacing_mm: 0.5 0.5 2\n0 0 0 1\n1 1 0 2\n";
    ost_error err = {0};
    ost_import_result result;
    const char *path = scratch_write(folder, "given.txt", text, sizeof text - 1);
    assert_ok(import(path, NULL, &result, &err));
    assert_int_equal(result.rect.dims.x, 3);
    assert_int_equal(result.rect.dims.z, 1);
    assert_true(result.rect.spacing.z == 2000000000);
    assert_false(result.spacing_inferred[0]);
    assert_ok(import(path, &(ost_import_options){.spacing = {250000000, 0, 0}}, &result, &err));
    assert_int_equal(result.rect.dims.x, 5);
    assert_int_equal(result.rect.dims.y, 3);
    assert_int_equal(import(path, &(ost_import_options){.spacing = {999999, 0, 0}}, &result, &err), OST_ERR_RANGE);
    assert_non_null(strstr(err.text, "0.001 to 100 mm"));
}

/* ------------------------------------------------- duplicates, offsets, sparse texts */

static void duplicates_follow_the_option(void **state)
{
    (void)state;
    static const char text[] =
        "# osteon spacing_mm: 1 1 1\n0 0 0 200\n1 0 0 300\n0 0 0 200\n0 0 0 150\n0 0 0 900\n0 0 0 600\n";
    static const int expected[] = {0, 200, 600, 900};
    static const char *const names[] = {"", "first", "last", "max"};
    const char *path = scratch_write(folder, "double.txt", text, sizeof text - 1);
    for (int rule = OST_DUPLICATES_ERROR; rule <= OST_DUPLICATES_MAX; rule++) {
        ost_error err = {0};
        ost_bone *bone;
        ost_import_result result;
        ost_status status =
            ost_import(backend, path, &(ost_import_options){.duplicates = (ost_duplicates)rule}, &bone, &result, &err);
        if (rule == OST_DUPLICATES_ERROR) {
            assert_int_equal(status, OST_ERR_INPUT);
            assert_null(bone);
            assert_non_null(strstr(err.text,
                                   "double.txt:5: density 150 at (0, 0, 0), where an earlier line has 200; choose one "
                                   "with 'osteon import --duplicates first', 'last' or 'max'"));
            continue;
        }
        assert_int_equal(status, OST_OK);
        int16_t voxels[2];
        assert_ok(ost_bone_download(bone, 0, 1, voxels, &err));
        assert_int_equal(voxels[0], expected[rule]);
        assert_int_equal(voxels[1], 300);
        assert_int_equal(result.scatter.duplicates, 4);
        assert_string_equal(ost_meta_get(&result.meta, "duplicates"), names[rule]);
        ost_bone_free(bone);
    }
}

static void positions_off_the_lattice(void **state)
{
    (void)state;
    ost_error err = {0};
    ost_import_result result;
    const ost_import_options options = {.spacing = {1000000000, 1000000000, 1000000000}};
    static const char warned[] = "0 0 0 1\n1.2 0 0 2\n2 0.13 0 3\n3 0 0 4\n";
    assert_ok(import(scratch_write(folder, "warned.txt", warned, sizeof warned - 1), &options, &result, &err));
    assert_int_equal(result.scatter.off_lattice, 2);
    assert_int_equal(result.scatter.worst_line, 2);
    assert_int_equal(result.scatter.worst_offset_ppm, 200000);
    static const char refused[] = "0 0 0 1\n1 0 0 2\n\n2 1.376 0 3\n3 0 0 4\n";
    assert_int_equal(import(scratch_write(folder, "refused.txt", refused, sizeof refused - 1), &options, &result, &err),
                     OST_ERR_INPUT);
    assert_non_null(
        strstr(err.text,
               "refused.txt:4: y = 1.376 lies 0.376 voxels off the lattice of 1 mm from 0 mm; expected at most 3/8"));
}

/* A text of a few samples that are far apart must be refused before memory for the grid between them is allocated. */
static void sparse_texts_are_refused(void **state)
{
    (void)state;
    ost_error err = {0};
    ost_import_result result;
    const ost_import_options options = {.spacing = {1000000, 1000000, 1000000}};
    static const char sparse[] = "0 0 0 1\n1 1 1 2\n";
    static const char enormous[] = "0 0 0 1\n100 100 100 2\n";
    assert_int_equal(import(scratch_write(folder, "sparse.txt", sparse, sizeof sparse - 1), &options, &result, &err),
                     OST_ERR_INPUT);
    assert_non_null(
        strstr(err.text, "sparse.txt: 2 samples span 1001 x 1001 x 1001 voxels, of which all but one in 501501500"));
    assert_int_equal(import(scratch_write(folder, "big.txt", enormous, sizeof enormous - 1), &options, &result, &err),
                     OST_ERR_RANGE);
    assert_non_null(strstr(err.text, "big.txt"));
    assert_non_null(strstr(err.text, "100001 voxels along x"));
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

/* ------------------------------------------ progress, cancellation, changed files */

typedef struct watcher {
    const char *path;        /* file that is changed at the start of the second pass */
    const char *cancel;      /* stage at which the import is cancelled */
    double last_share;
    int calls;
} watcher;

static bool watch(void *user, const char *stage, double share)
{
    watcher *w = user;
    assert_true(share >= 0 && share <= 1);
    w->calls++;
    w->last_share = share;
    if (w->path && strcmp(stage, "rect") == 0) {
        int fd = open(w->path, O_WRONLY);
        assert_true(fd >= 0);
        assert_int_equal(pwrite(fd, "9", 1, 6), 1);
        close(fd);
        w->path = NULL;
    }
    return !w->cancel || strcmp(stage, w->cancel) != 0;
}

static void progress_function_can_cancel(void **state)
{
    (void)state;
    static const char text[] = "0 0 0 1\n1 1 1 2\n";
    static const char *const stages[] = {"samples", "rect", "cubic", "chunks"};
    const char *path = scratch_write(folder, "watched.txt", text, sizeof text - 1);
    for (int s = 0; s < 5; s++) {
        ost_error err = {0};
        ost_import_result result;
        watcher w = {.cancel = s < 4 ? stages[s] : NULL};
        ost_status status = import(path, &(ost_import_options){.progress = watch, .progress_user = &w}, &result, &err);
        assert_int_equal(status, s < 4 ? OST_ERR_CANCELLED : OST_OK);
        assert_true(w.calls > 0);
        if (s == 4)
            assert_true(w.last_share == 1);
    }
}

static void change_between_the_passes_is_detected(void **state)
{
    (void)state;
    static const char text[] = "0 0 0 1\n1 1 1 2\n";
    ost_error err = {0};
    ost_import_result result;
    watcher w = {.path = scratch_write(folder, "change.txt", text, sizeof text - 1)};
    ost_status status = import(w.path, &(ost_import_options){.progress = watch, .progress_user = &w}, &result, &err);
    assert_int_equal(status, OST_ERR_INPUT);
    assert_non_null(strstr(err.text, "file changed while it was read"));
}

/* -------------------------------------------------------- files that are refused */

static void other_files_are_refused(void **state)
{
    (void)state;
    static const struct {
        const char *name, *content, *message;
        ost_status status;
    } cases[] = {
        {"mesh.stl", "solid x\nfacet normal 0 0 1\nendsolid\n", "is a mesh, not a CT", OST_ERR_INPUT},
        {"path.csv", "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz\n0,0,0,0,1,0,0,0\n", "is a tool's path, not a CT", OST_ERR_INPUT},
        {"what.bin", "\x01\x02\x03", "not a CT", OST_ERR_INPUT},
        {"page.html", "<html>\n", "not a CT", OST_ERR_INPUT},
        {"tool.txt", "# osteon kind: tool\n0 0 0 1\n1 1 1 1\n", "is a tool grid; expected a bone or a CT",
         OST_ERR_INPUT},
        {"bone.txt", "# osteon kind: bone\n# osteon threshold: 0\n0 0 0 1\n1 1 1 1\n", "threshold '0'", OST_ERR_INPUT},
        {"layer.txt", "0 0 5 1\n1 1 5 2\n", "all samples lie in one layer, z = 5", OST_ERR_INPUT},
        {"twice.txt", "# osteon dims: 2 1 1\n# osteon spacing_mm: 1 1 1\n0 0 0 7\n0 0 0 7\n# osteon dims: 2 1 1\n",
         "the declared dims are 2 voxels along x, but its positions make 1", OST_ERR_INPUT},
        {"twice.txt", "# osteon dims: 2 2 1\n# osteon spacing_mm: 1 1 1\n0 0 0 7\n1 1 0 7\n1 0 0 7\n1 0 0 7\n",
         "twice.txt:1: this line declares one sample per voxel, but 1 samples repeat a voxel", OST_ERR_INPUT},
        {"dims.txt", "# osteon dims: 1 2 1\n0 0 0 1\n1 1 1 2\n", "the declared dims are 1 voxels along x",
         OST_ERR_INPUT},
        {"origin.txt", "# osteon origin_mm: 0.5 0 0\n0 0 0 1\n1 1 1 2\n",
         "origin.txt:1: the declared origin is x = 0.5", OST_ERR_INPUT},
    };
    ost_error err = {0};
    ost_import_result result;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        const char *path = scratch_write(folder, cases[i].name, cases[i].content, strlen(cases[i].content));
        ost_status status = import(path, NULL, &result, &err);
        if (status != cases[i].status || !strstr(err.text, cases[i].message) || !strstr(err.text, cases[i].name))
            fail_msg("%s: %s '%s', expected '%s'", cases[i].name, ost_status_name(status), err.text, cases[i].message);
    }
    /* makes osteon search for osteon-dicom in a folder that lacks it */
    assert_int_equal(setenv("OSTEON_LIBEXECDIR", folder, 1), 0);
    assert_int_equal(import(folder, NULL, &result, &err), OST_ERR_UNAVAILABLE);
    assert_non_null(strstr(err.text, "reading DICOM needs the program osteon-dicom"));
    assert_int_equal(unsetenv("OSTEON_LIBEXECDIR"), 0);
    assert_int_equal(import(in_folder("absent.txt"), NULL, &result, &err), OST_ERR_IO);
    assert_non_null(strstr(err.text, "absent.txt: cannot open: No such file"));
}

/* ------------------------------------------------------------------------- memory */

#define MEMORY_OPTION "--import-within-bounds"

/*
 * Returns the peak memory of this process in KiB, or -1. ru_maxrss is unsuitable, because it includes the memory before
 * exec.
 */
static long peak_kib(void)
{
    FILE *status = fopen("/proc/self/status", "r");
    if (!status)
        return -1;
    char line[256];
    long peak = -1;
    while (peak < 0 && fgets(line, sizeof line, status))
        if (sscanf(line, "VmHWM: %ld kB", &peak) != 1)
            peak = -1;
    (void)fclose(status);
    return peak;
}

enum { BOUNDED = 0, UNREADABLE = 1, GREW = 2, UNKNOWN = 77 };

/* Runs in the second process: imports the text and returns an exit status that states whether the peak was bounded. */
static int import_within_bounds(const char *spec, const char *path)
{
    ost_error err = {0};
    ost_import_result result;
    const long before = peak_kib();
    if (before < 0)
        return UNKNOWN;
    if (ost_backend_open(spec, &backend, &err) != OST_OK ||
        import(path, &(ost_import_options){.digests = true}, &result, &err) != OST_OK) {
        (void)fprintf(stderr, "%s\n", err.text);
        return UNREADABLE;
    }
    ost_backend_close(backend);
    const long grown = peak_kib() - before;
    print_message("the peak memory grew by %ld KiB\n", grown);
    return grown < 10 * 1024 && result.scatter.samples == 1000000 ? BOUNDED : GREW;
}

/*
 * The test imports 20 MB of text for a grid of 50^3 voxels, each given eight times. The peak memory must not depend on
 * the size of the file: the grid and the buffers need a few hundred kilobytes, and the test allows 10 MiB. The import
 * runs in a new process for two reasons: this process has already used more memory, and after a fork without exec,
 * OpenMP would wait for threads that exist only in the parent.
 */
static void memory_is_bounded_by_the_grid(void **state)
{
    (void)state;
#if defined __SANITIZE_ADDRESS__
    skip(); /* with a sanitizer, the measurement would include the sanitizer's own memory */
#endif
    if (strncmp(test_backend, "cl", 2) == 0)
        skip(); /* skipped, because the measurement would include the driver's compiler */
    const char *path = in_folder("large.txt");
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    for (int repeat = 0; repeat < 8; repeat++)
        for (int v = 0; v < 125000; v++)
            fprintf(file, "%d.5000 %d.5000 %d.5000 %d\n", v % 50, v / 50 % 50, v / 2500, v % 3000);
    long size = ftell(file);
    assert_int_equal(fclose(file), 0);
    assert_true(size > 20000000);
    fflush(NULL);
    pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        execl("/proc/self/exe", "test_import", MEMORY_OPTION, test_backend, path, (char *)NULL);
        _exit(UNKNOWN);
    }
    int ended;
    assert_int_equal(waitpid(child, &ended, 0), child);
    assert_true(WIFEXITED(ended));
    if (WEXITSTATUS(ended) == UNKNOWN)
        skip(); /* skipped if the system has no /proc */
    assert_int_equal(WEXITSTATUS(ended), BOUNDED);
}

/* A bone of 2^36 voxels takes 137 GB and must be refused at once if the machine has less memory. */
static void bone_larger_than_memory_is_refused(void **state)
{
    (void)state;
    if ((double)sysconf(_SC_PHYS_PAGES) * (double)sysconf(_SC_PAGESIZE) > 130e9)
        skip();
    char text[64 * 24] = "";
    for (int i = 0; i < 64; i++)
        snprintf(text + strlen(text), sizeof text - strlen(text), "%d %d %d 1000\n", i % 4 * 16, i / 4 % 4 * 16,
                 i / 16 * 16);
    const char *path = scratch_write(folder, "fine.txt", text, strlen(text));
    const ost_import_options options = {.cubic = 16 * OST_PM_PER_MM / 1024, .digests = true};
    ost_error err = {0};
    ost_bone *bone;
    ost_import_result result;
    assert_int_equal(ost_import(backend, path, &options, &bone, &result, &err), OST_ERR_MEMORY);
    assert_null(bone);
    assert_int_equal(result.stage_count, 2);
    if (!strstr(err.text, "fine.txt: with cubic voxels of 0.015625 mm the bone takes 137 GB; this machine has "))
        fail_msg("the error is '%s'", err.text);
}

int main(int argc, char **argv)
{
    if (argc == 4 && strcmp(argv[1], MEMORY_OPTION) == 0)
        return import_within_bounds(argv[2], argv[3]);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(no_layer_is_empty_or_doubled),
        cmocka_unit_test(every_format_gives_the_same_grid),
        cmocka_unit_test(every_orientation_equals_the_volume),
        cmocka_unit_test(written_bone_is_restored),
        cmocka_unit_test(result_describes_the_import),
        cmocka_unit_test(labels_are_resampled_by_nearest),
        cmocka_unit_test(unchanged_bone_keeps_its_resampling_rule),
        cmocka_unit_test(given_spacings_are_used),
        cmocka_unit_test(duplicates_follow_the_option),
        cmocka_unit_test(positions_off_the_lattice),
        cmocka_unit_test(sparse_texts_are_refused),
        cmocka_unit_test(crop_is_a_part_of_the_complete_grid),
        cmocka_unit_test(grid_outside_the_crop_is_checked),
        cmocka_unit_test(progress_function_can_cancel),
        cmocka_unit_test(change_between_the_passes_is_detected),
        cmocka_unit_test(other_files_are_refused),
        cmocka_unit_test(memory_is_bounded_by_the_grid),
        cmocka_unit_test(bone_larger_than_memory_is_refused),
    };
    return run_on_backends(tests, set_up, tear_down);
}
