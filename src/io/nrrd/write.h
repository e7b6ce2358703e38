/* SPDX-License-Identifier: Apache-2.0 */
#ifndef OST_IO_NRRD_WRITE_H
#define OST_IO_NRRD_WRITE_H

#include "io/volume/writer.h"

/*
 * Writes the header. The writer is then ready for voxels. fields: further lines of the header, each of which ends with
 * LF, or NULL.
 */
ost_status ost_nrrd_write_header(ost_volume_writer *writer, const ost_geometry *geometry, const ost_meta *meta,
                                 const char *fields, ost_element element, bool odd_voxel, bool compress,
                                 ost_error *err);

/* Escapes backslashes, which begin an escape in the value of a field. */
void ost_nrrd_escape(const char *value, char out[2 * OST_META_VALUE]);

/*
 * Formats the line of a fact, "osteon_KEY:=VALUE\n", with backslashes escaped. The text is "" for the keys that
 * describe a grid's own geometry.
 */
enum { OST_NRRD_FACT = OST_META_KEY + 2 * OST_META_VALUE + 16 };
void ost_nrrd_fact(const char *key, const char *value, char text[OST_NRRD_FACT]);

#endif
