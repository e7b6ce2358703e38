/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A clip plane hides the part of the grid on one side of the plane. The test uses integers: a voxel
 * with the grid index v is shown if and only if n . v <= d.
 *
 * n is a direction in units of 2^-14: |n| <= 2^14 on each axis, v < 2^14, so n . v < 2^30.
 */
#ifndef OST_RENDER_CLIP_H
#define OST_RENDER_CLIP_H

#include "render/points/surface.h"

enum { OST_CLIP_UNIT = 1 << 14 };

/*
 * Computes a clip plane through a point in mm. The side to which the normal points is hidden. Returns OST_ERR_RANGE if
 * the normal is zero or not finite.
 */
ost_status ost_clip_make(const ost_geometry *geometry, const double at_mm[3], const double normal[3], ost_clip *out,
                         ost_error *err);
/* Sets the clip plane for later updates; NULL means that all voxels are shown. An update processes only those blocks in
   which the set of shown voxels changes. */
void ost_surface_clip(ost_surface *surface, const ost_clip *clip);
/* Computes which voxels of a block are shown. */
void ost_clip_words(const ost_clip *clip, const int32_t block[3], const uint32_t occupied[OST_BLOCK_ROWS],
                    uint32_t shown[OST_BLOCK_ROWS]);

#endif
