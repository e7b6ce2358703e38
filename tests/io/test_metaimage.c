/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests reading MetaImage: every type, byte order and form of data, the position of the grid, and
 * headers that are refused. Every file is built byte by byte from the format's description.
 *
 * Covers: AR-LEN-3, AR-GRID-4, AR-FILE-5, REQ-METAIMAGE
 */
#include "volume_files.h"

enum { NX = 4, NY = 3, NZ = 5, COUNT = NX * NY * NZ };

/* Returns a value that is different for each n and small enough for every type. */
static int density(int n)
{
    return n * 2 + 1;
}

typedef enum number { INTEGER, SINGLE, DOUBLE } number;

static void put_voxels(bytes *b, size_t size, number kind, bool big, int from, int count)
{
    for (int n = from; n < from + count; n++) {
        uint64_t bits = (uint64_t)(int64_t)density(n);
        if (kind == SINGLE)
            bits = float_bits((float)density(n));
        else if (kind == DOUBLE)
            bits = double_bits((double)density(n));
        put_bits(b, bits, size, big);
    }
}

static ost_volume_report assert_reads(const char *name)
{
    ost_error err = {0};
    ost_volume v;
    ost_volume_report report;
    assert_ok(ost_volume_read(at(name), NULL, &v, &report, &err));
    assert_int_equal(v.geometry.dims.x, NX);
    assert_int_equal(v.geometry.dims.y, NY);
    assert_int_equal(v.geometry.dims.z, NZ);
    for (int n = 0; n < COUNT; n++)
        if (v.voxels[n] != density(n))
            fail_msg("%s: voxel %d is %d, expected %d", name, n, v.voxels[n], density(n));
    ost_volume_free(&v);
    return report;
}

static void every_type_byte_order_and_data_form(void **state)
{
    static const struct {
        const char *name, *read_as;
        size_t size;
        number kind;
    } types[] = {
        {"MET_CHAR", "int8", 1, INTEGER},       {"MET_UCHAR", "uint8", 1, INTEGER},
        {"MET_SHORT", "int16", 2, INTEGER},     {"MET_USHORT", "uint16", 2, INTEGER},
        {"MET_INT", "int32", 4, INTEGER},       {"MET_UINT", "uint32", 4, INTEGER},
        {"MET_LONG", "int32", 4, INTEGER},      {"MET_ULONG", "uint32", 4, INTEGER},
        {"MET_LONG_LONG", "int64", 8, INTEGER}, {"MET_ULONG_LONG", "uint64", 8, INTEGER},
        {"MET_FLOAT", "float32", 4, SINGLE},    {"MET_DOUBLE", "float64", 8, DOUBLE},
    };
    static bytes file, raw, packed;
    (void)state;
    for (size_t t = 0; t < sizeof types / sizeof types[0]; t++) {
        for (int variant = 0; variant < 12; variant++) {
            /* a variant is a combination of byte order, position of the data (after the header or in another file) and
               form of the data (raw, zlib or gzip) */
            const bool big = variant & 1, local = variant & 2;
            const int form = variant / 4;
            char header[400];
            file.size = raw.size = packed.size = 0;
            snprintf(header, sizeof header,
                     "ObjectType = Image\nNDims = 3\nBinaryData = True\n%s = %s\nCompressedData = %s\n"
                     "TransformMatrix = 1 0 0 0 1 0 0 0 1\nOffset = 0 0 0\nElementSpacing = 0.47 0.47 1\n"
                     "DimSize = 4 3 5\nElementType = %s\nElementDataFile = %s\n",
                     form ? "ElementByteOrderMSB" : "BinaryDataByteOrderMSB", big ? "True" : "False",
                     form ? "True" : "False", types[t].name, local ? "LOCAL" : "a.raw");
            put_text(&file, header);
            put_voxels(&raw, types[t].size, types[t].kind, big, 0, COUNT);
            if (form)
                put_deflated(&packed, raw.data, raw.size, form == 1 ? 15 : 15 + 16);
            const bytes *data = form ? &packed : &raw;
            if (local)
                put_bytes(&file, data->data, data->size);
            else
                write_file("a.raw", data->data, data->size);
            write_file("a.mha", file.data, file.size);
            const ost_volume_report report = assert_reads("a.mha");
            assert_string_equal(report.type, types[t].read_as);
            assert_string_equal(report.encoding, form ? "zlib" : "raw");
            assert_string_equal(report.orientation, "LPS");
            assert_false(report.reoriented || report.assumed);
        }
    }
}

/* Writes a file with 2 x 3 x 4 voxels of one byte; the voxel (x, y, z) is 100 + x + 2 * y + 6 * z. */
static void write_small(const char *name, const char *lines)
{
    static bytes file;
    file.size = 0;
    put_text(&file, "NDims = 3\r\nDimSize = 2 3 4\r\nElementType = MET_UCHAR\r\n");
    put_text(&file, lines);
    put_text(&file, "ElementDataFile = LOCAL\n");
    for (int n = 0; n < 24; n++)
        put_bits(&file, (uint64_t)(100 + n), 1, false);
    write_file(name, file.data, file.size);
}

static ost_volume read_volume(const char *name, ost_volume_report *report)
{
    ost_error err = {0};
    ost_volume v;
    assert_ok(ost_volume_read(at(name), NULL, &v, report, &err));
    return v;
}

/*
 * The rows of TransformMatrix are the directions of the axes. In this test the file's x points to
 * posterior, its y to right and its z to superior, so voxel (x, y, z) is at (10 - 0.7 y, 20 + 0.5 x, -3 +
 * 1.25 z) in LPS.
 */
static void matrix_rows_are_axis_directions(void **state)
{
    (void)state;
    ost_volume_report report;
    write_small("r.mha", "TransformMatrix = 0 1 0 -1 0 0 0 0 1\nPosition = 10 20 -3\nAnatomicalOrientation = RAI\n"
                         "CenterOfRotation = 0 0 0\nElementSpacing = 0.5 0.7 1.25\n");
    ost_volume v = read_volume("r.mha", &report);
    const ost_geometry expected = {{3, 2, 4}, {700000000, 500000000, 1250000000},
                                   {10000000000 - 2 * 700000000, 20000000000, -3000000000}};
    assert_true(ost_geometry_equal(&v.geometry, &expected));
    assert_true(report.reoriented);
    for (int z = 0; z < 4; z++)
        for (int y = 0; y < 3; y++)
            for (int x = 0; x < 2; x++)
                assert_int_equal(v.voxels[(2 - y) + 3 * (x + 2 * z)], 100 + x + 2 * y + 6 * z);
    ost_volume_free(&v);
}

static void units_and_defaults(void **state)
{
    (void)state;
    static const struct {
        const char *lines;
        ost_pm spacing;
        bool assumed;
    } cases[] = {
        {"ElementSpacing = 0.1 0.1 0.1\n", 100000000, true},
        {"ElementSize = 0.1 0.1 0.1\nDistanceUnits = mm\n", 100000000, true},
        {"ElementSpacing = 0.1 0.1 0.1\nElementSize = 1 1 1\nDistanceUnits = cm\n", 1000000000, true},
        {"ElementSpacing = 100 100 100\nDistanceUnits = um\nOrientation = 1 0 0 0 1 0 0 0 1\n", 100000000, false},
        {"Comment = a note with = signs\n\nElementSpacing=1e-1 .1 +0.10\nUnknownKey = 7\n"
         "Rotation = 1 0 0 0 1 0 0 0 1\n",
         100000000, false},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        ost_volume_report report;
        write_small("d.mha", cases[i].lines);
        ost_volume v = read_volume("d.mha", &report);
        assert_true(v.geometry.spacing.x == cases[i].spacing && v.geometry.spacing.z == cases[i].spacing);
        assert_true(v.geometry.origin.x == 0);
        assert_int_equal(report.assumed, cases[i].assumed);
        assert_int_equal(v.voxels[23], 123);
        ost_volume_free(&v);
    }
}

static void data_in_several_files(void **state)
{
    (void)state;
    static const struct {
        const char *data;
        int files;
    } cases[] = {
        {"s%02d.raw 1 5 1", 5},
        {"LIST\ns01.raw\ns02.raw\ns03.raw\ns04.raw\ns05.raw", 5},
        {"LIST 2D\r\ns01.raw\r\ns02.raw\r\ns03.raw\r\ns04.raw\r\ns05.raw\r", 5},
        {"LIST 3\ns01.raw", 1},
    };
    static bytes raw;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        char text[300];
        const int part = COUNT / cases[i].files;
        for (int f = 0; f < cases[i].files; f++) {
            char name[32];
            snprintf(name, sizeof name, "s%02d.raw", f + 1);
            raw.size = 0;
            put_text(&raw, "skip"); /* four bytes that the reader must skip if HeaderSize is 4 or -1 */
            put_voxels(&raw, 2, INTEGER, false, f * part, part);
            write_file(name, raw.data, raw.size);
        }
        for (int skip = -1; skip < 5; skip += 5) {
            snprintf(text, sizeof text,
                     "ObjectType = Image\nNDims = 3\nDimSize = 4 3 5\nElementSpacing = 1 1 1\nHeaderSize = %d\n"
                     "ElementType = MET_SHORT\nElementDataFile = %s\n", skip, cases[i].data);
            write_file("s.mhd", text, strlen(text));
            assert_reads("s.mhd");
        }
    }
}

/*
 * Writes a valid file with one changed line. The new line replaces the line with the same key. If there is no such
 * line, the new line is added.
 */
static void write_changed(const char *line)
{
    static const char *const right[] = {"ObjectType = Image\n",      "NDims = 3\n",  "DimSize = 2 2 2\n",
                                        "ElementSpacing = 1 1 1\n", "ElementType = MET_SHORT\n",
                                        "ElementDataFile = LOCAL\n"};
    static bytes file;
    const size_t key = strcspn(line, " =");
    bool replaced = false;
    file.size = 0;
    for (size_t i = 0; i < 6; i++) {
        const bool same = strncmp(right[i], line, key) == 0 && right[i][key] == ' ';
        if (i == 5 && !same && !replaced)
            put_text(&file, line);
        put_text(&file, same ? line : right[i]);
        replaced = replaced || same;
    }
    put_bytes(&file, "0123456789abcdef", 16);
    write_file("b.mha", file.data, file.size);
}

static void refuses_invalid_headers(void **state)
{
    (void)state;
    static const struct {
        const char *line, *words;
        ost_status status;
    } cases[] = {
        {"ObjectType = Mesh\n", "b.mha:1: ObjectType = 'Mesh'; expected Image", OST_ERR_INPUT},
        {"NDims = 2\n", "b.mha:2: NDims = '2'; expected 3", OST_ERR_INPUT},
        {"NDims =\n", "b.mha:2: NDims = ''; expected 3", OST_ERR_INPUT},
        {"DimSize = 2 2\n", "b.mha:3: DimSize = '2 2'; expected three whole numbers", OST_ERR_INPUT},
        {"DimSize = 2 2 2 2\n", "expected three whole numbers", OST_ERR_INPUT},
        {"DimSize = 2 2.5 2\n", "expected three whole numbers", OST_ERR_INPUT},
        {"DimSize = 2 0 2\n", "expected at least 1", OST_ERR_INPUT},
        {"DimSize = 2 2 99999\n", "expected at most 16384", OST_ERR_RANGE},
        {"DimSize = 16384 16384 16384\n", "2^36", OST_ERR_RANGE},
        {"DimSize = 1024 1024 1024\n", "need 2147483648", OST_ERR_INPUT},
        {"DimSize = 2 2 1\n", "8 bytes too many", OST_ERR_INPUT},
        {"ElementNumberOfChannels = 3\n", "expected 1, which is one density per voxel", OST_ERR_INPUT},
        {"ElementType = MET_SHORT_ARRAY\n", "b.mha:5: ElementType = 'MET_SHORT_ARRAY'; expected MET_CHAR",
         OST_ERR_INPUT},
        {"ElementSpacing = 1 1\n", "ElementSpacing = '1 1'; expected three lengths", OST_ERR_INPUT},
        {"ElementSpacing = 1 0 1\n", "greater than 0", OST_ERR_INPUT},
        {"ElementSpacing = 1 -1 1\n", "greater than 0", OST_ERR_INPUT},
        {"ElementSpacing = 1 nan 1\n", "expected three lengths", OST_ERR_INPUT},
        {"ElementSpacing = 1e300 1 1\n", "expected three lengths", OST_ERR_INPUT},
        {"Offset = 0 0 9000\n", "within 8 m", OST_ERR_INPUT},
        {"Offset = 0 0\n", "Offset = '0 0'; expected three lengths", OST_ERR_INPUT},
        {"TransformMatrix = 1 0 0 0 1 0 0 0\n", "expected nine numbers", OST_ERR_INPUT},
        {"TransformMatrix = 1 0 0 0 1 0 0 0 1e9\n", "expected directions of length 1", OST_ERR_INPUT},
        {"TransformMatrix = 0.6 0.8 0 -0.8 0.6 0 0 0 1\n", "--resample-oblique", OST_ERR_INPUT},
        {"TransformMatrix = 1 0 0 1 0 0 0 0 1\n", "b.mha", OST_ERR_INPUT},
        {"DistanceUnits = inch\n", "expected mm, um or cm", OST_ERR_INPUT},
        {"BinaryData = False\n", "text data are not supported", OST_ERR_INPUT},
        {"BinaryDataByteOrderMSB = maybe\n", "expected True or False", OST_ERR_INPUT},
        {"CompressedData = True\n", "compressed data damaged", OST_ERR_INPUT},
        {"ElementToIntensityFunctionSlope = 2\n", "slope 1 and offset 0", OST_ERR_INPUT},
        {"ElementToIntensityFunctionOffset = -1024\n", "slope 1 and offset 0", OST_ERR_INPUT},
        {"HeaderSize = -2\n", "expected a number of bytes", OST_ERR_INPUT},
        {"HeaderSize = 4\n", "the data follow the header", OST_ERR_INPUT},
        {"HeaderSize = -1\nCompressedData = True\n", "the data are compressed", OST_ERR_INPUT},
        {"ElementDataFile = ../other.raw\n", "it leads upwards", OST_ERR_INPUT},
        {"ElementDataFile = /etc/passwd\n", "it is absolute", OST_ERR_INPUT},
        {"ElementDataFile = missing.raw\n", "missing.raw", OST_ERR_IO},
        {"ElementDataFile =\n", "a file name is empty", OST_ERR_INPUT},
        {"ElementDataFile = LIST\n", "data files", OST_ERR_INPUT},
        /* keys that do not affect the result may be repeated */
        {"Modality = MET_MOD_CT\nModality = MET_MOD_CT\n", NULL, OST_OK},
        {"Offset = 0 0 0\nPosition = 1 1 1\n", "duplicate 'Position'; the first one is in line 6", OST_ERR_INPUT},
        {"a line without a value\n", "is not 'Key = Value'", OST_ERR_INPUT},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        write_changed(cases[i].line);
        if (cases[i].words) {
            assert_refused(at("b.mha"), NULL, cases[i].status, cases[i].words);
        } else {
            ost_volume v = read_volume("b.mha", NULL);
            ost_volume_free(&v);
        }
    }
}

static void refuses_incomplete_headers(void **state)
{
    (void)state;
    static const char *const texts[] = {"ObjectType = Image", "ObjectType = Image\nNDims = 3\n",
                                        "NDims = 3\nDimSize = 1 1 1\nElementDataFileName = LOCAL\n",
                                        "NDims = 3\nElementDataFile 1 = LOCAL\n"};
    for (size_t i = 0; i < sizeof texts / sizeof texts[0]; i++) {
        write_file("e.mhd", texts[i], strlen(texts[i]));
        assert_refused(at("e.mhd"), NULL, OST_ERR_INPUT, "expected ElementDataFile");
    }
    static const char *const missing[][2] = {
        {"ObjectType = Image\nElementDataFile = LOCAL\n", "no 'NDims ='"},
        {"NDims = 3\nElementDataFile = LOCAL\n", "no 'DimSize ='"},
        {"NDims = 3\nDimSize = 1 1 1\nElementDataFile = LOCAL\n", "no 'ElementType ='"},
        {"NDims = 3\nDimSize = 1 1 1\nElementType = MET_CHAR\nElementDataFile = LOCAL\nx",
         "expected 'ElementSpacing ='"},
    };
    for (size_t i = 0; i < sizeof missing / sizeof missing[0]; i++) {
        write_file("e.mhd", missing[i][0], strlen(missing[i][0]));
        assert_refused(at("e.mhd"), NULL, OST_ERR_INPUT, missing[i][1]);
    }
    write_file("e.mhd", "NDims = 3\n\0", 11);
    assert_refused(at("e.mhd"), NULL, OST_ERR_INPUT, "a NUL in its header");
}

static void refuses_truncated_data(void **state)
{
    (void)state;
    static const char header[] = "NDims = 3\nDimSize = 4 3 5\nElementSpacing = 1 1 1\nElementType = MET_SHORT\n"
                                 "CompressedData = True\nElementDataFile = LOCAL\n";
    static bytes raw, packed, file;
    raw.size = packed.size = 0;
    put_voxels(&raw, 2, INTEGER, false, 0, COUNT);
    put_deflated(&packed, raw.data, raw.size, 15);
    for (size_t n = 8; n < packed.size; n += 7) {
        file.size = 0;
        put_text(&file, header);
        put_bytes(&file, packed.data, n);
        write_file("t.mha", file.data, file.size);
        assert_refused(at("t.mha"), NULL, OST_ERR_INPUT, "truncated at the end of the file");
    }
    file.size = 0;
    put_text(&file, header);
    put_bytes(&file, packed.data, packed.size);
    put_text(&file, "more");
    write_file("t.mha", file.data, file.size);
    assert_refused(at("t.mha"), NULL, OST_ERR_INPUT, "4 bytes follow its compressed data");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_type_byte_order_and_data_form),
        cmocka_unit_test(matrix_rows_are_axis_directions),
        cmocka_unit_test(units_and_defaults),
        cmocka_unit_test(data_in_several_files),
        cmocka_unit_test(refuses_invalid_headers),
        cmocka_unit_test(refuses_incomplete_headers),
        cmocka_unit_test(refuses_truncated_data),
    };
    return cmocka_run_group_tests(tests, make_scratch, drop_scratch);
}
