/* SPDX-License-Identifier: Apache-2.0 */
#ifndef OST_IO_VOLUME_READ_H
#define OST_IO_VOLUME_READ_H

#include <osteon/io.h>

#include "io/volume/element.h"
#include "io/volume/target.h"

/*
 * Implements ost_volume_read and ost_volume_read_header. If target is NULL, the voxels are not read. options may be
 * NULL; no other pointer may be NULL.
 */
ost_status ost_volume_read_any(const char *path, const ost_volume_options *options, const ost_target *target,
                               ost_geometry *geometry, ost_meta *meta, ost_volume_report *report, ost_element *element,
                               ost_error *err);

#endif
