/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Reads arbitrary bytes as a NIfTI file, either a single file or the header of a pair. The result
 * must be an error of one line or a volume within its ranges.
 */
#include "fuzz.h"

#include <osteon/io.h>

const char *const fuzz_words[] = {"n+1",
                                  "ni1",
                                  "n+2",
                                  "ni2",
                                  "\x5c\x01",
                                  "\x1c\x02",
                                  "\x1f\x8b\x08",
                                  "osteon spacing_mm: 1 1 1\n",
                                  "osteon origin_mm: 0 0 0\n",
                                  NULL};

/* Stores the lowest `size` bytes of `bits` in little-endian order. The callers' offsets are those of the format. */
static void put(uint8_t *at, uint64_t bits, size_t size)
{
    for (size_t i = 0; i < size; i++)
        at[i] = (uint8_t)(bits >> 8 * i);
}

enum { ONE = 0x3f800000, SEEDS = 5 };

/*
 * The seeds are volumes of 2 x 1 x 2 uint8 voxels. Four seeds are of version 1: one without
 * orientation, one with qform, one with sform and an extension, and one as the header of a pair.
 * The last seed is of version 2.
 */
size_t fuzz_seed(unsigned index, uint8_t *bytes, size_t capacity)
{
    bool two = index == 4;
    size_t size = two ? 540 : 348, extension = index == 2 ? 32 : 0, total = size + 4 + extension + 4;
    if (index >= SEEDS || total > capacity)
        return 0;
    memset(bytes, 0, total);
    put(bytes, size, 4);
    static const int dims[8] = {3, 2, 1, 2, 1, 1, 1, 1};
    for (size_t a = 0; a < 8; a++)
        put(bytes + (two ? 16 + 8 * a : 40 + 2 * a), (uint64_t)dims[a], two ? 8 : 2);
    put(bytes + (two ? 12 : 70), 2, 2);
    put(bytes + (two ? 14 : 72), 8, 2);
    for (size_t a = 0; a < 4; a++)
        put(bytes + (two ? 104 + 8 * a : 76 + 4 * a), two ? 0x3ff0000000000000 : ONE, two ? 8 : 4);
    if (two) {
        put(bytes + 168, 544, 8);
        memcpy(bytes + 4, "n+2\0\r\n\032\n", 8);
    } else {
        put(bytes + 108, index == 2 ? 0x43c00000 : 0x43b00000, 4); /* offset of the voxels: 384 or 352 */
        memcpy(bytes + 344, index == 3 ? "ni1" : "n+1", 4);
    }
    if (index == 1) {
        put(bytes + 252, 1, 2);
        put(bytes + 264, ONE, 4); /* quatern_d */
    }
    if (index == 2) {
        put(bytes + 254, 1, 2);
        for (size_t w = 0; w < 3; w++)
            put(bytes + 280 + 20 * w, ONE, 4);
        bytes[348] = 1;
        put(bytes + 352, 32, 4);
        put(bytes + 356, 6, 4);
        memcpy(bytes + 360, "osteon side: left\n", 18);
    }
    memcpy(bytes + total - 4, "\1\2\3\4", 4);
    return total;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    char path[1024];
    fuzz_file("f.img", (const uint8_t *)"\1\2\3\4", 4);
    snprintf(path, sizeof path, "%s", fuzz_file("f.hdr", data, size));
    for (int variant = 0; variant < 2; variant++) {
        const ost_volume_options options = {.clamp = variant == 1, .resample_oblique = variant == 1};
        ost_error err = {0};
        ost_geometry g;
        ost_volume v;
        ost_status status = ost_volume_read_header(path, &g, NULL, NULL, &err);
        if (status != OST_ERR_UNAVAILABLE)
            fuzz_require_error(status, err, fuzz_folder());
        if (status == OST_OK && ost_dims_count(g.dims) > 1 << 22)
            continue;
        memset(&err, 0, sizeof err);
        status = ost_volume_read(path, &options, &v, NULL, &err);
        if (status != OST_ERR_UNAVAILABLE)
            fuzz_require_error(status, err, fuzz_folder());
        fuzz_require((status == OST_OK) == (v.voxels != NULL));
        if (status == OST_OK)
            fuzz_require(ost_geometry_check(&v.geometry, path, &err) == OST_OK);
        ost_volume_free(&v);
    }
    return 0;
}
