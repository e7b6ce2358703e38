/* SPDX-License-Identifier: Apache-2.0 */
/* Tests that the type of a file is determined by its content, or by its name if the content is not conclusive. */
#include "harness.h"

#include <zlib.h>

#include <osteon/io.h>

#include "io_scratch.h"

static ost_file_kind kind_of(const char *folder, const char *name, const void *bytes, size_t size)
{
    ost_error err = {0};
    ost_file_kind kind;
    assert_ok(ost_file_kind_find(scratch_write(folder, name, bytes, size), &kind, &err));
    return kind;
}

static void type_is_found_by_content(void **state)
{
    (void)state;
    static const struct {
        const char *name, *text;
        ost_file_kind kind;
    } cases[] = {
        {"a.txt", "NRRD0004\ntype: short\n", OST_FILE_NRRD},
        {"a", "NRRD0005\n", OST_FILE_NRRD},
        {"a", "ObjectType = Image\nNDims = 3\n", OST_FILE_METAIMAGE},
        {"a.txt", "NDims = 3\nDimSize = 2 2 2\n", OST_FILE_METAIMAGE},
        {"a.bin", "ply\nformat ascii 1.0\n", OST_FILE_MESH},
        {"a.txt", "solid cube\n facet normal 0 0 1\n", OST_FILE_MESH},
        {"a", "0 0 0 100\n", OST_FILE_CT_TEXT},
        {"a.csv", "# note\nx,y,z,density\n0,0,0,1\n", OST_FILE_CT_TEXT},
        {"a.csv", "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz\n", OST_FILE_PATH_CSV},
        {"a", "0,0,0,0,1,0,0,0\n", OST_FILE_PATH_CSV},
        {"a", "0,0,0,0,1,0,0,0,2\r\n", OST_FILE_PATH_CSV},
        {"a", "0 0 0 100\r0 0 1 100\r", OST_FILE_CT_TEXT}, /* the reader of CT texts refuses these line ends */
        {"a.csv", "# note\r0,0,0,0,1,0,0,0\r", OST_FILE_PATH_CSV},
        {"a", "one two three\n", OST_FILE_UNKNOWN},
        {"a", "", OST_FILE_UNKNOWN},
        /*
         * If the content is not conclusive, the name determines the format, and the reader of
         * this format reports the error.
         */
        {"a.TXT", "junk", OST_FILE_CT_TEXT},
        {"a.csv", "junk", OST_FILE_PATH_CSV},
        {"a", "\x89OSTSES\n", OST_FILE_SESSION},
        {"a.csv", "................................................................\x89OSTSES\n", OST_FILE_SESSION},
        {"a.session", "junk", OST_FILE_SESSION},
        {"a.nii.gz", "junk", OST_FILE_NIFTI},
        {"a.nhdr", "junk", OST_FILE_NRRD},
        {"a.MHA", "junk", OST_FILE_METAIMAGE},
        {"a.obj", "v 0 0 0\n", OST_FILE_MESH},
    };
    char *folder = scratch_folder();
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++)
        if (kind_of(folder, cases[i].name, cases[i].text, strlen(cases[i].text)) != cases[i].kind)
            fail_msg("case %zu: the type of %s is not %d", i, cases[i].name, (int)cases[i].kind);
    scratch_remove(folder);
}

static void binary_signatures(void **state)
{
    (void)state;
    char *folder = scratch_folder(), path[600];
    unsigned char dicom[132] = {0};
    memcpy(dicom + 128, "DICM", 4);
    /* the content determines the type, so the name has no effect */
    assert_int_equal(kind_of(folder, "a.nii", dicom, sizeof dicom), OST_FILE_DICOM);
    unsigned char header[540] = {348 & 255, 348 >> 8};
    memcpy(header + 344, "n+1", 4);
    assert_int_equal(kind_of(folder, "a.txt", header, 352), OST_FILE_NIFTI);
    assert_int_equal(kind_of(folder, "a", header, 347), OST_FILE_UNKNOWN);

    snprintf(path, sizeof path, "%s/z", folder);
    gzFile gz = gzopen(path, "wb");
    assert_non_null(gz);
    assert_int_equal(gzwrite(gz, header, 352), 352);
    assert_int_equal(gzclose(gz), Z_OK);
    ost_error err = {0};
    ost_file_kind kind;
    assert_ok(ost_file_kind_find(path, &kind, &err));
    assert_int_equal(kind, OST_FILE_NIFTI);

    unsigned char big[352] = {0, 0, 348 >> 8, 348 & 255};
    memcpy(big + 344, "ni1", 4);
    assert_int_equal(kind_of(folder, "a", big, sizeof big), OST_FILE_NIFTI);
    memset(header, 0, sizeof header);
    header[0] = 540 & 255;
    header[1] = 540 >> 8;
    memcpy(header + 4, "n+2", 4);
    assert_int_equal(kind_of(folder, "a", header, 540), OST_FILE_NIFTI);

    unsigned char stl[84 + 100] = "made by code";
    stl[80] = 2;
    assert_int_equal(kind_of(folder, "a", stl, sizeof stl), OST_FILE_MESH);
    assert_int_equal(kind_of(folder, "a", stl, sizeof stl - 1), OST_FILE_UNKNOWN);

    unsigned char main3ds[16] = {0x4d, 0x4d, 16, 0, 0, 0};
    assert_int_equal(kind_of(folder, "a", main3ds, sizeof main3ds), OST_FILE_MESH);
    scratch_remove(folder);
}

static void folders_absent_files_and_pipes(void **state)
{
    (void)state;
    char *folder = scratch_folder(), path[600];
    ost_error err = {0};
    ost_file_kind kind;
    assert_ok(ost_file_kind_find(folder, &kind, &err));
    assert_int_equal(kind, OST_FILE_DICOM); /* the files of a folder are examined only when the folder is read */
    snprintf(path, sizeof path, "%s/absent.nrrd", folder);
    assert_int_equal(ost_file_kind_find(path, &kind, &err), OST_ERR_IO);
    assert_non_null(strstr(err.text, "No such file"));
    snprintf(path, sizeof path, "%s/pipe.nrrd", folder);
    assert_int_equal(mkfifo(path, 0600), 0);
    assert_int_equal(ost_file_kind_find(path, &kind, &err), OST_ERR_IO);
    assert_non_null(strstr(err.text, "is a pipe"));
    scratch_remove(folder);
}

/* A format that osteon does not read must be refused. The error line contains the name of the format and of a
   program that converts it. */
static void refuses_foreign_formats(void **state)
{
    static const struct {
        const char *name, *bytes;
        size_t size, offset;
        const char *what, *remedy;
    } cases[] = {
        {"a.mnc", "CDF\001", 4, 0, "a NetCDF file", "mnc2nii"},
        {"a.mnc", "\x89HDF\r\n\x1a\n", 8, 0, "an HDF5 file", "mnc2nii"},
        {"a.txt.bz2", "BZh91AY", 7, 0, "compressed by bzip2", "bunzip2"},
        {"a.nrrd.xz", "\xfd\x37zXZ\0", 6, 0, "compressed by xz", "unxz"},
        {"a.zip", "PK\003\004", 4, 0, "a ZIP archive", "unzip"},
        {"a.txt.gz", "\x1f\x8b\x08\0\0\0\0\0\0\x03\x33\x54\x30\x04\0\x3d\xa7\x2b\x33\x03\0\0\0", 23, 0,
         "compressed by gzip", "gunzip"},
    };
    unsigned char file[200];
    char *folder = scratch_folder();
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        ost_error err = {0};
        ost_file_kind kind;
        memset(file, 0, sizeof file);
        memcpy(file + cases[i].offset, cases[i].bytes, cases[i].size);
        const char *path = scratch_write(folder, cases[i].name, file, cases[i].offset + cases[i].size);
        assert_int_equal(ost_file_kind_find(path, &kind, &err), OST_ERR_INPUT);
        if (!strstr(err.text, cases[i].what) || !strstr(err.text, cases[i].remedy))
            fail_msg("case %zu (%s): the error '%s' does not contain '%s' and '%s'", i, cases[i].name, err.text,
                     cases[i].what, cases[i].remedy);
    }
    scratch_remove(folder);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(type_is_found_by_content),
        cmocka_unit_test(binary_signatures),
        cmocka_unit_test(folders_absent_files_and_pipes),
        cmocka_unit_test(refuses_foreign_formats),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
