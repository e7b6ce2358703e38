/* SPDX-License-Identifier: Apache-2.0 */
#ifndef OST_IO_NIFTI_READ_H
#define OST_IO_NIFTI_READ_H

#include <osteon/io.h>

#include "io/volume/element.h"
#include "io/volume/input.h"
#include "io/volume/target.h"

/* Number of bytes from the start of the (unpacked) file that identify the format. */
enum { OST_NIFTI_SNIFF = 348 };
/* Returns 1 for NIfTI-1, 2 for NIfTI-2, 7 for ANALYZE 7.5 (the predecessor of NIfTI), and 0 for any other file. */
int ost_nifti_sniff(const unsigned char *bytes, size_t size);
/* Returns true if the bytes, which are a complete file, begin like a NIfTI-1 header but end before its magic string. */
bool ost_nifti_is_truncated(const unsigned char *bytes, size_t size);

/*
 * Reads a NIfTI file. The input must be at the start of the (unpacked) header. For the other parameters, see
 * ost_nrrd_read. Returns OST_ERR_UNAVAILABLE if osteon was built without libnifti.
 */
ost_status ost_nifti_read(ost_input *input, const ost_volume_options *options, const ost_target *target,
                          ost_geometry *geometry, ost_meta *meta, ost_volume_report *report,
                          ost_element *element, ost_error *err);

#endif
