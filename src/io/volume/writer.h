/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A volume out, slab by slab, so that a bone goes from its backend to a file
 * without ever being whole in memory.
 *
 *   start -> bytes (header), pack -> put (voxels, x fastest) ... -> commit     or discard
 *
 * Voxels go plain or as one gzip member without name or time: equal grids are
 * equal files (of one zlib; others may pack the same bytes otherwise).
 */
#ifndef OST_IO_VOLUME_WRITER_H
#define OST_IO_VOLUME_WRITER_H

#include <osteon/io.h>

#include "io/volume/element.h"

typedef struct ost_volume_writer ost_volume_writer;

/* Opens the file; count voxels are to come, after whatever header its format has. */
ost_status ost_volume_writer_start(const char *path, ost_element element, int64_t count, ost_volume_writer **out, ost_error *err);
ost_status ost_volume_writer_put(ost_volume_writer *writer, const void *voxels, size_t count, ost_error *err);
/* Ends the writer in any case. Every voxel must have been put. */
ost_status ost_volume_writer_commit(ost_volume_writer *writer, ost_error *err);
void ost_volume_writer_discard(ost_volume_writer *writer); /* NULL is allowed */

/* For the formats: bytes as they are, packed from ost_volume_writer_pack on. */
ost_status ost_volume_writer_bytes(ost_volume_writer *writer, const void *bytes, size_t size, ost_error *err);
ost_status ost_volume_writer_pack(ost_volume_writer *writer, ost_error *err);

#endif
