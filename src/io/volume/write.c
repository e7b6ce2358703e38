/* SPDX-License-Identifier: Apache-2.0 */
#include "io/volume/write.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include <zlib.h>

#include "io/outfile.h"
#include "io/text/write.h"

enum { PACKED_BYTES = 1 << 16, LEVEL = 6 };

struct ost_volume_writer {
    ost_outfile *file;
    size_t element_bytes;
    int64_t left; /* voxels still to come */
    bool packing;
    z_stream z;
    unsigned char packed[PACKED_BYTES];
};

static bool ends_in(const char *text, const char *end)
{
    size_t n = strlen(text), m = strlen(end);
    return n >= m && strcasecmp(text + n - m, end) == 0;
}

ost_volume_format ost_volume_format_of(const char *path)
{
    return ends_in(path, ".nrrd")     ? OST_FORMAT_NRRD
           : ends_in(path, ".nii")    ? OST_FORMAT_NIFTI
           : ends_in(path, ".nii.gz") ? OST_FORMAT_NIFTI_GZIP
           : ends_in(path, ".txt")    ? OST_FORMAT_TEXT
                                      : OST_FORMAT_UNKNOWN;
}

ost_status ost_volume_format_unknown(const char *path, ost_error *err)
{
    return ost_fail(err, OST_ERR_USAGE, "%s: the name does not say which format to write; it should end in .nrrd, .nii, .nii.gz or .txt",
                    path);
}

/* ------------------------------------------------------------------- bytes */

/* Feeds deflate and writes what it gives; with Z_FINISH until it has given all. */
static ost_status deflate_bytes(ost_volume_writer *w, const void *bytes, size_t size, int flush, ost_error *err)
{
    const unsigned char *at = bytes;
    do {
        size_t piece = size < (1u << 30) ? size : (1u << 30);
        int now = piece == size ? flush : Z_NO_FLUSH;
        w->z.next_in = (unsigned char *)(uintptr_t)at; /* zlib does not write there */
        w->z.avail_in = (uInt)piece;
        do {
            w->z.next_out = w->packed;
            w->z.avail_out = PACKED_BYTES;
            if (deflate(&w->z, now) == Z_STREAM_ERROR)
                return ost_fail(err, OST_ERR_INTERNAL, "%s: packing failed", ost_outfile_path(w->file));
            ost_status status = ost_outfile_write(w->file, w->packed, PACKED_BYTES - w->z.avail_out, err);
            if (status != OST_OK)
                return status;
        } while (w->z.avail_out == 0);
        at += piece;
        size -= piece;
    } while (size > 0);
    return OST_OK;
}

ost_status ost_volume_writer_bytes(ost_volume_writer *w, const void *bytes, size_t size, ost_error *err)
{
    return w->packing ? deflate_bytes(w, bytes, size, Z_NO_FLUSH, err) : ost_outfile_write(w->file, bytes, size, err);
}

ost_status ost_volume_writer_pack(ost_volume_writer *w, ost_error *err)
{
    assert(!w->packing);
    memset(&w->z, 0, sizeof w->z);
    /* 16: a gzip header of zlib's own, which has no name and time 0. */
    if (deflateInit2(&w->z, LEVEL, Z_DEFLATED, 15 + 16, 8, Z_DEFAULT_STRATEGY) != Z_OK)
        return ost_fail(err, OST_ERR_MEMORY, "%s: no memory to pack it", ost_outfile_path(w->file));
    w->packing = true;
    return OST_OK;
}

/* ------------------------------------------------------------------ writer */

ost_status ost_volume_writer_open(const char *path, const ost_geometry *geometry, const ost_meta *meta, ost_element element,
                                  bool odd_half, const ost_write_options *options, ost_volume_writer **out, ost_error *err)
{
    *out = NULL;
    ost_volume_format format = ost_volume_format_of(path);
    if (format == OST_FORMAT_UNKNOWN)
        return ost_volume_format_unknown(path, err);
    assert(format != OST_FORMAT_TEXT);
    assert(element == OST_ELEMENT_INT16 || (element == OST_ELEMENT_UINT8 && format == OST_FORMAT_NRRD));
    ost_volume_writer *w = malloc(sizeof *w);
    if (!w)
        return ost_fail(err, OST_ERR_MEMORY, "%s: no memory for an output buffer", path);
    memset(w, 0, offsetof(ost_volume_writer, packed));
    w->element_bytes = ost_element_bytes(element);
    w->left = ost_dims_count(geometry->dims);
    ost_status status = ost_outfile_open(path, &w->file, err);
    if (status == OST_OK)
        status = format == OST_FORMAT_NRRD
                     ? ost_nrrd_write_header(w, geometry, meta, element, odd_half, options && options->compress, err)
                     : ost_nifti_write_header(w, geometry, meta, format == OST_FORMAT_NIFTI_GZIP, err);
    if (status != OST_OK) {
        ost_volume_writer_discard(w);
        return status;
    }
    *out = w;
    return OST_OK;
}

ost_status ost_volume_writer_put(ost_volume_writer *w, const void *voxels, size_t count, ost_error *err)
{
    assert((int64_t)count <= w->left);
    w->left -= (int64_t)count;
    return ost_volume_writer_bytes(w, voxels, count * w->element_bytes, err);
}

ost_status ost_volume_writer_commit(ost_volume_writer *w, ost_error *err)
{
    assert(w->left == 0);
    ost_status status = w->packing ? deflate_bytes(w, "", 0, Z_FINISH, err) : OST_OK;
    if (status == OST_OK) {
        status = ost_outfile_commit(w->file, err);
        w->file = NULL;
    }
    ost_volume_writer_discard(w);
    return status;
}

void ost_volume_writer_discard(ost_volume_writer *w)
{
    if (!w)
        return;
    if (w->packing)
        deflateEnd(&w->z);
    ost_outfile_discard(w->file);
    free(w);
}

/* ------------------------------------------------------------------ volumes */

ost_status ost_volume_write(const char *path, const ost_volume *volume, const ost_write_options *options, ost_error *err)
{
    ost_volume_format format = ost_volume_format_of(path);
    if (format == OST_FORMAT_UNKNOWN)
        return ost_volume_format_unknown(path, err);
    ost_status status = ost_geometry_check(&volume->geometry, path, err);
    if (status != OST_OK)
        return status;
    if (!volume->voxels)
        return ost_fail(err, OST_ERR_USAGE, "%s: the volume to write has no voxels", path);
    if (format == OST_FORMAT_TEXT)
        return ost_text_write_volume(path, volume, options ? options->text_decimals : 0, err);
    ost_volume_writer *w;
    status = ost_volume_writer_open(path, &volume->geometry, &volume->meta, OST_ELEMENT_INT16, false, options, &w, err);
    if (status != OST_OK)
        return status;
    status = ost_volume_writer_put(w, volume->voxels, (size_t)ost_dims_count(volume->geometry.dims), err);
    if (status == OST_OK)
        return ost_volume_writer_commit(w, err);
    ost_volume_writer_discard(w);
    return status;
}
