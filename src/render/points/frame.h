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
 * Its memory is kept from frame to frame.
 */
#ifndef OST_RENDER_FRAME_H
#define OST_RENDER_FRAME_H

#include "render/points/blocks.h"
#include "render/points/light.h"

enum {
    OST_BAND = 64,     /* rows that a thread draws at once: keys of 1280 pixels of these stay in a second-level cache */
    OST_SPAN_ROWS = OST_TILE, /* rows that share a span; a divisor of OST_BAND */
};

/* The farthest key of a tile, or one beyond it where stale. */
typedef struct ost_frame_tile {
    uint64_t farthest;
    bool stale;
} ost_frame_tile;

/* What a thread needs while it draws a band: its memory stays in a cache from band to band, and from layer to layer. */
typedef struct ost_frame_bench {
    ost_planes over;        /* owned; a layer but the first; its keys are the first's too */
    ost_frame_tile *tiles;  /* owned; rows of tiles_across */
} ost_frame_bench;

/* Columns, half-open, in multiples of OST_LANES. */
typedef struct ost_frame_span {
    int from, to;
} ost_frame_span;

/* One thing that is drawn, and its list. */
typedef struct ost_frame_layer {
    const ost_surface *surface; /* borrowed for a frame */
    ost_frame_block *blocks; /* owned; count of them after the cull */
    int32_t count, block_room;
    ost_visible visible;    /* the list */
    size_t visible_room;
    float *bases;           /* owned; 4 a slot */
    ost_splat_eye eye;
    ost_light light;
    float scale;            /* its voxels in voxels of the first */
    bool within;            /* the eye is in it or close to it: faces that are not to the air may be seen */
    int y0, y1;             /* rows that it may cover, half-open */
    ost_frame_span span[OST_FRAME_MAX / OST_SPAN_ROWS]; /* what it may cover, for each OST_SPAN_ROWS rows */
} ost_frame_layer;

enum { OST_FRAME_LAYERS = 4 };

typedef struct ost_frame {
    int width, height;
    ost_planes planes;      /* owned; key only after ost_frame_keep_keys */
    ost_planes ghost;       /* owned; where a ghost is drawn; NULL before there was one; no keys */
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
