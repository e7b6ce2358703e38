/* SPDX-License-Identifier: Apache-2.0 */
#ifndef OST_IO_DICOM_READ_H
#define OST_IO_DICOM_READ_H

#include <osteon/io.h>

#include "io/volume/element.h"
#include "io/volume/target.h"

/*
 * Returns true if a file that begins with these bytes is DICOM. Files without the prefix DICM are not recognised; they
 * are read only as part of a folder.
 */
bool ost_dicom_sniff(const unsigned char *head, size_t size);

/* Reads one series from a folder, or one file. For the parameters, see ost_volume_read_any (volume_read.h). */
ost_status ost_dicom_read(const char *path, const ost_volume_options *options, const ost_target *target,
                          ost_geometry *geometry, ost_meta *meta, ost_volume_report *report, ost_element *element,
                          ost_error *err);

#endif
