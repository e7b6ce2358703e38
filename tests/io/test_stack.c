/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests reading stacks of TIFF and PNG slices: types, byte orders and compressions, the order of the
 * slices, the axes, and stacks that are refused. Every file is built byte by byte (stack_files.h).
 *
 * Covers: AR-FILE-9, REQ-STACK
 */
#include "stack_files.h"

#include <math.h>

enum { NX = 3, NY = 2, NZ = 4, SLICE = NX * NY };

#ifndef HAVE_TIFF
enum { HAS_TIFF = 0 };
#else
enum { HAS_TIFF = 1 };
#endif
#ifndef HAVE_PNG
enum { HAS_PNG = 0 };
#else
enum { HAS_PNG = 1 };
#endif

/* columns are 0.5 mm apart, rows 0.25 mm, and slices 2 mm */
static const ost_volume_options spaced = {.stack_spacing = {500000000, 250000000, 2000000000}};

/* Returns the value of a pixel. It is different for each voxel and within the range of every type. */
static int value(int x, int y, int z)
{
    return 1 + x + NX * (y + NY * z);
}

static void put_slice(bytes *b, int z, size_t size, bool is_float, bool big)
{
    b->size = 0;
    for (int y = 0; y < NY; y++)
        for (int x = 0; x < NX; x++)
            put_bits(b, is_float ? float_bits((float)value(x, y, z)) : (uint64_t)value(x, y, z), size, big);
}

static void make_folder(const char *name)
{
    assert_int_equal(mkdir(at(name), 0700), 0);
}

static void assert_is_stack(const ost_volume *v)
{
    assert_int_equal(v->geometry.dims.x, NX);
    assert_int_equal(v->geometry.dims.y, NY);
    assert_int_equal(v->geometry.dims.z, NZ);
    for (int z = 0; z < NZ; z++)
        for (int y = 0; y < NY; y++)
            for (int x = 0; x < NX; x++)
                assert_int_equal(v->voxels[x + NX * (y + NY * z)], value(x, y, z));
}

static ost_volume_report assert_reads(const char *name)
{
    ost_error err = {0};
    ost_volume v;
    ost_volume_report report;
    assert_ok(ost_volume_read(at(name), &spaced, &v, &report, &err));
    assert_is_stack(&v);
    assert_int_equal(v.geometry.spacing.x, 500000000);
    assert_int_equal(v.geometry.spacing.y, 250000000);
    assert_int_equal(v.geometry.spacing.z, 2000000000);
    assert_true(v.geometry.origin.x == 0 && v.geometry.origin.y == 0 && v.geometry.origin.z == 0);
    assert_string_equal(ost_meta_get(&v.meta, OST_META_ORIENTATION), "assumed LPS");
    ost_volume_free(&v);
    return report;
}

static void tiff_types_and_compressions(void **state)
{
    static const struct {
        unsigned bits, format;
        const char *name;
    } types[] = {{8, 1, "uint8"},   {8, 2, "int8"},   {16, 1, "uint16"}, {16, 2, "int16"},
                 {32, 1, "uint32"}, {32, 2, "int32"}, {32, 3, "float32"}};
    static bytes raw[NZ], packed[NZ];
    (void)state;
    if (!HAS_TIFF)
        skip();
    for (size_t t = 0; t < sizeof types / sizeof types[0]; t++) {
        /* a variant is a combination of byte order and compression (none or deflate) */
        for (int variant = 0; variant < 4; variant++) {
            const bool big = variant & 1, deflate = variant & 2;
            tiff_page pages[NZ];
            for (int z = 0; z < NZ; z++) {
                put_slice(&raw[z], z, types[t].bits / 8, types[t].format == 3, big);
                packed[z].size = 0;
                put_deflated(&packed[z], raw[z].data, raw[z].size, 15);
                const bytes *b = deflate ? &packed[z] : &raw[z];
                pages[z] = tiff_plain(NX, NY, types[t].bits, b->data, b->size);
                pages[z].format = types[t].format;
                pages[z].compression = deflate ? 8 : 1;
            }
            write_tiff("pages.tif", big, pages, NZ);
            const ost_volume_report report = assert_reads("pages.tif");
            assert_string_equal(report.type, types[t].name);
            assert_string_equal(report.encoding, deflate ? "deflate" : "raw");
            assert_true(report.assumed);
        }
    }
}

/* Tests a folder of files whose names contain a number from 8 to 11 without leading zeros, and another number that
   is constant. */
static void folders_are_ordered_by_number(void **state)
{
    static bytes raw;
    char name[64];
    (void)state;
    if (!HAS_TIFF)
        skip();
    make_folder("f");
    make_folder("f/inside");
    write_file("f/.hidden", "x", 1);
    for (int z = 0; z < NZ; z++) {
        put_slice(&raw, z, 1, false, false);
        const tiff_page page = tiff_plain(NX, NY, 8, raw.data, raw.size);
        snprintf(name, sizeof name, "f/s12_bc%d.tif", 8 + z); /* the numbers are 8, 9, 10 and 11 */
        write_tiff(name, false, &page, 1);
    }
    assert_reads("f");
    ost_error err = {0};
    ost_file_kind kind;
    assert_ok(ost_file_kind_find(at("f"), &kind, &err));
    assert_int_equal(kind, OST_FILE_STACK);
    /* If a folder also contains other files, a pattern must select the slices. */
    write_file("f/scan.log", "x", 1);
    assert_ok(ost_file_kind_find(at("f"), &kind, &err));
    assert_int_equal(kind, OST_FILE_DICOM);
    assert_reads("f/s12_*.tif");
    assert_refused(at("f/x*.tif"), &spaced, OST_ERR_INPUT, "no file");
}

static void png_of_8_and_16_bits(void **state)
{
    static bytes raw, file;
    char name[64];
    (void)state;
    if (!HAS_PNG)
        skip();
    for (unsigned bits = 8; bits <= 16; bits += 8) {
        snprintf(name, sizeof name, "png%u", bits);
        make_folder(name);
        for (int z = 0; z < NZ; z++) {
            put_slice(&raw, z, bits / 8, false, true);
            file.size = 0;
            put_png(&file, NX, NY, bits, 0, 0, raw.data, NX * bits / 8, NY);
            snprintf(name, sizeof name, "png%u/%04d.png", bits, z);
            write_file(name, file.data, file.size);
        }
        snprintf(name, sizeof name, "png%u", bits);
        const ost_volume_report report = assert_reads(name);
        assert_string_equal(report.type, bits == 8 ? "uint8" : "uint16");
    }
}

/*
 * With the orientation SAR, x points to superior, y to anterior, and z to right. Relative to the first
 * voxel, voxel (x, y, z) of the stack is 0.5 x mm superior, 0.25 y mm anterior and 2 z mm right. The
 * grid has 4 x 2 x 3 voxels in LPS.
 */
static void orientation_option_is_applied(void **state)
{
    static bytes raw[NZ];
    tiff_page pages[NZ];
    ost_error err = {0};
    ost_volume v;
    ost_volume_options options = spaced;
    (void)state;
    if (!HAS_TIFF)
        skip();
    memcpy(options.orientation, "SAR", 4);
    for (int z = 0; z < NZ; z++) {
        put_slice(&raw[z], z, 1, false, false);
        pages[z] = tiff_plain(NX, NY, 8, raw[z].data, raw[z].size);
    }
    write_tiff("o.tif", false, pages, NZ);
    assert_ok(ost_volume_read(at("o.tif"), &options, &v, NULL, &err));
    const ost_geometry expected = {{NZ, NY, NX}, {2000000000, 250000000, 500000000}, {-6000000000, -250000000, 0}};
    assert_true(ost_geometry_equal(&v.geometry, &expected));
    for (int z = 0; z < NZ; z++)
        for (int y = 0; y < NY; y++)
            for (int x = 0; x < NX; x++)
                assert_int_equal(v.voxels[(NZ - 1 - z) + NZ * ((NY - 1 - y) + NY * x)], value(x, y, z));
    ost_volume_free(&v);
}

static void spacing_is_required(void **state)
{
    const unsigned char pixels[SLICE] = {1, 2, 3, 4, 5, 6};
    ost_error err = {0};
    ost_volume v;
    ost_volume_report report;
    (void)state;
    if (!HAS_TIFF)
        skip();
    tiff_page page = tiff_plain(NX, NY, 8, pixels, SLICE);
    write_tiff("s.tif", false, &page, 1);
    assert_refused(at("s.tif"), NULL, OST_ERR_USAGE, "--spacing MM,MM,MM");
    page.resolution = 500; /* 500 pixels per cm, or 0.02 mm per pixel */
    write_tiff("s.tif", false, &page, 1);
    assert_refused(at("s.tif"), NULL, OST_ERR_USAGE, "0.02 x 0.02 mm");
    assert_ok(ost_volume_read(at("s.tif"), &spaced, &v, &report, &err));
    assert_true(fabs(report.pixel_mm[0] - 0.02) < 1e-9 && fabs(report.pixel_mm[1] - 0.02) < 1e-9);
    assert_int_equal(v.geometry.spacing.x, 500000000);
    ost_volume_free(&v);
}

/* Tests values that int16 cannot represent. A uint16 value beyond int16 is refused with a message that contains its
   position, unless an option requests saturation. NaN is refused, unless an option requests the density of air. */
static void values_beyond_int16(void **state)
{
    static bytes raw;
    ost_error err = {0};
    ost_volume v;
    ost_volume_report report;
    ost_volume_options options = spaced;
    (void)state;
    if (!HAS_TIFF)
        skip();
    for (int i = 0; i < SLICE; i++)
        put_bits(&raw, i == 4 ? 40000 : 7, 2, false);
    tiff_page page = tiff_plain(NX, NY, 16, raw.data, raw.size);
    write_tiff("v.tif", false, &page, 1);
    assert_refused(at("v.tif"), &spaced, OST_ERR_INPUT, "voxel (1, 1, 0) at column 1, row 1: 40000");
    options.clamp = true;
    assert_ok(ost_volume_read(at("v.tif"), &options, &v, &report, &err));
    assert_int_equal(v.voxels[4], 32767);
    assert_int_equal(report.clamped_values, 1);
    ost_volume_free(&v);
    raw.size = 0;
    for (int i = 0; i < SLICE; i++)
        put_bits(&raw, i == 2 ? 0x7fc00000 : float_bits(7.0f), 4, false);
    page = tiff_plain(NX, NY, 32, raw.data, raw.size);
    page.format = 3;
    write_tiff("v.tif", false, &page, 1);
    assert_refused(at("v.tif"), &spaced, OST_ERR_INPUT, "--nan-as-air");
    options.nan_as_air = true;
    assert_ok(ost_volume_read(at("v.tif"), &options, &v, &report, &err));
    assert_int_equal(v.voxels[2], -1024);
    assert_int_equal(report.nan_values, 1);
    ost_volume_free(&v);
}

/* Writes a folder with one valid slice per name and returns the path of the folder. */
static const char *folder_of(const char *folder, const char *const *names, size_t count)
{
    static const unsigned char pixels[SLICE] = {1, 2, 3, 4, 5, 6};
    const tiff_page page = tiff_plain(NX, NY, 8, pixels, SLICE);
    char path[200];
    make_folder(folder);
    for (size_t i = 0; i < count; i++) {
        snprintf(path, sizeof path, "%s/%s", folder, names[i]);
        write_tiff(path, false, &page, 1);
    }
    return folder;
}

static void refuses_inconsistent_file_names(void **state)
{
    static const struct {
        const char *names[3], *words;
    } cases[] = {
        {{"a1.tif", "a2.tif", "a4.tif"}, "slice 3 is missing: a4.tif follows a2.tif"},
        {{"a1.tif", "a2.tif", "b3.tif"}, "b3.tif is not named like a1.tif"},
        {{"a1.tif", "a2.tif", "a02.tif"}, "have the same number"},
        {{"a1.tif", "a01.tif", "a2.tif"}, "have the same number"},
        {{"p1_1.tif", "p1_2.tif", "p2_3.tif"}, "differ in two numbers"},
        {{"p1_1.tif", "p1_2.tif", "p2_1.tif"}, "differ in another number"},
        {{"a1.tif", "a2.tif", "a3.tiff"}, "a3.tiff is not named like"},
        {{"a1.tif", "a2.tif", "a1234567890123456789.tif"}, "at most 18 digits"},
    };
    char folder[20];
    (void)state;
    if (!HAS_TIFF)
        skip();
    for (size_t c = 0; c < sizeof cases / sizeof cases[0]; c++) {
        snprintf(folder, sizeof folder, "n%zu", c);
        assert_refused(at(folder_of(folder, cases[c].names, 3)), &spaced, OST_ERR_INPUT, cases[c].words);
    }
    make_folder("empty");
    ost_error err = {0};
    ost_file_kind kind;
    assert_ok(ost_file_kind_find(at("empty"), &kind, &err));
    assert_int_equal(kind, OST_FILE_DICOM);
}

static void refuses_unsupported_tiff_pages(void **state)
{
    static const unsigned char pixels[200] = {1, 2, 3};
    (void)state;
    if (!HAS_TIFF)
        skip();
    struct {
        tiff_page page;
        ost_status status;
        const char *words;
    } cases[20];
    size_t n = 0;
    const tiff_page good = tiff_plain(NX, NY, 8, pixels, SLICE);
#define CASE(change, expected, text) \
    cases[n] = (__typeof__(cases[0])){good, expected, text}; \
    cases[n++].page.change
    CASE(samples = 3, OST_ERR_INPUT, "values per pixel: 3");
    CASE(photometric = 3, OST_ERR_INPUT, "colours of a palette");
    CASE(photometric = 0, OST_ERR_INPUT, "0 is black");
    CASE(photometric = 2, OST_ERR_INPUT, "0 is black");
    CASE(orientation = 4, OST_ERR_INPUT, "orientation tag 4");
    CASE(compression = 7, OST_ERR_INPUT, "compression 7");
    CASE(compression = 34712, OST_ERR_INPUT, "compression 34712");
    CASE(bits = 12, OST_ERR_INPUT, "bits per value: 12");
    CASE(bits = 1, OST_ERR_INPUT, "bits per value: 1");
    CASE(format = 5, OST_ERR_INPUT, "bits per value: 8");
    CASE(tile = 16, OST_ERR_INPUT, "tiffcp -s");
    CASE(width = 16385, OST_ERR_RANGE, "1 to 16384");
    CASE(width = 16000, OST_ERR_INPUT, "has at most");
    CASE(height = 0x7fffffff, OST_ERR_RANGE, "1 to 16384");
    CASE(description = "ImageJ=1.53\nimages=40\n", OST_ERR_INPUT, "40 slices");
#undef CASE
    for (size_t c = 0; c < n; c++) {
        char name[20];
        snprintf(name, sizeof name, "r%zu.tif", c);
        write_tiff(name, false, &cases[c].page, 1);
        assert_refused(at(name), &spaced, cases[c].status, cases[c].words);
    }
}

/* If a slice differs from the earlier slices, the error line contains its name. */
static void refuses_slices_that_differ(void **state)
{
    static const unsigned char pixels[64] = {1, 2, 3};
    const tiff_page good = tiff_plain(NX, NY, 8, pixels, SLICE);
    const tiff_page wide = tiff_plain(NX + 1, NY, 8, pixels, SLICE + NY);
    const tiff_page deep = tiff_plain(NX, NY, 16, pixels, 2 * SLICE);
    const tiff_page mixed[2] = {good, deep}, two[2] = {good, good};
    (void)state;
    if (!HAS_TIFF)
        skip();
    write_tiff("m.tif", false, mixed, 2);
    assert_refused(at("m.tif"), &spaced, OST_ERR_INPUT, "m.tif: page 2: values of type uint16");
    make_folder("d");
    write_tiff("d/1.tif", false, &good, 1);
    write_tiff("d/2.tif", false, &wide, 1);
    assert_refused(at("d"), &spaced, OST_ERR_INPUT, "2.tif: 4 x 2 pixels");
    write_tiff("d/2.tif", false, two, 2);
    assert_refused(at("d"), &spaced, OST_ERR_INPUT, "2.tif: has several pages");
}

static void refuses_unsupported_png_files(void **state)
{
    static const struct {
        unsigned width, bits, colour, interlace;
        size_t rows;
        const char *words;
        ost_status status;
    } cases[] = {
        {NX, 8, 2, 0, NY, "colour type 2", OST_ERR_INPUT},     {NX, 8, 3, 0, NY, "palette", OST_ERR_INPUT},
        {NX, 8, 4, 0, NY, "colour type 4", OST_ERR_INPUT},     {NX, 4, 0, 0, NY, "bits per value: 4", OST_ERR_INPUT},
        {NX, 8, 0, 1, NY, "interlaced", OST_ERR_INPUT},        {NX, 8, 0, 0, 1, "cannot read row", OST_ERR_INPUT},
        {16385, 8, 0, 0, NY, "not a readable PNG", OST_ERR_INPUT},
    };
    static const unsigned char pixels[64] = {1, 2, 3};
    static bytes file;
    (void)state;
    if (!HAS_PNG)
        skip();
    for (size_t c = 0; c < sizeof cases / sizeof cases[0]; c++) {
        const size_t channels = cases[c].colour == 2 ? 3 : cases[c].colour == 4 ? 2 : 1;
        file.size = 0;
        put_png(&file, cases[c].width, NY, cases[c].bits, cases[c].colour, cases[c].interlace, pixels,
                (NX * cases[c].bits * channels + 7) / 8, cases[c].rows);
        write_file("r.png", file.data, file.size);
        assert_refused(at("r.png"), &spaced, cases[c].status, cases[c].words);
    }
    /* a file of a few hundred bytes cannot contain 16384 x 16384 pixels */
    file.size = 0;
    put_png(&file, 16384, 16384, 16, 0, 0, pixels, 6, 2);
    write_file("bomb.png", file.data, file.size);
    assert_refused(at("bomb.png"), &spaced, OST_ERR_INPUT, "need 536870912 bytes");
}

/*
 * Pages of a TIFF may share their pixels. In the first file, 300 pages of 60 x 60 pixels refer to the same strip, so
 * that a small file would need 1.08 MB of memory. Such a file must be refused. In the second file, the links between
 * pages form a cycle. Reading this file must end.
 */
static void refuses_pages_that_share_pixels(void **state)
{
    static bytes file;
    static const unsigned char pixels[3600] = {1};
    (void)state;
    if (!HAS_TIFF)
        skip();
    tiff_page pages[300];
    for (size_t p = 0; p < 300; p++) {
        pages[p] = tiff_plain(60, 60, 8, pixels, p ? 0 : sizeof pixels);
        pages[p].strip_bytes = sizeof pixels;
    }
    put_tiff(&file, false, pages, 300);
    /* Every strip offset (tag 273) is set to 8, the offset of the first page's strip. */
    for (size_t i = 8 + sizeof pixels; i + 12 < file.size; i++)
        if (memcmp(file.data + i, "\x11\1\4\0\1\0\0\0", 8) == 0)
            memcpy(file.data + i + 8, "\10\0\0\0", 4);
    write_file("shared.tif", file.data, file.size);
    assert_refused(at("shared.tif"), &spaced, OST_ERR_INPUT, "pages need");

    file.size = 0;
    put_tiff(&file, false, pages, 1);
    /* The last field of the file is the link to the next directory. This line makes it point to the first directory,
       which is the only one. */
    memcpy(file.data + file.size - 4, file.data + 4, 4);
    write_file("circle.tif", file.data, file.size);
    ost_error err = {0};
    ost_volume v;
    (void)ost_volume_read(at("circle.tif"), &spaced, &v, NULL, &err);
    ost_volume_free(&v);
}

/* A valid file that is truncated at any byte must be refused without a memory leak. */
static void refuses_truncated_files(void **state)
{
    static bytes tiff, png;
    static const unsigned char pixels[SLICE] = {1, 2, 3, 4, 5, 6};
    static bytes packed;
    (void)state;
    put_deflated(&packed, pixels, sizeof pixels, 15);
    tiff_page page = tiff_plain(NX, NY, 8, packed.data, packed.size);
    page.compression = 8;
    put_tiff(&tiff, true, &page, 1);
    put_png(&png, NX, NY, 8, 0, 0, pixels, NX, NY);
    for (int format = 0; format < 2; format++) {
        const bytes *b = format ? &png : &tiff;
        if (format ? !HAS_PNG : !HAS_TIFF)
            continue;
        /* The last field of the TIFF is the link to the next page. A file that lacks only this field is accepted. */
        for (size_t size = 0; size < b->size - (format ? 0 : 4); size++) {
            ost_error err = {0};
            ost_volume v;
            write_file("t", b->data, size);
            const ost_status status = ost_volume_read(at("t"), &spaced, &v, NULL, &err);
            if (status == OST_OK)
                fail_msg("format %d: a file with only the first %zu of %zu bytes was accepted", format, size, b->size);
            assert_null(v.voxels);
            assert_non_null(strstr(err.text, scratch));
        }
    }
}

static void without_libtiff_or_libpng(void **state)
{
    static const unsigned char pixels[SLICE] = {1, 2, 3, 4, 5, 6};
    static bytes file;
    (void)state;
    const tiff_page page = tiff_plain(NX, NY, 8, pixels, SLICE);
    write_tiff("x.tif", false, &page, 1);
    put_png(&file, NX, NY, 8, 0, 0, pixels, NX, NY);
    write_file("x.png", file.data, file.size);
    if (!HAS_TIFF)
        assert_refused(at("x.tif"), &spaced, OST_ERR_UNAVAILABLE, "libtiff-dev");
    if (!HAS_PNG)
        assert_refused(at("x.png"), &spaced, OST_ERR_UNAVAILABLE, "libpng-dev");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(tiff_types_and_compressions),
        cmocka_unit_test(folders_are_ordered_by_number),
        cmocka_unit_test(png_of_8_and_16_bits),
        cmocka_unit_test(orientation_option_is_applied),
        cmocka_unit_test(spacing_is_required),
        cmocka_unit_test(values_beyond_int16),
        cmocka_unit_test(refuses_inconsistent_file_names),
        cmocka_unit_test(refuses_unsupported_tiff_pages),
        cmocka_unit_test(refuses_slices_that_differ),
        cmocka_unit_test(refuses_unsupported_png_files),
        cmocka_unit_test(refuses_pages_that_share_pixels),
        cmocka_unit_test(refuses_truncated_files),
        cmocka_unit_test(without_libtiff_or_libpng),
    };
    return cmocka_run_group_tests(tests, make_scratch, drop_scratch);
}
