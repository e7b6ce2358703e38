/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Draws the voxels of a grid as boxes with their true proportions, as an SVG in parallel projection. The renderer
 * (render/) draws only cubes, so it cannot show the voxels of a CT.
 */
#ifndef OST_REPRODUCTION_VOXEL_BLOCKS_H
#define OST_REPRODUCTION_VOXEL_BLOCKS_H

#include <osteon/event.h>
#include <osteon/grid.h>

/*
 * Draws the active voxels of a box. The vector `inward` is the direction into the bone, and the viewer is on the
 * opposite side. The SVG is returned in memory that the caller must free.
 */
ost_status voxel_blocks_draw(const ost_volume *volume, const ost_voxel_box *box, int32_t threshold,
                             const double inward[3], uint8_t **svg, size_t *size, ost_error *err);

#endif
