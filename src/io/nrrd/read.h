/* SPDX-License-Identifier: Apache-2.0 */
#ifndef OST_IO_NRRD_READ_H
#define OST_IO_NRRD_READ_H

#include <osteon/io.h>

#include "io/volume/element.h"
#include "io/volume/input.h"
#include "io/volume/target.h"

/*
 * Reads a NRRD file. The input must be at the start of the file. If target is NULL, the voxels are skipped, and only
 * geometry, meta and report are filled; these three must not be NULL. *out is initialised in all cases.
 */
ost_status ost_nrrd_read(ost_input *input, const ost_volume_options *options, const ost_target *target,
                         ost_geometry *geometry, ost_meta *meta, ost_volume_report *report,
                         ost_element *element, ost_error *err);

#endif
