/* SPDX-License-Identifier: Apache-2.0 */
#ifndef OST_IO_METAIMAGE_WRITE_H
#define OST_IO_METAIMAGE_WRITE_H

#include "io/volume/writer.h"

/*
 * Writes the header of a .mha with int16 voxels, which follow it without compression. Lengths are exact decimals. The
 * facts become lines osteon_KEY = VALUE, which other programs ignore.
 */
ost_status ost_metaimage_write_header(ost_volume_writer *writer, const ost_geometry *geometry, const ost_meta *meta,
                                      ost_error *err);

#endif
