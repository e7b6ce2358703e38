/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A clip plane hides the part of the grid on one side of it. The test uses integers: the voxel with the grid index v is
 * shown iff n . v <= d.
 *
 * n is a direction in units of 2^-14. On each axis, |n| <= 2^14 and v < 2^14, so |n . v| < 3 * 2^28.
 */
#ifndef OST_RENDER_CLIP_H
#define OST_RENDER_CLIP_H

#include "render/points/surface.h"

enum { OST_CLIP_UNIT = 1 << 14 };

/*
 * Computes the clip plane through a point in mm. The side that the normal points to is hidden. Returns OST_ERR_RANGE if
 * the normal is zero or not finite.
 */
ost_status ost_clip_make(const ost_geometry *geometry, const double at_mm[3], const double normal[3], ost_clip *out,
                         ost_error *err);
/* Sets the clip plane for later updates; NULL shows all voxels. Only the blocks in which the set of shown voxels
   changes are updated. */
void ost_surface_clip(ost_surface *surface, const ost_clip *clip);
/* Computes which voxels of a block are shown. */
void ost_clip_words(const ost_clip *clip, const int32_t block[3], const uint32_t occupied[OST_BLOCK_ROWS],
                    uint32_t shown[OST_BLOCK_ROWS]);

#endif
