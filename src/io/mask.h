/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Restricts a CT to the voxels that a label map selects, before it is imported (AR-SEG-6).
 */
#ifndef OST_IO_MASK_H
#define OST_IO_MASK_H

#include <osteon/io.h>

/*
 * Reads options->mask and applies it to `volume`, the CT that was read from `path`. Voxels that are not selected
 * become 0 if their density is at least the threshold. With mask_fill, selected voxels below the threshold are set
 * to the threshold. The labels are recorded in `meta`. Returns OST_ERR_INPUT if the grid of the label map differs
 * from that of the CT, or if the label map selects no voxel.
 */
ost_status ost_mask_apply(const char *path, const ost_import_options *options, int32_t threshold, ost_volume *volume,
                          ost_meta *meta, ost_mask_report *report, ost_error *err);

/* Returns the error for a mask that is given with a CT in text form, which has no grid before its samples are read. */
ost_status ost_mask_refuse_text(const char *path, ost_error *err);

#endif
