/* SPDX-License-Identifier: Apache-2.0 */
#ifndef OST_IO_NIFTI_WRITE_H
#define OST_IO_NIFTI_WRITE_H

#include "io/volume/writer.h"

/* Writes the header. The writer is then ready for voxels. */
ost_status ost_nifti_write_header(ost_volume_writer *writer, const ost_geometry *geometry, const ost_meta *meta,
                                  bool compress, ost_error *err);

#endif
