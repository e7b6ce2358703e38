/* SPDX-License-Identifier: Apache-2.0 */
#ifndef OST_IO_NIFTI_READ_H
#define OST_IO_NIFTI_READ_H

#include <osteon/io.h>

#include "io/volume/element.h"
#include "io/volume/input.h"

/* Bytes from the file's start (unpacked, where packed) that are enough to tell. */
enum { OST_NIFTI_SNIFF = 348 };
/* 1 or 2: NIfTI of that version.  7: ANALYZE 7.5, which NIfTI grew from.  0: none of them. */
int ost_nifti_sniff(const unsigned char *bytes, size_t size);

/* As ost_nrrd_read, from an input at the (unpacked) start of the header. Without libnifti OST_ERR_UNAVAILABLE. */
ost_status ost_nifti_read(ost_input *input, const ost_volume_options *options, ost_volume *out, ost_geometry *geometry, ost_meta *meta,
                          ost_volume_report *report, ost_element *element, ost_error *err);

#endif
