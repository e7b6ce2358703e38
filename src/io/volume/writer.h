/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Writes a volume slab by slab, so that a bone can be copied from its backend to a
 * file without being completely in memory.
 *
 *   start -> bytes (header), pack -> put (voxels, x fastest) ... -> commit     or discard
 *
 * Voxels are written uncompressed or as one gzip member without name and time. Equal grids therefore give equal
 * files, if the same version of zlib is used; another version may compress the same bytes differently.
 */
#ifndef OST_IO_VOLUME_WRITER_H
#define OST_IO_VOLUME_WRITER_H

#include <osteon/io.h>

#include "io/volume/element.h"

typedef struct ost_volume_writer ost_volume_writer;

/*
 * Opens the file. `count` is the number of voxels that will be written after the header of the format. `options` is
 * used for progress and may be NULL.
 */
ost_status ost_volume_writer_start(const char *path, ost_element element, int64_t count,
                                   const ost_write_options *options, ost_volume_writer **out, ost_error *err);
ost_status ost_volume_writer_put(ost_volume_writer *writer, const void *voxels, size_t count, ost_error *err);
/* Completes the file and frees the writer, even after an error. All voxels must have been written. */
ost_status ost_volume_writer_commit(ost_volume_writer *writer, ost_error *err);
void ost_volume_writer_discard(ost_volume_writer *writer); /* NULL is allowed */

/* Called by the writer of a format. Writes bytes unchanged or, after a call of ost_volume_writer_pack, compressed. */
ost_status ost_volume_writer_bytes(ost_volume_writer *writer, const void *bytes, size_t size, ost_error *err);
ost_status ost_volume_writer_pack(ost_volume_writer *writer, ost_error *err);

#endif
