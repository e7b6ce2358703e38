/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests reading NIfTI-1 and NIfTI-2: types, byte orders, pairs of header and image, scaling,
 * units, and the choice among sform, qform and pixdim.
 *
 * Covers: AR-LEN-4, AR-GRID-4, AR-FILE-4, AR-FILE-5, AR-FILE-6, REQ-NIFTI
 */
#include "nifti_files.h"

#include <math.h>

static const unsigned char eight[8] = {0, 1, 2, 3, 4, 5, 6, 7};

static void read_plain(const char *name, ost_volume *v, ost_volume_report *report)
{
    ost_error err = {0};
    assert_ok(ost_volume_read(at(name), NULL, v, report, &err));
}

static void assert_grid(const ost_volume *v, ost_pm sx, ost_pm sy, ost_pm sz, ost_pm ox, ost_pm oy, ost_pm oz)
{
    const ost_geometry expected = {v->geometry.dims, {sx, sy, sz}, {ox, oy, oz}};
    if (!ost_geometry_equal(&v->geometry, &expected))
        fail_msg("spacing (%lld, %lld, %lld), origin (%lld, %lld, %lld) pm; expected spacing (%lld, %lld, %lld), "
                 "origin (%lld, %lld, %lld) pm",
                 (long long)v->geometry.spacing.x, (long long)v->geometry.spacing.y, (long long)v->geometry.spacing.z,
                 (long long)v->geometry.origin.x, (long long)v->geometry.origin.y, (long long)v->geometry.origin.z,
                 (long long)sx, (long long)sy, (long long)sz, (long long)ox, (long long)oy, (long long)oz);
}

static void every_type_version_and_order(void **state)
{
    (void)state;
    static const struct {
        int code, bits, kind; /* kind of the type: 0 integer, 1 float, 2 double */
        const char *name;
    } types[] = {{2, 8, 0, "uint8"},     {256, 8, 0, "int8"},    {4, 16, 0, "int16"},    {512, 16, 0, "uint16"},
                 {8, 32, 0, "int32"},    {768, 32, 0, "uint32"}, {1024, 64, 0, "int64"}, {1280, 64, 0, "uint64"},
                 {16, 32, 1, "float32"}, {64, 64, 2, "float64"}};
    for (size_t t = 0; t < sizeof types / sizeof types[0]; t++) {
        for (int variant = 0; variant < 8; variant++) {
            nifti_spec s = nifti_plain(variant & 1 ? 1 : 2);
            s.big = variant & 2;
            s.datatype = types[t].code;
            s.bitpix = types[t].bits;
            static bytes data;
            data.size = 0;
            for (int i = 0; i < 8; i++)
                put_bits(&data,
                         types[t].kind == 1   ? float_bits((float)(i * 15))
                         : types[t].kind == 2 ? double_bits(i * 15)
                                              : (uint64_t)(i * 15),
                         (size_t)types[t].bits / 8, s.big);
            const char *name = variant & 4 ? "t.nii.gz" : "t.nii";
            write_nifti(name, &s, data.data, data.size);
            ost_volume v;
            ost_volume_report report;
            read_plain(name, &v, &report);
            assert_string_equal(report.type, types[t].name);
            assert_string_equal(report.encoding, variant & 4 ? "gzip" : "raw");
            assert_string_equal(report.orientation, "");
            for (int i = 0; i < 8; i++)
                assert_int_equal(v.voxels[i], i * 15);
            ost_volume_free(&v);
        }
    }
}

static void pairs_of_header_and_image(void **state)
{
    (void)state;
    static bytes packed;
    for (int version = 1; version <= 2; version++) {
        nifti_spec s = nifti_plain(version);
        s.pair = true;
        ost_volume v;
        ost_volume_report report;
        unlink(at("p.img"));
        write_nifti("p.hdr", &s, NULL, 0);
        assert_refused(at("p.hdr"), NULL, OST_ERR_INPUT, "no file with the voxels");
        packed.size = 0;
        put_gzip(&packed, eight, 8);
        write_file("p.img.gz", packed.data, packed.size);
        read_plain("p.hdr", &v, &report);
        assert_memory_equal(v.voxels, ((int16_t[]){0, 1, 2, 3, 4, 5, 6, 7}), 16);
        ost_volume_free(&v);
        unlink(at("p.img.gz"));
        write_file("p.img", "skip\0\1\2\3\4\5\6\7", 12);
        s.vox_offset = 4;
        write_nifti("p.hdr", &s, NULL, 0);
        read_plain("p.img", &v, &report); /* if the path of the image is given, the reader also reads the header */
        assert_int_equal(v.voxels[7], 7);
        ost_volume_free(&v);
    }
}

static void slope_and_intercept(void **state)
{
    (void)state;
    static const struct {
        double slope, inter;
        int expected[3]; /* expected densities of the stored values 1, 2 and 3 */
        int rounded;
    } cases[] = {
        {0, 500, {1, 2, 3}, 0},     {1, -1024, {-1023, -1022, -1021}, 0}, {0.5, 0, {0, 1, 2}, 4},
        {2.5, 0, {2, 5, 8}, 4},     {-2, 1, {-1, -3, -5}, 0},            {1, 0, {1, 2, 3}, 0},
        {(double)NAN, 7, {1, 2, 3}, 0},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        nifti_spec s = nifti_plain(1);
        s.slope = cases[i].slope;
        s.inter = cases[i].inter;
        write_nifti("s.nii", &s, eight, 8);
        ost_volume v;
        ost_volume_report report;
        read_plain("s.nii", &v, &report);
        for (int n = 0; n < 3; n++)
            assert_int_equal(v.voxels[n + 1], cases[i].expected[n]);
        assert_int_equal(report.rounded_values, cases[i].rounded);
        ost_volume_free(&v);
    }
    nifti_spec s = nifti_plain(1);
    s.slope = 10000;
    write_nifti("s.nii", &s, eight, 8);
    assert_refused(at("s.nii"), NULL, OST_ERR_INPUT, "after slope and intercept");
    s.slope = 1;
    s.inter = (double)INFINITY;
    write_nifti("s.nii", &s, eight, 8);
    assert_refused(at("s.nii"), NULL, OST_ERR_INPUT, "scl_inter");
}

/* Tests which of sform, qform and pixdim is used. Each of the three gives a different voxel size or position. */
static void choice_of_sform_qform_or_pixdim(void **state)
{
    (void)state;
    static const struct {
        int sform, qform, expected; /* expected: 1 if sform is used, 2 if qform is used, 3 if only pixdim is used */
    } cases[] = {{1, 1, 1}, {2, 1, 1}, {1, 0, 1}, {0, 1, 2}, {4, 1, 2}, {3, 2, 2}, {4, 0, 1}, {0, 0, 3}};
    const ost_pm mm = OST_PM_PER_MM;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        for (int version = 1; version <= 2; version++) {
            nifti_spec s = nifti_plain(version);
            s.sform_code = cases[i].sform;
            s.qform_code = cases[i].qform;
            s.pixdim[1] = s.pixdim[2] = s.pixdim[3] = 2;
            s.quatern[2] = 1;
            s.qoffset[0] = 10;
            for (int w = 0; w < 3; w++)
                s.srow[w][w] = 3;
            s.srow[0][3] = 20;
            write_nifti("o.nii", &s, eight, 8);
            ost_volume v;
            ost_volume_report report;
            ost_error err = {0};
            /*
             * If `both` is true, sform and qform refer to the patient and disagree, so an option must
             * select one of them. The test sform_and_qform_that_disagree tests this option.
             */
            const bool both = cases[i].expected == 1 && cases[i].qform > 0;
            const ost_volume_options by_sform = {.form = both ? OST_FORM_SFORM : OST_FORM_AUTO};
            assert_ok(ost_volume_read(at("o.nii"), &by_sform, &v, &report, &err));
            assert_int_equal(report.assumed, cases[i].expected == 3);
            if (cases[i].expected == 1) {
                assert_grid(&v, 3 * mm, 3 * mm, 3 * mm, -23 * mm, -3 * mm, 0);
                assert_string_equal(report.orientation, "RAS");
                assert_int_equal(v.voxels[0], 3);
            } else if (cases[i].expected == 2) {
                assert_grid(&v, 2 * mm, 2 * mm, 2 * mm, -10 * mm, 0, 0);
                assert_string_equal(report.orientation, "LPS");
                assert_int_equal(v.voxels[0], 0);
            } else {
                assert_grid(&v, 2 * mm, 2 * mm, 2 * mm, 0, 0, 0);
                assert_string_equal(report.orientation, "");
            }
            ost_volume_free(&v);
        }
    }
}

/*
 * Reads a grid of 2 x 2 x 2 voxels of 1 mm. The sform differs from the qform in its z step and in its origin, which is
 * moved along R. The displacement of the farthest corner is the sum of both changes. If this displacement is at most
 * one voxel, the forms agree. If it is greater, an option must select a form.
 */
static void sform_and_qform_that_disagree(void **state)
{
    (void)state;
    static const struct {
        double moved, z_step;
        bool refused;
    } cases[] = {{0, 1, false}, {1, 1, false},    {1.001, 1, true}, {-1.001, 1, true},
                 {0, 2, false}, {0, 2.001, true}, {-4, 1, true}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        nifti_spec s = nifti_plain(1 + (int)(i % 2));
        s.qform_code = 1;
        s.sform_code = 1 + (int)(i / 2 % 2);
        for (int w = 0; w < 3; w++)
            s.srow[w][w] = 1;
        s.srow[0][3] = cases[i].moved;
        s.srow[2][2] = cases[i].z_step;
        write_nifti("f.nii", &s, eight, 8);
        ost_volume v;
        ost_error err = {0};
        if (cases[i].refused) {
            assert_refused(at("f.nii"), NULL, OST_ERR_INPUT, "its qform and its sform place the same voxel up to");
        } else {
            assert_ok(ost_volume_read(at("f.nii"), NULL, &v, NULL, &err));
            ost_volume_free(&v);
        }
        const ost_pm mm = OST_PM_PER_MM, moved = llround(cases[i].moved * 1000) * (mm / 1000),
                     z = llround(cases[i].z_step * 1000) * (mm / 1000);
        assert_ok(ost_volume_read(at("f.nii"), &(ost_volume_options){.form = OST_FORM_SFORM}, &v, NULL, &err));
        assert_grid(&v, mm, mm, z, -moved - mm, -mm, 0);
        ost_volume_free(&v);
        assert_ok(ost_volume_read(at("f.nii"), &(ost_volume_options){.form = OST_FORM_QFORM}, &v, NULL, &err));
        assert_grid(&v, mm, mm, mm, -mm, -mm, 0);
        ost_volume_free(&v);
        s.qform_code = 0;
        write_nifti("f.nii", &s, eight, 8);
        assert_ok(ost_volume_read(at("f.nii"), NULL, &v, NULL, &err));
        ost_volume_free(&v);
        assert_refused(at("f.nii"), &(ost_volume_options){.form = OST_FORM_QFORM}, OST_ERR_USAGE,
                       "--form qform: not in the header");
    }
}

/*
 * If a file has neither sform nor qform, the orientation letters give the directions of i, j and
 * k. Tests all 48 codes. Voxel (0, 0, 0) must stay at the origin.
 */
static void without_sform_and_qform(void **state)
{
    (void)state;
    static const char letters[3][3] = {"LR", "PA", "SI"};
    static const int orders[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
    const ost_pm mm = OST_PM_PER_MM;
    nifti_spec s = nifti_plain(1);
    ost_error err = {0};
    ost_volume v;
    ost_volume_report report;
    for (int a = 0; a < 3; a++)
        s.pixdim[a + 1] = a + 1;
    write_nifti("n.nii", &s, eight, 8);
    for (int code = 0; code < 48; code++) {
        ost_volume_options options = {.form = OST_FORM_AUTO};
        const int *order = orders[code / 8];
        ost_pm spacing[3], origin[3];
        int first = 0;
        for (int a = 0; a < 3; a++) {
            const int back = code >> a & 1;
            options.orientation[a] = letters[order[a]][back];
            spacing[order[a]] = (a + 1) * mm;
            origin[order[a]] = back ? -(a + 1) * mm : 0;
            first += back << a;
        }
        assert_ok(ost_volume_read(at("n.nii"), &options, &v, &report, &err));
        assert_grid(&v, spacing[0], spacing[1], spacing[2], origin[0], origin[1], origin[2]);
        assert_int_equal(v.voxels[0], first);
        assert_string_equal(report.orientation, options.orientation);
        assert_false(report.assumed);
        assert_string_equal(ost_meta_get(&v.meta, OST_META_ORIENTATION) + strlen("stated "), options.orientation);
        ost_volume_free(&v);
    }
    assert_ok(ost_volume_read(at("n.nii"), NULL, &v, &report, &err));
    assert_true(report.assumed);
    assert_string_equal(report.orientation, "");
    assert_string_equal(ost_meta_get(&v.meta, OST_META_ORIENTATION), "assumed LPS");
    ost_volume_free(&v);
    static const char *const bad[] = {"LLS", "LP", "lps", "XYZ", "L S"};
    for (size_t b = 0; b < sizeof bad / sizeof bad[0]; b++) {
        ost_volume_options options = {.form = OST_FORM_AUTO};
        strcpy(options.orientation, bad[b]);
        assert_int_equal(ost_volume_read(at("n.nii"), &options, &v, &report, &err), OST_ERR_USAGE);
        assert_non_null(strstr(err.text, "expected three letters"));
    }
    s.sform_code = 1;
    for (int w = 0; w < 3; w++)
        s.srow[w][w] = w + 1;
    write_nifti("n.nii", &s, eight, 8);
    assert_refused(at("n.nii"), &(ost_volume_options){.orientation = "RAS"}, OST_ERR_USAGE,
                   "its header states where its axes point");
}

/*
 * Reads quaternions of quarter turns, with exact components and with sqrt(1/2) rounded to float32. The
 * spacing must equal pixdim.
 */
static void quarter_turns(void **state)
{
    (void)state;
    static const struct {
        double b, c, d;
        const char *code;
    } cases[] = {{0, 0, 0, "RAS"},          {1, 0, 0, "RPI"},
                 {0, 1, 0, "LAI"},          {0, 0, 1, "LPS"},
                 {0.5, 0.5, 0.5, "ASR"},    {0, 0, 0.70710678, "ALS"},
                 {0.70710678, 0, 0, "RSP"}, {0.70710678, 0.70710678, 0, "ARI"}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        for (int flip = 0; flip < 2; flip++) {
            nifti_spec s = nifti_plain(1);
            s.qform_code = 1;
            s.pixdim[0] = flip ? -1 : 1;
            s.pixdim[1] = 0.47;
            s.pixdim[2] = 0.488281;
            s.pixdim[3] = 0.3;
            s.quatern[0] = cases[i].b;
            s.quatern[1] = cases[i].c;
            s.quatern[2] = cases[i].d;
            write_nifti("q.nii", &s, eight, 8);
            ost_volume v;
            ost_volume_report report;
            read_plain("q.nii", &v, &report);
            char code[4];
            strcpy(code, cases[i].code);
            if (flip)
                code[2] = code[2] == 'S'   ? 'I'
                          : code[2] == 'I' ? 'S'
                          : code[2] == 'R' ? 'L'
                          : code[2] == 'L' ? 'R'
                          : code[2] == 'P' ? 'A'
                                           : 'P';
            assert_string_equal(report.orientation, code);
            const ost_pm spacing[3] = {v.geometry.spacing.x, v.geometry.spacing.y, v.geometry.spacing.z};
            const ost_pm expected[3] = {470000000, 488281000, 300000000};
            for (int a = 0; a < 3; a++) {
                int w = strchr("RL", code[a]) ? 0 : strchr("AP", code[a]) ? 1 : 2;
                assert_int_equal(spacing[w], expected[a]);
            }
            ost_volume_free(&v);
        }
    }
}

static void units_and_float32(void **state)
{
    (void)state;
    static const double spacings[] = {0.3, 0.032, 0.488281, 0.47, 0.48828125, 1};
    for (size_t i = 0; i < sizeof spacings / sizeof spacings[0]; i++) {
        for (int units = 0; units < 4; units++) {
            for (int version = 1; version <= 2; version++) {
                nifti_spec s = nifti_plain(version);
                double unit = units == 1 ? 0.001 : units == 3 ? 1000 : 1;
                s.units = units | 8; /* the upper bits contain the time unit, seconds */
                s.sform_code = 1;
                s.srow[0][0] = -spacings[i] * unit;
                s.srow[1][1] = -spacings[i] * unit;
                s.srow[2][2] = spacings[i] * unit;
                s.srow[0][3] = 57.34 * unit;
                write_nifti("u.nii", &s, eight, 8);
                ost_volume v;
                ost_volume_report report;
                read_plain("u.nii", &v, &report);
                char text[32];
                ost_pm spacing;
                ost_error err = {0};
                snprintf(text, sizeof text, "%.8f", spacings[i]);
                assert_ok(ost_pm_parse(text, &spacing, &err));
                assert_grid(&v, spacing, spacing, spacing, -57340000000, 0, 0);
                ost_volume_free(&v);
            }
        }
    }
}

static void files_with_more_than_three_axes(void **state)
{
    (void)state;
    nifti_spec s = nifti_plain(1);
    s.dim[0] = 5;
    write_nifti("d.nii", &s, eight, 8);
    ost_volume v;
    ost_volume_report report;
    read_plain("d.nii", &v, &report);
    ost_volume_free(&v);
    s.dim[4] = 2;
    write_nifti("d.nii", &s, eight, 8);
    assert_refused(at("d.nii"), NULL, OST_ERR_INPUT, "dim[4] is 2");
}

static void oblique_grid_is_refused_or_resampled(void **state)
{
    (void)state;
    ost_error err = {0};
    ost_volume v;
    ost_volume_report report;
    const ost_volume_options resample = {.resample_oblique = true};
    nifti_spec s = nifti_plain(1);
    s.sform_code = 1;
    s.srow[0][0] = 0.8;
    s.srow[0][1] = -0.6;
    s.srow[1][0] = 0.6;
    s.srow[1][1] = 0.8;
    s.srow[2][2] = 1;
    write_nifti("b.nii", &s, eight, 8);
    assert_refused(at("b.nii"), NULL, OST_ERR_INPUT, "36.87 degrees");
    assert_ok(ost_volume_read(at("b.nii"), &resample, &v, &report, &err));
    assert_true(report.resampled);
    assert_int_equal(v.geometry.spacing.x, OST_PM_PER_MM);
    assert_int_equal(v.geometry.dims.x, 3);
    ost_volume_free(&v);
}

/* Without libnifti the type of the file must still be recognized, and the error must name the package to install. */
static void without_libnifti(void **state)
{
    (void)state;
    nifti_spec s = nifti_plain(1);
    if (HAS_NIFTI)
        skip();
    write_nifti("w.nii.gz", &s, eight, 8);
    assert_refused(at("w.nii.gz"), NULL, OST_ERR_UNAVAILABLE, "libnifti-dev");
}

int main(void)
{
    const struct CMUnitTest absent[] = {cmocka_unit_test(without_libnifti)};
    if (!HAS_NIFTI)
        return cmocka_run_group_tests(absent, make_scratch, drop_scratch);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_type_version_and_order),
        cmocka_unit_test(pairs_of_header_and_image),
        cmocka_unit_test(slope_and_intercept),
        cmocka_unit_test(choice_of_sform_qform_or_pixdim),
        cmocka_unit_test(quarter_turns),
        cmocka_unit_test(units_and_float32),
        cmocka_unit_test(files_with_more_than_three_axes),
        cmocka_unit_test(oblique_grid_is_refused_or_resampled),
        cmocka_unit_test(sform_and_qform_that_disagree),
        cmocka_unit_test(without_sform_and_qform),
    };
    return cmocka_run_group_tests(tests, make_scratch, drop_scratch);
}
