/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Reads arbitrary bytes as a MetaImage file. The result must be an error of one line, or a volume
 * that is unchanged after it has been written as NRRD and read again.
 */
#include "fuzz.h"

#include <osteon/io.h>

const char *const fuzz_words[] = {"ObjectType = Image\n",
                                  "NDims = 3\n",
                                  "DimSize = ",
                                  "ElementSpacing = ",
                                  "ElementSize = ",
                                  "ElementType = ",
                                  "MET_UCHAR\n",
                                  "MET_DOUBLE\n",
                                  "TransformMatrix = ",
                                  "1 0 0 0 1 0 0 0 1\n",
                                  "0.6 0.8 0 -0.8 0.6 0 0 0 1\n",
                                  "Offset = ",
                                  "CompressedData = True\n",
                                  "BinaryDataByteOrderMSB = True\n",
                                  "HeaderSize = -1\n",
                                  "DistanceUnits = cm\n",
                                  "ElementDataFile = LOCAL\n",
                                  "LIST",
                                  "%d 1 2 1",
                                  "../",
                                  "16384",
                                  "1e400",
                                  NULL};

#define START "ObjectType = Image\nNDims = 3\nElementSpacing = 0.47 0.47 1\n"

static const char *const seeds[] = {
    START "TransformMatrix = 1 0 0 0 1 0 0 0 1\nOffset = -57.34 0 12\nDimSize = 2 2 2\nElementType = MET_UCHAR\n"
          "ElementDataFile = LOCAL\nabcdefgh",
    START "TransformMatrix = 0 1 0 -1 0 0 0 0 -1\nDimSize = 1 1 2\nElementType = MET_SHORT\nHeaderSize = -1\n"
          "BinaryDataByteOrderMSB = True\nElementDataFile = LOCAL\nxxabcd",
    START "Orientation = 0.6 0.8 0 -0.8 0.6 0 0 0 1\nDimSize = 2 2 1\nElementType = MET_CHAR\n"
          "ElementDataFile = LOCAL\nabcd",
    START "DimSize = 1 1 1\nElementType = MET_UCHAR\nElementDataFile = LIST\nf.mha\n",
    START "DimSize = 1 1 2\nElementType = MET_UCHAR\nElementDataFile = f%02d 1 2 1\n",
    START "DimSize = 3 1 1\nElementType = MET_UCHAR\nCompressedData = True\nElementDataFile = LOCAL\n"
          "\x78\x9c\x4b\x4c\x4a\x06\x02\x4d\x01\x27",
};

size_t fuzz_seed(unsigned index, uint8_t *bytes, size_t capacity)
{
    if (index >= sizeof seeds / sizeof seeds[0])
        return 0;
    const size_t length = strlen(seeds[index]), size = length > capacity ? capacity : length;
    memcpy(bytes, seeds[index], size);
    return size;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    char path[1024], again[1100];
    snprintf(path, sizeof path, "%s", fuzz_file("f.mha", data, size));
    snprintf(again, sizeof again, "%s/again.nrrd", fuzz_folder());
    for (int variant = 0; variant < 2; variant++) {
        const ost_volume_options options = {.clamp = variant == 1, .resample_oblique = variant == 1};
        ost_geometry g;
        ost_error err = {0};
        ost_volume v, back;
        /* A volume is not read if its grid is too large to be tested in a short time. */
        if (ost_volume_read_header(path, &g, NULL, NULL, &err) == OST_OK && ost_dims_count(g.dims) > 1 << 22)
            continue;
        memset(&err, 0, sizeof err);
        const ost_status status = ost_volume_read(path, &options, &v, NULL, &err);
        fuzz_require_error(status, err, fuzz_folder());
        fuzz_require((status == OST_OK) == (v.voxels != NULL));
        if (status == OST_OK && variant == 0) {
            fuzz_require(ost_geometry_check(&v.geometry, path, &err) == OST_OK);
            fuzz_require(ost_volume_write(again, &v, NULL, &err) == OST_OK);
            fuzz_require(ost_volume_read(again, NULL, &back, NULL, &err) == OST_OK);
            fuzz_require(ost_geometry_equal(&v.geometry, &back.geometry));
            fuzz_require(memcmp(v.voxels, back.voxels, (size_t)ost_dims_count(v.geometry.dims) * 2) == 0);
            ost_volume_free(&back);
        }
        ost_volume_free(&v);
    }
    return 0;
}
