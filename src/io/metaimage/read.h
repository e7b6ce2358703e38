/* SPDX-License-Identifier: Apache-2.0 */
#ifndef OST_IO_METAIMAGE_READ_H
#define OST_IO_METAIMAGE_READ_H

#include <osteon/io.h>

#include "io/volume/element.h"
#include "io/volume/input.h"
#include "io/volume/target.h"

/*
 * Reads a MetaImage file. The input must be at the start of the file. For the other parameters, see ost_volume_read_any
 * (volume_read.h).
 */
ost_status ost_metaimage_read(ost_input *input, const ost_volume_options *options, const ost_target *target,
                              ost_geometry *geometry, ost_meta *meta, ost_volume_report *report, ost_element *element,
                              ost_error *err);

#endif
