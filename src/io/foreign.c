/* SPDX-License-Identifier: Apache-2.0 */
#include "io/foreign.h"

#include <string.h>

#define SLICER "3D Slicer imports it and saves NRRD"
#define SIGNATURE(text) text, sizeof(text) - 1

/* A signature: `length` bytes at `offset` that identify a file format. */
static const struct {
    size_t offset;
    const char *bytes;
    size_t length;
    const char *name;
    const char *remedy;
} formats[] = {
    {0, SIGNATURE("CDF\001"), "a NetCDF file", "mnc2nii converts it to NIfTI if it is MINC"},
    {0, SIGNATURE("\x89HDF\r\n\x1a\n"), "an HDF5 file", "mnc2nii converts it to NIfTI if it is MINC"},
    {0, SIGNATURE("# vtk DataFile"), "a VTK file", SLICER},
    {0, SIGNATURE("\xff\xd8\xff"), "a JPEG picture",
     "its densities are no longer exact; import the scan from which it was made"},
    {0, SIGNATURE("BZh"), "compressed by bzip2", "bunzip2 decompresses it"},
    {0, SIGNATURE("\xfd\x37zXZ\0"), "compressed by xz", "unxz decompresses it"},
    {0, SIGNATURE("\x28\xb5\x2f\xfd"), "compressed by zstd", "unzstd decompresses it"},
    {0, SIGNATURE("PK\003\004"), "a ZIP archive", "unzip unpacks it"},
    {0, SIGNATURE("7z\xbc\xaf\x27\x1c"), "a 7z archive", "7zr unpacks it"},
};

ost_status ost_refuse_foreign(const char *path, const unsigned char *head, size_t size, ost_error *err)
{
    for (size_t i = 0; i < sizeof formats / sizeof formats[0]; i++)
        if (size >= formats[i].offset + formats[i].length &&
            memcmp(head + formats[i].offset, formats[i].bytes, formats[i].length) == 0)
            return ost_fail(err, OST_ERR_INPUT, "%s: is %s, which osteon does not read; %s", path, formats[i].name,
                            formats[i].remedy);
    return OST_OK;
}
