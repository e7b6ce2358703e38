/* SPDX-License-Identifier: Apache-2.0 */
/* Changes a loaded volume before `osteon export` writes it. */
#ifndef OST_APP_EXPORT_PARTS_H
#define OST_APP_EXPORT_PARTS_H

#include "app/input/load.h"

/*
 * Replaces the voxels of *in with the removed voxels. A removed voxel is at or above the threshold in the bone `before`
 * and below the threshold in *in; its density is copied from `before`. All other voxels become 0. Returns an error if
 * the grids differ or if nothing was removed. *count is set to the number of removed voxels.
 */
ost_status export_removed(const app_state *app, const char *before, const char *name, loaded_volume *in, int64_t *count,
                          ost_error *err);

/*
 * Replaces the voxels with a label map: 1 at or above the threshold, 0 elsewhere. The header facts are changed to the
 * facts of a label map. If the volume already is a label map, it remains unchanged.
 */
ost_status export_labels(const char *name, loaded_volume *in, ost_error *err);

#endif
