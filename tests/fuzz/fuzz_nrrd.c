/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Reads arbitrary bytes as a NRRD file. The result must be an error of one line, or a volume
 * that is unchanged after it has been written and read again.
 */
#include "fuzz.h"

#include <osteon/io.h>

const char *const fuzz_words[] = {"NRRD0005\n",     "type: ",        "uint8",         "double",      "dimension: 3\n",
                                  "sizes: ",        "spacings: ",    "encoding: ",    "raw",         "gzip",
                                  "text",           "endian: big\n", "space: LPS\n",  "RAS",         "(1,0,0)",
                                  "space origin: ", "byte skip: ",   "line skip: ",   "data file: ", "LIST",
                                  "%d 1 2 1",       "../",           "units: \"um\"", "nan",         "1e400",
                                  "16384",          "osteon_kind:=", "\n\n",          NULL};

static const char *const seeds[] = {
    ("NRRD0005\ntype: uint8\ndimension: 3\nspace: left-posterior-superior\nsizes: 2 2 2\n"
     "space directions: (0.47,0,0) (0,0.47,0) (0,0,1)\nkinds: domain domain domain\nendian: little\nencoding: raw\n"
     "space units: \"mm\" \"mm\" \"mm\"\nspace origin: (-57.34,0,12)\nosteon_kind:=ct\n\nabcdefgh"),
    "NRRD0004\ntype: float\ndimension: 3\nsizes: 2 1 2\nspacings: 0.3 0.3 0.3\nencoding: text\n\n1 -2.5 3e2\n400\n",
    "NRRD0001\n# comment\ntype: short\ndimension: 3\nsizes: 1 1 2\nspacings: 1 1 1\nendian: big\nencoding: raw\nbyte "
    "skip: -1\n\nxxabcd",
    "NRRD0005\ntype: uint8\ndimension: 3\nspace: RAS\nsizes: 2 3 1\nspace directions: (0,0,1) (0.6,0.8,0) "
    "(-0.8,0.6,0)\nencoding: text\n\n1 2 3 4 5 6",
    "NRRD0005\ntype: uint8\ndimension: 3\nsizes: 1 1 1\nspacings: 1 1 1\nencoding: raw\nline skip: 1\ndata file: "
    "LIST\nf.nrrd\n",
    "NRRD0005\ntype: uint8\ndimension: 3\nsizes: 1 1 2\nspacings: 1 1 1\nencoding: raw\ndata file: f%02d 1 2 1\n",
    ("NRRD0005\ntype: uint8\ndimension: 3\nsizes: 3 1 1\nspacings: 1 1 1\nencoding: gzip\n\n"
     "\x1f\x8b\x08\0\0\0\0\0\0\x03\x4b\x4c\x4a\x06\0\xc2\x41\x24\x35\x03\0\0\0"),
};

static const size_t gzip_tail = 23; /* size of the last seed's gzip data, which contain NUL bytes */

size_t fuzz_seed(unsigned index, uint8_t *bytes, size_t capacity)
{
    const unsigned count = sizeof seeds / sizeof seeds[0];
    if (index >= count)
        return 0;
    size_t size = index == count - 1 ? (size_t)(strstr(seeds[index], "\n\n") + 2 - seeds[index]) + gzip_tail
                                     : strlen(seeds[index]);
    if (size > capacity)
        size = capacity;
    memcpy(bytes, seeds[index], size);
    return size;
}

/* Returns true if the header declares a grid that is too large to be tested in a short time. */
static bool is_large(const char *path)
{
    ost_geometry g;
    ost_error err = {0};
    return ost_volume_read_header(path, &g, NULL, NULL, &err) == OST_OK && ost_dims_count(g.dims) > 1 << 22;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    char path[1024], again[1100];
    snprintf(path, sizeof path, "%s", fuzz_file("f.nrrd", data, size));
    snprintf(again, sizeof again, "%s/again.nrrd", fuzz_folder());
    for (int variant = 0; variant < 2; variant++) {
        const ost_volume_options options = {.clamp = variant == 1, .resample_oblique = variant == 1};
        ost_error err = {0};
        ost_volume v, back;
        ost_tool_volume tool;
        if (is_large(path))
            continue;
        ost_status status = ost_volume_read(path, &options, &v, NULL, &err);
        fuzz_require_error(status, err, fuzz_folder());
        fuzz_require((status == OST_OK) == (v.voxels != NULL));
        if (status == OST_OK && variant == 0) {
            fuzz_require(ost_geometry_check(&v.geometry, path, &err) == OST_OK);
            fuzz_require(ost_volume_write(again, &v, NULL, &err) == OST_OK);
            fuzz_require(ost_volume_read(again, NULL, &back, NULL, &err) == OST_OK);
            fuzz_require(ost_geometry_equal(&v.geometry, &back.geometry));
            fuzz_require(memcmp(v.voxels, back.voxels, (size_t)ost_dims_count(v.geometry.dims) * 2) == 0);
            fuzz_require(v.meta.count == back.meta.count);
            ost_volume_free(&back);
        }
        ost_volume_free(&v);
        memset(&err, 0, sizeof err);
        status = ost_tool_volume_read(path, &tool, &err);
        fuzz_require_error(status, err, fuzz_folder());
        ost_tool_volume_free(&tool);
    }
    return 0;
}
