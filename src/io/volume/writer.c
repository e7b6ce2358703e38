/* SPDX-License-Identifier: Apache-2.0 */
#include "io/volume/writer.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include <zlib.h>

#include "io/outfile.h"

enum { PACKED_BYTES = 1 << 16, LEVEL = 6 };
enum { PIECE = 1 << 20 }; /* number of voxels between two calls of the progress callback */

struct ost_volume_writer {
    ost_outfile *file;
    size_t element_bytes;
    int64_t all, left; /* all: number of voxels in the file; left: number of voxels not yet written */
    ost_progress *progress;
    void *progress_user;
    bool packing;
    z_stream z;
    unsigned char packed[PACKED_BYTES];
};

/* ------------------------------------------------------------------- bytes */

/*
 * Compresses bytes and writes the output of deflate. If flush is Z_FINISH, also writes all output that is buffered in
 * deflate.
 */
static ost_status deflate_bytes(ost_volume_writer *w, const void *bytes, size_t size, int flush, ost_error *err)
{
    const unsigned char *at = bytes;
    do {
        size_t piece = size < (1u << 30) ? size : (1u << 30);
        int now = piece == size ? flush : Z_NO_FLUSH;
        w->z.next_in = (unsigned char *)(uintptr_t)at; /* zlib does not modify its input */
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
    /* The value 16 makes zlib write a gzip header, which contains no name and the time 0. */
    if (deflateInit2(&w->z, LEVEL, Z_DEFLATED, 15 + 16, 8, Z_DEFAULT_STRATEGY) != Z_OK)
        return ost_fail(err, OST_ERR_MEMORY, "%s: out of memory for compression", ost_outfile_path(w->file));
    w->packing = true;
    return OST_OK;
}

/* ------------------------------------------------------------------ writer */

ost_status ost_volume_writer_start(const char *path, ost_element element, int64_t count,
                                   const ost_write_options *options, ost_volume_writer **out, ost_error *err)
{
    *out = NULL;
    ost_volume_writer *w = malloc(sizeof *w);
    if (!w)
        return ost_fail(err, OST_ERR_MEMORY, "%s: out of memory for an output buffer", path);
    memset(w, 0, offsetof(ost_volume_writer, packed));
    w->element_bytes = ost_element_bytes(element);
    w->all = w->left = count;
    w->progress = options ? options->progress : NULL;
    w->progress_user = options ? options->progress_user : NULL;
    ost_status status = ost_outfile_open(path, &w->file, err);
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
    const unsigned char *at = voxels;
    ost_status status = OST_OK;
    while (count > 0 && status == OST_OK) {
        const size_t piece = count < PIECE ? count : PIECE;
        if (w->progress && !w->progress(w->progress_user, "writing", (double)(w->all - w->left) / (double)w->all))
            return ost_fail(err, OST_ERR_CANCELLED, "%s: writing was cancelled", ost_outfile_path(w->file));
        status = ost_volume_writer_bytes(w, at, piece * w->element_bytes, err);
        at += piece * w->element_bytes;
        count -= piece;
        w->left -= (int64_t)piece;
    }
    return status;
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
