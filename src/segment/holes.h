/* SPDX-License-Identifier: Apache-2.0 */
/* Holes: voxels without a label that are enclosed by labels and contain no air (AR-SEG-5, AR-SEG-7). */
#ifndef OST_SEGMENT_HOLES_H
#define OST_SEGMENT_HOLES_H

#include <osteon/segment.h>

/* Fills the holes of the volume with the surrounding labels, and adds the numbers of filled voxels to
   segments[label - 1].filled. */
ost_status ost_segment_fill_holes(const ost_volume *ct, int32_t air, ost_volume *labels, ost_segment *segments,
                                  ost_error *err);
/* Fills the holes of each slice z = constant with the negative of the surrounding label. */
ost_status ost_segment_fill_slices(const ost_volume *ct, int32_t air, ost_volume *labels, ost_error *err);

#endif
