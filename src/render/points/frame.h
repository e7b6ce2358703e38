/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A frame: a surface through a camera, into planes and then into colours.
 *
 *   blocks --frustum, order--> near ones first --facing, tint--> a list --bands of rows, by threads--> planes
 *
 * A second thing, a tool with voxels of its own that stands at an angle, is
 * drawn the same way into planes of a band beside these, and of each pixel the
 * nearer one stays.
 *
 * A block is left out where nearer ones already cover all pixels that it could
 * reach: of each tile of 8 x 8 pixels the farthest key is kept, found anew only
 * when it is asked for and something was drawn since.  It changes no picture.
 *
 * What did not change is kept, after ost_frame_keep.  While the eye and the
 * light stay as they are:
 *
 *   blocks whose lists changed --entry by entry, old beside new--> voxels that look different
 *        --cells that these may cover--> drawn again, in the planes of the first thing alone
 *   those cells, and what was laid over others --put back from these planes--> the frame, and over it the rest
 *
 * It is the same picture to the bit as one that is drawn from nothing: a voxel
 * that is the same in both lists is nearest in a cell that no other touches if
 * it was before, and equal distances are told apart by the voxel's number,
 * which orders voxels as their places do.
 *
 * Its memory is kept from frame to frame: 9 bytes a pixel, 18 with what is kept.
 */
#ifndef OST_RENDER_FRAME_H
#define OST_RENDER_FRAME_H

#include "render/lettering.h"
#include "render/points/blocks.h"
#include "render/points/cells.h"
#include "render/points/light.h"

enum {
    OST_BAND = 64,     /* rows that a thread draws at once: keys of 1280 pixels of these stay in a second-level cache */
};

/* The farthest key of a tile, or one beyond it where stale. */
typedef struct ost_frame_tile {
    uint64_t farthest;
    bool stale;
} ost_frame_tile;

_Static_assert(OST_BAND % OST_CELL_HEIGHT == 0 && (int)OST_CELL_HEIGHT == OST_TILE && (int)OST_CELL_WIDTH == OST_LANES, "cells are whole tiles");

/* What a thread needs while it draws a band: its memory stays in a cache from band to band, and from layer to layer. */
typedef struct ost_frame_bench {
    ost_planes over;        /* owned; a layer but the first; its keys are the first's too */
    ost_frame_tile *tiles;  /* owned; rows of tiles_across */
    struct ost_frame_lists *lists; /* owned; what lists are made with */
} ost_frame_bench;

/* The list of a block, for the layer's eye. */
typedef struct ost_frame_list {
    uint64_t version;       /* of the block that it was made of */
    uint32_t count, room;
    uint32_t place;         /* where the next one is put; this one is at visible.begin */
    int32_t at[3];          /* the block's */
    bool listed;            /* it is made; else nothing of the block is seen */
    bool there;             /* the block was in sight of the last frame, be it hidden */
} ost_frame_list;

/* One thing that is drawn, and its list. */
typedef struct ost_frame_layer {
    const ost_surface *surface; /* borrowed for a frame */
    ost_frame_block *blocks; /* owned; count of them after the cull */
    int32_t count;
    ost_visible visible;    /* the lists */
    size_t visible_room, visible_used;
    ost_frame_list *list;   /* owned; of each slot */
    int32_t slots, slot_room; /* of the last frame */
    float *bases;           /* owned; 4 a slot */
    ost_splat_eye eye;
    ost_light light;
    float scale;            /* its voxels in voxels of the first */
    bool within;            /* the eye is in it or close to it: faces that are not to the air may be seen */
    bool same;              /* eye and light as in the frame before, and frames are kept */
    int y0, y1;             /* rows that it may cover, half-open */
    ost_cells cells;        /* what it may cover */
} ost_frame_layer;

enum { OST_FRAME_LAYERS = 4 };

typedef struct ost_frame {
    int width, height;
    ost_planes planes;      /* owned; key only after ost_frame_keep_keys */
    ost_planes ghost;       /* owned; where a ghost is drawn; NULL before there was one; no keys */
    ost_planes kept;        /* owned; those of the first layer alone; NULL before ost_frame_keep; no keys */
    bool is_kept;           /* they are those of the last frame */
    ost_cells part;         /* of the first layer: what this frame draws anew */
    ost_cells stale;        /* what is put back: drawn anew, or laid over in the frame before */
    ost_cells over;         /* where colours may be others than kept ones; whoever writes on a frame adds to it (ost_frame_sheet) */
    ost_frame_bench *bench; /* owned; of each thread */
    int tiles_across;
    uint32_t *blank;        /* owned; a row of background */
    ost_splat_kernels kernels;
    ost_light_tint_of *tint;
    int threads;
    int band;               /* rows that a thread draws at once, a multiple of OST_TILE */
    ost_frame_layer layer[OST_FRAME_LAYERS];
    int layers;             /* of the last frame */
    ost_style style;
    ost_directions *directions; /* owned */
} ost_frame;

/* A thing in front of the camera. */
typedef struct ost_frame_thing {
    const ost_surface *surface;
    ost_eye eye;            /* in its voxels; its size is the frame's */
    ost_paint paint;
    const uint32_t *palette; /* borrowed; NULL: all of it has its own paint */
} ost_frame_thing;

/* threads 0: all processors. */
ost_status ost_frame_init(ost_frame *frame, int width, int height, ost_style style, ost_isa isa, int threads, ost_error *err);
void ost_frame_free(ost_frame *frame); /* also of a zeroed one */

/* Keys of the first layer are kept in the planes from now on, for who wants to know which voxel a pixel shows. */
ost_status ost_frame_keep_keys(ost_frame *frame, ost_error *err);

/* From now on frames like the last one but for some blocks are drawn where they differ. */
ost_status ost_frame_keep(ost_frame *frame, ost_error *err);
/* All of the planes was written by others. */
void ost_frame_overwritten(ost_frame *frame);
/* To be written upon. */
ost_sheet ost_frame_sheet(const ost_frame *frame);

/* Fills the planes; depth is in voxels of the first. OST_ERR_RANGE when the eye is more than 2^15 of its voxels away from a thing. */
ost_status ost_frame_draw_things(ost_frame *frame, const ost_frame_thing *things, int count, ost_error *err);
/*
 * One thing more, over a frame that was drawn, by whom ever: it is seen before
 * other things by `share` 256ths, behind them by half of that, and changes
 * colours alone.  spacing: of the first thing's voxels, which depth is in.
 */
ost_status ost_frame_draw_ghost(ost_frame *frame, const ost_frame_thing *thing, unsigned share, ost_pm spacing, ost_error *err);
/* Of bone alone. */
ost_status ost_frame_draw(ost_frame *frame, const ost_surface *surface, const ost_eye *eye, ost_error *err);

/* The colours of the last frame; picture has the frame's size. */
void ost_frame_copy(const ost_frame *frame, ost_picture *picture);
/* The same of colours as a frame has them, r in the lowest byte, stride a row. */
void ost_colours_copy(const uint32_t *colours, int stride, ost_picture *picture);

#endif
