/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests the result of ost_import and the header of the imported bone. The tests cover the rule by which a file is
 * resampled, and spacings that the caller or the file gives.
 *
 * Covers: AR-CT-3, AR-CT-8, AR-CUB-1, AR-CUB-5, AR-CUB-6, AR-CHK-1
 */
#include "import_bone.h"

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

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(result_describes_the_import),
        cmocka_unit_test(labels_are_resampled_by_nearest),
        cmocka_unit_test(unchanged_bone_keeps_its_resampling_rule),
        cmocka_unit_test(given_spacings_are_used),
    };
    return run_on_backends(tests, set_up, tear_down);
}
