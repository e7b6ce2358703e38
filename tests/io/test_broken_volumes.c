/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tests that broken volumes are refused. The error must be one line with the name of the file and
 * the defect, and the reader must neither leak memory nor leave a file. The test truncates valid
 * files at every byte and replaces one field of a header at a time.
 *
 * Covers: AR-GRID-3, AR-FILE-4
 */
#include "nifti_files.h"

#include <math.h>

static const char good_fields[] =
    "type: int16\ndimension: 3\nsizes: 2 2 2\nspacings: 1 1 1\nencoding: raw\nendian: little\n";
static const char sixteen[] = "\1\0\2\0\3\0\4\0\5\0\6\0\7\0\10\0";

/* Writes the valid header. The line of `field` is replaced by `line`, or omitted if `line` is "". */
static void write_replaced(const char *field, const char *line, const void *data, size_t size)
{
    static bytes file;
    file.size = 0;
    put_text(&file, "NRRD0005\n");
    for (const char *p = good_fields; *p;) {
        size_t n = strcspn(p, "\n") + 1;
        if (strncmp(p, field, strlen(field)) != 0)
            put_bytes(&file, p, n);
        p += n;
    }
    put_text(&file, line);
    put_text(&file, "\n");
    put_bytes(&file, data, size);
    write_file("b.nrrd", file.data, file.size);
}

static void refuses_invalid_nrrd_fields(void **state)
{
    (void)state;
    static const struct {
        const char *field, *line, *words;
        ost_status status;
    } cases[] = {
        {"type", "", "no 'type:'", OST_ERR_INPUT},
        {"type", "type: block\n", "not a supported voxel type", OST_ERR_INPUT},
        {"type", "type: int17\n", "b.nrrd:7: 'int17'", OST_ERR_INPUT},
        {"type", "type:\n", "not a supported voxel type", OST_ERR_INPUT},
        {"dimension", "", "no 'dimension:'", OST_ERR_INPUT},
        {"dimension", "dimension: 4\n", "4 axes", OST_ERR_INPUT},
        {"dimension", "dimension: 2\n", "2 axes", OST_ERR_INPUT},
        {"dimension", "dimension: x\n", "count of axes", OST_ERR_INPUT},
        {"dimension", "dimension: 3.5\n", "count of axes", OST_ERR_INPUT},
        {"dimension", "dimension: 1e5000\n", "count of axes", OST_ERR_INPUT},
        {"sizes", "", "no 'sizes:'", OST_ERR_INPUT},
        {"sizes", "sizes: 2 2\n", "three whole numbers", OST_ERR_INPUT},
        {"sizes", "sizes: 2 2 2 2\n", "three whole numbers", OST_ERR_INPUT},
        {"sizes", "sizes: 2 2 -2\n", "at least 1", OST_ERR_INPUT},
        {"sizes", "sizes: 2 0 2\n", "at least 1", OST_ERR_INPUT},
        {"sizes", "sizes: 2 2 nan\n", "three whole numbers", OST_ERR_INPUT},
        {"sizes", "sizes: 2 2 16385\n", "at most 16384", OST_ERR_RANGE},
        {"sizes", "sizes: 2 2 99999999999999999999999\n", "three whole numbers", OST_ERR_INPUT},
        {"sizes", "sizes: 16384 16384 16384\n", "2^36", OST_ERR_RANGE},
        {"sizes", "sizes: 16000 8000 256\nspace units: \"um\" \"um\" \"um\"\nspace dimension: 3\n", "need 65536000000",
         OST_ERR_INPUT},
        {"sizes", "sizes: 2 2 3\n", "need 24", OST_ERR_INPUT},
        {"sizes", "sizes: 2 2 1\n", "8 bytes too many", OST_ERR_INPUT},
        {"sizes", "sizes: 2 2 2\nsizes: 2 2 2\n", "duplicate 'sizes'; the first one", OST_ERR_INPUT},
        {"spacings", "", "no voxel size in the header", OST_ERR_INPUT},
        {"spacings", "spacings: nan nan nan\n", "no voxel size in the header", OST_ERR_INPUT},
        {"spacings", "spacings: 1 nan 1\n", "greater than 0", OST_ERR_INPUT},
        {"spacings", "spacings: 1 0 1\n", "greater than 0", OST_ERR_INPUT},
        {"spacings", "spacings: 1 -1 1\n", "greater than 0", OST_ERR_INPUT},
        {"spacings", "spacings: 1 inf 1\n", "greater than 0", OST_ERR_INPUT},
        {"spacings", "spacings: 1 1\n", "greater than 0", OST_ERR_INPUT},
        {"spacings", "spacings: 1 1 1 1\n", "three lengths", OST_ERR_INPUT},
        {"spacings", "spacings: 1 1 0.0000001\n", "spacing of 1e-07 mm", OST_ERR_RANGE},
        {"spacings", "spacings: 1 1 101\n", "100 mm", OST_ERR_RANGE},
        {"spacings", "spacings: 1 1 1e9\n", "up to 8000 mm", OST_ERR_INPUT},
        {"spacings", "spacings: 1 1 1e-12\n", "greater than 0", OST_ERR_INPUT},
        {"spacings", "spacings: 1 1 1\nunits: \"mm\" \"mm\" \"inch\"\n", "unknown unit", OST_ERR_INPUT},
        {"spacings", "spacings: 1 1 1\nunits: \"mm\" \"mm\"\n", "double quotes", OST_ERR_INPUT},
        {"spacings", "spacings: 1 1 1\nunits: \"mm\" \"mm\" \"mm\n", "double quotes", OST_ERR_INPUT},
        {"spacings", "spacings: 1 1 1\nspace: LPS\nspace directions: (1,0,0) (0,1,0) (0,0,1)\n", "already",
         OST_ERR_INPUT},
        {"spacings", "space: LPS\nspace directions: (1,0,0) (0,1,0)\n", "three vectors", OST_ERR_INPUT},
        {"spacings", "space: LPS\nspace directions: (1,0,0) (0,1,0) none\n", "three vectors", OST_ERR_INPUT},
        {"spacings", "space: LPS\nspace directions: (1,0,0) (0,1,0) (0,0,1) (0,0,1)\n", "three vectors", OST_ERR_INPUT},
        {"spacings", "space: LPS\nspace directions: (1,0) (0,1) (0,0)\n", "three vectors", OST_ERR_INPUT},
        {"spacings", "space: LPS\nspace directions: (1,0,nan) (0,1,0) (0,0,1)\n", "three vectors", OST_ERR_INPUT},
        {"spacings", "space: LPS\nspace directions: (1,0,0) (0,1,0) (0,0,0)\n", "do not span", OST_ERR_INPUT},
        {"spacings", "space: LPS\nspace directions: (1,0,0) (2,0,0) (0,0,1)\n", "do not span", OST_ERR_INPUT},
        {"spacings", "space directions: (1,0,0) (0,1,0) (0,0,1)\n", "a vector without a space", OST_ERR_INPUT},
        {"spacings", "spacings: 1 1 1\nspace: XYZ\n", "unknown space", OST_ERR_INPUT},
        {"spacings", "spacings: 1 1 1\nspace: LPST\n", "time", OST_ERR_INPUT},
        {"spacings", "spacings: 1 1 1\nspace dimension: 2\n", "3 was expected", OST_ERR_INPUT},
        {"spacings", "spacings: 1 1 1\nspace: LPS\nspace dimension: 3\n", "beside 'space'", OST_ERR_INPUT},
        {"spacings", "spacings: 1 1 1\nspace: LPS\nspace origin: (0,0,9e3)\n", "from -8000 to 8000 mm", OST_ERR_INPUT},
        {"spacings", "spacings: 1 1 1\nspace: LPS\nspace origin: (0,0,7999.5)\n", "8000 mm", OST_ERR_RANGE},
        {"spacings", "spacings: 1 1 1\nspace: LPS\nspace origin: (0,0,0) x\n", "one vector", OST_ERR_INPUT},
        {"spacings", "spacings: 1 1 1\nkinds: vector domain domain\n", "not vectors", OST_ERR_INPUT},
        {"spacings", "spacings: 1 1 1\nkinds: domain domain\n", "three kinds", OST_ERR_INPUT},
        {"spacings", "spacings: 1 1 1\nkinds: domain domain domain domain\n", "three kinds", OST_ERR_INPUT},
        {"encoding", "", "no 'encoding:'", OST_ERR_INPUT},
        {"encoding", "encoding: hex\n", "is not supported", OST_ERR_INPUT},
        {"encoding", "encoding: bzip2\n", "is not supported", OST_ERR_INPUT},
        {"encoding", "encoding: lzma\n", "raw, gzip or text", OST_ERR_INPUT},
        {"encoding", "encoding: gzip\n", "damaged", OST_ERR_INPUT},
        {"encoding", "encoding: text\n", "not a number", OST_ERR_INPUT},
        {"endian", "", "no 'endian:'", OST_ERR_INPUT},
        {"endian", "endian: middle\n", "little or big", OST_ERR_INPUT},
        {"#", "nonsense\n", "neither 'field: value'", OST_ERR_INPUT},
        {"#", "colour: red\n", "not a field of the NRRD format", OST_ERR_INPUT},
        {"#", "osteon_Bad Key:=x\n", "is not a key", OST_ERR_RANGE},
        {"#", "line skip: -1\n", "count of lines", OST_ERR_INPUT},
        {"#", "line skip: 99\n", "ends after", OST_ERR_INPUT},
        {"#", "byte skip: -2\n", "count of bytes", OST_ERR_INPUT},
        {"#", "byte skip: 17\n", "to be skipped", OST_ERR_INPUT},
        {"#", "byte skip: 1\n", "need 16", OST_ERR_INPUT},
        {"encoding", "encoding: gzip\nbyte skip: -1\n", "only raw", OST_ERR_INPUT},
        {"#", "data file: absent.raw\n", "cannot open", OST_ERR_IO},
        {"#", "data file: b.%d 1 3 1\n", "do not fit", OST_ERR_INPUT},
        {"#", "data file: b.%d 1 2 0\n", "leads from one to the other", OST_ERR_INPUT},
        {"#", "data file: b.%d 2 1 1\n", "leads from one to the other", OST_ERR_INPUT},
        {"#", "data file: b.%d 1 2 1 4\n", "1, 2 or 3 axes", OST_ERR_INPUT},
        {"#", "data file: b.%d 1 2 1 -9\n", "1, 2 or 3 axes", OST_ERR_INPUT},
        {"#", "data file: b%d%d 1 2 1\n", "one %d", OST_ERR_INPUT},
        {"#", "data file: b%99d 1 2 1\n", "one %d", OST_ERR_INPUT},
        {"#", "data file: b%d 0 1000000000 1\n", "at most 65536", OST_ERR_RANGE},
        {"#", "data file: LIST\n", "no file names", OST_ERR_INPUT},
        {"#", "data file: LIST 7\nb\n", "1, 2 or 3 axes", OST_ERR_INPUT},
        {"#", "data file: LIST x\nb\n", "LIST", OST_ERR_INPUT},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        /* If the header declares a list of files, every line after this field is a file name, so no data follow. */
        write_replaced(cases[i].field, cases[i].line, sixteen, strstr(cases[i].line, "LIST") ? 0 : 16);
        assert_refused(at("b.nrrd"), NULL, cases[i].status, cases[i].words);
    }
}

static void refuses_invalid_nrrd_beginnings(void **state)
{
    (void)state;
    static const struct {
        const char *text, *words;
    } cases[] = {
        {"", "is empty"},
        {"N", "not an NRRD, NIfTI, MetaImage or DICOM file"},
        {"NRRD", "expected NRRD0001"},
        {"NRRD0006\n\n", "NRRD0001 to NRRD0005"},
        {"NRRD0000\n\n", "NRRD0001 to NRRD0005"},
        {"NRRD00051\n\n", "NRRD0001 to NRRD0005"},
        {"NRRD0005", "file ends in the header"},
        {"NRRD0005\n", "file ends in the header"},
        {"NRRD0005\n\n", "no 'dimension:'"},
        {"NRRD0005\ntype: uint8", "file ends in the header"},
        {"solid cube\n", "not an NRRD, NIfTI, MetaImage or DICOM file"},
        {"1 2 3 4\n", "not an NRRD, NIfTI, MetaImage or DICOM file"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        write_file("s.nrrd", cases[i].text, strlen(cases[i].text));
        assert_refused(at("s.nrrd"), NULL, OST_ERR_INPUT, cases[i].words);
    }
    write_file("s.nrrd", "NRRD0005\nty\0pe: x\n\n", 19);
    assert_refused(at("s.nrrd"), NULL, OST_ERR_INPUT, "a NUL");
    assert_refused(at("absent.nrrd"), NULL, OST_ERR_IO, "cannot open");
    assert_int_equal(mkfifo(at("pipe.nrrd"), 0600), 0);
    assert_refused(at("pipe.nrrd"), NULL, OST_ERR_IO, "is a pipe or a device");
}

/* A header without an end must be refused at the size limit for headers, not when memory is exhausted. */
static void refuses_header_without_end(void **state)
{
    (void)state;
    FILE *file = fopen(at("long.nrrd"), "wb");
    assert_non_null(file);
    fputs("NRRD0005\n", file);
    for (int i = 0; i < 5 << 20; i++)
        putc('a', file);
    fclose(file);
    assert_refused(at("long.nrrd"), NULL, OST_ERR_INPUT, "longer than 4194304 bytes");
}

/* A file that is truncated at any byte, or has one more byte, must be refused with a specific error. */
static void assert_truncated_is_refused(const char *name, const bytes *good)
{
    static bytes cut;
    ost_error err = {0};
    ost_volume v;
    write_file(name, good->data, good->size);
    assert_ok(ost_volume_read(at(name), NULL, &v, NULL, &err));
    ost_volume_free(&v);
    for (size_t n = 0; n < good->size; n++) {
        write_file(name, good->data, n);
        memset(&err, 0, sizeof err);
        ost_status status = ost_volume_read(at(name), NULL, &v, NULL, &err);
        if (status != OST_ERR_INPUT || !strstr(err.text, name) || v.voxels)
            fail_msg("%s truncated to %zu bytes: %s (%s)", name, n, ost_status_name(status), err.text);
    }
    cut.size = 0;
    put_bytes(&cut, good->data, good->size);
    put_bytes(&cut, "x", 1);
    write_file(name, cut.data, cut.size);
    assert_int_equal(ost_volume_read(at(name), NULL, &v, NULL, &err), OST_ERR_INPUT);
}

static void refuses_files_truncated_at_any_byte(void **state)
{
    (void)state;
    static bytes file, inner;
    file.size = 0;
    put_text(&file, "NRRD0005\n");
    put_text(&file, good_fields);
    put_text(&file, "\n");
    put_bytes(&file, sixteen, 16);
    assert_truncated_is_refused("cut.nrrd", &file);
    file.size = 0;
    put_text(&file,
             "NRRD0005\ntype: int16\ndimension: 3\nsizes: 2 2 2\nspacings: 1 1 1\nencoding: gzip\nendian: little\n\n");
    put_gzip(&file, sixteen, 16);
    assert_truncated_is_refused("cutgz.nrrd", &file);
    for (int version = 1; HAS_NIFTI && version <= 2; version++) {
        nifti_spec s = nifti_plain(version);
        unsigned char header[540];
        size_t size = nifti_header(&s, header);
        inner.size = 0;
        put_bytes(&inner, header, size);
        put_bytes(&inner, "\0\0\0\0", 4);
        put_bytes(&inner, sixteen, 8);
        assert_truncated_is_refused("cut.nii", &inner);
        file.size = 0;
        put_gzip(&file, inner.data, inner.size);
        assert_truncated_is_refused("cut.nii.gz", &file);
    }
}

/*
 * If any bit of compressed data is flipped, deflate or the checksum must detect this. The padding
 * bits in deflate's last byte are an exception.
 */
static void detects_flipped_bits_in_compressed_data(void **state)
{
    (void)state;
    static bytes file;
    file.size = 0;
    put_text(&file,
             "NRRD0005\ntype: int16\ndimension: 3\nsizes: 2 2 2\nspacings: 1 1 1\nencoding: gzip\nendian: little\n\n");
    size_t start = file.size;
    int padding = 0;
    put_gzip(&file, sixteen, 16);
    /* the loop begins after the gzip header, because the time and the name in this header do not affect the data */
    for (size_t n = start + 10; n < file.size; n++) {
        for (int bit = 0; bit < 8; bit++) {
            file.data[n] ^= (unsigned char)(1 << bit);
            write_file("bit.nrrd", file.data, file.size);
            ost_error err = {0};
            ost_volume v;
            ost_status status = ost_volume_read(at("bit.nrrd"), NULL, &v, NULL, &err);
            if (status == OST_OK) {
                assert_memory_equal(v.voxels, sixteen, 16);
                padding++;
            } else {
                assert_int_equal(status, OST_ERR_INPUT);
            }
            ost_volume_free(&v);
            file.data[n] ^= (unsigned char)(1 << bit);
        }
    }
    assert_true(padding < 8);
}

/* A header that declares 2^36 voxels (69 GB or more) in a file of a few bytes must be refused before any allocation. */
static void refuses_small_files_that_declare_huge_sizes(void **state)
{
    (void)state;
    if (!HAS_NIFTI)
        skip();
    static bytes file;
    nifti_spec s = nifti_plain(1);
    s.dim[1] = s.dim[2] = 16384;
    s.dim[3] = 256;
    s.pixdim[1] = s.pixdim[2] = 0.25;
    write_nifti("huge.nii", &s, sixteen, 8);
    assert_refused(at("huge.nii"), NULL, OST_ERR_INPUT, "need 68719476736");
    write_nifti("huge.nii.gz", &s, sixteen, 8);
    assert_refused(at("huge.nii.gz"), NULL, OST_ERR_INPUT, "the packed data end at byte ");
    file.size = 0;
    put_text(&file,
             "NRRD0005\ntype: uint8\ndimension: 3\nsizes: 16384 16384 256\nspacings: 0.1 0.1 1\nencoding: gzip\n\n");
    put_gzip(&file, sixteen, 16);
    write_file("huge.nrrd", file.data, file.size);
    assert_refused(at("huge.nrrd"), NULL, OST_ERR_INPUT, "the packed data end at byte ");
    file.size = 0;
    put_text(
        &file,
        "NRRD0005\ntype: uint8\ndimension: 3\nsizes: 16384 16384 256\nspacings: 0.1 0.1 1\nencoding: text\n\n1 2 3");
    write_file("huge.nrrd", file.data, file.size);
    assert_refused(at("huge.nrrd"), NULL, OST_ERR_INPUT, "at least 137438953471");
}

static void refuses_invalid_nrrd_values(void **state)
{
    (void)state;
    static const struct {
        const char *type, *values, *words;
    } cases[] = {
        {"int16", "1 2 3 4 5 6 7", "ends"},
        {"int16", "1 2 3 4 5 6 7 8 9", "unexpected value"},
        {"int16", "1 2 3 4 5 6 7 eight", "is not a density"},
        {"int16", "1 2 3 4 5 6 7 0x10", "is not a density"},
        {"int16", "1 2 3 4 5 6 7 1.5", "is not a value of type int16"},
        {"uint8", "1 2 3 4 5 6 7 256", "is not a value of type uint8"},
        {"uint8", "1 2 3 4 5 6 7 -1", "is not a value of type uint8"},
        {"float", "1 2 3 4 5 6 7 nan", "voxel (1, 1, 1)"},
        {"float", "1 2 3 4 5 6 7 inf", "is not a density"},
        {"float", "1 2 3 4 5 6 7 1e30", "is outside -32768 to 32767"},
        {"double", "1 2 3 4 -32768.6 6 7 8", "voxel (0, 0, 1)"},
        {"uint64", "1 2 3 4 5 6 7 18446744073709551615", "is outside -32768 to 32767"},
        {"uint64", "1 2 3 4 5 6 7 18446744073709551616", "is not a value of type uint64"},
        {"uint64", "1 2 3 4 5 6 7 1e9999", "is not a value of type uint64"},
        {"uint64", "1 2 3 4 5 6 7 -1", "is not a value of type uint64"},
        {"int64", "1 2 3 4 5 6 7 -9223372036854775808", "-9223372036854775808 is outside -32768 to 32767"},
        {"int64", "1 2 3 4 5 6 7 -9223372036854775809", "is not a value of type int64"},
        {"int64", "1 2 3 4 5 6 7 9223372036854775808", "is not a value of type int64"},
        {"int32", "1 2 3 4 5 6 7 2147483648", "is not a value of type int32"},
        {"int8", "1 2 3 4 5 6 7 -129", "is not a value of type int8"},
    };
    char fields[200];
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        snprintf(fields, sizeof fields,
                 "NRRD0005\ntype: %s\ndimension: 3\nsizes: 2 2 2\nspacings: 1 1 1\nencoding: text\n\n%s", cases[i].type,
                 cases[i].values);
        write_file("v.nrrd", fields, strlen(fields));
        assert_refused(at("v.nrrd"), NULL, OST_ERR_INPUT, cases[i].words);
    }
    static bytes file;
    file.size = 0;
    put_text(&file,
             "NRRD0005\ntype: float\ndimension: 3\nsizes: 2 1 1\nspacings: 1 1 1\nencoding: raw\nendian: big\n\n");
    size_t start = file.size;
    put_bits(&file, float_bits(1), 4, true);
    put_bits(&file, float_bits(NAN), 4, true);
    write_file("n.nrrd", file.data, file.size);
    char location[40];
    snprintf(location, sizeof location, "(1, 0, 0) at byte %zu: ", start + 4);
    assert_refused(at("n.nrrd"), NULL, OST_ERR_INPUT, location);
}

static void refuses_invalid_nifti_fields(void **state)
{
    (void)state;
    if (!HAS_NIFTI)
        skip();
    for (int version = 1; version <= 2; version++) {
        for (int c = 0;; c++) {
            nifti_spec s = nifti_plain(version);
            const char *words = NULL;
            ost_status status = OST_ERR_INPUT;
            switch (c) {
            case 0: s.dim[0] = 0; words = "dim[0]"; break;
            case 1: s.dim[0] = 8; words = "dim[0]"; break;
            case 2: s.dim[0] = 2; words = "2 axes"; break;
            case 3: s.dim[2] = 0; words = "at least 1"; break;
            case 4: s.dim[3] = -5; words = "at least 1"; break;
            case 5: s.dim[1] = 16385; words = "16384"; status = OST_ERR_RANGE; break;
            case 6: s.dim[0] = 4; s.dim[4] = 3; words = "dim[4]"; break;
            case 7: s.dim[0] = 7; s.dim[7] = 0; words = "dim[7]"; break;
            case 8: s.datatype = 128; s.bitpix = 24; words = "RGB"; break;
            case 9: s.datatype = 32; s.bitpix = 64; words = "complex"; break;
            case 10: s.datatype = 0; words = "unknown datatype"; break;
            case 11: s.datatype = -3; words = "unknown datatype"; break;
            case 12: s.bitpix = 16; words = "bitpix"; break;
            case 13: s.vox_offset = 100; words = "vox_offset"; break;
            case 14: s.vox_offset = 1e9; words = "to be skipped"; break;
            case 15: s.vox_offset = -352; words = "vox_offset"; break;
            case 16: s.pixdim[1] = 0; words = "pixdim[1]"; break;
            case 17: s.pixdim[2] = -1; words = "pixdim[2]"; break;
            case 18: s.pixdim[3] = (double)NAN; words = "pixdim[3]"; break;
            case 19: s.pixdim[3] = 1e6; words = "pixdim[3]"; break;
            case 20: s.pixdim[3] = 500; words = "100 mm"; status = OST_ERR_RANGE; break;
            case 21: s.units = 5; words = "xyzt_units"; break;
            case 22: s.sform_code = 1; words = "do not span"; break;
            case 23: s.sform_code = 1; s.srow[0][0] = (double)NAN; words = "sform"; break;
            case 24: s.sform_code = 1; s.srow[2][3] = (double)INFINITY; words = "sform"; break;
            case 25: s.sform_code = 1; s.srow[0][0] = 1e20; words = "sform"; break;
            case 26: s.qform_code = 1; s.quatern[0] = (double)NAN; words = "quatern_b"; break;
            case 27: s.qform_code = 1; s.quatern[0] = s.quatern[1] = 1; words = "longer than 1"; break;
            case 28: s.qform_code = 1; s.qoffset[1] = (double)INFINITY; words = "qoffset_y"; break;
            case 29: s.slope = 2; s.inter = (double)NAN; words = "scl_inter"; break;
            case 30: s.slope = 1; s.inter = 40000; words = "is outside -32768 to 32767"; break;
            case 31: s.vox_offset = 100000.5; words = version == 1 ? "vox_offset" : "to be skipped"; break;
            case 32: s.qform_code = 1; s.pixdim[0] = (double)NAN; words = "pixdim[0]"; break;
            default: break;
            }
            if (!words)
                break;
            write_nifti("f.nii", &s, sixteen, 8);
            assert_refused(at("f.nii"), NULL, status, words);
        }
    }
    nifti_spec s = nifti_plain(1);
    static bytes file;
    unsigned char header[540];
    size_t size = nifti_header(&s, header);
    memset(header + 344, 0, 4);
    file.size = 0;
    put_bytes(&file, header, size);
    write_file("f.hdr", file.data, file.size);
    assert_refused(at("f.hdr"), NULL, OST_ERR_INPUT, "ANALYZE 7.5");
    s.pair = true;
    write_nifti("noext", &s, "", 0);
    assert_refused(at("noext"), NULL, OST_ERR_INPUT, ".hdr");
    file.size = 0;
    put_gzip(&file, "hello", 5);
    write_file("f.nii.gz", file.data, file.size);
    assert_refused(at("f.nii.gz"), NULL, OST_ERR_INPUT, "not a NIfTI volume");
    write_file("f.nii.gz", "\x1f\x8b\x08 nonsense", 12);
    assert_refused(at("f.nii.gz"), NULL, OST_ERR_INPUT, "gzip");
    file.size = 0;
    put_gzip(&file, "NRRD0005\n\n", 10);
    write_file("f.nrrd.gz", file.data, file.size);
    assert_refused(at("f.nrrd.gz"), NULL, OST_ERR_INPUT, "gzip -d");
}

/*
 * The voxels do not depend on extensions, so a broken chain of extensions is not an error. A file is refused only if a
 * fact that osteon stores in an extension is invalid.
 */
static void nifti_extensions(void **state)
{
    (void)state;
    if (!HAS_NIFTI)
        skip();
    static const struct {
        int size, code;
        const char *text;
        int metas; /* expected number of facts; -1 if the file must be refused */
    } cases[] = {
        {32, 6, "osteon side: left\n", 1},
        {32, 4, "osteon side: left\n", 0},
        {0, 6, "", 0},
        {-16, 6, "", 0},
        {1 << 30, 6, "osteon side: left", 0},
        {15, 6, "", 0},
        {32, 6, "osteon ", 0},
        {32, 6, "osteon A: b\n", -1},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        static bytes file;
        unsigned char header[540];
        nifti_spec s = nifti_plain(1);
        ost_error err = {0};
        ost_meta meta;
        s.vox_offset = 384;
        size_t size = nifti_header(&s, header);
        file.size = 0;
        put_bytes(&file, header, size);
        put_bytes(&file, "\1\0\0\0", 4);
        put_bits(&file, (uint64_t)(int64_t)cases[i].size, 4, false);
        put_bits(&file, (uint64_t)cases[i].code, 4, false);
        char text[24] = "";
        strcpy(text, cases[i].text);
        put_bytes(&file, text, 24);
        put_bytes(&file, sixteen, 8);
        write_file("e.nii", file.data, file.size);
        if (cases[i].metas < 0) {
            assert_refused(at("e.nii"), NULL, OST_ERR_RANGE, "is not a key");
            continue;
        }
        assert_ok(ost_volume_read_header(at("e.nii"), NULL, &meta, NULL, &err));
        /* the reader adds one fact, which states that the orientation was assumed */
        assert_int_equal(meta.count, cases[i].metas + 1);
        ost_volume v;
        assert_ok(ost_volume_read(at("e.nii"), NULL, &v, NULL, &err));
        ost_volume_free(&v);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(refuses_invalid_nrrd_fields),
        cmocka_unit_test(refuses_invalid_nrrd_beginnings),
        cmocka_unit_test(refuses_header_without_end),
        cmocka_unit_test(refuses_files_truncated_at_any_byte),
        cmocka_unit_test(detects_flipped_bits_in_compressed_data),
        cmocka_unit_test(refuses_small_files_that_declare_huge_sizes),
        cmocka_unit_test(refuses_invalid_nrrd_values),
        cmocka_unit_test(refuses_invalid_nifti_fields),
        cmocka_unit_test(nifti_extensions),
    };
    return cmocka_run_group_tests(tests, make_scratch, drop_scratch);
}
