/* SPDX-License-Identifier: Apache-2.0 */
#ifndef OST_IO_NRRD_WRITE_H
#define OST_IO_NRRD_WRITE_H

#include "io/volume/writer.h"

/*
 * Writes the header; the writer is then ready for voxels. `fields` contains further lines of the header, each of
 * which ends with LF; it may be NULL.
 */
ost_status ost_nrrd_write_header(ost_volume_writer *writer, const ost_geometry *geometry, const ost_meta *meta,
                                 const char *fields, ost_element element, bool odd_voxel, bool compress,
                                 ost_error *err);

/* Doubles each backslash, because a single backslash begins an escape sequence in the value of a field. */
void ost_nrrd_escape(const char *value, char out[2 * OST_META_VALUE]);

/*
 * Formats the header line of a fact, "osteon_KEY:=VALUE\n", with escaped backslashes. The text is "" for a key that
 * describes the geometry of a grid, because the header has fields for it.
 */
enum { OST_NRRD_FACT = OST_META_KEY + 2 * OST_META_VALUE + 16 };
void ost_nrrd_fact(const char *key, const char *value, char text[OST_NRRD_FACT]);

#endif
