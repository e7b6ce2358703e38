/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A volume out, slab by slab, so that a bone goes from its backend to a file
 * without ever being whole in memory.
 *
 *   open (header) -> put (voxels, x fastest) ... -> commit     or discard
 *
 * Voxels go plain or as one gzip member without name or time: equal grids are
 * equal files (of one zlib; others may pack the same bytes otherwise).
 */
#ifndef OST_IO_VOLUME_WRITE_H
#define OST_IO_VOLUME_WRITE_H

#include <osteon/io.h>

#include "io/volume/element.h"

typedef enum ost_volume_format { OST_FORMAT_UNKNOWN, OST_FORMAT_NRRD, OST_FORMAT_NIFTI, OST_FORMAT_NIFTI_GZIP, OST_FORMAT_TEXT } ost_volume_format;

/* By the name's end, in whatever case. */
ost_volume_format ost_volume_format_of(const char *path);
/* OST_ERR_USAGE naming the ends that are known. */
ost_status ost_volume_format_unknown(const char *path, ost_error *err);

typedef struct ost_volume_writer ost_volume_writer;

/*
 * element: int16 or, for NRRD only, uint8. Not for text.  odd_half (NRRD
 * only): the origin lies half a picometre further on every axis, which a tool
 * of an odd voxel needs (AR-FILE-3).
 */
ost_status ost_volume_writer_open(const char *path, const ost_geometry *geometry, const ost_meta *meta, ost_element element,
                                  bool odd_half, const ost_write_options *options, ost_volume_writer **out, ost_error *err);
ost_status ost_volume_writer_put(ost_volume_writer *writer, const void *voxels, size_t count, ost_error *err);
/* Ends the writer in any case. Every voxel must have been put. */
ost_status ost_volume_writer_commit(ost_volume_writer *writer, ost_error *err);
void ost_volume_writer_discard(ost_volume_writer *writer); /* NULL is allowed */

/* Between the writer and its formats: plain bytes, packed from ost_volume_writer_pack on. */
ost_status ost_volume_writer_bytes(ost_volume_writer *writer, const void *bytes, size_t size, ost_error *err);
ost_status ost_volume_writer_pack(ost_volume_writer *writer, ost_error *err);

/* nrrd_write.c and nifti_write.c: the header, leaving the writer ready for voxels. */
ost_status ost_nrrd_write_header(ost_volume_writer *writer, const ost_geometry *geometry, const ost_meta *meta, ost_element element,
                                 bool odd_half, bool compress, ost_error *err);
ost_status ost_nifti_write_header(ost_volume_writer *writer, const ost_geometry *geometry, const ost_meta *meta, bool compress,
                                  ost_error *err);

#endif
