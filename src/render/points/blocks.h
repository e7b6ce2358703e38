/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Selects the blocks of a surface that are in the view frustum of an eye, and sorts them, nearest first. Used by all
 * renderers.
 *
 *   blocks of the surface --frustum--> those that may be visible --by distance--> order
 */
#ifndef OST_RENDER_BLOCKS_H
#define OST_RENDER_BLOCKS_H

#include "render/points/splat.h"

typedef struct ost_frame_block {
    int32_t slot;
    float distance;      /* squared distance from the eye to the block's centre, the sort key */
    uint64_t nearest;    /* lower bound on the keys of the block's voxels (splat.h) */
    ost_extent pixels;   /* range of pixels that the block may cover */
    uint32_t count;      /* number of points of the block */
} ost_frame_block;

/* Returns OST_ERR_RANGE if the eye is more than 2^15 voxels away from the surface's grid. */
ost_status ost_blocks_check(const ost_surface *surface, const ost_eye *eye, ost_error *err);

/*
 * Selects and sorts the blocks that may be visible, and computes `bases` for all slots. `blocks` must have space for
 * surface->used entries, and `bases` for 4 floats per slot. *y0 and *y1 receive the half-open range of rows that the
 * selected blocks may cover.
 */
void ost_blocks_choose(const ost_surface *surface, const ost_splat_eye *eye, ost_frame_block *blocks, float *bases,
                       int32_t *count, int *y0, int *y1);

/*
 * Computes the half-open range of pixels that a cube with edges of `side` voxels may cover. `middle` is the vector from
 * the eye to the cube's centre. Returns false if the cube is not visible.
 */
bool ost_blocks_pixels(const ost_splat_eye *eye, const float middle[3], int side, ost_extent *out);

/*
 * Computes, for each coordinate i along an axis, which faces are turned to the eye, as bits of ost_face. `base` is the
 * coordinate of voxel 0 relative to the eye.
 */
void ost_blocks_turned(float base, int axis, uint8_t turned[OST_BLOCK]);

#endif
