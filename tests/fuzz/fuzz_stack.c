/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Reads arbitrary bytes as a TIFF or PNG file of a stack. The result must be an error of one line, or a
 * volume that is unchanged after it has been written as NRRD and read again.
 */
#include "fuzz.h"

#include <osteon/io.h>

const char *const fuzz_words[] = {"II*",  "MM",   "\x89PNG\r\n\x1a\n", "IHDR", "IDAT",       "IEND",
                                  "PLTE", "tRNS", "pHYs",              "iCCP", "ImageJ=1\n", "\nimages=9\n",
                                  "\3\1", "\1\3", "\x11\1",            "\1\x11", NULL};

/* A TIFF of 2 x 2 pixels of 16 bits: header, strip, directory with 9 entries of type SHORT. */
#define ENTRY(tag, value) tag "\1\3\0\1\0\0\0" value "\0\0\0"
static const char tiff[] =
    "II*\0\20\0\0\0\1\0\2\0\3\0\4\0\11\0" ENTRY("\0", "\2") ENTRY("\1", "\2") ENTRY("\2", "\20") ENTRY("\3", "\1")
    ENTRY("\6", "\1") ENTRY("\x11", "\10") ENTRY("\x15", "\1") ENTRY("\x16", "\2") ENTRY("\x17", "\10") "\0\0\0\0";

/* A PNG of 2 x 2 grey pixels. In most mutations, its chunks have wrong checksums. libpng must refuse such a file. */
static const char png[] =
    "\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\0\2\0\0\0\2\10\0\0\0\0\x57\xdd\x52\xf8"
    "\0\0\0\16IDAT\x78\xda\x63\x60\x64\x62\x60\x66\x01\x00\x00\x1d\x00\x0b\x10\xdd\x1c\x70\0\0\0\0IEND\xae\x42\x60\x82";

size_t fuzz_seed(unsigned index, uint8_t *bytes, size_t capacity)
{
    static const struct {
        const char *bytes;
        size_t size;
    } seeds[] = {{tiff, sizeof tiff - 1}, {png, sizeof png - 1}};
    if (index >= sizeof seeds / sizeof seeds[0])
        return 0;
    const size_t size = seeds[index].size > capacity ? capacity : seeds[index].size;
    memcpy(bytes, seeds[index].bytes, size);
    return size;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    char path[1024], again[1100];
    snprintf(path, sizeof path, "%s", fuzz_file("f1.tif", data, size));
    snprintf(again, sizeof again, "%s/again.nrrd", fuzz_folder());
    const ost_volume_options options = {.clamp = true, .nan_as_air = true,
                                        .stack_spacing = {1000000, 1000000, 1000000}};
    ost_error err = {0};
    ost_volume v, back;
    /* Files of other types are not read, because they may declare any size. The size of a stack is limited by the size
       of its file. */
    ost_file_kind kind;
    if (ost_file_kind_find(path, &kind, &err) != OST_OK || kind != OST_FILE_STACK)
        return 0;
    const ost_status status = ost_volume_read(path, &options, &v, NULL, &err);
    fuzz_require_error(status, err, fuzz_folder());
    fuzz_require((status == OST_OK) == (v.voxels != NULL));
    if (status == OST_OK) {
        fuzz_require((uint64_t)ost_dims_count(v.geometry.dims) <= 1400 * (uint64_t)size);
        fuzz_require(ost_geometry_check(&v.geometry, path, &err) == OST_OK);
        fuzz_require(ost_volume_write(again, &v, NULL, &err) == OST_OK);
        fuzz_require(ost_volume_read(again, NULL, &back, NULL, &err) == OST_OK);
        fuzz_require(ost_geometry_equal(&v.geometry, &back.geometry));
        fuzz_require(memcmp(v.voxels, back.voxels, (size_t)ost_dims_count(v.geometry.dims) * 2) == 0);
        ost_volume_free(&back);
    }
    ost_volume_free(&v);
    return 0;
}
