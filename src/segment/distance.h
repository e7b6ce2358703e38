/* SPDX-License-Identifier: Apache-2.0 */
/* The distance of each labelled voxel to the nearest voxel without a label (AR-SEG-7). */
#ifndef OST_SEGMENT_DISTANCE_H
#define OST_SEGMENT_DISTANCE_H

#include "segment/sparse.h"

/*
 * The maximum distance in micrometres. Greater distances are clamped to this value. If the grid has no unlabelled
 * voxel, all distances have this value.
 */
enum { SEGMENT_DISTANCE_MAX = 65535 };

/* Stores the distance of voxel i in height[i], for all sparse->count voxels. */
ost_status ost_segment_distance(const segment_sparse *sparse, ost_pm3 spacing, uint32_t *height, ost_error *err);

#endif
