/* SPDX-License-Identifier: Apache-2.0 */
/* Changes of a loaded volume before osteon export writes it. */
#ifndef OST_APP_VERBS_EXPORT_PARTS_H
#define OST_APP_VERBS_EXPORT_PARTS_H

#include "app/input/load.h"

/*
 * Replaces the voxels by what was removed: those at or above the threshold in the bone `before`, with
 * their density, and below the threshold in *in. All other voxels become 0. It is an error if the grids
 * differ or nothing was removed. *count is the number of removed voxels.
 */
ost_status export_removed(const app_state *app, const char *before, const char *name, loaded_volume *in, int64_t *count,
                          ost_error *err);

/*
 * Replaces the voxels by a label map: 1 at or above the threshold, 0 elsewhere. The facts become those of a label map.
 * A label map stays as it is.
 */
ost_status export_labels(const char *name, loaded_volume *in, ost_error *err);

#endif
