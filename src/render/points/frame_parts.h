/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A frame in three parts:
 *
 *   frame.c        its memory, its objects, the teams of threads
 *   frame_list.c   which voxels of a block show a face to the eye, and where the lists changed since the last frame
 *   frame_band.c   a band of rows: lists into planes, layers over one another
 */
#ifndef OST_RENDER_FRAME_PARTS_H
#define OST_RENDER_FRAME_PARTS_H

#include "render/points/frame.h"

#ifdef _OPENMP
#include <omp.h>
#endif

/* The scratch of a thread that makes a list, and the list that it replaces. */
typedef struct ost_frame_lists {
    ost_chosen chosen;
    uint32_t tint[OST_BLOCK_POINTS + OST_LANES];
    uint64_t seen[OST_BLOCK_POINTS];
    uint8_t only[OST_BLOCK_POINTS];
} ost_frame_lists;

/* Returns the calling thread's number in its team, which is its scratch's index. */
static inline int ost_frame_thread(void)
{
#ifdef _OPENMP
    return omp_get_thread_num();
#else
    return 0;
#endif
}

/* ---- frame_list.c */

/*
 * Reserves memory for the lists of layer->surface; layer->slots becomes the surface's.
 * layer->same becomes false where lists were lost, or are of other blocks.
 */
ost_status ost_layer_reserve(ost_frame_layer *layer, ost_error *err);
void ost_layer_free(ost_frame_layer *layer);
/* Makes the list of the block in this slot. */
void ost_layer_make_list(const ost_frame *frame, const ost_frame_layer *layer, int32_t slot, ost_frame_lists *with);
/* Makes the lists that are missing. Called by all threads of a team. */
void ost_layer_make_lists(const ost_frame *frame, const ost_frame_layer *layer);
/* Drops the lists that are not valid for this frame. */
void ost_layer_drop_lists(const ost_frame_layer *layer);
/*
 * Sets frame->part and frame->stale: the cells of the first layer to draw, and the cells to copy
 * from the stored planes.  Returns the planes to draw into.  The stored planes are drawn
 * completely only in the second of two equal frames, so that a moving eye does not pay for them.
 * Voxel numbers change with a list, so a frame with keys draws all cells again.
 */
const ost_planes *ost_frame_choose_part(ost_frame *frame);

/* ---- frame_band.c */

/* Draws a band of all layers. base: planes of the first layer alone, the frame's own unless they are stored. */
void ost_frame_draw_band(const ost_frame *f, int number, const ost_planes *base);
/* Draws a band of one layer into the ghost's planes. */
void ost_frame_draw_ghost_band(const ost_frame *f, const ost_frame_layer *layer, int number);
/* Mixes a row of the ghost's planes into the frame's colours. */
void ost_frame_merge_ghost_row(const ost_frame *f, const ost_frame_layer *layer, unsigned ghost, int y);

#endif
