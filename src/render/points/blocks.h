/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Selects the blocks of a surface that are in an eye's view, near ones first,
 * for every renderer.
 *
 *   blocks of the surface --frustum--> those that may be visible --by distance--> order
 */
#ifndef OST_RENDER_BLOCKS_H
#define OST_RENDER_BLOCKS_H

#include "render/points/splat.h"

typedef struct ost_frame_block {
    int32_t slot;
    float distance;      /* squared distance of its centre, by which blocks are sorted */
    uint64_t nearest;    /* lower bound of the keys of its voxels (splat.h) */
    ost_extent pixels;   /* pixels that it may cover */
    uint32_t count;      /* number of its points */
} ost_frame_block;

/* Returns OST_ERR_RANGE if the eye is more than 2^15 voxels away from the surface's grid. */
ost_status ost_blocks_check(const ost_surface *surface, const ost_eye *eye, ost_error *err);

/*
 * Selects and sorts the blocks that may be visible, and computes bases for all
 * slots.  blocks must have room for surface->used entries, bases for 4 floats
 * each.  Stores in *y0 and *y1 the rows that the selected blocks may cover,
 * half-open.
 */
void ost_blocks_choose(const ost_surface *surface, const ost_splat_eye *eye, ost_frame_block *blocks, float *bases,
                       int32_t *count, int *y0, int *y1);

/*
 * Computes the pixels, half-open, that a cube of `side` voxels a side may cover.
 * middle: its centre, relative to the eye.  Returns false if it is not visible.
 */
bool ost_blocks_pixels(const ost_splat_eye *eye, const float middle[3], int side, ost_extent *out);

/*
 * Computes, for each coordinate i on an axis, the faces turned to the eye, as bits
 * of ost_face.  base: coordinate of voxel 0 minus the eye's.
 */
void ost_blocks_turned(float base, int axis, uint8_t turned[OST_BLOCK]);

#endif
