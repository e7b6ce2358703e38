/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests reading NRRD: every type, byte order and encoding, all forms of detached data, spaces and
 * units. Every file is built byte by byte from the format's description, without osteon's writer.
 *
 * The file has more than 500 lines, because all variants of this format are built with the same table of types.
 *
 * Covers: AR-LEN-3, AR-GRID-4, AR-FILE-4, AR-FILE-5, AR-FILE-6, REQ-NRRD
 */
#include "volume_files.h"

enum { NX = 4, NY = 3, NZ = 5, COUNT = NX * NY * NZ };

/* Returns a value that is different for each n and small enough for every type; int8 stores it with an offset. */
static int density(int n)
{
    return n * 2 + 1;
}

typedef struct type_case {
    const char *name;
    size_t bytes;
    int is_float;
} type_case;

static const type_case type_cases[] = {
    {"signed char", 1, 0},        {"int8", 1, 0},      {"int8_t", 1, 0},       {"uchar", 1, 0},
    {"unsigned char", 1, 0},      {"uint8", 1, 0},     {"uint8_t", 1, 0},      {"short", 2, 0},
    {"short int", 2, 0},          {"signed short", 2, 0}, {"signed short int", 2, 0}, {"int16", 2, 0},
    {"int16_t", 2, 0},            {"ushort", 2, 0},    {"unsigned short", 2, 0}, {"unsigned short int", 2, 0},
    {"uint16", 2, 0},             {"uint16_t", 2, 0},  {"int", 4, 0},          {"signed int", 4, 0},
    {"int32", 4, 0},              {"int32_t", 4, 0},   {"uint", 4, 0},         {"unsigned int", 4, 0},
    {"uint32", 4, 0},             {"uint32_t", 4, 0},  {"longlong", 8, 0},     {"long long", 8, 0},
    {"long long int", 8, 0},      {"signed long long", 8, 0}, {"int64", 8, 0}, {"int64_t", 8, 0},
    {"ulonglong", 8, 0},          {"unsigned long long", 8, 0}, {"uint64", 8, 0}, {"uint64_t", 8, 0},
    {"float", 4, 1},              {"double", 8, 2},
};

static void put_voxels(bytes *b, const type_case *t, bool big, int from, int count)
{
    for (int n = from; n < from + count; n++) {
        uint64_t bits = (uint64_t)(int64_t)density(n);
        if (t->is_float == 1)
            bits = float_bits((float)density(n));
        else if (t->is_float == 2)
            bits = double_bits((double)density(n));
        put_bits(b, bits, t->bytes, big);
    }
}

static void put_text_voxels(bytes *b, int from, int count)
{
    char word[32];
    for (int n = from; n < from + count; n++) {
        snprintf(word, sizeof word, n % 7 == 6 ? " %d\r\n" : " %d", density(n));
        put_text(b, word);
    }
    put_text(b, "\n");
}

/* Reads the file and compares every voxel. The grid must have NX x NY x NZ voxels in the file's order. */
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

static void every_type_order_and_encoding(void **state)
{
    (void)state;
    static bytes file, raw;
    for (size_t t = 0; t < sizeof type_cases / sizeof type_cases[0]; t++) {
        for (int variant = 0; variant < 6; variant++) {
            /* the variants are raw and gzip in both byte orders, text, and gzip in two members */
            bool big = variant & 1;
            const char *encoding = variant < 2    ? "raw"
                                   : variant < 4  ? (big ? "gz" : "gzip")
                                   : variant == 4 ? "ascii"
                                                  : "GZIP";
            char header[300];
            file.size = raw.size = 0;
            snprintf(header, sizeof header,
                     "NRRD000%d\n# made by a test\ntype: %s\ndimension: 3\nsizes: 4 3 5\nspacings: 0.47 0.47 "
                     "1\nencoding: %s\nendian: %s\n\n",
                     variant % 5 + 1, type_cases[t].name, encoding, big ? "big" : "little");
            put_text(&file, header);
            put_voxels(&raw, &type_cases[t], big, 0, COUNT);
            if (variant < 2)
                put_bytes(&file, raw.data, raw.size);
            else if (variant < 4)
                put_gzip(&file, raw.data, raw.size);
            else if (variant == 4)
                put_text_voxels(&file, 0, COUNT);
            else {
                put_gzip(&file, raw.data, raw.size / 3);
                put_gzip(&file, raw.data + raw.size / 3, raw.size - raw.size / 3);
            }
            write_file("a.nrrd", file.data, file.size);
            ost_volume_report report = assert_reads("a.nrrd");
            assert_string_equal(report.encoding, variant < 2 ? "raw" : variant == 4 ? "text" : "gzip");
            assert_false(report.reoriented);
            assert_string_equal(report.orientation, "");
            assert_int_equal(report.rounded_values, 0);
        }
    }
}

static void floats_are_rounded_and_counted(void **state)
{
    (void)state;
    static const char header[] =
        "NRRD0004\ntype: float\ndimension: 3\nsizes: 4 1 1\nspacings: 1 1 1\nencoding: %s\nendian: little\n\n";
    static bytes file;
    char text[300];
    ost_error err = {0};
    ost_volume v;
    ost_volume_report report;
    for (int as_text = 0; as_text < 2; as_text++) {
        file.size = 0;
        snprintf(text, sizeof text, header, as_text ? "text" : "raw");
        put_text(&file, text);
        if (as_text) {
            put_text(&file, "0.5 1.5 -2.75e2 7");
        } else {
            const float values[4] = {0.5f, 1.5f, -275.0f, 7.0f};
            for (int i = 0; i < 4; i++)
                put_bits(&file, float_bits(values[i]), 4, false);
        }
        write_file("f.nrrd", file.data, file.size);
        assert_ok(ost_volume_read(at("f.nrrd"), NULL, &v, &report, &err));
        assert_int_equal(v.voxels[0], 0);
        assert_int_equal(v.voxels[1], 2);
        assert_int_equal(v.voxels[2], -275);
        assert_int_equal(v.voxels[3], 7);
        assert_int_equal(report.rounded_values, 2);
        ost_volume_free(&v);
    }
}

static void nan_in_raw_and_text_data(void **state)
{
    (void)state;
    static bytes file;
    ost_error err = {0};
    ost_volume v;
    ost_volume_report report;
    const ost_volume_options as_air = {.nan_as_air = true};
    for (int as_text = 0; as_text < 2; as_text++) {
        char text[200];
        file.size = 0;
        snprintf(text, sizeof text,
                 "NRRD0005\ntype: float\ndimension: 3\nsizes: 2 1 1\nspacings: 1 1 1\nencoding: %s\nendian: little\n\n",
                 as_text ? "text" : "raw");
        put_text(&file, text);
        if (as_text) {
            put_text(&file, "-NaN 7");
        } else {
            put_bits(&file, 0x7fc00000, 4, false);
            put_bits(&file, float_bits(7.0f), 4, false);
        }
        write_file("n.nrrd", file.data, file.size);
        assert_refused(at("n.nrrd"), NULL, OST_ERR_INPUT, "--nan-as-air");
        assert_ok(ost_volume_read(at("n.nrrd"), &as_air, &v, &report, &err));
        assert_int_equal(v.voxels[0], -1024);
        assert_int_equal(v.voxels[1], 7);
        assert_int_equal(report.nan_values, 1);
        assert_int_equal(report.rounded_values, 0);
        ost_volume_free(&v);
    }
}

static void values_beyond_int16_are_refused_or_clamped(void **state)
{
    (void)state;
    static bytes file;
    ost_error err = {0};
    ost_volume v;
    ost_volume_report report;
    const ost_volume_options clamp = {.clamp = true};
    for (int as_text = 0; as_text < 2; as_text++) {
        file.size = 0;
        put_text(&file, "NRRD0004\ntype: int\ndimension: 3\nsizes: 2 2 2\nspacings: 1 1 1\nendian: big\nencoding: ");
        put_text(&file, as_text ? "text\n\n0 0 0 0 0 0 32768 -40000" : "raw\n\n");
        for (int i = 0; !as_text && i < 8; i++)
            put_bits(&file, (uint64_t)(int64_t)(i < 6 ? 0 : i == 6 ? 32768 : -40000), 4, true);
        write_file("c.nrrd", file.data, file.size);
        assert_refused(at("c.nrrd"), NULL, OST_ERR_INPUT, "voxel (0, 1, 1)");
        assert_refused(at("c.nrrd"), NULL, OST_ERR_INPUT, "32768 is outside -32768 to 32767");
        assert_ok(ost_volume_read(at("c.nrrd"), &clamp, &v, &report, &err));
        assert_int_equal(v.voxels[6], 32767);
        assert_int_equal(v.voxels[7], -32768);
        assert_int_equal(report.clamped_values, 2);
        ost_volume_free(&v);
    }
}

/* AR-FILE-4: the extreme values of every integer type must be read from text. Values beyond int16 are saturated. */
static void extreme_values_of_types_are_read(void **state)
{
    (void)state;
    static const struct {
        const char *type, *least, *greatest;
        int16_t low, high;
    } cases[] = {
        {"int8", "-128", "127", -128, 127}, {"uint8", "-0", "255.0", 0, 255},
        {"int16", "-32768", "32767", INT16_MIN, INT16_MAX}, {"uint16", "0", "65535", 0, INT16_MAX},
        {"int32", "-2147483648", "2147483647", INT16_MIN, INT16_MAX}, {"uint32", "0", "4294967295", 0, INT16_MAX},
        {"int64", "-9223372036854775808", "9223372036854775807", INT16_MIN, INT16_MAX},
        {"uint64", "0", "18446744073709551615", 0, INT16_MAX},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        ost_error err = {0};
        ost_volume v;
        char text[256];
        int size = snprintf(
            text, sizeof text,
            "NRRD0004\ntype: %s\ndimension: 3\nsizes: 2 1 1\nspacings: 1 1 1\nencoding: text\n\n%s %s\n", cases[i].type,
            cases[i].least, cases[i].greatest);
        write_file("e.nrrd", text, (size_t)size);
        assert_ok(ost_volume_read(at("e.nrrd"), &(ost_volume_options){.clamp = true}, &v, NULL, &err));
        assert_int_equal(v.voxels[0], cases[i].low);
        assert_int_equal(v.voxels[1], cases[i].high);
        ost_volume_free(&v);
    }
}

/* ----------------------------------------------------------- detached data */

static void write_header(const char *name, const char *fields)
{
    static bytes file;
    file.size = 0;
    put_text(&file, "NRRD0004\ntype: short\ndimension: 3\nsizes: 4 3 5\nspacings: 1 1 1\nendian: big\n");
    put_text(&file, fields);
    write_file(name, file.data, file.size);
}

/*
 * Writes a file that begins with the text `lines`. The data follow: the text `skipped`, and then
 * `count` voxels as big-endian int16, beginning with voxel `from`. If `packed`, the data are
 * compressed.
 */
static void write_part(const char *name, const char *lines, const char *skipped, int from, int count, bool packed)
{
    static bytes file, raw;
    file.size = raw.size = 0;
    put_text(&file, lines);
    put_text(&raw, skipped);
    put_voxels(&raw, &type_cases[7], true, from, count);
    if (packed)
        put_gzip(&file, raw.data, raw.size);
    else
        put_bytes(&file, raw.data, raw.size);
    write_file(name, file.data, file.size);
}

static void detached_data_in_one_file(void **state)
{
    (void)state;
    assert_int_equal(mkdir(at("below"), 0700), 0);
    write_part("v.raw", "", "", 0, COUNT, false);
    write_header("v.nhdr", "encoding: raw\ndata file: v.raw\n");
    assert_reads("v.nhdr");
    write_header("crlf.nhdr", "encoding: raw\r\ndata file: v.raw\r\n\r\n");
    assert_reads("crlf.nhdr");
    write_part("below/my v.gz", "two\nlines\n", "skip", 0, COUNT, true);
    write_header("w.nhdr", "encoding: gzip\nline skip: 2\nbyteskip: 4\ndatafile: ./below/my v.gz\n\n");
    assert_reads("w.nhdr");
    write_part("x.raw", "a line\n", "12345", 0, COUNT, false);
    write_header("x.nhdr", "encoding: raw\nlineskip: 1\nbyte skip: 5\ndata file: x.raw\n");
    assert_reads("x.nhdr");
    write_header("y.nhdr", "encoding: raw\nbyte skip: -1\ndata file: x.raw\n");
    assert_reads("y.nhdr");
}

static void detached_data_in_many_files(void **state)
{
    (void)state;
    char name[32];
    for (int k = 0; k < NZ; k++) {
        snprintf(name, sizeof name, "s.%d", 2 * k + 3);
        write_part(name, "", "", k * NX * NY, NX * NY, false);
        snprintf(name, sizeof name, "r%03d.gz", NZ - k);
        write_part(name, "x\n", "yy", k * NX * NY, NX * NY, true);
    }
    write_header("s.nhdr", "encoding: raw\ndata file: s.%d 3 11 2\n");
    assert_reads("s.nhdr");
    write_header("s2.nhdr", "encoding: raw\ndata file: s.%d 3 11 2 2\n");
    assert_reads("s2.nhdr");
    write_header("r.nhdr", "encoding: gzip\nline skip: 1\nbyte skip: 2\ndata file: r%03d.gz 5 1 -1\n");
    assert_reads("r.nhdr");
    write_header("l.nhdr", "encoding: raw\ndata file: LIST\ns.3\ns.5\ns.7\r\ns.9\ns.11");
    assert_reads("l.nhdr");

    for (int row = 0; row < NY * NZ; row++) {
        snprintf(name, sizeof name, "row%%%02d", row);
        write_part(name, "", "", row * NX, NX, false);
    }
    write_header("rows.nhdr", "encoding: raw\ndata file: row%%%02d 0 14 1 1\n");
    assert_reads("rows.nhdr");
    write_part("slab1", "", "", 0, COUNT, false);
    write_header("slab.nhdr", "encoding: raw\ndata file: LIST 3\nslab1\n");
    assert_reads("slab.nhdr");

    static bytes text;
    for (int k = 0; k < NZ; k++) {
        text.size = 0;
        put_text_voxels(&text, k * NX * NY, NX * NY);
        snprintf(name, sizeof name, "t.%d", k);
        write_file(name, text.data, text.size);
    }
    write_header("t.nhdr", "encoding: text\ndata file: t.%d 0 4 1\n");
    assert_reads("t.nhdr");
}

static void refuses_data_files_outside_the_folder(void **state)
{
    (void)state;
    static const char *const names[] = {"/etc/passwd", "../v.raw", "below/../../v.raw", "..",
                                        "LIST\nv.raw/../x\nb\nc\nd\ne"};
    char fields[200];
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        snprintf(fields, sizeof fields, "encoding: raw\ndata file: %s\n", names[i]);
        write_header("bad.nhdr", fields);
        assert_refused(at("bad.nhdr"), NULL, OST_ERR_INPUT, "in the header's folder or below it");
    }
    write_header("bad.nhdr", "encoding: raw\ndata file: ../s.%d 0 4 1\n");
    assert_refused(at("bad.nhdr"), NULL, OST_ERR_INPUT, "in the header's folder or below it");
    write_header("bad.nhdr", "encoding: raw\ndata file: %n%s%d 0 4 1\n");
    assert_refused(at("bad.nhdr"), NULL, OST_ERR_INPUT, "one %d");
}

/* -------------------------------------------------------- spaces and units */

static void read_grid(const char *fields, ost_geometry *g, ost_volume_report *report, int16_t voxels[8])
{
    static bytes file;
    ost_error err = {0};
    ost_volume v;
    file.size = 0;
    put_text(&file, "NRRD0005\ntype: uint8\ndimension: 3\nsizes: 2 2 2\nencoding: text\n");
    put_text(&file, fields);
    put_text(&file, "\n0 1 2 3 4 5 6 7\n");
    write_file("g.nrrd", file.data, file.size);
    assert_ok(ost_volume_read(at("g.nrrd"), NULL, &v, report, &err));
    *g = v.geometry;
    memcpy(voxels, v.voxels, 16);
    ost_volume_free(&v);
}

static void assert_grid(const ost_geometry *g, ost_pm sx, ost_pm sy, ost_pm sz, ost_pm ox, ost_pm oy, ost_pm oz)
{
    const ost_geometry expected = {{2, 2, 2}, {sx, sy, sz}, {ox, oy, oz}};
    assert_true(ost_geometry_equal(g, &expected));
}

static void spaces_and_units(void **state)
{
    (void)state;
    ost_geometry g;
    ost_volume_report report;
    int16_t v[8];
    const ost_pm mm = OST_PM_PER_MM;
    read_grid("space: left-posterior-superior\nspace directions: (0.48828125,0,0) (0,.47e0,0) (0,0,1)\nspace origin: "
              "(-57.34,0,1e1)\n",
              &g, &report, v);
    assert_grid(&g, 488281250, 470000000, mm, -57340000000, 0, 10 * mm);
    assert_string_equal(report.orientation, "LPS");
    assert_int_equal(v[1], 1);
    /*
     * In RAS with positive steps, the LPS coordinates x and y decrease. The last voxel along each of these
     * axes therefore becomes the first voxel.
     */
    read_grid("space: RAS\nspace directions: (1,0,0) (0,2,0) (0,0,3)\nspace origin: (10,20,30)\n", &g, &report, v);
    assert_grid(&g, mm, 2 * mm, 3 * mm, -11 * mm, -22 * mm, 30 * mm);
    assert_string_equal(report.orientation, "RAS");
    assert_true(report.reoriented);
    assert_int_equal(v[0], 3);
    assert_int_equal(v[1], 2);
    assert_int_equal(v[2], 1);
    assert_int_equal(v[4], 7);
    read_grid("space: left-anterior-superior\nspace directions: ( 0 , 0 , 1 ) (1,0,0) (0,-1,0)\n", &g, &report, v);
    assert_grid(&g, mm, mm, mm, 0, 0, 0);
    assert_string_equal(report.orientation, "SLP");
    assert_int_equal(v[1], 2);
    assert_int_equal(v[2], 4);
    assert_int_equal(v[4], 1);
    read_grid("space: scanner-xyz\nspacings: 1 2 3\nspace origin: (1,2,3)\n", &g, &report, v);
    assert_grid(&g, mm, 2 * mm, 3 * mm, mm, 2 * mm, 3 * mm);
    assert_string_equal(report.orientation, "");
    read_grid("space dimension: 3\nspace directions: (1,0,0) (0,1,0) (0,0,1)\n", &g, &report, v);
    assert_grid(&g, mm, mm, mm, 0, 0, 0);
    /* The off-diagonal values are below a picometre, and the spacings are decimals with many digits. */
    read_grid("space: LPS\nspace directions: (0.46999999999999997,1e-17,0) (0,0.47000000000000003,0) (0,0,1)\n", &g,
              &report, v);
    assert_grid(&g, 470000000, 470000000, mm, 0, 0, 0);

    read_grid("space: LPS\nspace units: \"um\" \"cm\" \"m\"\nspace directions: (32,0,0) (0,.1,0) (0,0,0.001)\nspace "
              "origin: (1,1,1)\n",
              &g, &report, v);
    assert_grid(&g, 32000000, mm, mm, 1000000, 10 * mm, 1000 * mm);
    read_grid("spacings: 500 0.5 2\nunits: \"microns\" \"mm\" \"\"\n", &g, &report, v);
    assert_grid(&g, 500000000, 500000000, 2 * mm, 0, 0, 0);
    read_grid("spacings: 1 1 1\nkinds: domain space ???\ncenterings: cell cell node\nlabels: \"a\" \"b\" \"c\"\n", &g,
              &report, v);
    assert_grid(&g, mm, mm, mm, 0, 0, 0);
}

/*
 * If the space does not define patient axes, orientation letters map the coordinates. Directions and origin
 * must be transformed together.
 */
static void space_without_patient_axes(void **state)
{
    (void)state;
    static const char *const spaces[] = {"space: scanner-xyz\n", "space: 3D-right-handed\n", "space: 3D-left-handed\n",
                                         "space dimension: 3\n"};
    static bytes file;
    const ost_pm mm = OST_PM_PER_MM;
    for (size_t i = 0; i < sizeof spaces / sizeof spaces[0]; i++) {
        ost_error err = {0};
        ost_volume v;
        ost_volume_report report;
        file.size = 0;
        put_text(&file, "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 2 2\nencoding: raw\n");
        put_text(&file, spaces[i]);
        put_text(&file, "space directions: (1,0,0) (0,2,0) (0,0,3)\nspace origin: (10,20,30)\n\n");
        put_bytes(&file, "\0\1\2\3\4\5\6\7", 8);
        write_file("space.nrrd", file.data, file.size);
        assert_ok(ost_volume_read(at("space.nrrd"), NULL, &v, &report, &err));
        assert_true(report.assumed);
        assert_string_equal(ost_meta_get(&v.meta, OST_META_ORIENTATION), "assumed LPS");
        assert_grid(&v.geometry, mm, 2 * mm, 3 * mm, 10 * mm, 20 * mm, 30 * mm);
        /*
         * The fact that the orientation was assumed must be preserved when the volume is written and read
         * again. An option must not override this fact.
         */
        assert_ok(ost_volume_write(at("again.nrrd"), &v, NULL, &err));
        ost_volume_free(&v);
        assert_ok(ost_volume_read(at("again.nrrd"), NULL, &v, &report, &err));
        assert_true(report.assumed);
        ost_volume_free(&v);
        assert_refused(at("again.nrrd"), &(ost_volume_options){.orientation = "RAS"}, OST_ERR_USAGE,
                       "import the CT itself with --orientation RAS");
        /* The expected values are those for RAS in the test spaces_and_units. */
        assert_ok(ost_volume_read(at("space.nrrd"), &(ost_volume_options){.orientation = "RAS"}, &v, &report, &err));
        assert_false(report.assumed);
        assert_grid(&v.geometry, mm, 2 * mm, 3 * mm, -11 * mm, -22 * mm, 30 * mm);
        assert_string_equal(ost_meta_get(&v.meta, OST_META_ORIENTATION), "stated RAS");
        assert_int_equal(v.voxels[0], 3);
        ost_volume_free(&v);
    }
}

static void oblique_grid_is_refused_or_resampled(void **state)
{
    (void)state;
    static bytes file;
    ost_error err = {0};
    ost_volume v;
    ost_volume_report report;
    const ost_volume_options resample = {.resample_oblique = true};
    file.size = 0;
    put_text(&file, "NRRD0005\ntype: uint8\ndimension: 3\nsizes: 3 3 1\nencoding: text\nspace: LPS\n"
                    "space directions: (0.6,0.8,0) (-0.8,0.6,0) (0,0,1)\nosteon_side:=left\n\n1 2 3 4 5 6 7 8 9");
    write_file("o.nrrd", file.data, file.size);
    assert_refused(at("o.nrrd"), NULL, OST_ERR_INPUT, "36.87 degrees");
    assert_ok(ost_volume_read(at("o.nrrd"), &resample, &v, &report, &err));
    assert_true(report.resampled);
    assert_string_equal(ost_meta_get(&v.meta, "side"), "left");
    ost_volume_free(&v);
}

static void keys_become_facts(void **state)
{
    (void)state;
    static bytes file;
    ost_error err = {0};
    ost_meta meta;
    ost_geometry g;
    file.size = 0;
    put_text(&file, "NRRD0005\ntype: uint8\ndimension: 3\nsizes: 1 1 1\nspacings: 1 1 1\nencoding: raw\n"
                    "osteon_side:=right\nDICOM:0008,0060:=CT\nosteon_note:=back\\\\slash: and\\nline\n\nx");
    write_file("m.nrrd", file.data, file.size);
    assert_ok(ost_volume_read_header(at("m.nrrd"), &g, &meta, NULL, &err));
    assert_int_equal(meta.count, 3); /* two facts of the file, and the assumed orientation as the third fact */
    assert_string_equal(ost_meta_get(&meta, "side"), "right");
    assert_string_equal(ost_meta_get(&meta, "note"), "back\\slash: and line");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_type_order_and_encoding),
        cmocka_unit_test(floats_are_rounded_and_counted),
        cmocka_unit_test(values_beyond_int16_are_refused_or_clamped),
        cmocka_unit_test(nan_in_raw_and_text_data),
        cmocka_unit_test(extreme_values_of_types_are_read),
        cmocka_unit_test(detached_data_in_one_file),
        cmocka_unit_test(detached_data_in_many_files),
        cmocka_unit_test(refuses_data_files_outside_the_folder),
        cmocka_unit_test(spaces_and_units),
        cmocka_unit_test(space_without_patient_axes),
        cmocka_unit_test(oblique_grid_is_refused_or_resampled),
        cmocka_unit_test(keys_become_facts),
    };
    return cmocka_run_group_tests(tests, make_scratch, drop_scratch);
}
