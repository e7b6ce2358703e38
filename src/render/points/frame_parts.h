/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Declarations shared by the files that draw a frame:
 *
 *   frame.c        memory, objects, teams of threads
 *   frame_list.c   which voxels of a block have a face toward the eye, and where the lists have changed
 *   frame_band.c   a band of rows: draws lists into planes, and merges layers
 */
#ifndef OST_RENDER_FRAME_PARTS_H
#define OST_RENDER_FRAME_PARTS_H

#include "render/points/frame.h"

#ifdef _OPENMP
#include <omp.h>
#endif

/* Scratch of a thread for computing a list; includes space for a copy of the previous list. */
typedef struct ost_frame_lists {
    ost_chosen chosen;
    uint32_t tint[OST_BLOCK_POINTS + OST_LANES];
    uint64_t seen[OST_BLOCK_POINTS];
    uint8_t only[OST_BLOCK_POINTS];
} ost_frame_lists;

/* Returns the calling thread's number in its team, which is also the index of the thread's scratch. */
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
 * Reserves memory for the lists of layer->surface, and sets layer->slots to the surface's number of slots. Sets
 * layer->same to false if lists were discarded, or if the existing lists belong to blocks at other positions.
 */
ost_status ost_layer_reserve(ost_frame_layer *layer, ost_error *err);
void ost_layer_free(ost_frame_layer *layer);
/* Computes the list of the points to draw for the block in the given slot. */
void ost_layer_make_list(const ost_frame *frame, const ost_frame_layer *layer, int32_t slot, ost_frame_lists *with);
/* Computes the missing lists. All threads of a team must call this function. */
void ost_layer_make_lists(const ost_frame *frame, const ost_frame_layer *layer);
/* Drops the lists that are not valid for this frame. */
void ost_layer_drop_lists(const ost_frame_layer *layer);
/*
 * Sets frame->part to the cells of the first layer that must be drawn. Sets frame->stale to the cells that must be
 * copied from the stored planes. Returns the planes to draw into. The stored planes are filled only if the eye and the
 * light are the same as in the previous frame, so storing them costs no time while the eye moves. If the frame has
 * keys, all cells are drawn: a key contains the index of a voxel in its list, and a changed list may shift the indices
 * of unchanged voxels.
 */
const ost_planes *ost_frame_choose_part(ost_frame *frame);

/* ---- frame_band.c */

/* Draws a band of all layers. Only the first layer is drawn into the planes `base`. If frames are not stored, `base` is
 * &f->drawn. */
void ost_frame_draw_band(const ost_frame *f, int number, const ost_planes *base);
/* Draws a band of one layer into the ghost's planes. */
void ost_frame_draw_ghost_band(const ost_frame *f, const ost_frame_layer *layer, int number);
/* Blends a row of the ghost's planes into the frame's colours. */
void ost_frame_merge_ghost_row(const ost_frame *f, const ost_frame_layer *layer, unsigned ghost, int y);

#endif
