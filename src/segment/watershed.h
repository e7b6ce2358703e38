/* SPDX-License-Identifier: Apache-2.0 */
/* Divides labelled voxels into pieces that are connected by necks (AR-SEG-8, AR-SEG-9). */
#ifndef OST_SEGMENT_WATERSHED_H
#define OST_SEGMENT_WATERSHED_H

#include "segment/distance.h"

/*
 * Divides the voxels into pieces. Stores the number of the piece of voxel i, from 0 to *pieces - 1, in
 * piece[i]. Two maxima of the height within one label belong to different pieces if every path between them
 * falls by at least `depth` micrometres below the lower maximum. `depth` must be 1 to SEGMENT_DISTANCE_MAX, and
 * every height at most SEGMENT_DISTANCE_MAX.
 */
ost_status ost_segment_watershed(const segment_sparse *sparse, const uint32_t *height, uint32_t depth, uint32_t *piece,
                                 uint32_t *pieces, ost_error *err);

#endif
