/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Restricts a CT to the voxels that a label map selects, before the CT is imported (AR-SEG-6).
 */
#ifndef OST_IO_MASK_H
#define OST_IO_MASK_H

#include <osteon/io.h>

/*
 * Applies options->mask and then options->labels to `volume`. The volume is the CT that was read from `path`. The
 * density of an unselected voxel is set to 0 if it is at least the threshold. If mask_fill is set or options->labels is
 * used, the density of a selected voxel below the threshold is raised to the threshold. result->rect must be the grid
 * of the CT with the spacing of the options. The counts and header facts are stored in *result. Returns OST_ERR_INPUT
 * if the grid of the label map does not match the grid of the CT, or if the label map selects no voxel.
 */
ost_status ost_mask_apply(const char *path, const ost_import_options *options, int32_t threshold, ost_volume *volume,
                          ost_import_result *result, ost_error *err);

/* Returns the error for a mask on a CT in text form. The grid of such a CT is unknown until its samples are read. */
ost_status ost_mask_refuse_text(const char *path, ost_error *err);

#endif
