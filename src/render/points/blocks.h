/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Which blocks of a surface an eye can see, near ones first: what every
 * renderer asks before it draws.
 *
 *   blocks of the surface --frustum--> those that may be seen --by distance--> order
 */
#ifndef OST_RENDER_BLOCKS_H
#define OST_RENDER_BLOCKS_H

#include "render/points/splat.h"

typedef struct ost_frame_block {
    int32_t slot;
    float distance;      /* squared, of its centre: the order */
    uint64_t nearest;    /* no key of a voxel of it is less (splat.h) */
    ost_extent pixels;   /* that it may cover */
    uint32_t count;      /* of its points */
} ost_frame_block;

/* OST_ERR_RANGE when the eye is more than 2^15 voxels away from the surface's grid. */
ost_status ost_blocks_check(const ost_surface *surface, const ost_eye *eye, ost_error *err);

/*
 * blocks and bases, 4 floats a slot, have room for surface->used; bases is of
 * all slots.  *y0 to *y1: rows that the chosen ones may cover, half-open.
 */
void ost_blocks_choose(const ost_surface *surface, const ost_splat_eye *eye, ost_frame_block *blocks, float *bases, int32_t *count, int *y0,
                       int *y1);

/*
 * Pixels, half-open, that a cube of `side` voxels on a side about `middle`, from
 * the eye, may cover.  False when it is not seen.
 */
bool ost_blocks_pixels(const ost_splat_eye *eye, const float middle[3], int side, ost_extent *out);

/* For coordinate i of an axis whose voxel 0 is base from the eye: the faces turned to it, as bits of ost_face. */
void ost_blocks_turned(float base, int axis, uint8_t turned[OST_BLOCK]);

#endif
