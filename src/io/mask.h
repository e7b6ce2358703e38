/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Restricts a CT to the voxels that a label map selects, before it is imported (AR-SEG-6).
 */
#ifndef OST_IO_MASK_H
#define OST_IO_MASK_H

#include <osteon/io.h>

/*
 * Applies options->mask, then options->labels, to `volume`, the CT that was read from `path`.
 * Voxels that are not selected become 0 if their density is at least the threshold.  With
 * mask_fill, and for options->labels, selected voxels below the threshold are set to the
 * threshold.  result->rect is the grid of the CT with the spacing of the options; the counts
 * and facts are stored in *result.  Returns OST_ERR_INPUT if the grid of the label map differs
 * from that of the CT, or if the label map selects no voxel.
 */
ost_status ost_mask_apply(const char *path, const ost_import_options *options, int32_t threshold, ost_volume *volume,
                          ost_import_result *result, ost_error *err);

/* Returns the error for a mask that is given with a CT in text form, which has no grid before its samples are read. */
ost_status ost_mask_refuse_text(const char *path, ost_error *err);

#endif
