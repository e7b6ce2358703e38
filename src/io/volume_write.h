/* SPDX-License-Identifier: Apache-2.0 */
/* Writes volumes. The ending of the file name selects the format. */
#ifndef OST_IO_VOLUME_WRITE_H
#define OST_IO_VOLUME_WRITE_H

#include <osteon/io.h>

#include "io/volume/writer.h"

typedef enum ost_volume_format {
    OST_FORMAT_UNKNOWN,
    OST_FORMAT_NRRD,
    OST_FORMAT_NIFTI,
    OST_FORMAT_NIFTI_GZIP,
    OST_FORMAT_METAIMAGE,
    OST_FORMAT_TEXT
} ost_volume_format;

/* Returns the format that belongs to the extension of a file name, regardless of case. */
ost_volume_format ost_volume_format_of(const char *path);
/* Returns OST_ERR_USAGE with a message that names the supported endings. */
ost_status ost_volume_format_unknown(const char *path, ost_error *err);

/*
 * Opens a writer for a volume in any format except text. element is int16 or, for NRRD only, uint8. If odd_voxel is set
 * (NRRD only), half a picometre is added to the origin on every axis. This is needed for tools whose voxel size is an
 * odd number of picometres (AR-FILE-3). `fields` (NRRD only) contains further lines of the header; it may be NULL.
 */
ost_status ost_volume_writer_open(const char *path, const ost_geometry *geometry, const ost_meta *meta,
                                  const char *fields, ost_element element, bool odd_voxel,
                                  const ost_write_options *options,
                                  ost_volume_writer **out, ost_error *err);

#endif
