/* SPDX-License-Identifier: Apache-2.0 */
#ifndef OST_IO_METAIMAGE_WRITE_H
#define OST_IO_METAIMAGE_WRITE_H

#include "io/volume/writer.h"

/*
 * Writes the header of a .mha file with uncompressed int16 voxels, which the caller writes next. Lengths are exact
 * decimals. Header facts become lines osteon_KEY = VALUE, which other programs ignore.
 */
ost_status ost_metaimage_write_header(ost_volume_writer *writer, const ost_geometry *geometry, const ost_meta *meta,
                                      ost_error *err);

#endif
