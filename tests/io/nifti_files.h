/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Makes NIfTI headers byte by byte from the offsets in the description of the format
 * (nifti.nimh.nih.gov), in either byte order, without libnifti and without osteon's writer.
 */
#ifndef OST_TESTS_NIFTI_FILES_H
#define OST_TESTS_NIFTI_FILES_H

#include "volume_files.h"

typedef struct nifti_spec {
    int version; /* version of the format, 1 or 2 */
    bool big, pair;
    int64_t dim[8];
    int datatype, bitpix;
    double pixdim[4];
    double vox_offset; /* 0 means that the data follow the header directly */
    double slope, inter;
    int units;
    int qform_code, sform_code;
    double quatern[3], qoffset[3];
    double srow[3][4];
} nifti_spec;

static inline void set_bits(unsigned char *header, size_t at, uint64_t bits, size_t size, bool big)
{
    for (size_t i = 0; i < size; i++)
        header[at + i] = (unsigned char)(bits >> 8 * (big ? size - 1 - i : i));
}

/* Sets a float field of version 1, or a double field of version 2. */
static inline void set_real(const nifti_spec *s, unsigned char *header, size_t at1, size_t at2, double value)
{
    if (s->version == 1)
        set_bits(header, at1, float_bits((float)value), 4, s->big);
    else
        set_bits(header, at2, double_bits(value), 8, s->big);
}

/* Fills header (348 or 540 bytes) and returns its size. */
static inline size_t nifti_header(const nifti_spec *s, unsigned char header[540])
{
    bool one = s->version == 1;
    size_t size = one ? 348 : 540;
    memset(header, 0, 540);
    set_bits(header, 0, size, 4, s->big);
    for (size_t a = 0; a < 8; a++)
        set_bits(header, one ? 40 + 2 * a : 16 + 8 * a, (uint64_t)s->dim[a], one ? 2 : 8, s->big);
    set_bits(header, one ? 70 : 12, (uint64_t)s->datatype, 2, s->big);
    set_bits(header, one ? 72 : 14, (uint64_t)s->bitpix, 2, s->big);
    for (size_t a = 0; a < 4; a++)
        set_real(s, header, 76 + 4 * a, 104 + 8 * a, s->pixdim[a]);
    double offset = s->vox_offset != 0 || s->pair ? s->vox_offset : (double)(size + 4);
    if (one)
        set_bits(header, 108, float_bits((float)offset), 4, s->big);
    else
        set_bits(header, 168, (uint64_t)(int64_t)offset, 8, s->big);
    set_real(s, header, 112, 176, s->slope);
    set_real(s, header, 116, 184, s->inter);
    if (one)
        header[123] = (unsigned char)s->units;
    else
        set_bits(header, 500, (uint64_t)s->units, 4, s->big);
    set_bits(header, one ? 252 : 344, (uint64_t)s->qform_code, one ? 2 : 4, s->big);
    set_bits(header, one ? 254 : 348, (uint64_t)s->sform_code, one ? 2 : 4, s->big);
    for (size_t w = 0; w < 3; w++) {
        set_real(s, header, 256 + 4 * w, 352 + 8 * w, s->quatern[w]);
        set_real(s, header, 268 + 4 * w, 376 + 8 * w, s->qoffset[w]);
        for (size_t c = 0; c < 4; c++)
            set_real(s, header, 280 + 16 * w + 4 * c, 400 + 32 * w + 8 * c, s->srow[w][c]);
    }
    if (one)
        memcpy(header + 344, s->pair ? "ni1" : "n+1", 4);
    else
        memcpy(header + 4, s->pair ? "ni2\0\r\n\032\n" : "n+2\0\r\n\032\n", 8);
    return size;
}

/* Returns a volume of 2 x 2 x 2 uint8 voxels of 1 mm, without orientation. */
static inline nifti_spec nifti_plain(int version)
{
    return (nifti_spec){.version = version,
                        .dim = {3, 2, 2, 2, 1, 1, 1, 1},
                        .datatype = 2,
                        .bitpix = 8,
                        .pixdim = {1, 1, 1, 1}};
}

/*
 * Writes the header and, unless it is the header of a pair, four zero bytes and the data. The file is compressed if its
 * name ends in .gz.
 */
static inline void write_nifti(const char *name, const nifti_spec *s, const void *data, size_t size)
{
    static bytes plain, packed;
    unsigned char header[540];
    plain.size = packed.size = 0;
    size_t header_bytes = nifti_header(s, header);
    put_bytes(&plain, header, header_bytes);
    if (!s->pair) {
        put_bytes(&plain, "\0\0\0\0", 4);
        put_bytes(&plain, data, size);
    }
    const char *end = strrchr(name, '.');
    if (end && strcmp(end, ".gz") == 0) {
        put_gzip(&packed, plain.data, plain.size);
        write_file(name, packed.data, packed.size);
    } else {
        write_file(name, plain.data, plain.size);
    }
}

#endif
