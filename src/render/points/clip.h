/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A half of the grid is not shown.  Which side a voxel is on is decided in
 * integers:  shown  iff  n . v <= d,  v the voxel's place in the grid.
 *
 * n is a direction in 2^-14: |n| <= 2^14 an axis, v < 2^14, so n . v < 2^30.
 */
#ifndef OST_RENDER_CLIP_H
#define OST_RENDER_CLIP_H

#include "render/points/surface.h"

enum { OST_CLIP_UNIT = 1 << 14 };

/* Through a point in mm; what lies on the normal's side goes. OST_ERR_RANGE when the normal is no direction. */
ost_status ost_clip_make(const ost_geometry *geometry, const double at_mm[3], const double normal[3], ost_clip *out, ost_error *err);
/* From now on, with the next update; NULL: all is shown. Blocks that look as before are left as they are. */
void ost_surface_clip(ost_surface *surface, const ost_clip *clip);
/* What of a block's bits is shown. */
void ost_clip_words(const ost_clip *clip, const int32_t block[3], const uint32_t whole[OST_BLOCK_ROWS], uint32_t shown[OST_BLOCK_ROWS]);

#endif
