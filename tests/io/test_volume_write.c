/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests volumes and bones that are written as NRRD and NIfTI, with and without compression, and read back. Floats
 * cannot represent some of their spacings exactly. Further tests check the bytes of the files, progress and
 * cancellation.
 *
 * Covers: AR-FILE-1, AR-FILE-2, AR-FILE-6, AR-FILE-8, REQ-CT-SAME
 */
#include "written_volumes.h"

#include <unistd.h>

/* Every format must preserve the spacings and offsets of the thesis, and writing a volume twice must give equal
   files. */
static void every_format_restores_the_volume(void **state)
{
    (void)state;
    static const char *const spacings[] = {"0.3", "0.032", "0.488281", "0.47", "0.48828125", "1", "0.123456789"};
    static const char *const origins[] = {"-57.34", "0", "12.3456789", "-0.016", "7990.1"};
    static const struct {
        const char *name;
        bool compress;
    } formats[] = {{"a.nrrd", false}, {"b.nrrd", true}, {"c.nii", false}, {"d.nii.gz", false},
                 {"E.NRRD", false}, {"f.mha", false}};
    test_rng rng = rng_seeded("volumes");
    ost_error err = {0};
    for (size_t s = 0; s < sizeof spacings / sizeof spacings[0]; s++) {
        /* Every file is synced to disk, which takes time. Therefore each spacing is tested with only two origins. */
        for (size_t turn = 0; turn < 2; turn++) {
            size_t o = (s + turn) % (sizeof origins / sizeof origins[0]);
            ost_volume v;
            const ost_geometry g = {.dims = {5, 4, 3},
                                    .spacing = {pm(spacings[s]), pm(spacings[s]), pm("0.625")},
                                    .origin = {pm(origins[o]), pm("-57.34"), pm(origins[o])}};
            make_volume(&v, &g, &rng);
            assert_ok(ost_meta_set(&v.meta, OST_META_KIND, "ct", &err));
            assert_ok(ost_meta_set(&v.meta, OST_META_GLENOID_AT, "-117.8 196.5 -159", &err));
            assert_ok(ost_meta_set(&v.meta, "note", "a \\ and: a colon", &err));
            for (size_t f = 0; f < sizeof formats / sizeof formats[0]; f++) {
                if (!HAS_NIFTI && strstr(formats[f].name, ".nii"))
                    continue;
                const ost_write_options options = {.compress = formats[f].compress};
                ost_volume back;
                size_t size, again_size;
                assert_ok(ost_volume_write(at(formats[f].name), &v, &options, &err));
                assert_ok(ost_volume_read(at(formats[f].name), NULL, &back, NULL, &err));
                assert_volumes_equal(&v, &back);
                char *first = read_all(at(formats[f].name), &size);
                assert_ok(ost_volume_write(at(formats[f].name), &back, &options, &err));
                char *again = read_all(at(formats[f].name), &again_size);
                assert_int_equal(size, again_size);
                assert_memory_equal(first, again, size);
                free(first);
                free(again);
                ost_volume_free(&back);
            }
            ost_volume_free(&v);
        }
    }
}

/*
 * AR-FILE-8: facts must be read back in their order, with any bytes in their values. If a fact
 * has the same key as a property of the grid, for example `dims`, it must not change the
 * geometry.
 */
static void facts_keep_their_order(void **state)
{
    (void)state;
    static const char *const keys[] = {"zebra", "dims", "note", "spacing_mm", "a", "origin_mm", "uml", "empty", "nine"};
    static const char *const values[] = {"first", "5 5 5", "a:=b \\ c\\n: d", "3 3 3", "1", "7 7 7", "T\xc3\xbcr \xff",
                                         "",      "# x"};
    static const char *const kept[] = {"zebra", "note", "a", "uml", "empty", "nine"};
    static const char *const formats[] = {"f.nrrd", "f.nii", "f.nii.gz"};
    test_rng rng = rng_seeded("facts");
    ost_error err = {0};
    ost_volume v;
    const ost_geometry g = {
        .dims = {2, 1, 3}, .spacing = {pm("0.123456789"), pm("0.5"), pm("1")}, .origin = {pm("-0.000000001"), 0, 0}};
    make_volume(&v, &g, &rng);
    for (size_t k = 0; k < sizeof keys / sizeof keys[0]; k++)
        assert_ok(ost_meta_set(&v.meta, keys[k], values[k], &err));
    /* the new value is stored at the position of the old one */
    assert_ok(ost_meta_set(&v.meta, "zebra", "again", &err));
    for (size_t f = 0; f < sizeof formats / sizeof formats[0]; f++) {
        if (!HAS_NIFTI && strstr(formats[f], ".nii"))
            continue;
        ost_volume back;
        assert_ok(ost_volume_write(at(formats[f]), &v, NULL, &err));
        assert_ok(ost_volume_read(at(formats[f]), NULL, &back, NULL, &err));
        assert_true(ost_geometry_equal(&back.geometry, &g));
        assert_int_equal(back.meta.count, sizeof kept / sizeof kept[0]);
        for (size_t k = 0; k < sizeof kept / sizeof kept[0]; k++) {
            assert_string_equal(back.meta.entry[k].key, kept[k]);
            assert_string_equal(back.meta.entry[k].value, ost_meta_get(&v.meta, kept[k]));
        }
        ost_volume_free(&back);
    }
    ost_volume_free(&v);
}

/* If a NRRD file contains a key twice, the last value is stored at the position of the first. Spaces around a value
   are removed. */
static void nrrd_keys_become_facts(void **state)
{
    (void)state;
    static const char text[] = "NRRD0005\ntype: int8\ndimension: 3\nsizes: 1 1 1\nspace: LPS\nspace directions: "
                               "(1,0,0) (0,1,0) (0,0,1)\nencoding: text\nosteon_b:=1\n"
                               "osteon_a:=  two\\\\ \\nlines \nother:=x\nosteon_b:=3\n\n5\n";
    ost_error err = {0};
    ost_volume v;
    write_file("g.nrrd", text, sizeof text - 1);
    assert_ok(ost_volume_read(at("g.nrrd"), NULL, &v, NULL, &err));
    assert_int_equal(v.meta.count, 2);
    assert_string_equal(v.meta.entry[0].key, "b");
    assert_string_equal(v.meta.entry[0].value, "3");
    assert_string_equal(v.meta.entry[1].value, "two\\  lines");
    ost_volume_free(&v);
}

/*
 * Without osteon's comment in the header, lengths are read as the shortest decimals of the
 * float32 values. This restores lengths of up to six digits exactly.
 */
static void nifti_without_osteon_comment(void **state)
{
    (void)state;
    if (!HAS_NIFTI)
        skip();
    static const char *const lengths[] = {"0.3", "0.032", "0.488281", "0.47", "0.48828125", "57.34", "1"};
    test_rng rng = rng_seeded("nifti");
    ost_error err = {0};
    for (size_t l = 0; l < sizeof lengths / sizeof lengths[0]; l++) {
        ost_volume v, back;
        ost_pm length = pm(lengths[l]);
        const ost_geometry g = {
            .dims = {2, 3, 2}, .spacing = {length, length, length}, .origin = {-length, length, -length}};
        size_t size;
        make_volume(&v, &g, &rng);
        assert_ok(ost_volume_write(at("n.nii"), &v, NULL, &err));
        char *file = read_all(at("n.nii"), &size);
        file[348] = 0; /* the extender field; 0 means that no extensions follow */
        write_file("n.nii", file, size);
        free(file);
        assert_ok(ost_volume_read(at("n.nii"), NULL, &back, NULL, &err));
        assert_volumes_equal(&v, &back);
        ost_volume_free(&v);
        ost_volume_free(&back);
    }
}

/* If another program has changed the volume's position, osteon's comment in the header is outdated and must not be
   used. */
static void changed_nifti_header_overrides_the_comment(void **state)
{
    (void)state;
    if (!HAS_NIFTI)
        skip();
    ost_error err = {0};
    ost_volume v, back;
    const ost_geometry g = {.dims = {1, 1, 1}, .spacing = {pm("0.123456789"), pm("1"), pm("1")}, .origin = {0, 0, 0}};
    test_rng rng = rng_seeded("changed");
    size_t size;
    make_volume(&v, &g, &rng);
    assert_ok(ost_volume_write(at("n.nii"), &v, NULL, &err));
    char *file = read_all(at("n.nii"), &size);
    const float moved = -5.5f;
    memcpy(file + 280 + 12, &moved, 4); /* srow_x[3] */
    memcpy(file + 268, &moved, 4);      /* qoffset_x */
    write_file("n.nii", file, size);
    free(file);
    assert_ok(ost_volume_read(at("n.nii"), NULL, &back, NULL, &err));
    assert_int_equal(back.geometry.origin.x, pm("5.5"));
    assert_int_equal(back.geometry.spacing.x, pm("0.12345679"));
    assert_int_equal(back.meta.count, 0);
    ost_volume_free(&v);
    ost_volume_free(&back);
}

static void nrrd_header_has_the_expected_bytes(void **state)
{
    (void)state;
    static const char expected[] = "NRRD0005\n"
                                   "type: int16\n"
                                   "dimension: 3\n"
                                   "space: left-posterior-superior\n"
                                   "sizes: 2 1 1\n"
                                   "space directions: (0.47,0,0) (0,0.47,0) (0,0,1)\n"
                                   "kinds: domain domain domain\n"
                                   "endian: little\n"
                                   "encoding: raw\n"
                                   "space units: \"mm\" \"mm\" \"mm\"\n"
                                   "space origin: (-57.34,0,0.5)\n"
                                   "osteon_side:=left\n"
                                   "\n"
                                   "\x01\x02\xff\xff";
    ost_error err = {0};
    int16_t voxels[2] = {0x0201, -1};
    ost_volume v = {.geometry = {{2, 1, 1}, {pm("0.47"), pm("0.47"), pm("1")}, {pm("-57.34"), 0, pm("0.5")}},
                    .voxels = voxels};
    size_t size;
    assert_ok(ost_meta_set(&v.meta, "side", "left", &err));
    assert_ok(ost_volume_write(at("b.nrrd"), &v, NULL, &err));
    char *file = read_all(at("b.nrrd"), &size);
    assert_int_equal(size, sizeof expected - 1);
    assert_memory_equal(file, expected, size);
    free(file);
}

static void failed_writes_leave_no_file(void **state)
{
    (void)state;
    ost_error err = {0};
    int16_t voxel = 1;
    ost_volume v = {.geometry = {{1, 1, 1}, {pm("1"), pm("1"), pm("1")}, {0, 0, 0}}, .voxels = &voxel};
    assert_int_equal(ost_volume_write(at("x.mhd"), &v, NULL, &err), OST_ERR_USAGE);
    assert_non_null(strstr(err.text, ".nii.gz"));
    assert_int_equal(ost_volume_write(at("none/x.nrrd"), &v, NULL, &err), OST_ERR_IO);
    v.geometry.dims.x = 0;
    assert_int_equal(ost_volume_write(at("y.nrrd"), &v, NULL, &err), OST_ERR_RANGE);
    assert_int_equal(access(at("y.nrrd"), F_OK), -1);
}

/* Copies a text without its comment lines. */
static void strip_comments(const char *from, const char *to)
{
    size_t size, used = 0;
    char *text = read_all(at(from), &size);
    for (char *line = text; *line;) {
        size_t n = strcspn(line, "\n") + 1;
        if (*line != '#') {
            memmove(text + used, line, n);
            used += n;
        }
        line += n;
    }
    write_file(to, text, used);
    free(text);
}

static void import_digests(ost_backend *backend, const char *name, ost_geometry *rect, ost_digest digests[3])
{
    ost_error err = {0};
    ost_bone *bone;
    ost_import_result result;
    const ost_import_options options = {.digests = true};
    int found = 0;
    assert_ok(ost_import(backend, at(name), &options, &bone, &result, &err));
    for (int s = 0; s < result.stage_count; s++)
        if (strcmp(result.stages[s].name, "samples") != 0)
            digests[found++] = result.stages[s].digest;
    assert_int_equal(found, 3);
    *rect = result.rect;
    ost_bone_free(bone);
}

/*
 * Imports the same volume as text (with 4 decimals, 6 decimals, or as many as needed), NRRD and NIfTI.
 * Every format must give the same bone. If the text has no comments, the spacing is inferred from the
 * coordinates.
 */
static void every_format_imports_to_the_same_bone(void **state)
{
    (void)state;
    static const struct {
        const char *spacing, *thick, *origin;
    } cases[] = {{"0.3", "0.3", "-57.34"},        {"0.032", "0.032", "-0.512"},   {"0.488281", "1", "-57.34"},
                 {"0.47", "1", "-57.34"},         {"0.48828125", "1.25", "12.5"}};
    static const struct {
        const char *name;
        int decimals;
        bool compress;
    } ways[] = {{"i.nrrd", 0, false}, {"j.nrrd", 0, true}, {"i.nii", 0, false}, {"i.nii.gz", 0, false},
                {"i.txt", 0, false},  {"j.txt", 6, false}, {"k.txt", 4, false}};
    test_rng rng = rng_seeded("import");
    ost_error err = {0};
    ost_backend *backend;
    assert_ok(ost_backend_open(test_backend, &backend, &err));
    for (size_t c = 0; c < sizeof cases / sizeof cases[0]; c++) {
        ost_volume v;
        const ost_geometry g = {.dims = {40, 31, 23},
                                .spacing = {pm(cases[c].spacing), pm(cases[c].spacing), pm(cases[c].thick)},
                                .origin = {pm(cases[c].origin), pm(cases[c].origin), 0}};
        make_volume(&v, &g, &rng);
        ost_digest first[3], digests[3];
        ost_geometry rect;
        for (size_t w = 0; w < sizeof ways / sizeof ways[0]; w++) {
            if (!HAS_NIFTI && strstr(ways[w].name, ".nii"))
                continue;
            const ost_write_options options = {.compress = ways[w].compress, .text_decimals = ways[w].decimals};
            assert_ok(ost_volume_write(at(ways[w].name), &v, &options, &err));
            import_digests(backend, ways[w].name, &rect, w ? digests : first);
            assert_true(ost_geometry_equal(&rect, &g));
            if (w)
                assert_memory_equal(digests, first, sizeof first);
        }
        strip_comments("i.txt", "bare.txt");
        import_digests(backend, "bare.txt", &rect, digests);
        assert_true(ost_geometry_equal(&rect, &g));
        assert_memory_equal(digests, first, sizeof first);
        ost_volume_free(&v);
    }
    ost_backend_close(backend);
}

/* ------------------------------------------------------------------- bones */

static void bones_are_written_in_slabs(void **state)
{
    (void)state;
    ost_error err = {0};
    ost_backend *backend;
    ost_bone *bone;
    ost_volume v, back;
    /* The volume is greater than one slab of 8 MiB: 1200 x 900 x 9 int16 are 19 MB. */
    const ost_geometry g = {
        .dims = {1200, 900, 9}, .spacing = {pm("0.47"), pm("0.47"), pm("0.47")}, .origin = {pm("-57.34"), 0, 0}};
    test_rng rng = rng_seeded("bones");
    make_volume(&v, &g, &rng);
    assert_ok(ost_backend_open(test_backend, &backend, &err));
    assert_ok(ost_bone_create(backend, &g, 32, 150, &bone, &err));
    assert_ok(ost_bone_upload(bone, 0, g.dims.z, v.voxels, &err));
    ost_meta given = {0};
    assert_ok(ost_meta_set(&given, OST_META_SIDE, "left", &err));
    assert_ok(ost_bone_write(at("bone.nrrd"), bone, &given, NULL, &err));
    assert_ok(ost_volume_read(at("bone.nrrd"), NULL, &back, NULL, &err));
    assert_true(ost_geometry_equal(&back.geometry, &g));
    for (int64_t i = 0; i < ost_dims_count(g.dims); i++)
        if (back.voxels[i] != (v.voxels[i] >= 150 ? v.voxels[i] : 0))
            fail_msg("voxel %lld is %d; it was written as %d", (long long)i, back.voxels[i], v.voxels[i]);
    assert_string_equal(ost_meta_get(&back.meta, OST_META_KIND), "bone");
    assert_string_equal(ost_meta_get(&back.meta, OST_META_THRESHOLD), "150");
    assert_string_equal(ost_meta_get(&back.meta, OST_META_ARITHMETIC), "2");
    assert_string_equal(ost_meta_get(&back.meta, OST_META_SIDE), "left");
    ost_volume_free(&back);
    ost_bone_free(bone);
    ost_backend_close(backend);
    ost_volume_free(&v);
}

/* ---------------------------------------------------------------- progress */

typedef struct watcher {
    const char *stage;
    double last;
    int calls, cancel_at; /* cancel_at is the number of the call that cancels, or 0 for none */
} watcher;

static bool watch(void *user, const char *stage, double share)
{
    watcher *w = user;
    assert_string_equal(stage, w->stage);
    assert_true(share >= w->last && share < 1);
    w->last = share;
    return ++w->calls != w->cancel_at;
}

/*
 * Reading reports progress for each of the 9 slices. Writing reports progress for every 2^20 voxels and for the
 * remainder, in total 10 times for this volume. A cancelled call must return OST_ERR_CANCELLED and leave neither a file
 * nor voxels.
 */
static void progress_is_reported_and_can_cancel(void **state)
{
    (void)state;
    ost_error err = {0};
    ost_volume v, back;
    const ost_geometry g = {.dims = {1200, 900, 9}, .spacing = {pm("0.5"), pm("0.5"), pm("1")}};
    test_rng rng = rng_seeded("progress");
    make_volume(&v, &g, &rng);
    for (int cancel = 0; cancel < 2; cancel++) {
        watcher w = {.stage = "writing", .cancel_at = cancel ? 5 : 0};
        const ost_write_options write = {.progress = watch, .progress_user = &w};
        assert_int_equal(ost_volume_write(at(cancel ? "cancelled.nrrd" : "watched.nrrd"), &v, &write, &err),
                         cancel ? OST_ERR_CANCELLED : OST_OK);
        assert_int_equal(w.calls, cancel ? 5 : 10);
    }
    assert_int_equal(access(at("cancelled.nrrd"), F_OK), -1);
    for (int cancel = 0; cancel < 2; cancel++) {
        watcher w = {.stage = "reading", .cancel_at = cancel ? 5 : 0};
        const ost_volume_options read = {.progress = watch, .progress_user = &w};
        assert_int_equal(ost_volume_read(at("watched.nrrd"), &read, &back, NULL, &err),
                         cancel ? OST_ERR_CANCELLED : OST_OK);
        assert_int_equal(w.calls, cancel ? 5 : 9);
        assert_int_equal(back.voxels == NULL, cancel);
        ost_volume_free(&back);
    }
    ost_volume_free(&v);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(facts_keep_their_order),
        cmocka_unit_test(nrrd_keys_become_facts),
        cmocka_unit_test(every_format_restores_the_volume),
        cmocka_unit_test(nifti_without_osteon_comment),
        cmocka_unit_test(changed_nifti_header_overrides_the_comment),
        cmocka_unit_test(nrrd_header_has_the_expected_bytes),
        cmocka_unit_test(failed_writes_leave_no_file),
        cmocka_unit_test(every_format_imports_to_the_same_bone),
        cmocka_unit_test(bones_are_written_in_slabs),
        cmocka_unit_test(progress_is_reported_and_can_cancel),
    };
    return run_on_backends(tests, make_scratch, drop_scratch);
}
